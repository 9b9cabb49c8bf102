"""A session made ready: spikes taken out, servo-off stretches cut, repeats and gaits told apart.

Nothing here knows an effect. Everything downstream works on ``Data``: for each run the arrays, and for each
joint a mask of the samples that may be compared with a prediction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Bools, Floats, Ints
from snakebot.diagnosis.sizes import CLEAR, LITTLE, NEARLY_ALL, NEXT_TO_NOTHING, NO_PERCENT, OUTSTANDING
from snakebot.robust import MAD_TO_STD
from snakebot.runlog.matching.motion import CommandedMotion, same_motion

if TYPE_CHECKING:
    from snakebot.robot import Robot
    from snakebot.runlog import Run, Session


# Robust standard deviations off its neighbours, and encoder counts at least, that make a lone sample a bad reading;
# chosen: no noise gets there.
SPIKE = CLEAR * OUTSTANDING
BLOCK_S = 1.0  # length of a block: in it a servo and a body forget what was before, s; chosen
BRIEF_S = NEXT_TO_NOTHING * BLOCK_S  # in which hardly anything moves
# After a servo was without power, in which its state is not known. Shorter than ``SETTLED`` time constants:
# where the joint is, its readings tell; a prediction goes on from them.
WAKE_UP_S = BRIEF_S
# Time constants (or lengths of the hole, if it is short) after which a servo has settled: nothing of a step is left, in
# per cent. Of the stated servo, since what follows a hole is compared with its prediction.
SETTLED = -np.log(NO_PERCENT)
HOLE_S = LITTLE * BLOCK_S  # without a row, above which it is not known where a joint was meanwhile
# Within which a set-point was applied as commanded; chosen: a count of 12 bits is 1.5e-3 rad.
APPLIED_RAD = 2e-3
# Share of a run's samples that a clean line may lose, or apply otherwise than commanded.
CLEAN_LOSS = NO_PERCENT
QUARTERS = 4  # parts of a run, or of a cycle, that are looked at each for itself; chosen
MIN_SAMPLES = 8  # of a joint in a run, or windows over ground, below which they tell nothing; chosen
FEWEST_TO_COMPARE = 3  # motions, strokes, repeats, runs, windows: to fit to some and check on others; chosen
# Samples of all runs together, below which nothing can be told; of one run, below which no delay is; of a difference
# between runs, below which it is not said what it depends on; chosen.
FEWEST_SAMPLES = 40


@dataclass(frozen=True, eq=False)
class PreparedRun:
    """One run: N samples of k joints."""

    name: str
    t_s: Floats  # (N,) from zero
    command_rad: Floats  # (N, k); nan = servo off
    measured_rad: Floats  # (N, k); nan = lost or a spike
    use: Bools  # (N, k): compared with predictions
    applied_rad: Floats | None  # (N, k)
    pose: Floats | None  # (N, 3), heading unwrapped; all headings nan where none is known
    forward_speed_m_s: float | None
    omega_rad_s: float | None  # of the gait, when there is one
    motion: int  # runs of the same motion share this number
    hold_out: bool
    blocks: Ints  # (N,) number of the block each sample belongs to
    lifted: bool = False  # off the ground: nothing rubs, and where it went says nothing
    tick_s: float | None = None  # interval of the set-points, where it is known; see ``ticks``

    @property
    def commanded(self) -> CommandedMotion:
        return CommandedMotion(self.t_s, self.command_rad, self.lifted)

    @property
    def period_s(self) -> float:
        return float(np.median(np.diff(self.t_s)))

    @property
    def duration_s(self) -> float:
        return float(self.t_s[-1])


@dataclass(frozen=True, eq=False)
class Data:
    """All runs of a session, prepared."""

    robot: Robot
    runs: tuple[PreparedRun, ...]
    spikes: int  # samples taken out as bad readings

    @property
    def joints(self) -> int:
        return self.robot.joints

    @property
    def motions(self) -> tuple[int, ...]:
        return tuple(sorted({run.motion for run in self.runs}))

    @property
    def quantiser_rad(self) -> float:
        """Standard deviation that rounding to encoder counts brings in."""
        return float(self.robot.rad_per_count / np.sqrt(12.0))

    @property
    def has_ground(self) -> bool:
        """Whether the session says anything about the motion over ground."""
        return self.robot.body is not None and any(
            run.pose is not None or run.forward_speed_m_s is not None for run in self.runs
        )


def prepare(session: Session) -> Data:
    """Clean the runs of a session; see the module.

    Runs that are too short to be used at all are left out (``sanity`` warns about them).
    """
    motions = motion_numbers(session.runs)
    runs, spikes = [], 0
    for run, motion in zip(session.runs, motions, strict=True):
        if len(run) < MIN_SAMPLES:
            continue
        prepared, bad = _prepare_run(run, motion, session.robot)
        runs.append(prepared)
        spikes += bad
    return Data(session.robot, tuple(runs), spikes)


def _prepare_run(run: Run, motion: int, robot: Robot) -> tuple[PreparedRun, int]:
    t = run.t_s - run.t_s[0]
    measured = run.measured_rad.copy()
    bad = spikes(measured, SPIKE * robot.rad_per_count)
    measured[bad] = np.nan
    powered = np.isfinite(run.command_rad)
    use = np.isfinite(measured) & powered
    use &= ~_within_after(~powered, t, WAKE_UP_S)
    use &= ~_after_holes(t, robot.servo.time_constant_s)[:, None]
    lifted = run.metadata.get("lifted") is True
    pose = None
    if not lifted and run.pose is not None and np.isfinite(run.pose[:, :2]).all(axis=1).any():
        pose = run.pose.copy()
        known = np.isfinite(pose[:, 2])
        pose[known, 2] = np.unwrap(pose[known, 2])
    omega = float(run.gait.omega_rad_s) if run.gait is not None else None
    return (
        PreparedRun(
            name=run.name,
            t_s=t,
            command_rad=run.command_rad,
            measured_rad=measured,
            use=use,
            applied_rad=run.applied_rad,
            pose=pose,
            forward_speed_m_s=None if lifted else run.forward_speed_m_s,
            omega_rad_s=omega,
            motion=motion,
            hold_out=run.hold_out,
            blocks=block_numbers(t),
            lifted=lifted,
            tick_s=_tick_s(run.metadata.get("rate_hz")),
        ),
        int(bad.sum()),
    )


def _tick_s(rate_hz: object) -> float | None:
    """Interval of set-points that come at a rate, if it is one (a stranger may have written it)."""
    if isinstance(rate_hz, bool) or not isinstance(rate_hz, (int, float)) or not 0 < rate_hz < np.inf:
        return None
    return 1.0 / float(rate_hz)


def link_is_clean(data: Data) -> bool:
    """Whether the board says, in every run, that it applied what was commanded: at once or a tick later."""
    for run in data.runs:
        if run.applied_rad is None:
            return False
        known = (
            np.isfinite(run.applied_rad[1:])
            & np.isfinite(run.command_rad[1:])
            & np.isfinite(run.command_rad[:-1])
        )
        if known.mean() < 0.5:
            return False
        off = np.minimum(
            np.abs(run.applied_rad[1:] - run.command_rad[1:]),
            np.abs(run.applied_rad[1:] - run.command_rad[:-1]),
        )
        if np.mean(off[known] > APPLIED_RAD) > CLEAN_LOSS:
            return False
    return bool(data.runs)


def block_numbers(t_s: Floats) -> Ints:
    """Blocks of ``BLOCK_S``, or of a quarter of a shorter run; (N,)."""
    length = min(BLOCK_S, max(float(t_s[-1]) / QUARTERS, 1e-9))
    last = max(int(t_s[-1] / length * (1 + 1e-9)) - 1, 0)
    return np.minimum((t_s / length).astype(np.int64), last)


def spikes(measured_rad: Floats, least_rad: float) -> Bools:
    """Single samples far from both neighbours, which agree with each other; (N, k)."""
    bad = np.zeros(measured_rad.shape, dtype=bool)
    if measured_rad.shape[0] < 5:
        return bad
    before, here, after = measured_rad[:-2], measured_rad[1:-1], measured_rad[2:]
    off = here - 0.5 * (before + after)
    apart = np.abs(after - before)
    scale = np.zeros(off.shape[1])
    read = np.isfinite(off).any(axis=0)
    scale[read] = MAD_TO_STD * np.nanmedian(np.abs(off[:, read]), axis=0)
    with np.errstate(invalid="ignore"):
        bad[1:-1] = (np.abs(off) > np.maximum(SPIKE * scale, least_rad)) & (np.abs(off) > 2 * apart)
    return bad


def holes(t_s: Floats, least_s: float = 0.0) -> Ints:
    """The last samples before stretches, longer than ``least_s``, that a log lacks: what was commanded in them is not
    known; ``t_s`` (N,).
    """
    steps = np.diff(t_s)
    return np.flatnonzero((steps > least_s) & (np.round(steps / _usual_step_s(t_s)) > 1))


def _usual_step_s(t_s: Floats) -> float:
    return float(np.quantile(np.diff(t_s), NEARLY_ALL))  # the usual one, however unevenly it was sampled


def _after_holes(t_s: Floats, time_constant_s: float) -> Bools:
    """(N,) samples that come so soon after a hole in the log that the servo still shows it; ``t_s`` (N,)."""
    before = holes(t_s)
    lacking = t_s[before + 1] - t_s[before] - _usual_step_s(t_s)
    until = np.full(t_s.size, -np.inf)
    until[before + 1] = t_s[before + 1] + SETTLED * np.minimum(lacking, time_constant_s)
    return np.asarray(t_s <= np.maximum.accumulate(until))


def _within_after(flag: Bools, t_s: Floats, span_s: float) -> Bools:
    """Samples that come less than ``span_s`` after one where ``flag`` holds; (N, k)."""
    last = np.where(flag, t_s[:, None], -np.inf)
    np.maximum.accumulate(last, axis=0, out=last)
    return np.asarray(t_s[:, None] - last < span_s)


def motion_numbers(runs: Sequence[Run]) -> list[int]:
    """Number the motions: repeats, and runs whose commands are the same, share a number.

    A fold never splits a motion: a fitted run must not meet its twin among the held-out ones.
    """
    parent = list(range(len(runs)))
    told = [CommandedMotion.of(run) for run in runs]

    def root(i: int) -> int:
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    for i, run in enumerate(runs):
        for j in repeated(runs, run):
            if same_motion(told[i], told[j], claimed=True) is not None:
                parent[root(i)] = root(j)
    for i in range(len(runs)):
        for j in range(i):
            if root(i) != root(j) and same_motion(told[i], told[j]) is not None:
                parent[root(i)] = root(j)
    order: dict[int, int] = {}
    return [order.setdefault(root(i), len(order)) for i in range(len(runs))]


def repeated(runs: Sequence[Run], run: Run) -> list[int]:
    """Index of the run that ``run`` says to repeat, if it is there."""
    return [j for j, other in enumerate(runs) if other is not run and other.name == run.repeat_of]
