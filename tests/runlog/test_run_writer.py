"""A run is read back as it was written, and the writer keeps its promises to the run loop."""

from __future__ import annotations

import errno
import math
import os
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from runlog_samples import (
    ROBOT,
    START_NS,
    assert_equals_ticks,
    bench,
    flushed,
    make_ticks,
    write_everything,
    write_ticks,
)

from snakebot.errors import LogError
from snakebot.gait import Gait
from snakebot.runlog import (
    Event,
    PoseRecord,
    RunWriter,
    Tick,
    gait_to_mapping,
    metadata,
    new_log_path,
    read_log,
)
from snakebot.runlog.naming import gait_label


def test_ticks_come_back_to_the_last_bit(tmp_path: Path) -> None:
    ticks = make_ticks(3000)
    log = read_log(write_ticks(tmp_path / "run", ticks))
    assert len(log.sequence) == 3000
    assert log.complete
    assert log.problems == ()
    assert_equals_ticks(log, ticks)


def test_every_channel_comes_back(tmp_path: Path) -> None:
    log = read_log(write_everything(tmp_path / "run.mcap"))
    assert log.robot == ROBOT
    assert log.attachments["snakebot.dbc"] == b'VERSION ""'
    assert log.gait == Gait.from_degrees(66, 80, 2)
    assert log.metadata["ended"] == "finished"
    assert log.metadata["simulated"] is True
    assert [event.kind for event in log.events] == ["armed"]
    assert log.events[0].data == {"start_rad": [0.0] * 5}
    np.testing.assert_array_equal(log.pose[:3], [[0, -0.5, 0.1], [0.01, -0.5, 0.1], [0.02, -0.5, 0.1]])
    np.testing.assert_array_equal(log.pose_speed_m_s, np.full(50, 0.13))
    np.testing.assert_array_equal(log.link["sent"], [12, 24])
    np.testing.assert_array_equal(log.link["received"], [np.nan, 7])
    assert log.frames[0].data == b"\x00\xff"
    run = log.to_run()
    np.testing.assert_array_equal(run.command_rad, log.sent_rad)
    assert run.pose is not None
    np.testing.assert_array_equal(run.pose[:, 0], log.pose[:, 0])
    supply = run.extra["supply_v"]
    assert np.isnan(supply[run.t_s < 0.05]).all()
    assert (supply[run.t_s >= 0.05] == 7.4).all()


ANGLE = st.one_of(st.floats(-1e6, 1e6), st.just(math.nan), st.just(-0.0), st.floats(0, 1e-300))


@st.composite
def tick_lists(draw: st.DrawFn) -> tuple[int, list[Tick]]:
    joints = draw(st.integers(1, 16))
    vector = st.lists(ANGLE, min_size=joints, max_size=joints)
    return joints, [
        Tick(
            i,
            i * 0.1 + draw(st.floats(0, 0.09)),
            START_NS + draw(st.integers(0, 10**12)),
            draw(vector),
            draw(vector),
            draw(st.none() | vector),
            draw(st.none() | vector),
            draw(st.none() | st.integers(0, 2**53)),
            draw(st.none() | st.floats(0, 10)),
            draw(st.booleans()),
        )
        for i in range(draw(st.integers(0, 6)))
    ]


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(tick_lists())
def test_any_tick_comes_back(tmp_path_factory: pytest.TempPathFactory, case: tuple[int, list[Tick]]) -> None:
    joints, ticks = case
    log = read_log(write_ticks(tmp_path_factory.mktemp("any") / "run", ticks, bench(joints)))
    assert len(log.sequence) == len(ticks)
    assert log.setpoint_rad.shape == (len(ticks), joints)
    assert_equals_ticks(log, ticks)


TEXT = st.text(st.characters(codec="utf-8"), max_size=12)
SCALAR = (
    st.none()
    | st.booleans()
    | st.integers(-(2**53), 2**53)
    | st.floats(allow_nan=False, allow_infinity=False)
)
JSON = st.recursive(
    SCALAR | TEXT,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXT, inner, max_size=3),
    max_leaves=8,
)


@given(st.dictionaries(TEXT.filter(lambda key: key != "crc32"), JSON, max_size=5))
def test_metadata_comes_back_with_its_types(values: dict[str, object]) -> None:
    texts = metadata.to_strings(values)
    assert all(isinstance(text, str) for text in texts.values())
    assert metadata.from_strings(texts) == values


