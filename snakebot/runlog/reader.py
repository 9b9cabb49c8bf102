"""Reads a run log, finished or not, into numpy arrays.

JSON is decoded about a MiB at a time (one call of orjson for thousands of messages), so that memory is bounded
by the arrays and not by the objects they are made from: an empty list takes 2 bytes in a file and 64 in memory.
"""

from __future__ import annotations

import contextlib
import gc
import os
import warnings
from abc import ABC, abstractmethod
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import orjson

from snakebot.arrays import AnyArray, Floats
from snakebot.errors import BadInputError, NothingLeftError, UnreadableLogError
from snakebot.robot import MAX_LINKS, Robot, robot_from_mapping
from snakebot.runlog.channels import (
    EVENTS,
    FRAMES,
    JOINTS,
    LINK,
    POSE,
    ROBOT_ATTACHMENT,
    STEERING,
    TELEMETRY,
    level_name,
)
from snakebot.runlog.container import Container
from snakebot.runlog.finish import merge_metadata
from snakebot.runlog.log import RunLog
from snakebot.runlog.records import Event, RawFrame
from snakebot.safe_yaml import Lines, load_yaml

MAX_NAMES = 1024  # of counters or readings: one message is one array cell for each
MAX_MESSAGE_BYTES = 1 << 20  # chosen: a message of ours has less than 10 kB
BATCH_MESSAGES = 8192  # decoded at once,
BATCH_BYTES = 1 << 20  # or fewer if they are long


class LogWarning(UserWarning):
    """A log or session could be read, but not all of it is as it should be."""


def read_log(path: str | os.PathLike[str]) -> RunLog:
    """Read a finished log, an unfinished ``.part``, or a damaged one as far as its checksums hold.

    What was left out is in ``RunLog.problems`` and told by one ``LogWarning``; a row that is returned is as
    written. A ``.part`` is not ``complete``, and that alone is no problem.

    Raises:
        UnreadableLogError: no log of snakebot, or one that would need more memory than any log does.
    """
    container = Container(Path(path))
    tables = Tables(container)
    try:
        with _collector_paused():
            _fill(container, tables.by_topic)
        return _assemble(container, tables)
    except (KeyError, TypeError, ValueError, OverflowError, AttributeError) as error:
        why = f"{type(error).__name__}: {error}"
        raise UnreadableLogError(f"{path}: a message does not fit its schema ({why})") from None


@contextlib.contextmanager
def _collector_paused() -> Iterator[None]:
    """Hundreds of thousands of decoded numbers live for a moment: the collector would search them in vain."""
    running = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if running:
            gc.enable()


def _fill(container: Container, tables: dict[str, TopicTable]) -> None:
    stray = 0
    for messages in container.chunks():
        by_id = {number: tables.get(topic) for number, topic in container.topics.items()}
        for channel_id, _, _, publish_ns, data in messages:
            table = by_id.get(channel_id)
            if table is None:
                stray += 1
            else:
                table.pending.append(data)
                table.publish_ns.append(publish_ns)
        for table in tables.values():
            if len(table.pending) > BATCH_MESSAGES:
                table.decode()
    for table in tables.values():
        table.decode()
    if stray:
        container.problems.append(f"{stray} messages on unknown channels: left out")


class TopicTable(ABC):
    """The messages of one channel: bytes until there are many, then decoded."""

    def __init__(self) -> None:
        self.pending: list[bytes] = []
        self.publish_ns: list[int] = []

    def decode(self) -> None:
        pending, self.pending = self.pending, []
        batch: list[bytes] = []
        size = 0
        for data in pending:
            if len(data) > MAX_MESSAGE_BYTES:
                raise ValueError(f"{len(data)} bytes")
            batch.append(data)
            size += len(data)
            if size > BATCH_BYTES or len(batch) == BATCH_MESSAGES:
                self._decode(batch)
                batch, size = [], 0
        self._decode(batch)

    def _decode(self, batch: list[bytes]) -> None:
        if batch:
            rows = orjson.loads(b"[" + b",".join(batch) + b"]")
            if len(rows) != len(batch):
                raise ValueError("not one JSON object a message")
            self.store(rows)

    @abstractmethod
    def store(self, rows: list[Any]) -> None:
        """Take in decoded messages."""


