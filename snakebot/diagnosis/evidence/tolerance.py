"""What the nominal numbers may be off by is no gap, and no noise either: it is fitted, within what is credible, beside
every cause.

A simulation knows the lag of its servos to some per cent, the wire's latency to a millisecond, friction and mass to a
few per cent (``Robot.tolerance``, one standard deviation each). To widen the noise by all that would hide small causes
behind it. So each explanation, the nominal one too, may first let each joint lag a little more or less, and change
friction and mass, by no more than is credible; what is left over counts. Explanations that set such a number themselves
get no tolerance there.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from snakebot.arrays import Floats, Ints
from snakebot.diagnosis.evidence.within_bounds import MOST_TURNS, minimum_within
from snakebot.diagnosis.sizes import BEYOND_CHANCE, NEXT_TO_NOTHING
from snakebot.physics.compiled import jit
from snakebot.robot import Robot


def shift_limit_s(robot: Robot) -> float:
    """How much later or earlier than stated a joint may be."""
    return BEYOND_CHANCE * math.hypot(robot.lag_spread_s, robot.tolerance.delay_s)


@dataclass(frozen=True, eq=False)
class ShiftLimits:
    """How much later or earlier than stated joints may be.

    Joints for which an explanation sets one delay or lag are late as
    that says in the mean, and differ from each other as servos do.

    Attributes:
        each_s: (k,) of each joint; zero where an explanation sets that of this joint alone.
        group: (k,) number of the joints that an explanation sets together; -1 where it does not.
    """

    each_s: Floats
    group: Ints

    @staticmethod
    def of(robot: Robot, set_together: Iterable[Collection[int]] = ()) -> ShiftLimits:
        """``set_together``: joints (0-based) for which an explanation sets the delay, by one number each."""
        each, group = np.full(robot.joints, shift_limit_s(robot)), np.full(robot.joints, -1)
        for number, joints in enumerate(
            sorted(set_together, key=len, reverse=True)
        ):  # the narrowest says most
            group[list(joints)] = number
            each[list(joints)] = BEYOND_CHANCE * robot.lag_spread_s if len(joints) > 1 else 0.0
        return ShiftLimits(each, group)

    @staticmethod
    def none(joints: int) -> ShiftLimits:
        """Joints are exactly as late as stated."""
        return ShiftLimits(np.zeros(joints), np.full(joints, -1))

    def of_joints(self, columns: Ints) -> ShiftLimits:
        """Of some joints (0-based)."""
        return ShiftLimits(self.each_s[columns], self.group[columns])

    @property
    def any(self) -> bool:
        return bool(self.each_s.any())

    def within(self, shift_s: Floats) -> Floats:
        """(k,) the nearest shifts that are credible."""
        out = np.array(shift_s)
        for number in np.unique(self.group[self.group >= 0]):
            mine = (self.group == number) & (self.each_s > 0)
            if mine.any():
                out[mine] -= np.median(out[mine])
        return np.asarray(np.clip(out, -self.each_s, self.each_s))


@dataclass(frozen=True, eq=False)
class StackedTimes:
    """When the samples of some runs were taken, one run below the other (N in all), and what a lag makes of them.

    Attributes:
        before, after: (N,) neighbours of each sample; the first and the last of a run are their own.
        span_s: (N,) from the one to the other.
        ends: (runs,) where each run ends.
        kept: (N,) what the nominal lag leaves of the past from the sample before to this one; (0,) without a lag.
    """

    before: Ints
    after: Ints
    span_s: Floats
    ends: Ints
    kept: Floats

    @staticmethod
    def of(times_s: Sequence[Floats], time_constant_s: float) -> StackedTimes:
        """``times_s``: of two samples or more in each run; ``time_constant_s``: of the stated lag, 0 for none."""
        t_s = np.concatenate(times_s)
        ends = np.cumsum([t.size for t in times_s])
        before, after = np.arange(-1, t_s.size - 1), np.arange(1, t_s.size + 1)
        begins = ends - [t.size for t in times_s]
        before[begins], after[ends - 1] = begins, ends - 1
        kept = np.zeros(0)
        if time_constant_s > 0:
            kept = np.exp(-(t_s - t_s[before]) / time_constant_s)
        return StackedTimes(before, after, t_s[after] - t_s[before], ends, kept)

    def rates(self, reading_rad: Floats) -> Floats:
        """Time derivative (N, k) of predicted readings, by central differences."""
        rate = np.empty(reading_rad.shape)
        _rates(np.ascontiguousarray(reading_rad), self.before, self.after, self.span_s, rate)
        return rate

    def lag_marks(self, reading_rad: Floats) -> Floats:
        """Change (N, k) of predicted readings for each second that the servo's time constant is less than stated.

        For a first-order lag 1 / (1 + T s) that is its rate, behind the same lag once more.
        """
        rate = self.rates(reading_rad)
        if self.kept.size:
            _behind_lag(rate, self.kept, self.ends)
        return rate


@jit
def _rates(reading: Any, before: Any, after: Any, span_s: Any, out: Any) -> None:
    """Time derivative (N, k) of readings, by central differences."""
    for n in range(reading.shape[0]):
        for j in range(reading.shape[1]):
            out[n, j] = (reading[after[n], j] - reading[before[n], j]) / span_s[n]


@jit
def _behind_lag(rate: Any, kept: Any, ends: Any) -> None:
    """A first-order lag, in place, run by run; ``kept``: (N,) what is left of the past from sample to sample."""
    for j in range(rate.shape[1]):
        first = 0
        for end in ends:
            lagging, last = rate[first, j], rate[first, j]
            for n in range(first + 1, end):
                coming = rate[n, j]
                lagging = kept[n] * lagging + (1.0 - kept[n]) * 0.5 * (last + coming)
                rate[n, j], last = lagging, coming
            first = end


def shifts_s(
    residual: Floats, mark: Floats, block: Ints, allowed_square: Floats, limits: ShiftLimits
) -> Floats:
    """(k,) by how much less each joint lags than stated, as far as credible, where that takes most off its residual.

    Args:
        residual, mark: (N, k) of all runs, one below the other; see ``StackedTimes.lag_marks``.
        block: (N, k) block of each sample, -1 where unused.
        allowed_square: (B,). Blocks with large residuals weigh less, as they do in the score.
        limits: of the k joints.
    """
    k = block.shape[1]
    gained, power = np.zeros(k), np.zeros(k)
    _projected(residual, mark, block, allowed_square, gained, power)
    shift = np.divide(gained, power, out=np.zeros(k), where=power > 0)
    return limits.within(shift)


@jit
def _projected(residual: Any, mark: Any, block: Any, allowed_square: Any, gained: Any, power: Any) -> None:
    """Weighted products of each column of ``mark`` with the residual and with itself, added to (k,) and (k,)."""
    square, size = np.zeros(allowed_square.size), np.zeros(allowed_square.size)
    for n in range(block.shape[0]):
        for j in range(block.shape[1]):
            if block[n, j] >= 0:
                square[block[n, j]] += residual[n, j] * residual[n, j]
                size[block[n, j]] += 1.0
    for n in range(block.shape[0]):
        for j in range(block.shape[1]):
            b = block[n, j]
            if b >= 0:
                weight = 1.0 / (allowed_square[b] + square[b] / size[b])
                gained[j] += weight * residual[n, j] * mark[n, j]
                power[j] += weight * mark[n, j] * mark[n, j]


def bounded_share(
    residual: Floats, marks: Floats, least: Floats, most: Floats, spread: Floats, allowed_square: Floats
) -> Floats:
    """(m,) shares, from ``least`` to ``most`` and believed within ``spread`` of zero (m,), of the ``marks`` (F, m) that
    take most off a residual (F,).

    Features with large residuals weigh less, as they do in the score. Shares that change little stay near zero. Where
    each is credible, but not all of them at once, all are as much smaller as makes their distance so.
    """
    usable = np.isfinite(residual)
    if marks.shape[1] == 0 or not usable.any():
        return np.zeros(marks.shape[1])
    matrix, wanted, allowed = marks[usable], residual[usable], allowed_square[usable]
    share, left = np.zeros(marks.shape[1]), wanted
    for _ in range(MOST_TURNS):
        weight = 1.0 / (allowed + np.square(left))
        curvature = (matrix * weight[:, None]).T @ matrix + np.diag(1 / np.square(spread))
        before = share
        share = minimum_within(curvature, matrix.T @ (weight * wanted), least, most, share)
        left = wanted - matrix @ share
        if np.abs((share - before) / spread).max() < NEXT_TO_NOTHING:
            break
    distance = float(np.linalg.norm(share / spread))
    return share if distance <= BEYOND_CHANCE else share * (BEYOND_CHANCE / distance)
