"""Is this input a session that can be diagnosed at all? Each check names the problem and what to look at."""

from __future__ import annotations

from collections.abc import Sequence
from math import tau

import numpy as np

from snakebot.analysis.channels import doubts_of_runs
from snakebot.analysis.standstill import standstill_lines
from snakebot.diagnosis.evidence.data import BRIEF_S, FEWEST_SAMPLES, MIN_SAMPLES, Data, repeated
from snakebot.diagnosis.sizes import HALF, MOST_TOLD, MUCH, OUTSTANDING
from snakebot.errors import BadInputError
from snakebot.runlog import Run, Session
from snakebot.runlog.matching.motion import CommandedMotion, same_motion

LEAD_S = BRIEF_S  # by which commands are shifted to see whether readings run ahead of them


def check_session(session: Session) -> list[str]:
    """Warnings about a session as it was read.

    Raises:
        BadInputError: what is there can only give nonsense: no samples, no motion, wrong units.
    """
    where = str(session.path) if session.path is not None else "session"
    runs = session.runs
    if not runs:
        raise BadInputError(f"{where}: no runs")
    for run in runs:
        if run.joints != session.robot.joints:
            raise BadInputError(
                f"{where}: {run.name}: {run.joints} joints, but the robot has {session.robot.joints}"
            )
    short = [run.name for run in runs if len(run) < MIN_SAMPLES]
    if len(short) == len(runs):
        raise BadInputError(f"{where}: every run is shorter than {MIN_SAMPLES} samples: nothing to diagnose")
    if all(run.hold_out for run in runs if len(run) >= MIN_SAMPLES):
        few = f" of at least {MIN_SAMPLES} samples" if short else ""
        raise BadInputError(f"{where}: every run{few} is marked hold_out: nothing is left to fit")
    if sum(len(run) for run in runs) < FEWEST_SAMPLES:
        raise BadInputError(
            f"{where}: {sum(len(run) for run in runs)} samples in all; at least {FEWEST_SAMPLES} are needed"
        )
    warnings = [f"{_names(short)}: shorter than {MIN_SAMPLES} samples, left out"] if short else []
    _check_units(where, runs)
    warnings += _check_readings(where, runs)
    _check_motion(where, session)
    warnings += _check_copies(where, session)
    doubts = [*doubts_of_runs(runs, session.robot), *standstill_lines(runs, session.robot)]
    return [*warnings, *_check_repeats(runs), *doubts]


def check_data(data: Data) -> list[str]:
    """Warnings about prepared data: too little variety, readings that run ahead."""
    warnings = []
    if data.spikes:
        warnings.append(f"lone readings far off their neighbours, left out: {data.spikes}")
    if len({run.motion for run in data.runs if not run.hold_out}) < 2:
        warnings.append(
            "only one motion may be fitted: nothing can be checked on another one, so no cause is given "
            "with confidence; "
            "record at least three gaits"
        )
    off = sum(int(np.isnan(run.command_rad).sum()) for run in data.runs)
    if off:
        total = sum(run.command_rad.size for run in data.runs)
        warnings.append(
            f"the servo is off in {off / total:.0%} of the samples (no command): taken as free, not fitted"
        )
    led = leading_joints(data)
    if led:
        warnings.append(
            f"joint {_numbers(led)}: the reading runs ahead of the command; are the columns cmd and enc swapped, "
            "or commands logged later than they were sent?"
        )
    return warnings


def leading_joints(data: Data) -> list[int]:
    """0-based joints whose reading is matched best by a command that lies in the future: it leaves less
    than half of the mean square that one in the past leaves.
    """
    led = []
    for joint in range(data.joints):
        ahead = behind = 0.0
        for run in data.runs:
            use = run.use[:, joint]
            if use.sum() < FEWEST_SAMPLES:
                continue
            shift = max(LEAD_S, 2 * run.period_s)
            t = run.t_s[use]
            known = np.isfinite(run.command_rad[:, joint])
            future = np.interp(t + shift, run.t_s[known], run.command_rad[known, joint])
            past = np.interp(t - shift, run.t_s[known], run.command_rad[known, joint])
            inner = (t > shift) & (t < t[-1] - shift)
            ahead += float(np.square(run.measured_rad[use, joint] - future)[inner].sum())
            behind += float(np.square(run.measured_rad[use, joint] - past)[inner].sum())
        if behind > 0 and ahead < HALF * behind:
            led.append(joint)
    return led