class JointsTable(TopicTable):
    SCALARS = ("t_s", "board_time_us", "latency_s", "sequence")
    VECTORS = ("setpoint_rad", "sent_rad", "applied_rad", "measured_rad")

    def __init__(self) -> None:
        super().__init__()
        self.parts: dict[str, list[AnyArray]] = {}

    def store(self, rows: list[Any]) -> None:
        nothing = [None] * len(rows[0]["setpoint_rad"])
        if len(nothing) >= MAX_LINKS:
            raise ValueError(f"{len(nothing)} joints")
        columns: dict[str, AnyArray] = {}
        for name in self.SCALARS:
            kind = np.int64 if name == "sequence" else np.float64
            columns[name] = np.array([row[name] for row in rows], dtype=kind)
        for name in self.VECTORS:
            values = [nothing if row[name] is None else row[name] for row in rows]
            columns[name] = np.array(values, dtype=np.float64)
            if columns[name].shape != (len(rows), len(nothing)):
                raise ValueError(f"{name} differs in length")
        columns["late"] = np.array([row["late"] is True for row in rows], dtype=np.bool_)
        for name, column in columns.items():
            self.parts.setdefault(name, []).append(column)

    def columns(self, joints: int) -> dict[str, AnyArray]:
        """The whole columns; ``joints`` is the width where there is no row."""
        if not self.parts:
            empty = dict.fromkeys((*self.SCALARS, "late"), np.empty(0))
            return {**empty, **dict.fromkeys(self.VECTORS, np.empty((0, joints)))}
        return {name: np.concatenate(parts) for name, parts in self.parts.items()}


class PoseTable(TopicTable):
    def __init__(self) -> None:
        super().__init__()
        self.parts: list[Floats] = []

    def store(self, rows: list[Any]) -> None:
        values = []
        for row in rows:
            position = row["pose"]["position"]
            values.append((row["t_s"], position["x"], position["y"], row["heading_rad"], row["speed_m_s"]))
        self.parts.append(np.array(values, dtype=np.float64))

    def array(self) -> Floats:
        return np.concatenate(self.parts) if self.parts else np.empty((0, 5))


class EventsTable(TopicTable):
    def __init__(self, allowed_bytes: int) -> None:
        super().__init__()
        self.allowed_bytes = allowed_bytes  # as JSON: the details are kept as they are
        self.events: list[Event] = []

    def _decode(self, batch: list[bytes]) -> None:
        self.allowed_bytes -= sum(map(len, batch))
        if self.allowed_bytes < 0:
            raise ValueError("more text in events than in any log")
        super()._decode(batch)

    def store(self, rows: list[Any]) -> None:
        for row in rows:
            level = level_name(row["level"])
            self.events.append(
                Event(float(row["t_s"]), str(row["kind"]), str(row["message"]), level, dict(row["data"]))
            )


class FramesTable(TopicTable):
    def __init__(self) -> None:
        super().__init__()
        self.frames: list[RawFrame] = []

    def store(self, rows: list[Any]) -> None:
        for row in rows:
            data = bytes.fromhex(row["data"])
            self.frames.append(RawFrame(float(row["t_s"]), row["direction"], int(row["id"]), data))


class NumbersTable(TopicTable):
    """Named numbers at a time; not every message need have all of them."""

    def __init__(self, allowed_bytes: int) -> None:
        super().__init__()
        self.allowed_bytes = allowed_bytes  # of the arrays
        self.t_s: list[float] = []
        self.values: dict[str, dict[int, float]] = {}

    def store(self, rows: list[Any]) -> None:
        for row in rows:
            counters = row.get("counters", row)
            for name, value in counters.items():
                if name != "t_s":
                    self.values.setdefault(name, {})[len(self.t_s)] = value
            self.t_s.append(row["t_s"])
            if len(self.values) > MAX_NAMES:
                raise ValueError(f"more than {MAX_NAMES} different names")
        if 8 * len(self.values) * len(self.t_s) > self.allowed_bytes:
            raise ValueError(f"{len(self.values)} names at {len(self.t_s)} times")

    def columns(self) -> tuple[Floats, dict[str, Floats]]:
        columns = {}
        for name, values in sorted(self.values.items()):
            columns[name] = np.full(len(self.t_s), np.nan)
            columns[name][list(values)] = np.array(list(values.values()), dtype=np.float64)
        return np.array(self.t_s, dtype=np.float64), columns


