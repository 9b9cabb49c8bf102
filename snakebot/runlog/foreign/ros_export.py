"""Writes a run log as a ROS 2 bag: a folder with ``metadata.yaml`` and one MCAP file, every message in CDR."""

from __future__ import annotations

import os
import struct
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError, cannot_write
from snakebot.runlog.foreign.ros_bag import METADATA
from snakebot.runlog.foreign.ros_types import JOINT_STATE, KNOWN
from snakebot.safe_yaml import dump_yaml

if TYPE_CHECKING:
    from snakebot.runlog.log import RunLog

MEASURED, COMMAND = (
    "/joint_states",
    "/joint_commands",
)  # the first is where ros2_control's broadcaster publishes
_LATEST_NS = (1 << 31) * 1_000_000_000 - round(
    1e8 * 1e9
)  # a header's seconds have 32 bits, a run at most 1e8 s
VERSION = 5  # of the metadata: what ROS 2 Humble writes; later ones read it


def write_bag(log: RunLog, folder: Path) -> dict[str, int]:
    """Write set-points as sent, and encoders, as ``sensor_msgs/msg/JointState``; messages a topic.

    A lost sample, or a servo that is off, is nan. Joints are ``joint_1``, ...

    Raises:
        BadInputError: the folder is there already, or cannot be written; the log holds no ticks.
    """
    if os.path.lexists(folder):
        raise BadInputError(f"{folder}: exists already")
    times = _times(log)
    if not times:
        raise BadInputError(f"{log.path}: the log holds no ticks")
    counts = dict.fromkeys((MEASURED, COMMAND), len(times))
    try:
        with tempfile.TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name[:100]}.") as beside:
            made = Path(beside) / "bag"
            made.mkdir()
            file = made / f"{folder.name}_0.mcap"
            _write(file, log, times)
            text = dump_yaml(_metadata(file.name, times[0][0], times[-1][0], counts))
            (made / METADATA).write_text(text, encoding="utf-8")
            made.rename(folder)
    except OSError as error:
        raise cannot_write(f"{folder}: cannot be written", error) from None
    return counts


def _times(log: RunLog) -> list[tuple[int, int]]:
    """Wall clock in ns, and row, of every tick that has a time: the start's clock plus ``t_s``, as in the log."""
    rows = [(t, row) for row, t in enumerate(log.t_s.tolist()) if np.isfinite(t)]
    if not rows:
        return []
    start_ns = int(log.host_time_ns[rows[0][1]]) - round(rows[0][0] * 1e9)
    if not 0 <= start_ns < _LATEST_NS:
        start_ns = 0
    return [(start_ns + round(t * 1e9), row) for t, row in rows]


def _write(path: Path, log: RunLog, times: Sequence[tuple[int, int]]) -> None:
    from mcap.writer import Writer

    names = [f"joint_{number + 1}" for number in range(log.joints)]
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2", library="snakebot")
        schema = writer.register_schema(JOINT_STATE, "ros2msg", KNOWN[JOINT_STATE].encode())
        channels = [
            (writer.register_channel(topic, "cdr", schema, {"offered_qos_profiles": ""}), values)
            for topic, values in ((COMMAND, log.sent_rad), (MEASURED, log.measured_rad))
        ]
        for time_ns, row in times:
            for channel, values in channels:
                data = joint_state(time_ns, names, values[row])
                writer.add_message(channel, time_ns, data, time_ns, row)
        writer.finish()


def joint_state(stamp_ns: int, names: Sequence[str], position: Floats) -> bytes:
    """A ``JointState`` in little-endian CDR, without velocities and efforts."""
    out = bytearray(b"\0\1\0\0")
    out += struct.pack("<iI", *divmod(stamp_ns, 1_000_000_000))
    _text(out, "")
    _number(out, len(names))
    for name in names:
        _text(out, name)
    _number(out, len(position))
    if len(position):
        out += bytes(-(len(out) - 4) % 8)
        out += np.asarray(position, dtype="<f8").tobytes()
    _number(out, 0)
    _number(out, 0)
    return bytes(out)


def _number(out: bytearray, value: int) -> None:
    out += bytes(-(len(out) - 4) % 4)
    out += struct.pack("<I", value)


def _text(out: bytearray, text: str) -> None:
    raw = text.encode() + b"\0"
    _number(out, len(raw))
    out += raw


def _metadata(file: str, start_ns: int, end_ns: int, counts: dict[str, int]) -> dict[str, object]:
    span = {
        "duration": {"nanoseconds": end_ns - start_ns},
        "starting_time": {"nanoseconds_since_epoch": start_ns},
        "message_count": sum(counts.values()),
    }
    topics = [
        {
            "topic_metadata": {
                "name": topic,
                "type": JOINT_STATE,
                "serialization_format": "cdr",
                "offered_qos_profiles": "",
            },
            "message_count": count,
        }
        for topic, count in counts.items()
    ]
    return {
        "rosbag2_bagfile_information": {
            "version": VERSION,
            "storage_identifier": "mcap",
            **span,
            "topics_with_message_count": topics,
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [file],
            "files": [{"path": file, **span}],
        }
    }
