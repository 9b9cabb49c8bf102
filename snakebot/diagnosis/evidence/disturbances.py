"""Times at which two runs of a motion part and are alike elsewhere: something happened in one of them, no noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Floats, Ints
from snakebot.diagnosis.evidence.blocks import few_stretches, marked
from snakebot.diagnosis.evidence.data import Data
from snakebot.diagnosis.evidence.repeats import RepeatDifference, RepeatedPair
from snakebot.diagnosis.sizes import MOST_TOLD, OUTSTANDING
from snakebot.in_words import numbered


@dataclass(frozen=True)
class Disturbance:
    """A joint (0-based) in a stretch of two runs (indices) of a motion.

    Attributes:
        begin_s, end_s: by the clock of ``one``.
        rms_rad: of the difference in it.
    """

    one: int
    other: int
    joint: int
    begin_s: float
    end_s: float
    rms_rad: float


def disturbed(place: Ints, square: Floats, white_rad: float) -> list[Ints]:
    """Blocks (indices) in which two runs part as they do nowhere else, nearly: what friction does at one turn or
    another is not so far from what it does at the next.

    Args:
        place: (b,) numbers of the blocks in the one run, ascending.
        square: (b,) half the mean square of the difference in each.
        white_rad: noise of the readings.
    """
    if not square.size:
        return []
    usual = max(float(np.median(square)), white_rad**2)
    times = few_stretches(np.zeros_like(place), place, square, usual)
    high = marked(times, square.size)
    if not times or square[high].mean() < OUTSTANDING**2 * square[~high].max():
        return []
    return times


def disturbance(data: Data, pair: RepeatedPair, difference: RepeatDifference, place: Ints) -> Disturbance:
    """What two runs differ by in the blocks of these numbers."""
    run = data.runs[pair.one]
    mine = np.isin(run.blocks[difference.rows], place)
    t_s = run.t_s[difference.rows][mine]
    return Disturbance(
        pair.one,
        pair.other,
        difference.joint,
        float(t_s[0]),
        float(t_s[-1]),
        float(np.sqrt(np.square(difference.rad[mine]).mean())),
    )


def in_words(data: Data, found: Sequence[Disturbance]) -> list[str]:
    """A line for each time, of all joints together, the largest first, ``MOST_TOLD`` at most."""
    times: dict[tuple[int, int, int, int], list[Disturbance]] = {}
    for one in sorted(found, key=lambda d: -d.rms_rad):
        times.setdefault((one.one, one.other, round(one.begin_s), round(one.end_s)), []).append(one)
    lines = [_of_time(data, together) for together in list(times.values())[:MOST_TOLD]]
    if len(times) > MOST_TOLD:
        lines.append(f"so it is at {len(times) - MOST_TOLD} further times")
    return lines


def _of_time(data: Data, together: Sequence[Disturbance]) -> str:
    largest = together[0]
    joints = sorted({one.joint + 1 for one in together})
    one, other = data.runs[largest.one].name, data.runs[largest.other].name
    return (
        f"{numbered('joint', joints)}: {one} and {other}, the same motion, part from {largest.begin_s:.1f} to "
        f"{largest.end_s:.1f} s of {one}, by {np.degrees(largest.rms_rad):.2g} deg rms, and are alike elsewhere: "
        "something happened in one of them; this is not taken for noise"
    )
