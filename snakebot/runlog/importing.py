"""Turns a table that another program recorded into a run log."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.robot import Robot
from snakebot.runlog.column_map import Source, apply_map
from snakebot.runlog.log import gait_to_mapping
from snakebot.runlog.merging import EPOCH_S
from snakebot.runlog.naming import check_new_log
from snakebot.runlog.number_table import CsvForm, NumberTable, read_table
from snakebot.runlog.records import PoseRecord, Telemetry, Tick
from snakebot.runlog.run import Run
from snakebot.runlog.session import KnownColumns, run_from_table
from snakebot.runlog.writer import RunWriter


def import_table(
    source: str | os.PathLike[str],
    target: str | os.PathLike[str],
    robot: Robot,
    mapping: Mapping[str, Source] | None = None,
    metadata: Mapping[str, Any] | None = None,
    dialect: CsvForm | None = None,
) -> Path:
    """Write the run log ``target`` from a CSV, CSV.gz or Parquet.

    Time starts at zero in the log; where the table's is a wall clock, the log keeps it. Measured columns that the
    map does not name are left out.

    Raises:
        BadInputError: one line with file, row and column.
        LogError: the log exists or cannot be written.
    """
    path = Path(source)
    check_new_log(target)
    run = read_run(path, robot, mapping, dialect)
    start_s = float(run.t_s[0])
    wall_clock = start_s > EPOCH_S
    start_ns = round(start_s * 1e9) if wall_clock else round(path.stat().st_mtime * 1e9)
    about = {"imported_from": path.name, "simulated": False, **(metadata or {})}
    return write_run(target, robot, run, about, start_ns)


def read_run(
    path: Path, robot: Robot, mapping: Mapping[str, Source] | None = None, dialect: CsvForm | None = None
) -> Run:
    """A run from a table, through the column map where one is given.

    Raises:
        BadInputError: one line with file, row and column.
    """
    wanted = frozenset(source.column for source in mapping.values()) if mapping else KnownColumns()
    table = read_table(path, wanted, dialect)
    if mapping:
        table = NumberTable(apply_map(table.columns, mapping, str(path)), (), table.first_row)
    return run_from_table(path, table, robot.joints, set(), name=path.name)


def write_run(
    target: str | os.PathLike[str], robot: Robot, run: Run, metadata: Mapping[str, Any], start_ns: int
) -> Path:
    """Write a run as a finished log, its time starting at zero.

    Raises:
        BadInputError: the run has other joints than the robot.
        LogError: the log exists or cannot be written.
    """
    if run.joints != robot.joints:
        raise BadInputError(f"run {run.name} has {run.joints} joints, the robot {robot.joints}")
    about = dict(metadata)
    if run.gait is not None:
        about.setdefault("gait", gait_to_mapping(run.gait))
    if run.forward_speed_m_s is not None:
        about.setdefault("forward_speed_m_s", run.forward_speed_m_s)
    t_s = run.t_s - run.t_s[0]
    lists = _Rows(run, t_s)
    with RunWriter(target, robot, about, start_time_ns=start_ns) as writer:
        for row in range(len(run)):
            writer.tick(lists.tick(row, start_ns))
            if lists.pose is not None:
                writer.pose(PoseRecord(float(t_s[row]), *lists.pose[row]))
            if lists.telemetry:
                writer.telemetry(
                    Telemetry(float(t_s[row]), {name: v[row] for name, v in lists.telemetry.items()})
                )
    return writer.path


class _Rows:
    """The columns of a run as lists: a hundred times faster to go through than arrays."""

    def __init__(self, run: Run, t_s: Floats) -> None:
        self.t_s = t_s.tolist()
        self.command = run.command_rad.tolist()
        self.measured = run.measured_rad.tolist()
        self.applied = None if run.applied_rad is None else run.applied_rad.tolist()
        self.pose = None if run.pose is None else run.pose.tolist()
        extra = {name: np.asarray(values, dtype=np.float64) for name, values in run.extra.items()}
        self.own = {name: extra.pop(name).tolist() for name in _TICK_COLUMNS if name in extra}
        self.telemetry = {name: values.tolist() for name, values in extra.items()}

    def tick(self, row: int, start_ns: int) -> Tick:
        own = {name: values[row] for name, values in self.own.items()}
        sequence, board_us, latency = (
            own.get(name, np.nan) for name in ("sequence", "board_time_us", "latency_s")
        )
        return Tick(
            sequence=row if np.isnan(sequence) else int(sequence),
            t_s=self.t_s[row],
            host_time_ns=start_ns + round(self.t_s[row] * 1e9),
            setpoint_rad=self.command[row],
            sent_rad=self.command[row],
            applied_rad=None if self.applied is None else self.applied[row],
            measured_rad=self.measured[row],
            board_time_us=None if np.isnan(board_us) else int(board_us),
            latency_s=None if np.isnan(latency) else latency,
            late=bool(own.get("late", 0)),
        )


_TICK_COLUMNS = ("sequence", "board_time_us", "latency_s", "late")
