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
from snakebot.physics.kernel import FREE, PRESCRIBED, TORQUE
from snakebot.physics.model import STANDARD_GRAVITY_M_S2, ChainModel
from snakebot.physics.trajectory import Trajectory

Vector = npt.NDArray[np.float64]
_Setup = tuple[Vector, float, float, npt.NDArray[np.int64], Vector, float, Vector, int, int, int]

# With these, halving the step moves speed and power by less than 0.2 %.
VISCOUS_STEPS_PER_CYCLE = 200
COULOMB_STEPS_PER_CYCLE = 400
FREE_STEPS_PER_CYCLE = 1600  # a swinging link, or one on a stiff servo, answers faster than the gait
EPS_SHARE = 0.005  # of alpha omega l, the speed that the gait itself gives to the links


@dataclass(frozen=True)
class Pid:
    """Torque-level control of the joints (Fig. 3): u = kp e + ki integral(e) + kd de/dt, e = reference - angle."""

    kp_nm_rad: float
    ki_nm_rad_s: float = 0.0
    kd_nm_s_rad: float = 0.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (math.isfinite(value) and value >= 0):
                raise BadInputError(f"physics: the PID's {name} must be 0 or more, it is {value}")


@dataclass(frozen=True, eq=False)
class GaitResults:
    """Steady state of G gaits; arrays of shape (G,).

    Attributes:
        gaits: (G, 4) alpha_rad, beta_rad, omega_rad_s, offset_rad.
        speed_m_s: way of the centre of mass in a cycle over the cycle's length: along the heading of its motion.
        forward_speed_m_s: the same way along the mean link angle; positive towards link n. Less than the speed where
            the robot goes askew, as it does when it drags a free tail.
        power_in_w, power_dissipated_w: means over the same cycles.
        turn_rad: change of the mean link angle in a cycle.
        tracking_error: root mean square of reference less angle over alpha, all driven joints (37); 0 when prescribed.
    """

    gaits: Vector
    speed_m_s: Vector
    forward_speed_m_s: Vector
    power_in_w: Vector
    power_dissipated_w: Vector
    turn_rad: Vector
    tracking_error: Vector


def simulate_gaits(
    model: ChainModel,
    gaits: npt.ArrayLike,
    *,
    free_joints: Iterable[int] = (),
    rigid_joints: Iterable[int] | Mapping[int, float] = (),
    servo_time_constant_s: float = 0.0,
    pid: Pid | None = None,
    cycles: int = 8,
    averaged_cycles: int = 4,
    steps_per_cycle: int | None = None,
) -> GaitResults:
    """Simulate serpentine gaits (27) from rest and average the last cycles.

    The amplitude is ramped in over the first cycle. Joints are numbered from 1. The regularised sign of the Coulomb
    term turns within ``gait_eps_m_s``, so that slow gaits do not creep through it.

    Args:
        model: the chain.
        gaits: (G, 3) or (G, 4): alpha_rad, beta_rad, omega_rad_s and offset_rad.
        free_joints: joints that swing without torque.
        rigid_joints: joints that are stuck straight, or a mapping of joint to the angle in rad at which it is stuck.
        servo_time_constant_s: first-order lag between the gait and the joint angles; 0 is ideal tracking.
        pid: drive the joints by torque instead of prescribing their angles.
        cycles, averaged_cycles: length of the simulation, and how many of the last cycles are averaged.
        steps_per_cycle: time steps in one period 2 pi / omega; by default enough for an error of about 0.1 %.

    Raises:
        BadInputError: a shape, a joint or a number that makes no sense.
    """
    table = _gait_table(gaits)
    setup = _setup(
        model, free_joints, rigid_joints, servo_time_constant_s, pid, cycles, averaged_cycles, steps_per_cycle
    )
    out = np.zeros((len(table), 6))
    _batch(table, *setup, out)
    return GaitResults(table, *(np.ascontiguousarray(column) for column in out.T))


