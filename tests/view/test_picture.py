"""What a page is shown, from records: bounded, thinned, and never a number that JSON does not have."""

from __future__ import annotations

import asyncio
import json
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from snakebot.robot import load_robot
from snakebot.runlog import RunWriter, channels, read_log, records
from snakebot.view.messages import ViewPacket, pack, unpack
from snakebot.view.picture import ERROR_OVER_S, KEPT_S, ROW_S, Picture, Seen
from snakebot.view.recording import Player, Recording, about_recording
from snakebot.view.server import Server, is_loopback

ROBOT = load_robot("penn_state")


def tick(t_s: float, error_rad: float = 0.0, measured: bool = True) -> ViewPacket:
    angles = np.linspace(-0.5, 0.5, 5)
    record = records.Tick(
        sequence=round(t_s * 100) % 65536,
        t_s=t_s,
        host_time_ns=0,
        setpoint_rad=angles,
        sent_rad=angles,
        applied_rad=angles,
        measured_rad=angles + error_rad if measured else np.full(5, np.nan),
        latency_s=0.001,
    )
    return ViewPacket(channels.JOINTS.id, 0, channels.encode_tick(record))


def test_a_day_of_ticks_is_kept_as_30_s() -> None:
    picture = Picture(5)
    for number in range(20_000):
        picture.take(tick(number * 0.004))
    assert len(picture.rows) <= KEPT_S / ROW_S + 1
    assert picture.rows[-1][0] - picture.rows[0][0] == pytest.approx(KEPT_S, abs=2 * ROW_S)
    assert all(len(window) <= ERROR_OVER_S / 0.004 + 2 for window in picture._squares)


def test_the_rms_is_of_the_last_seconds() -> None:
    picture = Picture(5)
    for number in range(4000):
        t_s = number * 0.01
        picture.take(tick(t_s, math.radians(3.0 if t_s < 20 else 1.0)))
    assert picture.rms_deg() == pytest.approx([1.0] * 5, abs=1e-3)
    assert picture.loop() == {"rate_hz": pytest.approx(100), "round_trip_ms": pytest.approx(1.0)}


def test_lost_samples_are_gaps_and_json_has_no_nan() -> None:
    picture = Picture(5)
    picture.take(tick(0.0, measured=False))
    frame = picture.frame(Seen(), 100)
    assert frame["rows"][0][3] == [None] * 5
    assert frame["rms_deg"] == [None] * 5
    json.dumps(frame, allow_nan=False)


def test_a_page_that_missed_much_gets_thinned_rows_and_no_row_twice() -> None:
    picture = Picture(5)
    for number in range(1500):
        picture.take(tick(number * 0.02))
    seen = Seen()
    first = picture.frame(seen, 100)
    assert len(first["rows"]) <= 100
    assert first["rows"][-1] == picture.rows[-1]  # the newest is never thinned away
    assert picture.frame(seen, 100)["rows"] == []
    picture.take(tick(31.0))
    assert [row[0] for row in picture.frame(seen, 100)["rows"]] == [31.0]


def test_another_run_begins_on_a_page_that_stays_open() -> None:
    picture, seen = Picture(5), Seen()
    for number in range(100):
        picture.take(tick(number * 0.02))
    picture.take(status(story={"now": "run 1"}))
    assert picture.frame(seen, 100)["story"] == {"now": "run 1"}
    assert "story" not in picture.frame(seen, 100)
    picture.begin_again(5)
    frame = picture.frame(seen, 100)
    assert frame["fresh"]
    assert (frame["rows"], frame["status"], frame["rms_deg"]) == ([], {}, [None] * 5)
    picture.take(tick(0.0))
    frame = picture.frame(seen, 100)
    assert not frame["fresh"]
    assert [row[0] for row in frame["rows"]] == [0.0]
    assert picture.frame(Seen(), 100)["story"] == {"now": "run 1"}  # a page that comes later


def status(**values: object) -> ViewPacket:
    return unpack(pack(0, 0, values))


@given(st.integers(0, 255), st.integers(0, 2**64 - 1), st.dictionaries(st.text(), st.integers(0, 9)))
def test_packets_come_out_as_they_went_in(channel: int, log_ns: int, values: dict[str, int]) -> None:
    packet = unpack(pack(channel, log_ns, values))
    assert (packet.channel_id, packet.log_time_ns, packet.values()) == (channel, log_ns, values)


@given(st.binary(max_size=40))
def test_damaged_packets_are_a_value_error_and_nothing_else(data: bytes) -> None:
    picture = Picture(5)
    try:
        picture.take(unpack(data))
    except (ValueError, KeyError, TypeError):
        return


@pytest.mark.parametrize(
    ("address", "loopback"),
    [("127.0.0.1", True), ("127.9.9.9", True), ("localhost", True), ("::1", True), ("[::1]", True),
     ("0.0.0.0", False), ("192.168.1.2", False), ("::", False), ("robot.local", False), ("", False)],
)  # fmt: skip
def test_what_only_this_computer_can_reach(address: str, loopback: bool) -> None:
    assert is_loopback(address) is loopback


