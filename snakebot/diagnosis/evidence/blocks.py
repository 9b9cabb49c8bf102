"""Scores by blocks of time: residuals of one run are correlated, so the block is the unit of evidence.

A block is a second, or a quarter of a short run. Its number is unique over all runs, so that arrays of blocks from
different explanations of the same data can be compared one to one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Bools, Floats, Ints
from snakebot.diagnosis.evidence.data import Data
from snakebot.diagnosis.sizes import MOST_TOLD, MUCH, NEARLY_ALL, OUTSTANDING

# Correlation of neighbouring blocks that is believed at most: it makes an error three times as large.
MOST_CORRELATED = NEARLY_ALL


@dataclass(frozen=True, eq=False)
class BlockMap:
    """Which block every sample of every run and joint belongs to.

    Attributes:
        of_sample: per run (N, k), the block or -1 where the sample is not used.
        run, joint, samples: (B,) of each block.
        place: (B,) its number in its run: neighbours in time follow each other.
    """

    of_sample: tuple[Ints, ...]
    run: Ints
    joint: Ints
    samples: Floats
    place: Ints

    @property
    def count(self) -> int:
        return int(self.run.size)

    def mean_square(self, residual: list[Floats] | tuple[Floats, ...]) -> Floats:
        """Mean square of each block (B,); ``residual`` holds (N, k) a run, values where not used are ignored."""
        total = np.zeros(self.count)
        for blocks, r in zip(self.of_sample, residual, strict=True):
            used = blocks >= 0
            total += np.bincount(blocks[used], weights=np.square(r[used]), minlength=self.count)
        return total / self.samples


def block_map(data: Data) -> BlockMap:
    """Number the blocks of all runs and joints."""
    of_sample: list[Ints] = []
    run_of: list[Ints] = []
    joint_of: list[Ints] = []
    samples_of: list[Floats] = []
    place_of: list[Ints] = []
    first = 0
    for index, run in enumerate(data.runs):
        number = np.full(run.use.shape, -1, dtype=np.int64)
        usual = np.median(np.bincount(run.blocks))
        for joint in range(run.use.shape[1]):
            used = run.use[:, joint]
            counts = np.bincount(run.blocks[used], minlength=int(run.blocks[-1]) + 1)
            kept = np.flatnonzero(counts >= max(2.0, MUCH * usual))
            new = np.full(counts.size, -1, dtype=np.int64)
            new[kept] = first + np.arange(kept.size)
            number[used, joint] = new[run.blocks[used]]
            run_of.append(np.full(kept.size, index, dtype=np.int64))
            joint_of.append(np.full(kept.size, joint, dtype=np.int64))
            samples_of.append(counts[kept].astype(np.float64))
            place_of.append(kept)
            first += kept.size
        of_sample.append(number)
    return BlockMap(
        tuple(of_sample),
        np.concatenate(run_of),
        np.concatenate(joint_of),
        np.concatenate(samples_of),
        np.concatenate(place_of),
    )


@dataclass(frozen=True)
class MeanDifference:
    """A mean over blocks with its standard error."""

    mean: float
    se: float

    @property
    def z(self) -> float:
        return self.mean / self.se if self.se > 0 else (np.inf if self.mean > 0 else 0.0)


def mean_difference(gain: Floats, cluster: Ints) -> MeanDifference:
    """Mean of ``gain`` over blocks, with its standard error.

    Neighbouring blocks of one run are alike: their correlation, to lag one, widens the error. Runs differ by what they
    show, not by chance alone (a slow gait says nothing about a rate limit), so the spread between runs is no error;
    but where each has one block, nothing else tells of chance.
    """
    n = gain.size
    if n < 2:
        return MeanDifference(float(gain.mean()) if n else 0.0, np.inf)
    mean = float(gain.mean())
    if np.unique(cluster).size == n:
        cluster = np.zeros_like(cluster)
    names, index, counts = np.unique(cluster, return_inverse=True, return_counts=True)
    centred = gain - (np.bincount(index, weights=gain) / counts)[index]
    freedom = max(n - names.size, 1)
    variance = float(centred @ centred) / freedom
    same = cluster[1:] == cluster[:-1]
    lagged = float((centred[1:] * centred[:-1])[same].sum()) / freedom
    rho = float(np.clip(lagged / variance, 0.0, MOST_CORRELATED)) if variance > 0 else 0.0
    return MeanDifference(mean, float(np.sqrt(variance / n * (1 + rho) / (1 - rho))))


def few_stretches(run: Ints, place: Ints, square: Floats, usual: Floats | float) -> list[Ints]:
    """Blocks (indices) that stand out of the usual mean square, together where they follow each other in a run; none
    where these are more than ``MOST_TOLD`` stretches.

    Args:
        run, place: (b,) of each block, in ascending order.
    """
    high = np.flatnonzero(square > OUTSTANDING**2 * usual)
    if not high.size:
        return []
    parted = (np.diff(run[high]) != 0) | (np.diff(place[high]) > 1)
    parts = np.split(high, np.flatnonzero(parted) + 1)
    return parts if len(parts) <= MOST_TOLD else []


def marked(stretches: Sequence[Ints], count: int) -> Bools:
    """(count,) which blocks are in any of the stretches."""
    out = np.zeros(count, dtype=bool)
    for stretch in stretches:
        out[stretch] = True
    return out


def resample(cluster: Ints, rng: np.random.Generator, draws: int) -> Ints:
    """Block bootstrap: (draws, B) block numbers, drawn with replacement within each cluster (run).

    Gaits stay as they are: the interval says what other samples of the same motions would have given.
    """
    out = np.empty((draws, cluster.size), dtype=np.int64)
    start = 0
    order = np.argsort(cluster, kind="stable")
    for count in np.bincount(cluster):
        if count:
            mine = order[start : start + count]
            out[:, start : start + count] = mine[rng.integers(0, count, size=(draws, count))]
            start += count
    return out
