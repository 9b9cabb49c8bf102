"""Other people's readers see what ours sees: the mcap package, pandas, and @mcap/core with checksums on."""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.exceptions import EndOfFile
from mcap.reader import NonSeekingReader, make_reader
from runlog_samples import ROBOT, START_NS, flushed, make_ticks, write_everything

from snakebot.runlog import RunWriter, read_log
from snakebot.runlog.channels import CHANNELS, JOINTS, POSE
from snakebot.runlog.finish import finish

CHECKER = Path(__file__).with_name("check_crc.mjs")


def _unfinished(path: Path) -> Path:
    """A ``.part`` with a torn end, as a killed process leaves it."""
    writer = RunWriter(path, ROBOT, {"note": "killed"}, start_time_ns=START_NS)
    for tick in make_ticks(300, seed=3):
        writer.tick(tick)
    flushed(writer)
    data = writer.part_path.read_bytes()
    writer.close()
    path.unlink()
    writer.part_path.write_bytes(data[:-1000])
    return writer.part_path


def _floats(values: list[float | None] | None, joints: int = 5) -> list[float]:
    if values is None:
        return [np.nan] * joints
    return [np.nan if value is None else value for value in values]


def test_the_mcap_package_reads_the_same(tmp_path: Path) -> None:
    path = write_everything(tmp_path / "run.mcap", count=400)
    log = read_log(path)
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        rows = [(json.loads(m.data), m) for _, _, m in reader.iter_messages(topics=[JOINTS.topic])]
        poses = [json.loads(m.data) for _, _, m in reader.iter_messages(topics=[POSE.topic])]
        summary = reader.get_summary()
        attachments = {item.name: item.data for item in reader.iter_attachments()}
        about = {item.name: item.metadata for item in reader.iter_metadata()}
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == 400 + 400 + 1 + 1 + 2 + 1 + 1
    np.testing.assert_array_equal([row["t_s"] for row, _ in rows], log.t_s)
    np.testing.assert_array_equal([row["sequence"] for row, _ in rows], log.sequence)
    np.testing.assert_array_equal([message.sequence for _, message in rows], log.sequence)
    np.testing.assert_array_equal([message.publish_time for _, message in rows], log.host_time_ns)
    for name in ("setpoint_rad", "sent_rad", "applied_rad", "measured_rad"):
        np.testing.assert_array_equal([_floats(row[name]) for row, _ in rows], getattr(log, name))
    for name in ("board_time_us", "latency_s"):
        wanted = [np.nan if row[name] is None else row[name] for row, _ in rows]
        np.testing.assert_array_equal(wanted, getattr(log, name))
    np.testing.assert_array_equal([row["late"] for row, _ in rows], log.late)
    np.testing.assert_array_equal([pose["pose"]["position"]["x"] for pose in poses], log.pose[:, 0])
    np.testing.assert_array_equal([pose["heading_rad"] for pose in poses], log.pose[:, 2])
    assert attachments == dict(log.attachments)
    assert about["run"]["port"] == "sim:"
    assert json.loads(about["run"]["gait"]) == log.metadata["gait"]


def test_the_mcap_package_reads_an_unfinished_log(tmp_path: Path) -> None:
    writer = RunWriter(tmp_path / "run", ROBOT, start_time_ns=START_NS)
    for tick in make_ticks(50):
        writer.tick(tick)
    flushed(writer)
    seen: list[int] = []
    with writer.part_path.open("rb") as file, pytest.raises(EndOfFile):  # by design it has no end yet
        _read_into(seen, NonSeekingReader(file, validate_crcs=True))
    assert seen == list(range(50))
    writer.close()


def _read_into(seen: list[int], reader: NonSeekingReader) -> None:
    seen.extend(message.sequence for _, _, message in reader.iter_messages(log_time_order=False))