@pytest.mark.parametrize("text", ["5", "null", "true", '"quoted"', "plain", "", "[1, 2]"])
def test_metadata_text_stays_text(text: str) -> None:
    assert metadata.from_strings(metadata.to_strings({"note": text})) == {"note": text}


def test_metadata_that_was_tampered_with_is_not_believed() -> None:
    texts = metadata.to_strings({"speed": 0.131})
    assert metadata.from_strings({**texts, "speed": "0.231"}) is None


def test_the_caller_may_reuse_its_arrays(tmp_path: Path) -> None:
    buffer = np.zeros(5)
    with RunWriter(tmp_path / "run", ROBOT) as writer:
        for i in range(20):
            buffer[:] = i
            writer.tick(Tick(i, i * 0.01, START_NS, buffer, buffer))
    np.testing.assert_array_equal(read_log(writer.path).sent_rad[:, 2], np.arange(20))


def test_strided_and_single_precision_arrays_are_taken(tmp_path: Path) -> None:
    wide = np.arange(10.0)
    single = np.linspace(0, 1, 5, dtype=np.float32)
    tick = Tick(0, 0.0, START_NS, wide[::2], single)  # type: ignore[arg-type]  # callers do
    log = read_log(write_ticks(tmp_path / "run", [tick]))
    np.testing.assert_array_equal(log.setpoint_rad[0], wide[::2])
    np.testing.assert_allclose(log.sent_rad[0], single, rtol=1e-7)


def test_a_tick_recorded_late_stands_in_its_place(tmp_path: Path) -> None:
    ticks = make_ticks(6)
    log = read_log(write_ticks(tmp_path / "run", [ticks[i] for i in (0, 1, 3, 4, 2, 5)]))
    np.testing.assert_array_equal(log.sequence, range(6))
    assert_equals_ticks(log, ticks)


def test_a_wall_clock_set_back_does_not_disorder_the_log(tmp_path: Path) -> None:
    ticks = make_ticks(10)
    for tick in ticks[5:]:
        tick.host_time_ns -= 3_600_000_000_000
    log = read_log(write_ticks(tmp_path / "run", ticks))
    np.testing.assert_array_equal(log.sequence, range(10))
    assert_equals_ticks(log, ticks)


def test_wrong_joint_count_is_refused(tmp_path: Path) -> None:
    with (
        RunWriter(tmp_path / "run", ROBOT) as writer,
        pytest.raises(LogError, match="tick 7 has 4 values for 5"),
    ):
        writer.tick(Tick(7, 0.0, 0, np.zeros(5), np.zeros(5), measured_rad=np.zeros(4)))


def test_a_log_is_never_overwritten(tmp_path: Path) -> None:
    path = write_ticks(tmp_path / "run", make_ticks(3))
    before = path.read_bytes()
    with pytest.raises(LogError, match="exists already"):
        RunWriter(path, ROBOT)
    (tmp_path / "other.mcap.part").write_bytes(b"somebody's")
    with pytest.raises(LogError, match="exists already"):
        RunWriter(tmp_path / "other", ROBOT)
    assert path.read_bytes() == before
    assert (tmp_path / "other.mcap.part").read_bytes() == b"somebody's"


def test_a_file_that_takes_the_name_in_mid_run_stays(tmp_path: Path) -> None:
    writer = RunWriter(tmp_path / "run", ROBOT)
    writer.tick(make_ticks(1)[0])
    (tmp_path / "run.mcap").write_bytes(b"somebody's")
    (tmp_path / "run-2.mcap").symlink_to(tmp_path / "nowhere")
    with pytest.warns(UserWarning, match=r"run.mcap: appeared while the run went on, .* in .*run-3.mcap"):
        assert writer.close() == tmp_path / "run-3.mcap"
    assert writer.path == tmp_path / "run-3.mcap"
    assert read_log(writer.path).t_s.size == 1
    assert (tmp_path / "run.mcap").read_bytes() == b"somebody's"
    assert {file.name for file in tmp_path.iterdir()} == {"run.mcap", "run-2.mcap", "run-3.mcap"}


def test_an_unfinished_log_that_is_removed_in_mid_run_is_an_error_of_output(tmp_path: Path) -> None:
    writer = RunWriter(tmp_path / "run", ROBOT)
    writer.tick(make_ticks(1)[0])
    writer.part_path.unlink()
    with pytest.raises(
        LogError, match=r"run\.mcap: cannot finish the log: somebody has removed .*run\.mcap\.part"
    ):
        writer.close()
    assert not list(tmp_path.iterdir())


