"""Readings that jump by a whole turn where an angle passes 180 deg: made to run on, so that no joint seems to leap."""

from __future__ import annotations

from dataclasses import replace
from math import tau

import numpy as np

from snakebot.arrays import Bools, Floats
from snakebot.diagnosis.evidence.data import HOLE_S
from snakebot.diagnosis.sizes import NEARLY_ALL
from snakebot.runlog import Run, Session

# Of a reading in one sample, less than a whole turn by what the joint moves meanwhile, and beyond what it can.
LEAP_RAD = NEARLY_ALL * tau


def run_on(session: Session) -> tuple[Session, list[str]]:
    """The session with readings that run on past 180 deg, and a line that says where; else as it is.

    Commands of such a joint, too, are made to run on. Which turn a run begins in is not known: it is the one nearest
    to its commands, and to the other runs.
    """
    leaps = {run.name: _leaps(run.t_s, run.measured_rad) for run in session.runs}
    wrapped = np.zeros(session.robot.joints, dtype=bool)
    for leap in leaps.values():
        wrapped |= leap.any(axis=0)
    if not wrapped.any():
        return session, []
    runs, lines = list(session.runs), []
    for joint in np.flatnonzero(wrapped).tolist():
        runs = _at_one_turn([_joint_run_on(run, joint) for run in runs], joint)
        first = next(run for run in session.runs if leaps[run.name][:, joint].any())
        at_s = first.t_s[1:][leaps[first.name][:, joint]][0] - first.t_s[0]
        count = sum(int(leap[:, joint].sum()) for leap in leaps.values())
        lines.append(
            f"joint {joint + 1}: the reading jumps by a whole turn {count} times, first in {first.name} at "
            f"{at_s:.1f} s: taken as an angle that runs on past 180 deg"
        )
    return replace(session, runs=tuple(runs)), lines


def _leaps(t_s: Floats, angle_rad: Floats) -> Bools:
    """(N - 1, k) steps between samples that are a turn, nearly."""
    with np.errstate(invalid="ignore"):
        far = np.abs(np.diff(angle_rad, axis=0)) > LEAP_RAD
    return np.asarray(far & (np.diff(t_s) <= HOLE_S)[:, None])


def _joint_run_on(run: Run, joint: int) -> Run:
    """A run in which the angles of a joint go on where they leapt."""
    measured, command = run.measured_rad.copy(), run.command_rad.copy()
    for angle in (measured, command):
        column = angle[:, joint]
        leaps = _leaps(run.t_s, column[:, None])[:, 0]
        steps = np.where(leaps, np.nan_to_num(np.diff(column)), 0.0)
        angle[1:, joint] -= tau * np.cumsum(np.round(steps / tau))
    return replace(run, measured_rad=measured, command_rad=command)


def _at_one_turn(runs: list[Run], joint: int) -> list[Run]:
    """The same with readings in the turn of their commands, the same one in every run."""
    off = [_middle(run.measured_rad[:, joint] - run.command_rad[:, joint]) for run in runs]
    first = next((value for value in off if np.isfinite(value)), 0.0)
    moved = []
    for run, value in zip(runs, off, strict=True):
        turns = np.round(first / tau) + (np.round((value - first) / tau) if np.isfinite(value) else 0.0)
        measured = run.measured_rad.copy()
        measured[:, joint] -= tau * turns
        moved.append(replace(run, measured_rad=measured))
    return moved


def _middle(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if known.size else float("nan")