def _check_units(where: str, runs: Sequence[Run]) -> None:
    for run in runs:
        for name, values in (("cmd", run.command_rad), ("enc", run.measured_rad)):
            if not np.isfinite(values).any():
                continue
            worst = float(np.nanmax(np.abs(values)))
            if worst > tau:  # beyond a whole turn no joint of a snake goes
                joint = int(np.nanargmax(np.nanmax(np.abs(np.nan_to_num(values)), axis=0))) + 1
                raise BadInputError(
                    f"{where}: {run.name}: column {name}_{joint}_rad goes up to {worst:.3g} rad; "
                    "more than a full turn: are these degrees? give radians"
                )
    slope = _slope(runs)
    if slope is not None and HALF < np.degrees(abs(slope)) < 1 / HALF:
        raise BadInputError(
            f"{where}: the commands are {1 / abs(slope):.1f} times the readings: "
            "are the columns cmd in degrees? give radians"
        )


def _slope(runs: Sequence[Run]) -> float | None:
    """Reading over command, by least squares over all joints and runs; None where it leaves most of their variance."""
    xy = xx = yy = 0.0
    for run in runs:
        both = np.isfinite(run.command_rad) & np.isfinite(run.measured_rad)
        for joint in range(run.joints):
            rows = both[:, joint]
            if rows.sum() < MIN_SAMPLES:
                continue
            x = run.command_rad[rows, joint] - run.command_rad[rows, joint].mean()
            y = run.measured_rad[rows, joint] - run.measured_rad[rows, joint].mean()
            xy, xx, yy = xy + float(x @ y), xx + float(x @ x), yy + float(y @ y)
    if xx <= 0 or yy <= 0 or xy * xy < HALF * xx * yy:
        return None
    return xy / xx


def _check_readings(where: str, runs: Sequence[Run]) -> list[str]:
    warnings = []
    joints = runs[0].joints
    for joint in range(joints):
        seen = np.concatenate([run.measured_rad[:, joint] for run in runs])
        lost = float(np.mean(~np.isfinite(seen)))
        if lost == 1.0 and joints == 1:
            raise BadInputError(
                f"{where}: column enc_1_rad is empty in every run: no readings to compare with"
            )
        if lost == 1.0:
            warnings.append(f"joint {joint + 1}: no reading in any run; nothing is said about it")
        elif lost > MUCH:
            warnings.append(f"joint {joint + 1}: {lost:.0%} of the readings are lost")
    if all(not np.isfinite(run.measured_rad).any() for run in runs):
        raise BadInputError(f"{where}: the columns enc are empty in every run: no readings to compare with")
    return warnings


def _check_repeats(runs: Sequence[Run]) -> list[str]:
    """Runs that say to repeat another one and were told something else."""
    return [
        f"{run.name} is marked as a repeat of {runs[j].name}, but its commands are others, or hardly overlap: it is "
        "not taken for a repeat"
        for run in runs
        for j in repeated(runs, run)
        if same_motion(CommandedMotion.of(run), CommandedMotion.of(runs[j]), claimed=True) is None
    ]


def _check_motion(where: str, session: Session) -> None:
    least = OUTSTANDING * session.robot.rad_per_count
    told = seen = 0.0
    for run in session.runs:
        for joint in range(run.joints):
            for kind, column in (("told", run.command_rad[:, joint]), ("seen", run.measured_rad[:, joint])):
                finite = column[np.isfinite(column)]
                if finite.size >= 2:
                    if kind == "told":
                        start = run.measured_rad[:, joint]
                        start = start[np.isfinite(start)][:1]
                        told = max(told, float(np.ptp(np.concatenate([finite, start]))))
                    else:
                        seen = max(seen, float(np.ptp(finite)))
    if told <= least:
        raise BadInputError(f"{where}: no motion is commanded in any run: nothing to diagnose")
    if seen <= least:
        raise BadInputError(
            f"{where}: no joint moves in any run, though up to {np.degrees(told):.0f} deg are commanded: "
            "are the servos powered and the encoders connected?"
        )


def _check_copies(where: str, session: Session) -> list[str]:
    """Joints whose commands and readings are one and the same column: no servo that lags is that good, one was written
    twice.
    """
    if session.robot.servo.time_constant_s == 0:
        return []
    least = OUTSTANDING * session.robot.rad_per_count
    moved, copied = [], []
    for joint in range(session.robot.joints):
        told = np.concatenate([run.command_rad[:, joint] for run in session.runs])
        seen = np.concatenate([run.measured_rad[:, joint] for run in session.runs])
        both = np.isfinite(told) & np.isfinite(seen)
        if both.sum() >= MIN_SAMPLES and np.ptp(told[both]) > least:
            moved.append(joint)
            if np.array_equal(told[both], seen[both]):
                copied.append(joint)
    if not copied:
        return []
    text = "commands and readings are the same numbers in every sample: was one column written twice?"
    if copied == moved:
        raise BadInputError(f"{where}: {text}")
    return [f"joint {_numbers(copied)}: {text}"]


def _names(names: Sequence[str]) -> str:
    more = f" and {len(names) - MOST_TOLD} more" if len(names) > MOST_TOLD else ""
    return ", ".join(names[:MOST_TOLD]) + more


def _numbers(joints: Sequence[int]) -> str:
    return ", ".join(str(j + 1) for j in joints)
