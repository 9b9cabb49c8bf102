"""Whether two runs are one motion: their commands are the same, at equal times or with a shift in time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Bools, Floats
from snakebot.runlog.matching.shift import find_shift

if TYPE_CHECKING:
    from snakebot.runlog.run import Run


SAME_COMMAND = 0.01  # of a command's amplitude, closer than which two set-points are the same; chosen
# Range of a command below which the joint stands still: one count of a 12 bit encoder is 1.5e-3.
STILL_RAD = 2e-3
# Share of the samples of all joints that move, and of each joint, that must be the same; chosen. A joint may differ
# longer than all together: while it ramps up from where it stood.
SAME_SHARE, SAME_SHARE_JOINT = 0.95, 0.8
# The same for a run that says itself that it repeats the other: there some samples may differ (a link that lost some).
CLAIMED_SHARE, CLAIMED_SHARE_JOINT = 0.8, 0.5
# Rms of what the commands differ by, over their own, beyond which the motion is another one; chosen.
FAR_OFF = 0.25
COMMON_SHARE = 0.5  # share of the shorter run that both must have in common; chosen
# Of the longer run, by which runs may differ in length if none claims to repeat the other; chosen.
SAME_LENGTH = 0.1
NO_SHIFT = 0.05  # of a sample's interval: a shift that small is the jitter of the ticks; chosen
NEARBY = 1.5  # sample intervals, within which a shift is looked for first; chosen
FEWEST = 8  # samples, below which nothing is said


@dataclass(frozen=True, eq=False)
class CommandedMotion:
    """What a robot was told: times (N,), rising; set-points (N, k), nan = servo off; whether it was off the ground."""

    t_s: Floats
    command_rad: Floats
    lifted: bool = False

    @staticmethod
    def of(run: Run) -> CommandedMotion:
        """The motion that was commanded in a run."""
        return CommandedMotion(run.t_s, run.command_rad, run.metadata.get("lifted") is True)


@dataclass(frozen=True, eq=False)
class Match:
    """Where one motion lies in another.

    Attributes:
        shift_s: what the one is told at ``t``, the other is told at ``t + shift_s``, both from their first samples.
        same: (N, k) samples of the one at which both are told the same.
    """

    shift_s: float
    same: Bools


def same_motion(one: CommandedMotion, other: CommandedMotion, *, claimed: bool = False) -> Match | None:
    """Whether two runs are one motion; None if not.

    They are if, at equal times from their first samples, nearly all set-points are the same. A joint that is commanded
    to stand still in both must stand at the same angle, but is no evidence of a repeat: where none moves, nothing is.

    Args:
        claimed: one of the two says itself that it repeats the other. Then their logs may begin at other times, cover
            different parts of the motion, and differ at more samples.
    """
    if one.lifted != other.lifted or one.command_rad.shape[1] != other.command_rad.shape[1]:
        return None
    if min(one.t_s.size, other.t_s.size) < FEWEST:
        return None
    pair = _Pair(one, other)
    if not pair.moving.any():
        return None
    if not claimed:
        longer = max(pair.ta[-1], pair.tb[-1])
        if abs(pair.ta[-1] - pair.tb[-1]) > SAME_LENGTH * longer:
            return None
        return pair.match(0.0, SAME_SHARE, SAME_SHARE_JOINT)
    return pair.best_match()


def same_command(a_rad: Floats, b_rad: Floats, size_rad: Floats) -> Bools:
    """(N, k) samples at which two series of set-points (N, k), nan = servo off, are the same.

    They are within ``SAME_COMMAND`` of the amplitudes ``size_rad`` (k,), or within half of the step that the first one
    makes there: an edge may come half a sample sooner or later.
    """
    step = np.abs(np.diff(a_rad, axis=0, prepend=a_rad[:1]))
    steepest = np.fmax(step, np.vstack([step[1:], step[-1:]]))
    room = SAME_COMMAND * size_rad + 0.5 * np.nan_to_num(steepest)
    on_a, on_b = np.isfinite(a_rad), np.isfinite(b_rad)
    return np.asarray(np.where(on_a & on_b, np.abs(a_rad - b_rad) <= room, ~on_a & ~on_b))


class _Pair:
    """The commands of two motions, times from zero."""

    def __init__(self, one: CommandedMotion, other: CommandedMotion) -> None:
        self.ta, self.a = one.t_s - one.t_s[0], one.command_rad
        self.tb, self.b = other.t_s - other.t_s[0], other.command_rad
        self.period_s = float(max(np.median(np.diff(self.ta)), np.median(np.diff(self.tb))))
        self.moving = np.maximum(_ranges(self.a), _ranges(self.b)) > STILL_RAD  # (k,)
        self.size_rad = np.where(self.moving, _sizes(self.a), STILL_RAD / SAME_COMMAND)  # (k,)

    def best_match(self) -> Match | None:
        """The match at the shift nearest to none, else at the best shift of all."""
        columns = np.flatnonzero(self.moving)
        a, b = self.a[:, columns] / self.size_rad[columns], self.b[:, columns] / self.size_rad[columns]
        for most_s in (NEARBY * self.period_s, None):
            found = find_shift(self.ta, a, self.tb, b, most_s=most_s, offsets=False, min_overlap=COMMON_SHARE)
            if found is None:
                continue
            shift_s = 0.0 if abs(found.shift_s) < NO_SHIFT * self.period_s else found.shift_s
            match = self.match(shift_s, CLAIMED_SHARE, CLAIMED_SHARE_JOINT)
            if match is not None:
                return match
        return None

    def match(self, shift_s: float, share: float, share_joint: float) -> Match | None:
        """The two at a shift, or None where too few samples are the same there."""
        t_s = self.ta + shift_s
        inside = (t_s >= -1e-9) & (t_s <= self.tb[-1] + 1e-9)
        if inside.sum() * np.median(np.diff(self.ta)) < COMMON_SHARE * min(self.ta[-1], self.tb[-1]):
            return None
        other = np.stack([np.interp(t_s, self.tb, column) for column in self.b.T], axis=1)
        other[~inside] = np.nan
        same = same_command(self.a, other, self.size_rad) & inside[:, None]
        asked = (np.isfinite(self.a) | np.isfinite(other)) & inside[:, None]
        relative = ((self.a - other) / self.size_rad)[:, self.moving]
        both = np.isfinite(relative)
        if not both.any() or float(np.sqrt(np.square(relative[both]).mean())) > FAR_OFF:
            return None
        counted, agreed = asked.sum(axis=0), (same & asked).sum(axis=0)  # (k,)
        if agreed[self.moving].sum() < share * counted[self.moving].sum():
            return None
        return Match(shift_s, same) if np.all(agreed >= share_joint * counted) else None


def _ranges(command_rad: Floats) -> Floats:
    """(k,) range of each column; zero without a number."""
    known = np.isfinite(command_rad)
    high = np.where(known, command_rad, -np.inf).max(axis=0)
    low = np.where(known, command_rad, np.inf).min(axis=0)
    return np.where(known.any(axis=0), high - low, 0.0)


def _sizes(command_rad: Floats) -> Floats:
    """(k,) amplitude of each column: its standard deviation, and a little of the largest angle."""
    out = np.zeros(command_rad.shape[1])
    for j, column in enumerate(command_rad.T):
        known = column[np.isfinite(column)]
        if known.size:
            out[j] = np.std(known) + 0.05 * np.max(np.abs(known))
    return out + 1e-9