def gait_eps_m_s(model: ChainModel, alpha_rad: float, omega_rad_s: float) -> float:
    """Width of the regularised sign for a gait: ``model.eps``, or a small share of the links' speed if that is less."""
    return float(_gait_eps(model.packed, model.eps, alpha_rad, omega_rad_s))


def gait_trajectory(
    model: ChainModel,
    gait: npt.ArrayLike,
    *,
    free_joints: Iterable[int] = (),
    rigid_joints: Iterable[int] | Mapping[int, float] = (),
    servo_time_constant_s: float = 0.0,
    pid: Pid | None = None,
    cycles: int = 8,
    steps_per_cycle: int | None = None,
) -> Trajectory:
    """The motion of one gait, step by step; arguments as in ``simulate_gaits``. The first row is the start."""
    table = _gait_table(gait)
    if len(table) != 1:
        raise BadInputError(f"physics: a trajectory is that of one gait, {len(table)} were given")
    setup = _setup(model, free_joints, rigid_joints, servo_time_constant_s, pid, cycles, 1, steps_per_cycle)
    k = model.joints
    trace = np.zeros((cycles * setup[-1] + 1, 8 + 3 * k))
    _one_gait(table[0], *setup, np.zeros(6), trace)
    t = np.arange(len(trace)) * (2 * math.pi / table[0, 2] / setup[-1])
    base, power, angle, rate, torque = np.split(trace, np.cumsum((6, 2, k, k)), axis=1)
    return Trajectory(
        t, angle, rate, torque, base[:, 0:2], base[:, 3:5], base[:, 2], power[:, 0], power[:, 1]
    )  # fmt: skip


def _setup(
    model: ChainModel,
    free_joints: Iterable[int],
    rigid_joints: Iterable[int] | Mapping[int, float],
    servo_time_constant_s: float,
    pid: Pid | None,
    cycles: int,
    averaged_cycles: int,
    steps_per_cycle: int | None,
) -> _Setup:
    """The arguments of the compiled loop, checked."""
    kind, stuck = joint_kinds(model.joints, free_joints, rigid_joints)
    if not 1 <= averaged_cycles <= cycles:
        raise BadInputError(f"physics: cannot average the last {averaged_cycles} of {cycles} cycles")
    if not (math.isfinite(servo_time_constant_s) and servo_time_constant_s >= 0):
        raise BadInputError(
            f"physics: the servo time constant must be 0 or more, it is {servo_time_constant_s}"
        )
    gains = np.zeros(3)
    if pid is not None:
        kind[(kind == PRESCRIBED) & np.isnan(stuck)] = TORQUE
        gains[:] = (pid.kp_nm_rad, pid.ki_nm_rad_s, pid.kd_nm_s_rad)
    if steps_per_cycle is None:
        steps_per_cycle = default_steps_per_cycle(model, all_prescribed=bool(np.all(kind == PRESCRIBED)))
    if steps_per_cycle < 8:
        raise BadInputError(f"physics: {steps_per_cycle} steps per cycle are too few; give at least 8")
    slope = STANDARD_GRAVITY_M_S2 * math.sin(model.slope_rad)
    return (
        model.packed, slope, model.eps, kind, stuck, float(servo_time_constant_s), gains, cycles, averaged_cycles,
        steps_per_cycle,
    )  # fmt: skip


def default_steps_per_cycle(model: ChainModel, *, all_prescribed: bool = True) -> int:
    """Time steps in a cycle that suffice for an error of about 0.1 %."""
    if not all_prescribed:
        return FREE_STEPS_PER_CYCLE
    coulomb = np.any(model.ct0 > 0) or np.any(model.cn0 > 0)
    return COULOMB_STEPS_PER_CYCLE if coulomb else VISCOUS_STEPS_PER_CYCLE


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


