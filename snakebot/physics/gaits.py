"""Many gaits at once: steady speed and power of each, from rest, on all cores."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import prange

from snakebot.errors import BadInputError
from snakebot.physics import kernel
from snakebot.physics.compiled import jit, jit_parallel
from snakebot.physics.kernel import FREE, PRESCRIBED
from snakebot.physics.model import STANDARD_GRAVITY_M_S2, ChainModel

Vector = npt.NDArray[np.float64]

STEPS_PER_CYCLE = 200


@dataclass(frozen=True, eq=False)
class GaitResults:
    """Steady state of G gaits; arrays of shape (G,).

    Attributes:
        gaits: (G, 4) alpha_rad, beta_rad, omega_rad_s, offset_rad.
        speed_m_s: mean velocity of the centre of mass along the mean heading; positive towards link n.
        power_in_w, power_dissipated_w: means over the same cycles.
        heading_change_rad: turn per cycle of the mean link angle.
    """

    gaits: Vector
    speed_m_s: Vector
    power_in_w: Vector
    power_dissipated_w: Vector
    heading_change_rad: Vector


def simulate_gaits(
    model: ChainModel,
    gaits: npt.ArrayLike,
    *,
    free_joints: Iterable[int] = (),
    rigid_joints: Iterable[int] | Mapping[int, float] = (),
    servo_time_constant_s: float = 0.0,
    cycles: int = 8,
    averaged_cycles: int = 4,
    steps_per_cycle: int = STEPS_PER_CYCLE,
) -> GaitResults:
    """Simulate serpentine gaits (27) from rest and average the last cycles.

    The amplitude is ramped in over the first cycle. Joints are numbered from 1.

    Args:
        model: the chain.
        gaits: (G, 3) or (G, 4): alpha_rad, beta_rad, omega_rad_s and offset_rad.
        free_joints: joints that swing without torque.
        rigid_joints: joints that are stuck straight, or a mapping of joint to the angle in rad at which it is stuck.
        servo_time_constant_s: first-order lag between the gait and the joint angles; 0 is ideal tracking.
        cycles, averaged_cycles: length of the simulation, and how many of the last cycles are averaged.
        steps_per_cycle: time steps in one period 2 pi / omega.

    Raises:
        BadInputError: a shape, a joint or a number that makes no sense.
    """
    table = _gait_table(gaits)
    kind, stuck = joint_kinds(model.joints, free_joints, rigid_joints)
    if not 1 <= averaged_cycles <= cycles:
        raise BadInputError(f"physics: cannot average the last {averaged_cycles} of {cycles} cycles")
    if steps_per_cycle < 8:
        raise BadInputError(f"physics: {steps_per_cycle} steps per cycle are too few; give at least 8")
    if not (math.isfinite(servo_time_constant_s) and servo_time_constant_s >= 0):
        raise BadInputError(
            f"physics: the servo time constant must be 0 or more, it is {servo_time_constant_s}"
        )
    out = np.zeros((len(table), 4))
    _batch(
        model.packed, STANDARD_GRAVITY_M_S2 * math.sin(model.slope_rad), model.eps, table, kind, stuck,
        float(servo_time_constant_s), cycles, averaged_cycles, steps_per_cycle, out,
    )  # fmt: skip
    return GaitResults(table, out[:, 0], out[:, 1], out[:, 2], out[:, 3])


def joint_kinds(
    joints: int, free_joints: Iterable[int], rigid_joints: Iterable[int] | Mapping[int, float]
) -> tuple[npt.NDArray[np.int64], Vector]:
    """Kind of each joint and the angle it is stuck at (NaN: it follows the gait)."""
    kind = np.full(joints, PRESCRIBED, dtype=np.int64)
    stuck = np.full(joints, np.nan)
    free = list(free_joints)
    rigid = dict(rigid_joints) if isinstance(rigid_joints, Mapping) else dict.fromkeys(rigid_joints, 0.0)
    for joint in (*free, *rigid):
        if not 1 <= joint <= joints:
            raise BadInputError(f"physics: there is no joint {joint}; joints are numbered 1 to {joints}")
    both = set(free) & set(rigid)
    if both:
        raise BadInputError(f"physics: joint {min(both)} cannot be free and rigid at once")
    for joint in free:
        kind[joint - 1] = FREE
    for joint, angle in rigid.items():
        if not math.isfinite(angle):
            raise BadInputError(f"physics: joint {joint} cannot be stuck at {angle} rad")
        stuck[joint - 1] = angle
    return kind, stuck


def _gait_table(gaits: npt.ArrayLike) -> Vector:
    table = np.atleast_2d(np.asarray(gaits, dtype=np.float64))
    if table.ndim != 2 or table.shape[1] not in (3, 4):
        raise BadInputError(
            f"physics: gaits have shape {table.shape}; expected (G, 4): alpha, beta, omega, offset"
        )
    if table.shape[1] == 3:
        table = np.column_stack((table, np.zeros(len(table))))
    if not np.all(np.isfinite(table)):
        raise BadInputError("physics: a gait holds a number that is not finite")
    if np.any(table[:, 2] <= 0):
        raise BadInputError(f"physics: omega must be above zero, found {table[:, 2].min()} rad/s")
    return np.ascontiguousarray(table)


@jit  # type: ignore[misc]
def reference(gait: Any, tau: float, t: float, kind: Any, stuck: Any, phi: Any, dphi: Any, acc: Any) -> None:
    """Angle, rate and acceleration of prescribed joints at time t; other joints are left alone.

    The lag's answer to a sine is a sine of less amplitude, later; the ramp of the first cycle multiplies that.
    """
    alpha, beta, omega, offset = gait[0], gait[1], gait[2], gait[3]
    late = math.atan(omega * tau)
    alpha *= math.cos(late)
    s = t * omega / (2 * math.pi)
    ramp, d_ramp, dd_ramp = 1.0, 0.0, 0.0
    if s < 1.0:
        rate = omega / (2 * math.pi)
        ramp = s * s * s * (10.0 + s * (6.0 * s - 15.0))
        d_ramp = 30.0 * (s * (1.0 - s)) ** 2 * rate
        dd_ramp = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) * rate * rate
    for j in range(phi.size):
        acc[j] = 0.0
        if kind[j] != PRESCRIBED:
            continue
        if not math.isnan(stuck[j]):
            phi[j] = stuck[j]
            dphi[j] = 0.0
            continue
        angle = omega * t + j * beta - late
        f = alpha * math.sin(angle) + offset
        df = alpha * omega * math.cos(angle)
        ddf = -alpha * omega * omega * math.sin(angle)
        phi[j] = ramp * f
        dphi[j] = d_ramp * f + ramp * df
        acc[j] = dd_ramp * f + 2.0 * d_ramp * df + ramp * ddf


@jit_parallel  # type: ignore[misc]
def _batch(
    links: Any, slope: float, eps: float, gaits: Any, kind: Any, stuck: Any, tau: float, cycles: int, averaged: int,
    steps: int, out: Any,
) -> None:  # fmt: skip
    for g in prange(gaits.shape[0]):
        _one_gait(links, slope, eps, gaits[g], kind, stuck, tau, cycles, averaged, steps, out[g])


@jit  # type: ignore[misc]
def _one_gait(
    links: Any, slope: float, eps: float, gait: Any, kind: Any, stuck: Any, tau: float, cycles: int, averaged: int,
    steps: int, out: Any,
) -> None:  # fmt: skip
    n = links.shape[1]
    work, stage = kernel.workspace(n)
    base = np.zeros(6)
    phi, dphi, acc = np.zeros(n - 1), np.zeros(n - 1), np.zeros(n - 1)
    phi_end, dphi_end, acc_end = np.zeros(n - 1), np.zeros(n - 1), np.zeros(n - 1)
    nothing, torque = np.zeros(n - 1), np.zeros(n - 1)
    power = np.zeros(2)
    h = 2 * math.pi / gait[2] / steps
    reference(gait, tau, 0.0, kind, stuck, phi, dphi, acc)
    speed = power_in = lost = 0.0
    turn = 0.0
    for cycle in range(cycles):
        x, y = base[0], base[1]
        heading = 0.0
        start = base[2]
        measure = cycle >= cycles - averaged
        for i in range(steps):
            if measure:
                heading += base[2]
            reference(gait, tau, (cycle * steps + i + 1) * h, kind, stuck, phi_end, dphi_end, acc_end)
            kernel.step(
                links, slope, eps, h, kind, base, phi, dphi, acc, phi_end, dphi_end, acc_end, nothing, nothing,
                nothing, work, stage, torque, power,
            )  # fmt: skip
            if measure:
                power_in += power[0]
                lost += power[1]
            acc[:] = acc_end
        if measure:
            heading /= steps
            speed += (base[0] - x) * math.cos(heading) + (base[1] - y) * math.sin(heading)
            turn += base[2] - start
    out[0] = speed / (averaged * steps * h)
    out[1] = power_in / (averaged * steps)
    out[2] = lost / (averaged * steps)
    out[3] = turn / averaged