def test_runs_that_begin_at_one_time_each_get_a_log(tmp_path: Path) -> None:
    """All of them found the same name free."""
    path = new_log_path("run", tmp_path, datetime(2026, 11, 21, tzinfo=UTC))
    together = threading.Barrier(8)

    def one(number: int) -> Path:
        together.wait()
        with RunWriter(path, ROBOT, {"number": number}, or_numbered=True) as writer:
            writer.tick(make_ticks(1)[0])
        return writer.path

    with ThreadPoolExecutor(8) as pool:
        paths = list(pool.map(one, range(8)))
    assert len(set(paths)) == 8
    assert [read_log(path).metadata["number"] for path in paths] == list(range(8))
    assert {file.name for file in tmp_path.iterdir()} == {path.name for path in paths}


def test_a_name_is_taken_though_its_owner_has_finished_since(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another run's file was there when ours was to be made, and has its final name a moment later."""
    make = os.open

    def too_late(path: Path, flags: int, *how: int) -> int:
        if Path(path).name == "run.mcap.part":
            (tmp_path / "run.mcap").write_bytes(b"somebody's")
            raise FileExistsError(errno.EEXIST, "File exists")
        return make(path, flags, *how)

    monkeypatch.setattr(os, "open", too_late)
    with RunWriter(tmp_path / "run.mcap", ROBOT, or_numbered=True) as writer:
        writer.tick(make_ticks(1)[0])
    assert writer.path == tmp_path / "run-2.mcap"
    assert (tmp_path / "run.mcap").read_bytes() == b"somebody's"


@pytest.mark.parametrize("number", [errno.EPERM, errno.EOPNOTSUPP])
def test_a_name_is_taken_without_links_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    """FAT, and some network drives, have none."""

    def no_links(*_: object, **__: object) -> None:
        raise OSError(number, "no links here")

    monkeypatch.setattr(os, "link", no_links)
    writer = RunWriter(tmp_path / "run", ROBOT)
    (tmp_path / "run.mcap").write_bytes(b"somebody's")
    with pytest.warns(UserWarning, match=r"run-2.mcap"):
        writer.close()
    assert (tmp_path / "run.mcap").read_bytes() == b"somebody's"
    assert read_log(tmp_path / "run-2.mcap").complete
    assert len(list(tmp_path.iterdir())) == 2


def test_a_run_that_is_forgotten_leaves_nothing(tmp_path: Path) -> None:
    writer = RunWriter(tmp_path / "run", ROBOT)
    writer.tick(make_ticks(1)[0])
    writer.discard()
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(LogError, match="closed"):
        writer.pose(PoseRecord(0, 0, 0, 0))


def test_a_folder_that_cannot_be_made_is_one_clear_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(LogError, match="cannot make the log"):
        RunWriter(tmp_path / "file" / "run", ROBOT)


def test_closing_leaves_the_final_name_only(tmp_path: Path) -> None:
    path = write_ticks(tmp_path / "run.mcap", make_ticks(10))
    assert [file.name for file in tmp_path.iterdir()] == ["run.mcap"]
    assert path == tmp_path / "run.mcap"
    writer = RunWriter(tmp_path / "second", ROBOT)
    writer.close()
    with pytest.raises(LogError, match="closed"):
        writer.pose(PoseRecord(0, 0, 0, 0))


def test_an_exception_in_the_run_still_closes_the_log(tmp_path: Path) -> None:
    writer = RunWriter(tmp_path / "run", ROBOT)
    writer.tick(make_ticks(1)[0])
    with pytest.raises(RuntimeError, match="cable"), writer:
        raise RuntimeError("cable")
    assert len(read_log(tmp_path / "run.mcap").sequence) == 1


def test_no_thread_is_left_behind(tmp_path: Path) -> None:
    write_ticks(tmp_path / "run", make_ticks(3))
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("runlog")]


def test_an_unfinished_log_is_read_as_it_is(tmp_path: Path) -> None:
    ticks = make_ticks(500)
    writer = RunWriter(tmp_path / "run", ROBOT, start_time_ns=START_NS, flush_s=0.01)
    for tick in ticks:
        writer.tick(tick)
    flushed(writer)
    log = read_log(writer.part_path)
    assert not log.complete
    assert log.problems == ()
    assert len(log.sequence) == 500
    assert_equals_ticks(log, ticks)
    writer.close()


