"""Amplitudes of single joints: from a gait with equal ones uphill, in a taper or in each joint alone.

A taper is one number more, and the same for every robot: amplitudes fall evenly from tail to head or from head to tail.
Each joint alone is as many more as there are joints, and costs as much more; it is what a robot with one weak joint
wants. Either begins at the best gait with equal amplitudes, and is never worse than that.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from snakebot.arrays import Floats
from snakebot.optimise.search import GRID, Search

Amplitudes = Literal["equal", "taper", "each"]
LEAST = 0.1  # share of alpha that a joint keeps; chosen
FIRST, SHORTEST_SHARE = 0.2, 0.025  # steps in a share; chosen
ROUNDS = 3  # of shares, then alpha, beta and omega; chosen
LEAST_BETTER = 1e-3  # share of a score by which a round must improve it to be followed by another; chosen


def shaped(
    search: Search, best: Floats, joints: int, kind: Amplitudes, size: tuple[int, int, int] = GRID
) -> Floats:
    """The best gait found (3 + joints,): alpha, beta and omega, then each joint's share of alpha.

    Args:
        search: a new one; its simulator takes such rows.
        best: (3,) the gait with equal amplitudes to begin with.
    """
    start = np.concatenate([best[:3], np.ones(joints)])
    (gait,), (score,) = search.tried(start[None, :])
    for _ in range(ROUNDS):
        before = float(score)
        nearer = _uphill(search, gait, kind)
        nearer, found = search.uphill(nearer, size, first=0.25, shortest=1 / 8)
        if found <= before:
            break
        gait, score = nearer, found
        if found - before < LEAST_BETTER * abs(before):
            break
    return np.asarray(gait)


def taper(amount: float, joints: int) -> Floats:
    """Shares that fall evenly to ``1 - amount`` at the tail, or, where ``amount`` is negative, to the head."""
    ends = (1 - amount, 1.0) if amount >= 0 else (1.0, 1 + amount)
    return np.linspace(*ends, joints)


def _uphill(search: Search, gait: Floats, kind: Amplitudes) -> Floats:
    """The best shares at this gait; where the goal is a speed, with the omega that brings it."""
    rows, scores = search.tried(gait[None, :], thorough=False)
    best, score, step = rows[0], scores[0], FIRST
    while step >= SHORTEST_SHARE:
        around = np.array(_around(best, step, kind))
        rows, scores = search.tried(search.space.nearest(around), thorough=False)
        if scores.max() > score:
            best, score = rows[np.argmax(scores)], scores.max()
        else:
            step /= 2
    return np.asarray(best)


def _around(gait: Floats, step: float, kind: Amplitudes) -> list[Floats]:
    """Neighbours in the shares. Where one rises above 1, alpha rises and the others stay what they are."""
    shares = gait[3:]
    if kind == "taper":
        now = float(shares[-1] - shares[0])
        moved = [taper(float(np.clip(now + s, LEAST - 1, 1 - LEAST)), len(shares)) for s in (step, -step)]
    else:
        moved = [shares + s * row for row in np.eye(len(shares)) for s in (step, -step)]
    found = []
    for row in moved:
        most = float(row.max())
        found.append(np.concatenate([[gait[0] * most], gait[1:3], np.maximum(row / most, LEAST)]))
    return found
