"""Reads a run log, finished or not, into numpy arrays.

JSON is decoded a few MiB at a time (one call of orjson for thousands of messages), so that memory is bounded by the
arrays and not by the objects they are made from.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import orjson
from numpy.typing import NDArray

from snakebot.errors import BadInputError, LogError
from snakebot.robot import Robot, robot_from_mapping
from snakebot.runlog import channels
from snakebot.runlog.channels import EVENTS, FRAMES, JOINTS, LINK, POSE
from snakebot.runlog.container import Container, Message
from snakebot.runlog.finish import merge_metadata
from snakebot.runlog.log import RunLog
from snakebot.runlog.records import Event, RawFrame
from snakebot.runlog.safe_yaml import load_yaml

BATCH_BYTES = 8 << 20
ROBOT_ATTACHMENT = "robot.yaml"


class LogWarning(UserWarning):
    """A log or session could be read, but not all of it is as it should be."""


def read_log(path: str | os.PathLike[str]) -> RunLog:
    """Read a finished log, an unfinished ``.part``, or a damaged one as far as its checksums hold.

    What was left out is in ``RunLog.problems`` and told by one ``LogWarning``; a row that is returned is as written.

    Raises:
        LogError: no log of snakebot, or one that would need more memory than any log does.
    """
    container = Container(Path(path))
    tables: dict[str, Table] = {
        JOINTS.topic: JointsTable(),
        POSE.topic: PoseTable(),
        EVENTS.topic: Table(),
        LINK.topic: Table(),
        FRAMES.topic: Table(),
    }
    stray = 0
    try:
        for message in container.messages():
            table = tables.get(container.topics.get(message.channel_id, ""))
            if table is None:
                stray += 1
            else:
                table.add(message)
        for table in tables.values():
            table.decode()
        return _assemble(container, tables, stray)
    except (KeyError, TypeError, ValueError, OverflowError, AttributeError) as error:
        raise LogError(
            f"{path}: a message does not fit its schema ({type(error).__name__}: {error})"
        ) from None


class Table:
    """The messages of one channel: bytes until a batch is full, then arrays (here: decoded rows as they are)."""

    def __init__(self) -> None:
        self.pending: list[bytes] = []
        self.sequence: list[int] = []
        self.publish_ns: list[int] = []
        self.size = 0
        self.rows: list[Any] = []

    def add(self, message: Message) -> None:
        self.pending.append(message.data)
        self.sequence.append(message.sequence)
        self.publish_ns.append(message.publish_time_ns)
        self.size += len(message.data)
        if self.size > BATCH_BYTES:
            self.decode()

    def decode(self) -> None:
        if self.pending:
            rows = orjson.loads(b"[" + b",".join(self.pending) + b"]")
            if len(rows) != len(self.pending):
                raise ValueError("not one JSON object a message")
            self.store(rows)
            self.pending, self.size = [], 0

    def store(self, rows: list[Any]) -> None:
        self.rows.extend(rows)


class JointsTable(Table):
    SCALARS = ("t_s", "board_time_us", "latency_s", "sequence")
    VECTORS = ("setpoint_rad", "sent_rad", "applied_rad", "measured_rad")

    def __init__(self) -> None:
        super().__init__()
        self.parts: dict[str, list[NDArray[Any]]] = {
            name: [] for name in (*self.SCALARS, *self.VECTORS, "late")
        }

    def store(self, rows: list[Any]) -> None:
        nothing = [None] * len(rows[0]["setpoint_rad"])
        for name in self.SCALARS:
            kind = np.int64 if name == "sequence" else np.float64
            self.parts[name].append(np.array([row[name] for row in rows], dtype=kind))
        for name in self.VECTORS:
            values = [nothing if row[name] is None else row[name] for row in rows]
            array = np.array(values, dtype=np.float64)
            if array.shape != (len(rows), len(nothing)):
                raise ValueError(f"{name} differs in length")
            self.parts[name].append(array)
        self.parts["late"].append(np.array([row["late"] is True for row in rows], dtype=np.bool_))

    def column(self, name: str) -> NDArray[Any]:
        return np.concatenate(self.parts[name])


class PoseTable(Table):
    NAMES = ("t_s", "x_m", "y_m", "heading_rad", "speed_m_s")

    def __init__(self) -> None:
        super().__init__()
        self.parts: list[NDArray[np.float64]] = []

    def store(self, rows: list[Any]) -> None:
        self.parts.append(
            np.array([[row[name] for name in self.NAMES] for row in rows], dtype=np.float64).reshape(-1, 5)
        )

    def array(self) -> NDArray[np.float64]:
        return np.concatenate(self.parts) if self.parts else np.empty((0, 5))


def _assemble(container: Container, tables: dict[str, Any], stray: int) -> RunLog:
    if container.profile != channels.PROFILE:
        raise LogError(f"{container.path}: an MCAP file, but not a run log of snakebot")
    metadata, damaged = merge_metadata(container)
    problems = [*container.problems, *damaged]
    if stray:
        problems.append(f"{stray} messages on unknown channels: left out")
    attachments = {name: item.data for name, item in container.attachments.items()}
    joints_table: JointsTable = tables[JOINTS.topic]
    robot = _robot(container.path, attachments, metadata, joints_table, problems)
    if joints_table.parts["t_s"]:
        column = {name: joints_table.column(name) for name in joints_table.parts}
    else:
        column = {name: np.empty(0) for name in JointsTable.SCALARS}
        column.update({name: np.empty((0, robot.joints)) for name in JointsTable.VECTORS})
    if column["setpoint_rad"].shape[1] != robot.joints:
        raise ValueError(f"{column['setpoint_rad'].shape[1]} joints recorded, the robot has {robot.joints}")
    pose = tables[POSE.topic].array()
    link_t_s, link = _link(tables[LINK.topic].rows)
    if problems:
        shown = "; ".join(problems[:3]) + (f"; and {len(problems) - 3} more" if len(problems) > 3 else "")
        warnings.warn(f"{container.path}: {shown}", LogWarning, stacklevel=3)
    return RunLog(
        path=container.path,
        robot=robot,
        metadata=metadata,
        attachments=attachments,
        complete=container.complete,
        problems=tuple(problems),
        sequence=column["sequence"].astype(np.int64),
        t_s=column["t_s"],
        host_time_ns=np.array(joints_table.publish_ns, dtype=np.uint64).astype(np.int64),
        setpoint_rad=column["setpoint_rad"],
        sent_rad=column["sent_rad"],
        applied_rad=column["applied_rad"],
        measured_rad=column["measured_rad"],
        board_time_us=column["board_time_us"],
        latency_s=column["latency_s"],
        late=column.get("late", np.empty(0)).astype(np.bool_),
        pose_t_s=pose[:, 0],
        pose=pose[:, 1:4],
        pose_speed_m_s=pose[:, 4],
        events=tuple(_events(tables[EVENTS.topic].rows)),
        link_t_s=link_t_s,
        link=link,
        frames=tuple(
            RawFrame(float(row["t_s"]), row["direction"], int(row["id"]), bytes.fromhex(row["data"]))
            for row in tables[FRAMES.topic].rows
        ),
    )


def _robot(
    path: Path,
    attachments: dict[str, bytes],
    metadata: dict[str, Any],
    joints_table: JointsTable,
    problems: list[str],
) -> Robot:
    """The attached description, or, where that is damaged, a bench with as many joints as the rows have."""
    where = f"{path}: {ROBOT_ATTACHMENT}"
    if ROBOT_ATTACHMENT in attachments:
        try:
            return robot_from_mapping(load_yaml(attachments[ROBOT_ATTACHMENT], where), where)
        except BadInputError as error:
            raise LogError(str(error)) from None
    problems.append("the robot's description is missing")
    vectors = joints_table.parts["setpoint_rad"]
    joints = vectors[0].shape[1] if vectors else metadata.get("joints", 1)
    return robot_from_mapping({"joints": joints}, where)


def _events(rows: list[Any]) -> Iterator[Event]:
    for row in rows:
        yield Event(
            t_s=float(row["t_s"]),
            kind=str(row["kind"]),
            message=str(row["message"]),
            level=channels.level_name(row["level"]),  # type: ignore[arg-type]
            data=dict(row["data"]),
        )


def _link(rows: list[Any]) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    names = {str(name) for row in rows for name in row["counters"]}
    t_s = np.array([row["t_s"] for row in rows], dtype=np.float64)
    return t_s, {
        name: np.array([row["counters"].get(name) for row in rows], dtype=np.float64)
        for name in sorted(names)
    }