def test_every_message_fits_its_schema(tmp_path: Path) -> None:
    import jsonschema

    schemas = {channel.topic: json.loads(channel.schema) for channel in CHANNELS}
    seen = set()
    with write_everything(tmp_path / "run.mcap").open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema is not None
            assert json.loads(schema.data) == schemas[channel.topic]
            strict = schemas[channel.topic]
            data = json.loads(message.data)
            # lost samples are null inside arrays that viewers plot as numbers
            data = {key: _known(value) if key.endswith("_rad") else value for key, value in data.items()}
            jsonschema.validate(data, {**strict, "required": list(data)})
            seen.add(channel.topic)
    assert seen == set(schemas)


def _known(value: object) -> object:
    return [v for v in value if v is not None] if isinstance(value, list) else value


def test_pandas_sees_the_same_through_every_export(tmp_path: Path) -> None:
    pd = pytest.importorskip("pandas", reason="pandas is not installed")
    from snakebot.runlog.session_write import write_table

    log = read_log(write_everything(tmp_path / "run.mcap", count=200))
    frames = {"direct": log.to_pandas()}
    for name in ("a.csv", "a.csv.gz", "a.parquet"):
        write_table(tmp_path / name, log.columns())
        read = pd.read_parquet if name.endswith("parquet") else pd.read_csv
        frames[name] = read(tmp_path / name)
    for name, frame in frames.items():
        assert len(frame) == 200, name
        for column, values in log.columns().items():
            np.testing.assert_array_equal(
                frame[column].to_numpy(dtype=values.dtype), values, err_msg=f"{name} {column}"
            )
        np.testing.assert_array_equal(frame["enc_3_rad"].to_numpy(), log.measured_rad[:, 2])
        np.testing.assert_array_equal(frame["cmd_5_rad"].to_numpy(), log.sent_rad[:, 4])


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_mcap_core_reads_the_same_with_checksums_on(tmp_path: Path) -> None:
    npm, node = shutil.which("npm"), shutil.which("node")
    if npm is None or node is None:
        pytest.skip("npm and node are not installed; @mcap/core cannot check the logs")
    tools = tmp_path / "tools"
    tools.mkdir()
    shutil.copy(CHECKER, tools)
    command = [npm, "install", "--no-audit", "--no-fund", "--silent", "@mcap/core", "@mcap/nodejs", "fzstd"]
    installed = subprocess.run(command, cwd=tools, capture_output=True, text=True)
    if installed.returncode:
        pytest.skip(f"@mcap/core cannot be installed: {installed.stderr.strip()[-200:]}")

    whole = write_everything(tmp_path / "whole.mcap", count=5000)
    recovered = tmp_path / "recovered.mcap"
    problems = finish(_unfinished(tmp_path / "torn.mcap"), recovered)
    assert problems
    done = subprocess.run([node, CHECKER.name, whole, recovered], cwd=tools, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    results = json.loads(done.stdout)
    for path in (whole, recovered):
        seen = results[str(path)]
        ours = _digests(path)
        assert seen["stream"]["topics"] == ours
        assert seen["stream"]["done"]
        assert seen["indexed"]["topics"] == ours
        assert seen["indexed"]["messages"] == sum(count for count, _ in ours.values())
        assert seen["indexed"]["metadata"] == ["run"]
        assert "robot.yaml" in seen["indexed"]["attachments"]
        assert sorted(seen["indexed"]["schemas"]) == sorted(channel.schema_name for channel in CHANNELS)
    assert ours[JOINTS.topic][0] == len(read_log(recovered).sequence) > 100

    damaged = bytearray(whole.read_bytes())
    damaged[len(damaged) // 3] ^= 1
    (tmp_path / "damaged.mcap").write_bytes(damaged)
    command = [node, CHECKER.name, str(tmp_path / "damaged.mcap")]
    assert subprocess.run(command, cwd=tools, capture_output=True).returncode != 0  # the check can fail


def _digests(path: Path) -> dict[str, list[Any]]:
    """Count and digest of the messages of each topic, through our own reading path."""
    from snakebot.runlog.container import Container

    container = Container(path)
    found: dict[str, list[bytes]] = {}
    for messages in container.chunks():
        for channel_id, _, _, _, data in messages:
            found.setdefault(container.topics[channel_id], []).append(data)
    return {topic: [len(data), hashlib.sha256(b"".join(data)).hexdigest()] for topic, data in found.items()}
