"""Damaged and hostile logs: a documented error or fewer rows, never a wrong row, never without bound."""

from __future__ import annotations

import dataclasses
import functools
import struct
import tempfile
import tracemalloc
import warnings
import zlib
from pathlib import Path

import numpy as np
import orjson
import pytest
import zstandard
from hypothesis import example, given, settings
from hypothesis import strategies as st
from mcap.writer import CompressionType, Writer
from runlog_samples import ROBOT, START_NS, assert_equals_ticks, flushed, make_ticks
from samples import sample

from snakebot.errors import LogError, UnreadableLogError
from snakebot.runlog import LogWarning, PoseRecord, RunLog, RunWriter, metadata, read_log
from snakebot.runlog.channels import CHANNELS, JOINTS
from snakebot.runlog.finish import finish
from snakebot.runlog.listing import summarize
from snakebot.runlog.merging import merge_speed
from snakebot.runlog.part_file import metadata_record
from snakebot.runlog.replaying import recorded_setpoints

TICKS = make_ticks(240)


@functools.cache
def _whole(form: str) -> bytes:
    """A log of several chunks, as a ``.part`` or finished."""
    with tempfile.TemporaryDirectory() as folder:
        writer = RunWriter(Path(folder) / "run", ROBOT, {"note": "x"}, start_time_ns=START_NS, flush_s=60)
        for tick in TICKS:
            writer.tick(tick)
            writer.pose(PoseRecord(tick.t_s, tick.sequence * 0.01, 0.5, 0.25, 0.1))
        writer.add_metadata({"ended": "finished"})
        flushed(writer)
        part = writer.part_path.read_bytes()
        writer.close()
        return part if form == "part" else writer.path.read_bytes()