@jit
def reference(gait: Any, tau: float, t: float, kind: Any, stuck: Any, phi: Any, dphi: Any, acc: Any) -> None:
    """Angle, rate and acceleration at time t of joints that follow the gait or are stuck; free joints are left alone.

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
        if kind[j] == FREE:
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


@jit
def _gait_eps(links: Any, eps: float, alpha: float, omega: float) -> float:
    own = EPS_SHARE * abs(alpha) * omega * links[kernel.HALF].mean()
    return min(eps, own) if own > 0.0 else eps


@jit_parallel
def _batch(
    gaits: Any, links: Any, slope: float, eps: float, kind: Any, stuck: Any, tau: float, gains: Any, cycles: int,
    averaged: int, steps: int, out: Any,
) -> None:  # fmt: skip
    no_trace = np.zeros((0, 0))
    for g in prange(gaits.shape[0]):
        _one_gait(
            gaits[g], links, slope, eps, kind, stuck, tau, gains, cycles, averaged, steps, out[g], no_trace
        )


@jit
def _one_gait(
    gait: Any, links: Any, slope: float, eps: float, kind: Any, stuck: Any, tau: float, gains: Any, cycles: int,
    averaged: int, steps: int, out: Any, trace: Any,
) -> None:  # fmt: skip
    n = links.shape[1]
    eps = _gait_eps(links, eps, gait[0], gait[2])
    work, stage = kernel.workspace(n)
    base = np.zeros(6)
    phi, dphi, acc = np.zeros(n - 1), np.zeros(n - 1), np.zeros(n - 1)
    phi_end, dphi_end, acc_end = np.zeros(n - 1), np.zeros(n - 1), np.zeros(n - 1)
    torque, mean_torque, gap = np.zeros(n - 1), np.zeros(n - 1), np.zeros(n - 1)
    stiffness, damping, power = np.zeros(n - 1), np.zeros(n - 1), np.zeros(2)
    driven = 0
    for j in range(n - 1):
        if kind[j] == TORQUE:
            stiffness[j] = gains[0]
            damping[j] = gains[2]
            driven += 1
    h = 2 * math.pi / gait[2] / steps
    reference(gait, tau, 0.0, kind, stuck, phi, dphi, acc)
    if trace.shape[0] > 0:
        _record(trace[0], base, power, phi, dphi, mean_torque)
    way = forward = power_in = lost = turn = error = 0.0
    for cycle in range(cycles):
        x, y = base[0], base[1]
        heading = 0.0
        start = base[2]
        measure = cycle >= cycles - averaged
        for i in range(steps):
            reference(gait, tau, (cycle * steps + i + 1) * h, kind, stuck, phi_end, dphi_end, acc_end)
            for j in range(n - 1):
                gap[j] = phi_end[j] - h * dphi_end[j] - phi[j]
            kernel.step(
                links, slope, eps, h, kind, base, phi, dphi, acc, phi_end, dphi_end, acc_end, torque, stiffness,
                damping, work, stage, mean_torque, power,
            )  # fmt: skip
            for j in range(n - 1):
                if kind[j] == PRESCRIBED:
                    acc[j] = acc_end[j]
                elif kind[j] == TORQUE:
                    torque[j] += gains[1] * h * 0.5 * (gap[j] + phi_end[j] - phi[j])
                    if measure:
                        error += (phi_end[j] - phi[j]) ** 2
            if trace.shape[0] > 0:
                _record(trace[cycle * steps + i + 1], base, power, phi, dphi, mean_torque)
            if measure:
                heading += base[2]
                power_in += power[0]
                lost += power[1]
        if measure:
            heading /= steps
            dx, dy = base[0] - x, base[1] - y
            way += math.sqrt(dx * dx + dy * dy)
            forward += dx * math.cos(heading) + dy * math.sin(heading)
            turn += base[2] - start
    samples = averaged * steps
    out[0] = way / (samples * h)
    out[1] = forward / (samples * h)
    out[2] = power_in / samples
    out[3] = lost / samples
    out[4] = turn / averaged
    out[5] = math.sqrt(error / (samples * driven)) / abs(gait[0]) if driven > 0 and gait[0] != 0.0 else 0.0


@jit
def _record(row: Any, base: Any, power: Any, phi: Any, dphi: Any, torque: Any) -> None:
    k = phi.size
    row[0:6] = base
    row[6:8] = power
    row[8 : 8 + k] = phi
    row[8 + k : 8 + 2 * k] = dphi
    row[8 + 2 * k :] = torque
