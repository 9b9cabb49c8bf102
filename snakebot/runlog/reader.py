"""Reads a run log, finished or not, into numpy arrays.

JSON is decoded a few MiB at a time (one call of orjson for thousands of messages), so that memory is bounded
by the arrays and not by the objects they are made from.
"""

from __future__ import annotations

import contextlib
import gc
import os
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import orjson
from numpy.typing import NDArray

from snakebot.errors import BadInputError, UnreadableLogError
from snakebot.robot import Robot, robot_from_mapping
from snakebot.runlog.channels import (
    EVENTS,
    FRAMES,
    JOINTS,
    LINK,
    POSE,
    ROBOT_ATTACHMENT,
    TELEMETRY,
    level_name,
)
from snakebot.runlog.container import Container
from snakebot.runlog.finish import merge_metadata
from snakebot.runlog.log import RunLog
from snakebot.runlog.records import Event, RawFrame
from snakebot.safe_yaml import load_yaml

MAX_NAMES = 1024  # of counters or readings: one message is one array cell for each


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
    joints, poses, link, telemetry = JointsTable(), PoseTable(), NumbersTable(), NumbersTable()
    tables: dict[str, Table] = {
        JOINTS.topic: joints,
        POSE.topic: poses,
        EVENTS.topic: Table(),
        LINK.topic: link,
        FRAMES.topic: Table(),
        TELEMETRY.topic: telemetry,
    }
    try:
        with _collector_paused():
            _fill(container, tables)
        rows = {topic: table.rows for topic, table in tables.items()}
        return _assemble(container, joints, poses, link, telemetry, rows)
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


def _fill(container: Container, tables: dict[str, Table]) -> None:
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
            if len(table.pending) > table.batch_messages:
                table.decode()
    for table in tables.values():
        table.decode()
    if stray:
        container.problems.append(f"{stray} messages on unknown channels: left out")


class Table:
    """The messages of one channel: bytes until there are many, then decoded (here: rows as they are)."""

    batch_messages = 8192

    def __init__(self) -> None:
        self.pending: list[bytes] = []
        self.publish_ns: list[int] = []
        self.rows: list[Any] = []

    def decode(self) -> None:
        if self.pending:
            rows = orjson.loads(b"[" + b",".join(self.pending) + b"]")
            if len(rows) != len(self.pending):
                raise ValueError("not one JSON object a message")
            self.store(rows)
            self.pending = []

    def store(self, rows: list[Any]) -> None:
        self.rows.extend(rows)


class JointsTable(Table):
    SCALARS = ("t_s", "board_time_us", "latency_s", "sequence")
    VECTORS = ("setpoint_rad", "sent_rad", "applied_rad", "measured_rad")

    def __init__(self) -> None:
        super().__init__()
        self.parts: dict[str, list[NDArray[Any]]] = {}

    def store(self, rows: list[Any]) -> None:
        nothing = [None] * len(rows[0]["setpoint_rad"])
        columns: dict[str, NDArray[Any]] = {}
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

    def columns(self, joints: int) -> dict[str, NDArray[Any]]:
        """The whole columns; ``joints`` is the width where there is no row."""
        if not self.parts:
            empty = dict.fromkeys((*self.SCALARS, "late"), np.empty(0))
            return {**empty, **dict.fromkeys(self.VECTORS, np.empty((0, joints)))}
        return {name: np.concatenate(parts) for name, parts in self.parts.items()}


class PoseTable(Table):
    def __init__(self) -> None:
        super().__init__()
        self.parts: list[NDArray[np.float64]] = []

    def store(self, rows: list[Any]) -> None:
        values = []
        for row in rows:
            position = row["pose"]["position"]
            values.append((row["t_s"], position["x"], position["y"], row["heading_rad"], row["speed_m_s"]))
        self.parts.append(np.array(values, dtype=np.float64))

    def array(self) -> NDArray[np.float64]:
        return np.concatenate(self.parts) if self.parts else np.empty((0, 5))


class NumbersTable(Table):
    """Named numbers at a time; not every message need have all of them."""

    def __init__(self) -> None:
        super().__init__()
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

    def columns(self) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
        columns = {}
        for name, values in sorted(self.values.items()):
            columns[name] = np.full(len(self.t_s), np.nan)
            columns[name][list(values)] = np.array(list(values.values()), dtype=np.float64)
        return np.array(self.t_s, dtype=np.float64), columns


def _assemble(
    container: Container,
    joints: JointsTable,
    poses: PoseTable,
    link: NumbersTable,
    telemetry: NumbersTable,
    rows: dict[str, list[Any]],
) -> RunLog:
    metadata, damaged = merge_metadata(container.metadata)
    problems = [*container.problems, *damaged]
    attachments = {name: item.data for name, item in container.attachments.items()}
    robot = _robot(container.path, attachments, metadata, joints, problems)
    column = joints.columns(robot.joints)
    order = np.argsort(column["t_s"], kind="stable")  # a tick whose answer never came is recorded late
    column = {name: values[order] for name, values in column.items()}
    if column["setpoint_rad"].shape[1] != robot.joints:
        raise ValueError(f"{column['setpoint_rad'].shape[1]} joints recorded, the robot has {robot.joints}")
    pose = poses.array()
    link_t_s, counters = link.columns()
    telemetry_t_s, readings = telemetry.columns()
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
        events=tuple(_events(rows[EVENTS.topic])),
        link_t_s=link_t_s,
        link=counters,
        telemetry_t_s=telemetry_t_s,
        telemetry=readings,
        frames=tuple(
            RawFrame(float(row["t_s"]), row["direction"], int(row["id"]), bytes.fromhex(row["data"]))
            for row in rows[FRAMES.topic]
        ),
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
    try:
        if ROBOT_ATTACHMENT in attachments:
            return robot_from_mapping(load_yaml(attachments[ROBOT_ATTACHMENT], where), where)
        problems.append("the robot's description is missing")
        vectors = joints.parts.get("setpoint_rad")
        if not vectors and "joints" not in metadata:
            raise UnreadableLogError(
                f"{path}: too damaged: neither the robot's description nor a tick is left"
            )
        return robot_from_mapping({"joints": vectors[0].shape[1] if vectors else metadata["joints"]}, where)
    except BadInputError as error:
        raise UnreadableLogError(str(error)) from None


def _events(rows: list[Any]) -> Iterator[Event]:
    for row in rows:
        level = level_name(row["level"])
        yield Event(float(row["t_s"]), str(row["kind"]), str(row["message"]), level, dict(row["data"]))