def _read(data: bytes) -> RunLog | None:
    """The log, or None where the documented error was raised; any other error fails the test."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        path.write_bytes(data)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", LogWarning)
            try:
                return read_log(path)
            except LogError as error:
                said = str(error)
    assert "\n" not in said
    return None


def _no_wrong_row(log: RunLog | None) -> None:
    if log is None:
        return
    assert_equals_ticks(log, TICKS)
    assert len(set(log.sequence.tolist())) == len(log.sequence)
    known = {round(tick.t_s, 9): tick.sequence * 0.01 for tick in TICKS}
    for t_s, pose in zip(log.pose_t_s.tolist(), log.pose.tolist(), strict=True):
        assert pose == [known[round(t_s, 9)], 0.5, 0.25]
    assert log.metadata.get("note", "x") == "x"
    assert log.metadata.get("ended", "finished") == "finished"
    assert log.robot.joints == 5


FORMS = st.sampled_from(["part", "finished"])


PLACE = st.floats(0, 1, exclude_max=True)


@settings(max_examples=100, deadline=None)
@given(FORMS, PLACE, st.integers(1, 255))
def test_a_changed_byte_never_makes_a_wrong_row(form: str, place: float, change: int) -> None:
    _change_a_byte(form, place, change)


@pytest.mark.slow
@pytest.mark.timeout(600)
@settings(max_examples=sample(1500, 500), deadline=None)
@given(FORMS, PLACE, st.integers(1, 255))
def test_hundreds_of_changed_bytes_and_more_never_make_a_wrong_row(
    form: str, place: float, change: int
) -> None:
    _change_a_byte(form, place, change)


def _change_a_byte(form: str, place: float, change: int) -> None:
    data = bytearray(_whole(form))
    data[int(place * len(data))] ^= change
    _no_wrong_row(_read(bytes(data)))


@settings(max_examples=60, deadline=None)
@given(FORMS, st.floats(0, 1), st.floats(0, 0.2), st.binary(max_size=40), st.booleans())
def test_stretches_lost_doubled_or_overwritten(
    form: str, place: float, share: float, new: bytes, keep: bool
) -> None:
    data = _whole(form)
    start = int(place * len(data))
    stop = start if keep else start + int(share * len(data))
    log = _read(data[:start] + new + data[stop:])
    _no_wrong_row(log)


@settings(max_examples=50, deadline=None)
@given(st.floats(0, 1))
@example(0.0)
@example(1.0)
def test_cut_anywhere_keeps_all_chunks_before_the_cut(place: float) -> None:
    data = _whole("part")
    log = _read(data[: int(place * len(data))])
    _no_wrong_row(log)
    if log is not None:
        np.testing.assert_array_equal(log.sequence, range(len(log.sequence)))


def test_one_damaged_chunk_costs_that_chunk_only(tmp_path: Path) -> None:
    data = bytearray(_whole("part"))
    at = data.index(b'"sequence":60,')
    data[at + 12] ^= 1  # 60 -> 70: JSON still, and wrong
    (tmp_path / "run.mcap.part").write_bytes(data)
    with pytest.warns(LogWarning, match="damaged chunk"):
        log = read_log(tmp_path / "run.mcap.part")
    _no_wrong_row(log)
    assert 60 not in log.sequence
    assert 120 < len(log.sequence) < 240
    assert log.sequence[-1] == 239


def test_a_damaged_log_can_be_finished(tmp_path: Path) -> None:
    data = bytearray(_whole("part"))
    data[data.index(b'"sequence":60,') + 12] ^= 1
    (tmp_path / "run.mcap.part").write_bytes(data)
    problems = finish(tmp_path / "run.mcap.part", tmp_path / "run.mcap").problems
    assert any("damaged chunk" in problem for problem in problems)
    log = read_log(tmp_path / "run.mcap")
    assert log.complete
    assert log.problems == ()
    assert 120 < len(log.sequence) < 240
    _no_wrong_row(log)


@pytest.mark.parametrize(
    "data", [b"", b"\x89MCAP0\r\n", b"t_s,cmd_1_rad\n", bytes(5000), b"\x89MCAP0\r\n" + bytes(99)]
)
def test_what_is_no_log_is_refused(data: bytes) -> None:
    assert _read(data) is None


def test_another_programs_mcap_is_refused(tmp_path: Path) -> None:
    with (tmp_path / "other.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2", library="x")
        writer.finish()
    with pytest.raises(LogError, match="not a run log of snakebot"):
        read_log(tmp_path / "other.mcap")


def _forged(messages: list[tuple[int, bytes]], path: Path) -> Path:
    """A log with correct checksums whose messages are a stranger's."""
    with path.open("wb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start(profile="snakebot", library="x")
        for channel in CHANNELS:
            schema = writer.register_schema(channel.schema_name, "jsonschema", channel.schema)
            writer.register_channel(channel.topic, "json", schema)
        for number, data in messages:
            writer.add_message(number, 1, data, 1, 0)
        writer.add_metadata("run", metadata.to_strings({"joints": 1}))
        writer.finish()
    return path


ROW = {
    "t_s": 0.0,
    "sequence": 0,
    "setpoint_rad": [0.0],
    "sent_rad": [0.0],
    "applied_rad": None,
    "measured_rad": None,
}
ROW |= {"board_time_us": None, "latency_s": None, "late": False}


@pytest.mark.parametrize(
    "change",
    [
        {"setpoint_rad": "x"},
        {"setpoint_rad": []},
        {"setpoint_rad": [[0.0]]},
        {"setpoint_rad": {"a": 1}},
        {"sent_rad": [0.0, 1.0]},
        {"measured_rad": 3.0},
        {"t_s": "soon"},
        {"sequence": 10**30},
        {"sequence": None},
        {"board_time_us": [1]},
    ],
)
def test_rows_that_do_not_fit_their_schema_are_an_error(tmp_path: Path, change: dict[str, object]) -> None:
    good = orjson.dumps(ROW)
    bad = str({**ROW, **change}).replace("'", '"').replace("None", "null").replace("False", "false").encode()
    with pytest.raises(LogError, match="does not fit its schema"):
        read_log(_forged([(JOINTS.id, good), (JOINTS.id, bad)], tmp_path / "a.mcap"))


@pytest.mark.parametrize(
    "bad", [b"", b"{}", b"[]", b"null", b'{"t_s": 0', b"{},{}", b"\xff", b"[" * 5000, b'"x"', b"1"]
)
@pytest.mark.parametrize("channel", CHANNELS, ids=lambda channel: channel.topic)
def test_messages_that_are_nonsense_are_an_error(tmp_path: Path, bad: bytes, channel: object) -> None:
    path = _forged([(channel.id, bad)], tmp_path / "a.mcap")  # type: ignore[attr-defined]
    with pytest.raises(LogError, match="does not fit its schema"):
        read_log(path)


def _peak_bytes(path: Path) -> int:
    tracemalloc.start()
    try:
        with pytest.raises(LogError):
            read_log(path)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def _start() -> bytes:
    """Magic, header and a metadata record: a log without a tick."""
    data = _whole("part")
    return data[: 8 + 9 + struct.unpack_from("<Q", data, 9)[0]] + metadata_record({"joints": 1})


def _chunk_record(size: int, stored: bytes, crc: int = 0) -> bytes:
    body = struct.pack("<QQQII4sQ", 0, 0, size, crc, 4, b"zstd", len(stored)) + stored
    return struct.pack("<BQ", 6, len(body)) + body


def test_a_chunk_that_lies_about_its_size_is_not_unpacked(tmp_path: Path) -> None:
    start = _start()
    bomb = zstandard.ZstdCompressor().compress(bytes(300 << 20))
    for size in (300 << 20, 1 << 62, 1000):
        path = tmp_path / f"{size}.mcap"
        path.write_bytes(start + _chunk_record(size, bomb))
        if size == 1000:
            with pytest.warns(LogWarning, match="damaged chunk"):
                assert len(read_log(path).sequence) == 0
        else:
            assert _peak_bytes(path) < 8 << 20


def test_many_small_bombs_are_not_unpacked_either(tmp_path: Path) -> None:
    start = _start()
    zeros = bytes(32 << 20)
    one = _chunk_record(len(zeros), zstandard.ZstdCompressor().compress(zeros), zlib.crc32(zeros))
    path = tmp_path / "bombs.mcap"
    path.write_bytes(start + one * 200)
    with pytest.raises(LogError):
        read_log(path)


def test_a_record_longer_than_the_file_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "long.mcap"
    path.write_bytes(_start() + struct.pack("<BQ", 6, 1 << 60) + b"abc")
    with pytest.warns(LogWarning, match="cut short or damaged"):
        assert len(read_log(path).sequence) == 0


NASTY: list[object] = ["soon", None, [], {}, True, 1e308, -1, 10**30]


@pytest.mark.parametrize("value", NASTY, ids=repr)
def test_metadata_of_the_wrong_kind_is_put_up_with(tmp_path: Path, value: object) -> None:
    keys = (
        "start_time_ns",
        "rate_hz",
        "ramp_s",
        "forward_speed_m_s",
        "simulated",
        "faults",
        "notes",
        "joints",
    )
    with RunWriter(tmp_path / "run", ROBOT, start_time_ns=START_NS) as writer:
        writer.add_metadata(dict.fromkeys(keys, value))
        for tick in TICKS[:20]:
            tick = dataclasses.replace(tick, setpoint_rad=np.zeros(5))
            writer.tick(tick)
    run = read_log(writer.path).to_run()
    assert len(run) == 20
    merge_speed(writer.path, 0.1)
    assert read_log(writer.path).forward_speed_m_s == 0.1
    recorded_setpoints(read_log(writer.path))
    assert summarize(writer.path).ticks == 20


@pytest.mark.parametrize(
    "description", [b"", b"[]", b"joints: 0", b"joints: 3", b"\xff", b"joints: " + b"[" * 3000]
)
def test_a_robot_description_that_is_none_is_one_line(tmp_path: Path, description: bytes) -> None:
    with RunWriter(tmp_path / "run", ROBOT, attachments={"robot.yaml": description}) as writer:
        writer.tick(TICKS[0])
    with pytest.raises(UnreadableLogError) as error:
        read_log(writer.path)
    assert "\n" not in str(error.value)


def test_names_inside_a_log_are_never_used_as_paths(tmp_path: Path) -> None:
    with RunWriter(tmp_path / "in" / "run", ROBOT, attachments={"../../evil.txt": b"x"}) as writer:
        writer.tick(TICKS[0])
    log = read_log(writer.path)
    assert "../../evil.txt" in log.attachments
    assert [path.name for path in tmp_path.rglob("*") if path.is_file()] == ["run.mcap"]