def recorded(path: Path, events: Sequence[records.Event] = ()) -> Recording:
    start_ns = 1_700_000_000_000_000_000
    with RunWriter(path, ROBOT, {"note": "x"}, start_time_ns=start_ns) as writer:
        writer.event(records.Event(0.0, "armed", "joints powered where they are"))
        for number in range(400):
            t_s = number * 0.01
            angles = np.full(5, 0.1 * math.sin(t_s))
            writer.tick(
                records.Tick(number, t_s, start_ns + round(t_s * 1e9), angles, angles, angles, angles)
            )
            writer.pose(records.PoseRecord(t_s, 0.1 * t_s, 0.0, 0.0))
        writer.telemetry(records.Telemetry(1.0, {"supply_v": 7.4}))
        for event in events:
            writer.event(event)
    return Recording(read_log(path))


def test_a_recording_is_the_run_in_the_order_of_time(tmp_path: Path) -> None:
    recording = recorded(tmp_path / "run.mcap")
    packets = [recording.packet(index) for index in range(len(recording))]
    assert len(packets) == 1 + 400 + 400 + 1
    assert (np.diff(recording.times_s) >= 0).all()
    picture = Picture(5)
    for packet in packets:
        picture.take(packet)
    assert picture.telemetry == {"supply_v": 7.4}
    assert picture.pose is not None
    assert picture.pose[0] == pytest.approx(0.399)
    assert picture.rows[-1][0] == pytest.approx(3.98, abs=0.02)


def test_a_recording_is_played_paused_and_sought(tmp_path: Path) -> None:
    recording = recorded(tmp_path / "run.mcap")
    log = read_log(tmp_path / "run.mcap")

    async def play() -> None:
        player = Player(recording)
        server = Server(about_recording(log), player.ask)
        task = asyncio.create_task(player.play(server))
        assert await player.ask({"do": "pause"}) is None
        assert await player.ask({"do": "seek", "t_s": 2.5}) is None
        await asyncio.sleep(0.1)
        assert server.picture.rows[-1][0] == pytest.approx(2.5, abs=0.021)
        assert await player.ask({"do": "seek", "t_s": 1.0}) is None
        await asyncio.sleep(0.1)
        assert server.picture.rows[-1][0] == pytest.approx(1.0, abs=0.021)
        assert await player.ask({"do": "speed", "speed": 10}) is None
        assert await player.ask({"do": "play"}) is None
        async with asyncio.timeout(10.0):
            while server.picture.rows[-1][0] < 3.95:
                await asyncio.sleep(0.02)
        assert await player.ask({"do": "stop"}) == "this is a recording: nothing moves"
        for nonsense in ({"do": "seek"}, {"do": "seek", "t_s": "x"}, {"do": "speed", "speed": []}):
            assert await player.ask(nonsense) == "not understood"
        assert await player.ask({"do": "seek", "t_s": math.nan}) is None
        task.cancel()

    asyncio.run(play())


ENDS: list[tuple[list[records.Event], str]] = [
    ([records.Event(4.1, "holding", "joints held"), records.Event(4.3, "disarmed", "joints relaxed")], "disarmed"),
    ([records.Event(4.0, "error", "sim: emergency stop: the joints are without power", "error")], "stopped"),
    ([records.Event(4.0, "fault", "joint 2: the servo is too hot: 81 degC", "error"),
      records.Event(4.1, "error", "sim: joint 2: the servo is too hot: 81 degC", "error")], "fault"),
    ([records.Event(4.0, "error", "serial:/dev/ttyUSB0: the board does not answer", "error")], "silent"),
    ([], "silent"),
]  # fmt: skip


@pytest.mark.parametrize(("events", "mode"), ENDS)
def test_a_recording_that_has_ended_says_what_became_of_the_joints(
    events: list[records.Event], mode: str, tmp_path: Path
) -> None:
    recording = recorded(tmp_path / "run.mcap", events)
    assert recording.mode(2.0) == "armed"
    assert recording.mode(recording.end_s) == mode
    assert recording.end_s == max([3.99, *(event.t_s for event in events)])


def test_a_joint_that_was_freed_long_before_is_free_where_a_recording_is_sought(tmp_path: Path) -> None:
    start_ns = 1_700_000_000_000_000_000
    path = tmp_path / "run.mcap"
    with RunWriter(path, ROBOT, {"note": "x"}, start_time_ns=start_ns) as writer:
        writer.event(records.Event(1.0, "joint_mode", "joint 3: free", data={"joints": [3], "mode": "free"}))
        for number in range(80):
            t_s, angles = float(number), np.zeros(5)
            writer.tick(
                records.Tick(number, t_s, start_ns + round(t_s * 1e9), angles, angles, angles, angles)
            )
    log = read_log(path)

    async def play() -> list[str]:
        player = Player(Recording(log))
        server = Server(about_recording(log), player.ask)
        await player.ask({"do": "pause"})
        await player.ask({"do": "seek", "t_s": 70.0})
        task = asyncio.create_task(player.play(server))
        await asyncio.sleep(0.1)
        task.cancel()
        return server.picture.joint_modes

    assert asyncio.run(play()) == ["active", "active", "free", "active", "active"]
