"""The least of a quadratic within bounds: a few dozen unknowns, thousands of times in a diagnosis."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.sizes import ROUNDING
from snakebot.physics.compiled import jit

# Turns of a search, or of a reweighted least squares, at most; chosen. Ten are the rule, forty have been seen.
MOST_TURNS = 200


def minimum_within(curvature: Floats, pull: Floats, least: Floats, most: Floats, begin: Floats) -> Floats:
    """(m,) the minimum of 1/2 x A x - b x within bounds, A ``curvature`` (m, m) and b ``pull`` (m,); the search
    begins at ``begin`` (m,), which is within them.
    """
    found = begin.copy()
    if _descend_within(curvature, pull, least, most, found, ROUNDING):
        return found
    from scipy.optimize import lsq_linear

    # it goes in circles; as a least-squares problem: A = R' R, and R x = R'^-1 b
    root = np.linalg.cholesky(curvature).T
    return np.asarray(lsq_linear(root, np.linalg.solve(root.T, pull), (least, most), method="bvls").x)


@jit
def _descend_within(curvature: Any, pull: Any, least: Any, most: Any, found: Any, none: float) -> bool:
    """Move ``found`` (m,) to that minimum; whether it got there. Values stay at the bounds that they meet, one more
    each turn, until none is met; then the one that would go back furthest is let go (Nocedal and Wright 2006, 16.5).

    none: slope, in standard errors, that holds a value at its bound.
    """
    side = np.zeros(found.size)  # of those that stay: -1 at the lower bound, 1 at the upper one
    for i in range(found.size):
        side[i] = -1.0 if found[i] <= least[i] else 1.0 if found[i] >= most[i] else 0.0
    for _ in range(MOST_TURNS):
        system, wanted = curvature.copy(), pull.copy()
        for i in range(found.size):
            if side[i] != 0.0:
                system[i] = 0.0
                system[i, i], wanted[i] = 1.0, found[i]
        there = np.linalg.solve(system, wanted)
        met, part = -1, 1.0
        for i in range(found.size):
            if side[i] == 0.0 and not least[i] <= there[i] <= most[i]:
                bound = least[i] if there[i] < least[i] else most[i]
                reached = (bound - found[i]) / (there[i] - found[i])
                if reached < part:
                    met, part = i, reached
        for i in range(found.size):
            if side[i] == 0.0:
                found[i] += part * (there[i] - found[i])
        if met >= 0:
            side[met] = -1.0 if there[met] < least[met] else 1.0
            found[met] = least[met] if side[met] < 0.0 else most[met]
            continue
        slope = curvature @ found - pull
        back, furthest = -1, none
        for i in range(found.size):
            away = side[i] * slope[i] / math.sqrt(curvature[i, i])
            if away > furthest:
                back, furthest = i, away
        if back < 0:
            return True
        side[back] = 0.0
    return False