class Tables:
    """All tables of a log being read; what they may hold goes with what the file may unpack to."""

    def __init__(self, container: Container) -> None:
        allowed = container.allowed_bytes
        self.joints, self.poses, self.frames = JointsTable(), PoseTable(), FramesTable()
        self.events = EventsTable(allowed // 4)
        self.link, self.telemetry = NumbersTable(allowed), NumbersTable(allowed)
        self.steering = NumbersTable(allowed)
        self.by_topic: dict[str, TopicTable] = {
            JOINTS.topic: self.joints,
            POSE.topic: self.poses,
            EVENTS.topic: self.events,
            LINK.topic: self.link,
            FRAMES.topic: self.frames,
            TELEMETRY.topic: self.telemetry,
            STEERING.topic: self.steering,
        }


def _assemble(container: Container, tables: Tables) -> RunLog:
    joints = tables.joints
    metadata, damaged = merge_metadata(container.metadata)
    problems = [*container.problems, *damaged]
    attachments = {name: item.data for name, item in container.attachments.items()}
    robot = _robot(container.path, attachments, metadata, joints, problems)
    column = joints.columns(robot.joints)
    order = np.argsort(column["t_s"], kind="stable")  # a tick whose answer never came is recorded late
    column = {name: values[order] for name, values in column.items()}
    if column["setpoint_rad"].shape[1] != robot.joints:
        raise ValueError(f"{column['setpoint_rad'].shape[1]} joints recorded, the robot has {robot.joints}")
    pose = tables.poses.array()
    link_t_s, counters = tables.link.columns()
    telemetry_t_s, readings = tables.telemetry.columns()
    steering_t_s, steering = tables.steering.columns()
    log = RunLog(
        path=container.path,
        robot=robot,
        metadata=metadata,
        attachments=attachments,
        complete=container.complete,
        problems=tuple(problems),
        sequence=column["sequence"].astype(np.int64),
        t_s=column["t_s"],
        host_time_ns=np.array(joints.publish_ns, dtype=np.int64)[order],
        setpoint_rad=column["setpoint_rad"],
        sent_rad=column["sent_rad"],
        applied_rad=column["applied_rad"],
        measured_rad=column["measured_rad"],
        board_time_us=column["board_time_us"],
        latency_s=column["latency_s"],
        late=column["late"].astype(np.bool_),
        pose_t_s=pose[:, 0],
        pose=pose[:, 1:4],
        pose_speed_m_s=pose[:, 4],
        events=tuple(tables.events.events),
        link_t_s=link_t_s,
        link=counters,
        telemetry_t_s=telemetry_t_s,
        telemetry=readings,
        frames=tuple(tables.frames.frames),
        steering_t_s=steering_t_s,
        steering=steering,
    )
    _warn(container.path, problems)
    return log


def _warn(path: Path, problems: list[str]) -> None:
    if problems:
        more = f"; and {len(problems) - 3} more" if len(problems) > 3 else ""
        warnings.warn(f"{path}: {'; '.join(problems[:3])}{more}", LogWarning, stacklevel=4)


def _robot(
    path: Path,
    attachments: dict[str, bytes],
    metadata: dict[str, Any],
    joints: JointsTable,
    problems: list[str],
) -> Robot:
    """The attached description, or, where that is damaged, a bench with as many joints as the rows have."""
    where = f"{path}: {ROBOT_ATTACHMENT}"
    vectors = joints.parts.get("setpoint_rad")
    if ROBOT_ATTACHMENT not in attachments:
        problems.append("the robot's description is missing")
        if not vectors and "joints" not in metadata:
            raise NothingLeftError(f"{path}: too damaged: neither the robot's description nor a tick is left")
    try:
        if ROBOT_ATTACHMENT in attachments:
            text = attachments[ROBOT_ATTACHMENT]
            return robot_from_mapping(load_yaml(text, where), where, Lines(text))
        return robot_from_mapping({"joints": vectors[0].shape[1] if vectors else metadata["joints"]}, where)
    except BadInputError as error:
        raise UnreadableLogError(str(error)) from None