def test_an_error_of_the_disk_comes_up_at_the_next_call(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    writer = RunWriter(tmp_path / "run", ROBOT, start_time_ns=START_NS, flush_s=0.01)
    ticks = make_ticks(200)
    for tick in ticks[:100]:
        writer.tick(tick)
    flushed(writer)
    real_write = os.write
    calls = []

    def disk_that_fills_up(file: int, data: bytes) -> int:
        calls.append(len(data))
        if len(calls) == 1:
            return real_write(file, bytes(data)[:100])  # a torn chunk
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "write", disk_that_fills_up)
    with pytest.raises(LogError, match="No space left on device") as caught:
        _tick_slowly(writer, ticks[100:])
    monkeypatch.undo()
    assert "\n" not in str(caught.value)
    assert writer.close() == writer.part_path
    log = read_log(writer.part_path)
    assert log.problems == ()
    np.testing.assert_array_equal(log.sequence, range(100))
    assert_equals_ticks(log, ticks)


def _tick_slowly(writer: RunWriter, ticks: list[Tick]) -> None:
    for tick in ticks:
        writer.tick(tick)
        time.sleep(0.01)


def test_names_are_utc_time_and_gait_and_never_twice(tmp_path: Path) -> None:
    now = datetime(2026, 11, 21, 8, 15, 30, tzinfo=UTC)
    label = gait_label(Gait.from_degrees(66, 80, 2))
    first = new_log_path(label, tmp_path, now)
    assert first.name == "20261121T081530Z_a66_b80_w2.mcap"
    first.with_name(first.name + ".part").touch()
    second = new_log_path(label, tmp_path, now)
    assert second.name == "20261121T081530Z_a66_b80_w2-2.mcap"
    second.touch()
    assert new_log_path(label, tmp_path, now).name.endswith("w2-3.mcap")
    assert new_log_path("../../etc/x y", tmp_path, now).parent == tmp_path


def test_gaits_go_through_their_mapping() -> None:
    gait = Gait.from_degrees(66, 80, 2, -3.5)
    mapping = gait_to_mapping(gait)
    assert mapping == {"alpha_deg": 66.0, "beta_deg": 80.0, "omega_rad_s": 2.0, "offset_deg": -3.5}


def test_events_carry_numpy_and_odd_keys(tmp_path: Path) -> None:
    with RunWriter(tmp_path / "run", ROBOT) as writer:
        data = {"where": np.float32(0.5), "joints": (1, 2), "raw": b"\x01", "path": Path("x")}
        writer.event(Event(0.0, "fault", "joint 3 hot", "error", data))
    event = read_log(writer.path).events[0]
    assert event.level == "error"
    assert event.data == {"where": 0.5, "joints": [1, 2], "raw": "01", "path": "x"}


def test_what_json_cannot_carry_becomes_text_not_an_error(tmp_path: Path) -> None:
    with RunWriter(
        tmp_path / "run", ROBOT, {"huge": 10**30, "notes": "caf\udce9", "deep": ["\udcff"]}
    ) as writer:
        writer.event(Event(0.0, "odd", "caf\udce9", data={"huge": 10**30, "fine": 1}))
    log = read_log(writer.path)
    assert log.metadata["huge"] == str(10**30)
    assert log.metadata["notes"] == log.events[0].message == "caf\\udce9"
    assert log.events[0].data["huge"] == str(10**30)


def test_a_caller_that_never_waits_gives_way_to_the_log(tmp_path: Path) -> None:
    """As a loop in virtual time does: what is not yet written stays within bounds."""
    tick = make_ticks(1)[0]
    with RunWriter(tmp_path / "run.mcap", ROBOT) as writer:
        most = 0
        for _ in range(40_000):
            writer.tick(tick)
            most = max(most, writer.waiting_bytes)
    assert most < 4 << 20
    assert len(read_log(tmp_path / "run.mcap").sequence) == 40_000


def test_a_disk_that_hangs_does_not_hold_the_caller_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hung, go_on = threading.Event(), threading.Event()
    write = os.write

    def hang(file: int, data: bytes) -> int:
        if len(data) > 10_000:
            hung.set()
            go_on.wait(30)
        return write(file, data)

    tick = make_ticks(1)[0]
    with RunWriter(tmp_path / "run.mcap", ROBOT) as writer:
        monkeypatch.setattr(os, "write", hang)
        while not hung.is_set():
            writer.tick(tick)
        time.sleep(0.3)
        slept: list[float] = []
        monkeypatch.setattr(time, "sleep", slept.append)
        while writer.waiting_bytes < 3 << 20:
            writer.tick(tick)
        go_on.set()
    assert slept == []
