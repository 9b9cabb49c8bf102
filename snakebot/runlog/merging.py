"""Adds to a log what was measured outside it: a speed, or the track of a camera on its own clock."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError, LogError
from snakebot.runlog.channels import POSE, encode_pose
from snakebot.runlog.column_map import Source, apply_map
from snakebot.runlog.finish import Changes, finish
from snakebot.runlog.log import RunLog
from snakebot.runlog.naming import PART_SUFFIX, final_path
from snakebot.runlog.number_table import CsvForm, read_table
from snakebot.runlog.reader import read_log
from snakebot.runlog.records import PoseRecord
from snakebot.runlog.session import KnownColumns, check_time

EPOCH_S = 1e9  # a time beyond this is a wall clock's (2001 and later), not seconds since the start
ALIGN_RATE_HZ = 50.0  # at which both are compared; chosen, above what a gait contains
ENOUGH_CORRELATION = 0.6  # chosen: below it the shift that fits best says nothing
MIN_OVERLAP_S = 2.0  # chosen: about a cycle of a gait


@dataclass(frozen=True)
class PoseTrack:
    """Where the robot was, on a clock of its own. ``heading_rad`` may be nan throughout."""

    t_s: Floats  # (M,) rising
    pose: Floats  # (M, 3)


@dataclass(frozen=True)
class Offset:
    """``offset_s`` is subtracted from the track's time to get the run's; ``correlation`` says how sure that is."""

    offset_s: float
    correlation: float


def merge_speed(
    path: str | os.PathLike[str],
    speed_m_s: float,
    source: str = "entered by hand",
    output: str | os.PathLike[str] | None = None,
) -> Path:
    """Store a forward speed in a finished log (in place, or as ``output``).

    Raises:
        BadInputError: the speed is not a finite number.
        LogError: the log is unfinished or cannot be rewritten.
    """
    if not math.isfinite(speed_m_s):
        raise BadInputError(f"speed {speed_m_s}: not a finite number")
    about = {"forward_speed_m_s": float(speed_m_s), "forward_speed_source": source}
    return _rewrite(Path(path), output, Changes(metadata=about))


def read_track(path: Path, mapping: Mapping[str, Source], dialect: CsvForm | None = None) -> PoseTrack:
    """Read a track's table, through the column map where one is given.

    Raises:
        BadInputError: one line with file, row and column.
    """
    wanted = frozenset(source.column for source in mapping.values()) if mapping else KnownColumns()
    table = read_table(path, wanted, dialect)
    columns = apply_map(table.columns, mapping, str(path)) if mapping else table.columns
    for name in ("t_s", "x_m", "y_m"):
        if name not in columns:
            raise BadInputError(f"{path}: row 1: column {name} is missing; a track needs t_s, x_m and y_m")
    check_time(path, table.first_row, columns["t_s"])
    heading = columns.get("heading_rad", np.full(columns["t_s"].size, np.nan))
    return PoseTrack(columns["t_s"], np.column_stack([columns["x_m"], columns["y_m"], heading]))


def place_track(log: RunLog, track: PoseTrack, offset_s: float | None) -> tuple[Offset, str]:
    """Bring the track onto the run's time: by a given offset, by its wall clock, or by the motion.

    Raises:
        BadInputError: the motion does not say, or the two do not overlap.
    """
    start_s = log.start_time_ns * 1e-9
    if offset_s is not None:
        offset, how = Offset(offset_s, math.nan), "given"
    elif track.t_s[0] > EPOCH_S:
        offset, how = Offset(start_s, math.nan), "wall clock"
    else:
        offset, how = align_track(log, track), "motion"
    t_s = track.t_s - offset.offset_s
    if not log.t_s.size or t_s[-1] < log.t_s[0] or t_s[0] > log.t_s[-1]:
        raise BadInputError(
            f"{log.path}: run and track do not overlap at an offset of {offset.offset_s:.3f} s"
        )
    return offset, how


def merge_track(
    path: str | os.PathLike[str],
    track: PoseTrack,
    offset: Offset,
    speed_m_s: float | None = None,
    source: str = "track",
    output: str | os.PathLike[str] | None = None,
) -> Path:
    """Store a track as the log's poses, in place of any that it has, and the speed that follows from it.

    Raises:
        LogError: the log is unfinished or cannot be rewritten.
    """
    log = read_log(path)
    start_ns = log.start_time_ns
    poses = (
        PoseRecord(t, *row)
        for t, row in zip((track.t_s - offset.offset_s).tolist(), track.pose.tolist(), strict=True)
    )
    messages = [
        (POSE.topic, max(0, start_ns + round(pose.t_s * 1e9)), encode_pose(pose, start_ns)) for pose in poses
    ]
    about: dict[str, object] = {"pose_source": source, "pose_offset_s": offset.offset_s}
    if speed_m_s is not None:
        about.update(forward_speed_m_s=speed_m_s, forward_speed_source=source)
    changes = Changes(metadata=about, drop_topics=frozenset({POSE.topic}), messages=messages)
    return _rewrite(Path(path), output, changes)


def _rewrite(path: Path, output: str | os.PathLike[str] | None, changes: Changes) -> Path:
    if path.name.endswith(PART_SUFFIX):
        raise LogError(f"{path}: this log is not finished; run 'snakebot log recover' on it first")
    target = path if output is None else final_path(output)
    if target != path and os.path.lexists(target):
        raise LogError(f"{target}: exists already; a log is never overwritten")
    return finish(path, target, changes, keep_source=True).path


def with_heading(track: PoseTrack, period_s: float) -> PoseTrack:
    """Where the track has no heading: the direction of travel over ``period_s`` (one cycle of the gait)."""
    if np.isfinite(track.pose[:, 2]).any():
        return track
    course = course_rad(track.t_s, track.pose[:, :2], period_s)
    return PoseTrack(track.t_s, np.column_stack([track.pose[:, :2], course]))


def course_rad(t_s: Floats, position_m: Floats, period_s: float) -> Floats:
    """Direction of travel (N,) of a point (N, 2) over ``period_s`` around each time."""
    known = np.isfinite(position_m).all(axis=1)
    half = period_s / 2
    after, before = (
        np.stack([np.interp(t_s + shift, t_s[known], position_m[known, i]) for i in (0, 1)])
        for shift in (half, -half)
    )
    dx, dy = after - before
    return np.unwrap(np.arctan2(dy, dx))


def align_track(log: RunLog, track: PoseTrack) -> Offset:
    """Find the track's clock offset from when and how fast the robot moved, in the joints and in the track.

    The speed of the joints (rms over joints) and the speed of the tracked point rise and fall together at the
    start, the ramps and the end; the offset is where their correlation is largest.

    Raises:
        BadInputError: they never agree well enough to be sure.
    """
    run_t, joints = _activity(
        log.t_s, log.measured_rad if np.isfinite(log.measured_rad).any() else log.sent_rad
    )
    track_t, body = _activity(track.t_s, track.pose[:, :2])
    if min(run_t.size, track_t.size) < MIN_OVERLAP_S * ALIGN_RATE_HZ:
        raise BadInputError(f"{log.path}: too short to align a track by motion; give --offset")
    shift, correlation = _best_shift(joints, body)
    if correlation < ENOUGH_CORRELATION:
        raise BadInputError(
            f"{log.path}: the track does not fit the run (best correlation {correlation:.2f}); give --offset"
        )
    return Offset(float(track_t[0] - run_t[0] + shift / ALIGN_RATE_HZ), correlation)


def _activity(t_s: Floats, values: Floats) -> tuple[Floats, Floats]:
    """How fast something moves: rms rate over its columns, on an even grid, smoothed over a fifth of a second."""
    grid = np.arange(t_s[0], t_s[-1], 1 / ALIGN_RATE_HZ)
    total = np.zeros(grid.size)
    for column in values.T:
        known = np.isfinite(column)
        if known.sum() > 1:
            even = np.interp(grid, t_s[known], column[known])
            total += np.gradient(_smooth(even), 1 / ALIGN_RATE_HZ) ** 2
    return grid, _smooth(np.sqrt(total))


def _smooth(y: Floats) -> Floats:
    width = min(max(1, round(0.2 * ALIGN_RATE_HZ)), y.size)
    padded = np.pad(y, (width // 2, width - 1 - width // 2), mode="edge")
    return np.convolve(padded, np.ones(width) / width, mode="valid")


def _best_shift(a: Floats, b: Floats) -> tuple[int, float]:
    """Shift k (in samples) for which b[i + k] correlates best with a[i], and that correlation over the overlap.

    ``matching.find_shift`` compares like with like. Here are a rate of joints and a speed over ground, whose ratio
    nobody knows: only that they rise and fall together.
    """
    best = (0, -1.0)
    least = min(max(int(MIN_OVERLAP_S * ALIGN_RATE_HZ), min(a.size, b.size) // 2), min(a.size, b.size))
    for shift in range(least - a.size, b.size - least + 1):
        x = a[max(0, -shift) : b.size - shift]
        y = b[max(0, shift) : shift + a.size]
        x, y = x - x.mean(), y - y.mean()
        power = math.sqrt(float(x @ x) * float(y @ y))
        correlation = float(x @ y) / power if power > 0 else -1.0
        if correlation > best[1]:
            best = (shift, correlation)
    return best
