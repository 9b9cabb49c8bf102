"""The noise floor: how far two runs of the same motion differ, and what white noise the readings carry."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from snakebot.arrays import Bools, Floats, Ints
from snakebot.diagnosis.evidence.blocks import marked
from snakebot.diagnosis.evidence.data import BRIEF_S, MIN_SAMPLES, QUARTERS, Data, PreparedRun
from snakebot.diagnosis.evidence.disturbances import Disturbance, disturbance, disturbed, in_words
from snakebot.diagnosis.evidence.repeats import (
    RepeatDifference,
    change_warnings,
    doubt_warning,
    repeated_pairs,
)
from snakebot.diagnosis.sizes import CLEAR, LITTLE, MUCH, NEARLY_ALL, NEXT_TO_NOTHING, OUTSTANDING
from snakebot.robust import MAD_TO_STD


@dataclass(frozen=True, eq=False)
class Floor:
    """Noise a joint, as standard deviations in rad.

    Attributes:
        repeat_rad: (k,) from repeated runs, nan without any: noise of readings and of the motion itself.
        white_rad: (k,) white part of the readings, from their third differences; at least the quantiser's.
        pairs: number of pairs of runs behind ``repeat_rad``.
        like: pairs of runs that did the same at the same times, as far as noise goes, from end to end.
        warnings: of pairs of runs between which the robot changed, and of times at which they part, which are not in
            the floor; and of the largest difference in it that is a function of the motion.
        doubts: joints (0-based) whose floor is large enough to hide a gap that is plain to see, and a warning of each.
    """

    repeat_rad: Floats
    white_rad: Floats
    pairs: int
    quantiser_rad: float
    like: frozenset[tuple[int, int]] = frozenset()
    warnings: tuple[str, ...] = ()
    doubts: Mapping[int, str] = field(default_factory=dict)

    @property
    def rad(self) -> Floats:
        """(k,) the floor used everywhere: repeats where there are any, else the white part; not under the quantiser's.

        A robot that repeats itself to the count is still only read to the count.
        """
        known = np.where(np.isfinite(self.repeat_rad), self.repeat_rad, self.white_rad)
        return np.asarray(np.maximum(known, self.quantiser_rad))

    @property
    def known(self) -> bool:
        """Whether the floor comes from repeats, so that it holds more than sensor noise."""
        return self.pairs > 0


def noise_floor(data: Data, nominal: Sequence[Floats] | None = None) -> Floor:
    """Estimate the floor of a session.

    Args:
        nominal: predicted readings (N, k) a run, for robots that changed between repeats to be told from noise.
    """
    k = data.joints
    white = np.array([white_noise(data, joint) for joint in range(k)])
    squares: list[list[Floats]] = [[] for _ in range(k)]
    pairs = repeated_pairs(data, white, nominal)
    found: list[Disturbance] = []
    for pair in pairs:
        for difference in pair.differences:
            if difference.joint not in pair.changed:
                place, square = _by_block(data.runs[pair.one], difference)
                times = disturbed(place, square, white[difference.joint])
                squares[difference.joint].append(square[~marked(times, square.size)])
                found += [disturbance(data, pair, difference, place[blocks]) for blocks in times]
    parted = {(one.one, one.other) for one in found}
    repeat = np.array([_trimmed_root(np.concatenate(s)) if s else np.nan for s in squares])
    doubtful = [] if nominal is None else np.flatnonzero(_doubtful(data, nominal, repeat, white)).tolist()
    return Floor(
        repeat_rad=repeat,
        white_rad=white,
        pairs=sum(any(d.joint not in p.changed for d in p.differences) for p in pairs),
        quantiser_rad=data.quantiser_rad,
        like=frozenset(
            (p.one, p.other)
            for p in pairs
            if not p.changed and (p.one, p.other) not in parted and abs(p.shift_s) < BRIEF_S
        ),
        warnings=(*change_warnings(data, pairs), *in_words(data, found)),
        doubts={joint: doubt_warning(data, pairs, joint) for joint in doubtful},
    )


def _doubtful(data: Data, nominal: Sequence[Floats], repeat_rad: Floats, white_rad: Floats) -> Bools:
    """(k,) joints whose repeats are so far apart that they would hide a gap that is plain to see: not little beside the
    commanded motion, but not clearly more than the floor, which stands out of the white noise.

    What changes in mid-run does not depend on the motion, and need not be noise.
    """
    doubtful = np.zeros(data.joints, dtype=bool)
    for joint in range(data.joints):
        floor = repeat_rad[joint]
        if not floor > OUTSTANDING * white_rad[joint]:  # nan: no repeats
            continue
        gap = np.concatenate(
            [(r.measured_rad - p)[r.use[:, joint], joint] for r, p in zip(data.runs, nominal, strict=True)]
        )
        told = np.concatenate([r.command_rad[r.use[:, joint], joint] for r in data.runs])
        size = float(np.square(gap).mean())
        doubtful[joint] = LITTLE**2 * float(np.var(told)) < size < (CLEAR * floor) ** 2
    return doubtful


def _by_block(run: PreparedRun, difference: RepeatDifference) -> tuple[Ints, Floats]:
    """Blocks of a run, and half the mean square of a difference in each."""
    blocks = run.blocks[difference.rows]
    counts = np.bincount(blocks)
    kept = counts > 2
    square = 0.5 * np.square(difference.rad)
    return np.flatnonzero(kept), np.asarray(np.bincount(blocks, weights=square)[kept] / counts[kept])


def _trimmed_root(squares: Floats) -> float:
    ordered = np.sort(squares)
    kept = ordered[: max(1, int(np.ceil(ordered.size * (1 - NEXT_TO_NOTHING))))]
    return float(np.sqrt(kept.mean()))


def white_noise(data: Data, joint: int) -> float:
    """Standard deviation of what changes from sample to sample, from third differences of evenly spaced samples."""
    return _calm_scatter([_third_differences(run, joint) for run in data.runs], data.quantiser_rad)


def white_noise_by_part(data: Data, joint: int) -> list[float]:
    """The same of each quarter of each run, as far as it is known there."""
    parts = [
        part
        for run in data.runs
        for part in zip(*(np.array_split(x, QUARTERS) for x in _third_differences(run, joint)), strict=True)
    ]
    return [_calm_scatter([part], data.quantiser_rad) for part in parts if part[0].size >= MIN_SAMPLES]


def _third_differences(run: PreparedRun, joint: int) -> tuple[Floats, Floats]:
    """(n,) of the readings, as wide as white noise in them; (n,) by how much the commanded motion bends there."""
    use = run.use[:, joint]
    if use.sum() < MIN_SAMPLES:
        return np.zeros(0), np.zeros(0)
    dt = np.diff(run.t_s)
    even = np.abs(dt - run.period_s) < MUCH * run.period_s
    whole = use[:-3] & use[1:-2] & use[2:-1] & use[3:] & even[:-2] & even[1:-1] & even[2:]
    third = np.diff(run.measured_rad[:, joint], n=3)[whole]
    bent = np.abs(np.diff(run.command_rad[:, joint], n=3))[whole]
    return third / np.sqrt(20.0), bent  # of white noise: 1 + 9 + 9 + 1 times its variance


def _calm_scatter(parts: Sequence[tuple[Floats, Floats]], least: float) -> float:
    """Standard deviation of differences (n,), at least ``least``. The half of them counts where the commanded motion
    bends less: where the joint hardly moves, nothing but noise is left.
    """
    value, bent = (np.concatenate([part[i] for part in parts] or [np.zeros(0)]) for i in (0, 1))
    if value.size < MIN_SAMPLES:
        return least
    calm = value[bent <= np.quantile(bent, 0.5)]
    rms = np.sqrt(np.mean(np.square(_clip(calm))))  # a median may be small by chance
    return float(max(MAD_TO_STD * np.median(np.abs(calm)), NEARLY_ALL * rms, least))


def _clip(x: Floats) -> Floats:
    bound = OUTSTANDING * MAD_TO_STD * np.median(np.abs(x))
    return np.clip(x, -bound, bound)
