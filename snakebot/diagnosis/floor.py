"""The noise floor: how far two runs of the same motion differ, and what white noise the readings carry."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.data import Data, PreparedRun

Floats = NDArray[np.float64]

TRIM = 0.05  # of the largest block differences, taken for mishaps of one run


@dataclass(frozen=True, eq=False)
class Floor:
    """Noise a joint, as standard deviations in rad.

    Attributes:
        repeat_rad: (k,) from repeated runs, nan without any: noise of readings and of the motion itself.
        white_rad: (k,) white part of the readings, from their third differences; at least the quantiser's.
        pairs: number of pairs of runs behind ``repeat_rad``.
        speed_m_s: standard deviation of forward speed from repeats, or None.
    """

    repeat_rad: Floats
    white_rad: Floats
    pairs: int
    speed_m_s: float | None
    quantiser_rad: float

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


def noise_floor(data: Data) -> Floor:
    """Estimate the floor of a session."""
    k = data.joints
    squares: list[list[Floats]] = [[] for _ in range(k)]
    pairs = 0
    speeds: list[float] = []
    for motion in data.motions:
        runs = [run for run in data.runs if run.motion == motion]
        for a, b in combinations(runs, 2):
            found = False
            for joint in range(k):
                difference = _difference(a, b, joint)
                if difference is not None:
                    squares[joint].append(difference)
                    found = True
            pairs += found
            if a.forward_speed_m_s is not None and b.forward_speed_m_s is not None:
                speeds.append((a.forward_speed_m_s - b.forward_speed_m_s) ** 2 / 2)
    repeat = np.array([_trimmed_root(np.concatenate(s)) if s else np.nan for s in squares])
    white = np.array([white_noise(data, joint) for joint in range(k)])
    return Floor(
        repeat, white, pairs, float(np.sqrt(np.mean(speeds))) if speeds else None, data.quantiser_rad
    )


def _difference(a: PreparedRun, b: PreparedRun, joint: int) -> Floats | None:
    """Half the mean square difference of two runs, block by block of the first."""
    ua, ub = a.use[:, joint], b.use[:, joint]
    if ua.sum() < 8 or ub.sum() < 8:
        return None
    tb = b.t_s[ub]
    inside = ua & (a.t_s >= tb[0]) & (a.t_s <= tb[-1])
    # a stretch that b lost cannot be bridged
    after = np.searchsorted(tb, a.t_s[inside])
    gap = tb[np.minimum(after, tb.size - 1)] - tb[np.maximum(after - 1, 0)]
    rows = np.flatnonzero(inside)[gap < 4 * b.period_s]
    if rows.size < 8:
        return None
    other = np.interp(a.t_s[rows], tb, b.measured_rad[ub, joint])
    square = 0.5 * np.square(a.measured_rad[rows, joint] - other)
    blocks = a.blocks[rows]
    counts = np.bincount(blocks)
    kept = counts > 2
    return np.asarray(np.bincount(blocks, weights=square)[kept] / counts[kept])


def _trimmed_root(squares: Floats) -> float:
    ordered = np.sort(squares)
    kept = ordered[: max(1, int(np.ceil(ordered.size * (1 - TRIM))))]
    return float(np.sqrt(kept.mean()))


def white_noise(data: Data, joint: int) -> float:
    """Standard deviation of what changes from sample to sample, from third differences of evenly spaced samples.

    A quarter of the differences that are smallest in the commanded motion count: where the joint hardly moves, nothing
    but noise is left.
    """
    found: list[Floats] = []
    weight: list[Floats] = []
    for run in data.runs:
        use = run.use[:, joint]
        if use.sum() < 12:
            continue
        dt = np.diff(run.t_s)
        even = np.abs(dt - run.period_s) < 0.3 * run.period_s
        whole = use[:-3] & use[1:-2] & use[2:-1] & use[3:] & even[:-2] & even[1:-1] & even[2:]
        third = np.diff(run.measured_rad[:, joint], n=3)[whole]
        moved = np.abs(np.diff(run.command_rad[:, joint], n=3))[whole]
        found.append(third / np.sqrt(20.0))
        weight.append(moved)
    least = data.quantiser_rad
    if not found:
        return least
    value, moved = np.concatenate(found), np.concatenate(weight)
    if value.size < 8:
        return least
    calm = value[moved <= np.quantile(moved, 0.5)]
    return float(max(1.4826 * np.median(np.abs(calm)), 0.8 * np.sqrt(np.mean(np.square(_clip(calm)))), least))


def _clip(x: Floats) -> Floats:
    bound = 4 * 1.4826 * np.median(np.abs(x))
    return np.clip(x, -bound, bound)
