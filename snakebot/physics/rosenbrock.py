"""One time step of a chain, compiled: Rosenbrock's method on the equations of motion in ``kernel``."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from snakebot.physics.compiled import in_place
from snakebot.physics.kernel import (
    PRESCRIBED,
    UU,
    WORK_ROWS,
    dissipation,
    generalised_to_links,
    kinematics,
    solve,
)

STAGE_ROWS = 18  # of the scratch; 7 to 13 are for the caller of ``step``

# Two-stage Rosenbrock method of second order for any approximation of the Jacobian, L-stable for this gamma with the
# exact one (Verwer, Spee, Blom & Hundsdorfer, SIAM J. Sci. Comput. 20(4), 1999: ROS2).
GAMMA = 1.0 - 1.0 / math.sqrt(2.0)


@in_place
def step(
    links: Any, slope_force: float, eps: Any, h: Any, kind: Any, base: Any, phi: Any, dphi: Any,
    acc: Any, phi_end: Any, dphi_end: Any, acc_end: Any, torque: Any, stiffness: Any, damping: Any,
    work: Any, stage: Any, mean_torque: Any, power: Any,
) -> None:  # fmt: skip
    """One step of ROS2 in place: ``base`` (6,), ``phi`` and ``dphi`` (n-1,) move on by ``h``.

    A prescribed joint goes to ``phi_end``, ``dphi_end``; its accelerations are ``acc`` and ``acc_end`` at the two ends.
    On another joint acts ``torque``, plus ``stiffness`` and ``damping`` times its distance from a reference that gets
    to ``phi_end``, ``dphi_end``, ``acc_end``: a stiff servo is a joint like that, treated implicitly like the ground.

    ``mean_torque`` (n-1,) and ``power`` (2,) come out: torques and power put in over the step, power lost to the ground
    at its start. The reactions of the two stages are used for that: the true torque at one instant jumps wherever a
    link passes through zero speed, and its samples say little about the step.

    Args:
        stage: scratch (STAGE_ROWS, max(6, n)).
    """
    n = links.shape[1]
    k1, k1phi, k2, k2phi, base2, phi2, dphi2 = (
        stage[0],
        stage[1],
        stage[2],
        stage[3],
        stage[4],
        stage[5],
        stage[6],
    )
    stage_torque, stage_damping = stage[STAGE_ROWS - 2], stage[STAGE_ROWS - 1]
    known, known_end = stage[STAGE_ROWS - 4], stage[STAGE_ROWS - 3]
    gh = GAMMA * h
    for j in range(n - 1):
        if kind[j] == PRESCRIBED:
            known[j] = acc[j]
            known_end[j] = acc_end[j]
        else:
            known[j] = known_end[j] = 0.0
            rate_gap = dphi_end[j] - h * acc_end[j] - dphi[j]
            gap = phi_end[j] - h * (dphi_end[j] - 0.5 * h * acc_end[j]) - phi[j]
            spring = stiffness[j] * (gap + gh * rate_gap)
            stage_torque[j] = torque[j] + spring + damping[j] * (rate_gap + gh * acc_end[j])
            stage_damping[j] = gh * (damping[j] + gh * stiffness[j])
    kinematics(links, base, phi, dphi, known, work)
    solve(links, slope_force, eps, gh, 1.0, 0.0, kind, stage_torque, stage_damping, work, k1, k1phi)
    power[0] = 0.0
    power[1] = dissipation(n, work)
    for a in range(3):
        base2[a] = base[a] + h * (base[a + 3] + gh * k1[a])
        base2[a + 3] = base[a + 3] + h * k1[a]
    for j in range(n - 1):
        mean_torque[j] = 0.5 * work[UU, j + 1]
        power[0] += 0.5 * work[UU, j + 1] * dphi[j]
        if kind[j] == PRESCRIBED:
            phi2[j] = phi_end[j]
            dphi2[j] = dphi_end[j]
        else:
            phi2[j] = phi[j] + h * (dphi[j] + gh * k1phi[j])
            dphi2[j] = dphi[j] + h * k1phi[j]
            rate_gap = dphi_end[j] + dphi2[j] - 2.0 * (dphi[j] + gh * k1phi[j])
            spring = stiffness[j] * (phi_end[j] - phi2[j] - gh * rate_gap)
            stage_torque[j] = torque[j] + spring + damping[j] * (dphi_end[j] - dphi2[j] - gh * acc_end[j])
    kinematics(links, base2, phi2, dphi2, known_end, work)
    generalised_to_links(links, k1, k1phi, work)
    solve(links, slope_force, eps, gh, -1.0, 2.0, kind, stage_torque, stage_damping, work, k2, k2phi)
    for a in range(3):
        base[a] += h * (base[a + 3] + 0.5 * h * ((1.0 + GAMMA) * k1[a] + GAMMA * k2[a]))
        base[a + 3] += h * (1.5 * k1[a] + 0.5 * k2[a])
    for j in range(n - 1):
        if kind[j] == PRESCRIBED:
            phi[j] = phi_end[j]
            dphi[j] = dphi_end[j]
        else:
            phi[j] += h * (dphi[j] + 0.5 * h * ((1.0 + GAMMA) * k1phi[j] + GAMMA * k2phi[j]))
            dphi[j] += h * (1.5 * k1phi[j] + 0.5 * k2phi[j])
        mean_torque[j] += 0.5 * work[UU, j + 1]
        power[0] += 0.5 * work[UU, j + 1] * dphi[j]


def workspace(links: int) -> tuple[Any, Any]:
    """Scratch of one chain: ``work`` and ``stage``."""
    return np.zeros((WORK_ROWS, links)), np.zeros((STAGE_ROWS, max(6, links)))
