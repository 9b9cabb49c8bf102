"""A run log as a ROS 2 bag: two other libraries read what the log holds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from log_commands import Capture, snakebot
from mcap_ros2.reader import read_ros2_messages
from ros_samples import STORE
from rosbags.rosbag2 import Reader
from runlog_samples import make_ticks, write_ticks

from snakebot.runlog import read_log, read_session

TOPICS = {"/joint_states": "measured_rad", "/joint_commands": "sent_rad"}


def test_both_libraries_read_back_what_the_log_holds(tmp_path: Path, capsys: Capture) -> None:
    log = write_ticks(tmp_path / "run", make_ticks(300))
    held = read_log(log)
    snakebot(capsys, "log", "export", log, "--ros2", tmp_path / "bag")
    start_ns = int(held.host_time_ns[0]) - round(float(held.t_s[0]) * 1e9)
    times = [start_ns + round(t * 1e9) for t in held.t_s.tolist()]
    names = [f"joint_{number + 1}" for number in range(held.joints)]

    with Reader(tmp_path / "bag") as reader:
        assert reader.message_count == 600
        by_rosbags: dict[str, list[Any]] = {topic: [] for topic in TOPICS}
        for connection, time_ns, raw in reader.messages():
            message = STORE.deserialize_cdr(raw, connection.msgtype)
            stamp = message.header.stamp
            assert stamp.sec * 10**9 + stamp.nanosec == time_ns
            assert message.name == names
            assert not message.velocity.size
            by_rosbags[connection.topic].append((time_ns, message.position))
    by_foxglove: dict[str, list[Any]] = {topic: [] for topic in TOPICS}
    for read in read_ros2_messages(str(tmp_path / "bag" / "bag_0.mcap")):
        assert read.channel.message_encoding == "cdr"
        by_foxglove[read.channel.topic].append((read.log_time_ns, np.array(read.ros_msg.position)))
    for found in (by_rosbags, by_foxglove):
        for topic, name in TOPICS.items():
            assert [time for time, _ in found[topic]] == times
            values = np.stack([position for _, position in found[topic]])
            assert np.array_equal(values, getattr(held, name), equal_nan=True)

    snakebot(capsys, "session", "import", tmp_path / "bag", "-o", tmp_path / "again")
    run = read_session(tmp_path / "again").runs[0]
    assert np.array_equal(run.measured_rad, held.measured_rad, equal_nan=True)
    assert np.array_equal(run.command_rad, held.sent_rad, equal_nan=True)


def test_nothing_is_written_over_and_one_log_is_one_bag(tmp_path: Path, capsys: Capture) -> None:
    log = write_ticks(tmp_path / "run", make_ticks(5))
    (tmp_path / "taken").mkdir()
    assert "taken: exists already" in snakebot(
        capsys, "log", "export", log, "--ros2", tmp_path / "taken", status=2
    )
    assert "holds one log" in snakebot(capsys, "log", "export", log, log, "--ros2", tmp_path / "b", status=2)
    assert "cannot be written" in snakebot(
        capsys, "log", "export", log, "--ros2", tmp_path / "no" / "b", status=2
    )
    assert "give the log, then what to write" in snakebot(capsys, "log", "export", log, status=2)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run.mcap", "taken"]
