"""ROS 2 bags that the ``rosbags`` package wrote become sessions with the same numbers."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import numpy as np
import pytest
from foreign_samples import NAMES, wave
from log_commands import Capture, snakebot
from mcap_ros2.writer import Writer as McapWriter
from ros_samples import (
    ARRAY,
    CONTROLLER_STATE,
    JOINT_STATE,
    START_NS,
    TRAJECTORY,
    Row,
    array,
    bag,
    controller_state,
    joint_state,
    point,
    trajectory,
)
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Writer

from snakebot.runlog import Run, read_session
from snakebot.runlog.foreign.ros_types import KNOWN

T_S, COMMAND, MEASURED = (np.radians(values) if values.ndim > 1 else values for values in wave(100))
MEASUREMENT: list[Row] = [
    # the broadcaster's order is not that of the command
    ("/joint_states", JOINT_STATE, t, joint_state(t, NAMES[::-1], row[::-1]))
    for t, row in zip(T_S, MEASURED, strict=True)
]


def _imported(folder: Path, capsys: Capture, *options: object) -> Run:
    out = folder.parent / f"{folder.name}.session"
    snakebot(capsys, "session", "import", folder, "-o", out, *options)
    return read_session(out).runs[0]


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_joints_are_matched_by_name_and_commands_held(storage: str, tmp_path: Path, capsys: Capture) -> None:
    """Commands come at 25 Hz, a little after every second measurement, which is at 50 Hz."""
    rows: list[Row] = [
        ("/joint_commands", JOINT_STATE, t + 0.005, joint_state(t + 0.005, NAMES, row))
        for t, row in zip(T_S[::2], COMMAND[::2], strict=True)
    ]
    run = _imported(bag(tmp_path / "bag", [*MEASUREMENT, *rows], storage), capsys)
    assert run.metadata["joints"] == list(NAMES)
    assert np.array_equal(run.measured_rad, MEASURED)
    assert np.allclose(run.t_s, T_S, atol=1e-9)
    assert np.isnan(run.command_rad[0]).all(), "no command had been given"
    assert np.array_equal(run.command_rad[1::2], COMMAND[::2])
    assert np.array_equal(run.command_rad[2::2], COMMAND[:-2:2])


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
@pytest.mark.parametrize("suffix", [True, False])
def test_a_trajectory_is_a_command_at_each_of_its_points(
    storage: str, suffix: bool, tmp_path: Path, capsys: Capture
) -> None:
    """Ten points a second; a new trajectory takes the place of what the old one still had to do."""
    every = 5
    rows: list[Row] = []
    for first in range(0, 100, 4 * every):
        places = range(first, min(first + 6 * every, 100), every)
        points = [point(COMMAND[i][::-1], T_S[i] - T_S[first]) for i in places]
        rows.append(
            ("/arm/joint_trajectory", TRAJECTORY, T_S[first], trajectory(T_S[first], NAMES[::-1], points))
        )
    folder = bag(tmp_path / "bag", [*MEASUREMENT, *rows], storage)
    source = folder if suffix else next(path for path in folder.iterdir() if path.suffix in (".mcap", ".db3"))
    run = _imported(source, capsys, "--joints", ",".join(NAMES))
    assert np.array_equal(run.command_rad, COMMAND[np.arange(100) // every * every])


def test_values_without_names_are_asked_for_their_joints(tmp_path: Path, capsys: Capture) -> None:
    rows: list[Row] = [
        ("/position/commands", ARRAY, t, array(row)) for t, row in zip(T_S, COMMAND, strict=True)
    ]
    folder = bag(tmp_path / "bag", [*MEASUREMENT, *rows])
    line = snakebot(capsys, "session", "import", folder, "-o", tmp_path / "x", status=2)
    assert "/position/commands names no joints: give them in its order, --joints elbow,lift,pan" in line
    assert not (tmp_path / "x").exists()
    run = _imported(folder, capsys, "--joints", ",".join(NAMES))
    assert np.array_equal(run.command_rad, COMMAND)
    assert np.array_equal(run.measured_rad, MEASURED)


def test_the_state_of_a_controller_is_read_by_the_definition_in_the_bag(
    tmp_path: Path, capsys: Capture
) -> None:
    rows: list[Row] = [
        ("/arm/controller_state", CONTROLLER_STATE, t, controller_state(t, NAMES, command, measured))
        for t, command, measured in zip(T_S, COMMAND, MEASURED, strict=True)
    ]
    folder = bag(tmp_path / "bag", rows)
    run = _imported(folder, capsys)
    assert np.array_equal(run.command_rad, COMMAND)
    assert np.array_equal(run.measured_rad, MEASURED)
    old = bag(tmp_path / "old", rows, "sqlite3")
    database = sqlite3.connect(next(old.glob("*.db3")))
    database.execute("DROP TABLE message_definitions")
    database.commit()
    database.close()
    line = snakebot(capsys, "session", "import", old, "-o", tmp_path / "x", status=2)
    assert "holds no definition of control_msgs/msg/JointTrajectoryControllerState" in line


def test_messages_may_be_compressed_one_by_one(tmp_path: Path, capsys: Capture) -> None:
    def packed(writer: Writer) -> None:
        writer.set_compression(CompressionMode.MESSAGE, CompressionFormat.ZSTD)

    rows: list[Row] = [
        ("/cmd", JOINT_STATE, t, joint_state(t, NAMES, row)) for t, row in zip(T_S, COMMAND, strict=True)
    ]
    run = _imported(bag(tmp_path / "bag", [*MEASUREMENT, *rows], "sqlite3", packed), capsys)
    assert np.array_equal(run.command_rad, COMMAND)


def test_each_fault_is_one_line_and_nothing_is_written(tmp_path: Path, capsys: Capture) -> None:
    def told(source: Path, *options: str) -> str:
        line = snakebot(capsys, "session", "import", source, "-o", tmp_path / "out", *options, status=2)
        assert not (tmp_path / "out").exists()
        return line

    alone = bag(tmp_path / "alone", MEASUREMENT)
    assert "no topic of commands; choose with --command; there are /joint_states (sensor_msgs" in told(alone)
    assert "--command /nope: no topic of joints by that name" in told(alone, "--command", "/nope")
    commands: list[Row] = [
        (topic, JOINT_STATE, t, joint_state(t, NAMES, row))
        for topic in ("/a", "/b")
        for t, row in zip(T_S, COMMAND, strict=True)
    ]
    several = bag(tmp_path / "several", [*MEASUREMENT, *commands])
    assert "more than one topic may be the command (/a, /b)" in told(several)
    other: list[Row] = [("/a", JOINT_STATE, 0.0, joint_state(0, ["x"], np.zeros(1)))]
    assert "no joint is in both" in told(bag(tmp_path / "other", [*MEASUREMENT, *other]))
    for name, data in (("t.mcap", b"x" * 100), ("t.db3", b"x" * 100), ("e.mcap", b""), ("e.db3", b"")):
        (tmp_path / name).write_bytes(data)
        assert name in told(tmp_path / name)
    (alone / "metadata.yaml").write_text("rosbag2_bagfile_information: {relative_file_paths: [../../x.mcap]}")
    assert "x.mcap: no such file" in told(alone)
    database = sqlite3.connect(tmp_path / "view.db3")
    database.executescript("CREATE TABLE topics(id, name, type); CREATE VIEW messages AS SELECT 1 AS id")
    database.close()
    assert "it has no table messages" in told(tmp_path / "view.db3")


def test_a_bag_that_was_cut_short_is_read_as_far_as_it_goes(tmp_path: Path, capsys: Capture) -> None:
    file = tmp_path / "run.mcap"
    writer = McapWriter(str(file), chunk_size=2000)
    schema = writer.register_msgdef(JOINT_STATE, KNOWN[JOINT_STATE])
    for row, t in enumerate(T_S):
        for topic, values in (("/cmd", COMMAND), ("/joint_states", MEASURED)):
            stamp = {"sec": int(t), "nanosec": round(t % 1 * 1e9)}
            message = {"header": {"stamp": stamp, "frame_id": ""}, "name": NAMES, "position": values[row].tolist(),
                       "velocity": [], "effort": []}  # fmt: skip
            writer.write_message(topic, schema, message, log_time=START_NS + round(t * 1e9))
    writer.finish()
    whole = file.read_bytes()
    for size in (len(whole) - 60, len(whole) * 2 // 3):
        file.write_bytes(whole[:size])
        out = tmp_path / f"out{size}"
        said = snakebot(capsys, "session", "import", file, "-o", out)
        assert "cut short or damaged; read as far as it goes" in said
        run = read_session(out).runs[0]
        assert len(run) > 50
        assert np.array_equal(run.measured_rad, MEASURED[: len(run)])
    damaged = bytearray(whole)
    damaged[len(whole) // 3] ^= 0xFF
    file.write_bytes(damaged)
    assert "a damaged chunk is left out" in snakebot(
        capsys, "session", "import", file, "-o", tmp_path / "rest"
    )
