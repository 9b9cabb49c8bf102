"""Many gaits at once: steady speed and power of each, from rest, on all cores."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from snakebot.arrays import Floats, Ints
from snakebot.errors import BadInputError
from snakebot.physics.gait_loop import MEASURES, run_blocks
from snakebot.physics.kernel import FREE, PRESCRIBED, TORQUE
from snakebot.physics.lanes import WIDTH
from snakebot.physics.model import STANDARD_GRAVITY_M_S2, ChainModel
from snakebot.physics.trajectory import Trajectory

# With these, halving the step changes the speed and power of a gait that travels by less than 0.2 %.
VISCOUS_STEPS_PER_CYCLE = 200
# Friction that jumps at zero speed needs shorter steps (tests/physics/test_physics_convergence.py).
COULOMB_STEPS_PER_CYCLE = 800
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

    gaits: Floats
    speed_m_s: Floats
    forward_speed_m_s: Floats
    power_in_w: Floats
    power_dissipated_w: Floats
    turn_rad: Floats
    tracking_error: Floats


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
    eps_m_s: float | None = None,
    threads: int | None = None,
    shares: npt.ArrayLike = (),
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
        eps_m_s: another width of the regularised sign, the same for all gaits.
        threads: how many cores work; by default all that this process may use. The results do not depend on it.
        shares: amplitude of each joint as a share of alpha, the same in all gaits; none: alpha everywhere.

    Raises:
        BadInputError: a shape, a joint or a number that makes no sense.
    """
    table = _gait_table(gaits)
    drives, setup = _setup(
        model, table, free_joints, rigid_joints, servo_time_constant_s, pid, cycles, steps_per_cycle, shares
    )
    if not 1 <= averaged_cycles <= cycles:
        raise BadInputError(f"physics: cannot average the last {averaged_cycles} of {cycles} cycles")
    if eps_m_s is not None:
        if not (math.isfinite(eps_m_s) and eps_m_s > 0):
            raise BadInputError(f"physics: eps must be above zero, it is {eps_m_s}")
        drives[:, 5] = eps_m_s
    if threads is not None and threads < 1:
        raise BadInputError(f"physics: cannot work on {threads} threads")
    steps = setup[-1]
    out = np.zeros((len(table), averaged_cycles, len(MEASURES)))
    _batch(drives, setup, out, np.zeros((0, 0)), threads)
    dx, dy, heading, power_in, lost, turn, error = np.moveaxis(out, 2, 0)
    period = 2 * np.pi / table[:, 2]
    driven = max(int(np.count_nonzero(setup[3] == TORQUE)), 1)
    amplitude = np.where(table[:, 0] == 0, np.inf, np.abs(table[:, 0]))
    along = dx * np.cos(heading / steps) + dy * np.sin(heading / steps)
    return GaitResults(
        gaits=table,
        speed_m_s=np.hypot(dx, dy).mean(axis=1) / period,
        forward_speed_m_s=along.mean(axis=1) / period,
        power_in_w=power_in.mean(axis=1) / steps,
        power_dissipated_w=lost.mean(axis=1) / steps,
        turn_rad=turn.mean(axis=1),
        tracking_error=np.sqrt(error.mean(axis=1) / (steps * driven)) / amplitude,
    )


def gait_eps_m_s(model: ChainModel, alpha_rad: float, omega_rad_s: float) -> float:
    """Width of the regularised sign for a gait: ``model.eps``, or a small share of the links' speed if that is less."""
    return float(_gait_eps(model, np.array(alpha_rad), np.array(omega_rad_s)))


def _gait_eps(model: ChainModel, alpha_rad: Floats, omega_rad_s: Floats) -> Floats:
    own = EPS_SHARE * np.abs(alpha_rad) * omega_rad_s * model.half_length.mean()
    return np.minimum(model.eps, np.where(own > 0, own, model.eps))


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
    drives, setup = _setup(
        model, table, free_joints, rigid_joints, servo_time_constant_s, pid, cycles, steps_per_cycle
    )
    k, steps = model.joints, setup[-1]
    trace = np.zeros((cycles * steps + 1, 8 + 3 * k))
    _batch(drives, setup, np.zeros((1, 1, len(MEASURES))), trace)
    t = np.arange(len(trace)) * (2 * math.pi / table[0, 2] / steps)
    base, power, angle, rate, torque = np.split(trace, np.cumsum((6, 2, k, k)), axis=1)
    return Trajectory(
        t, angle, rate, torque, base[:, 0:2], base[:, 3:5], base[:, 2], power[:, 0], power[:, 1]
    )  # fmt: skip


_Setup = tuple[Floats, float, Floats, Ints, Floats, Floats, int, int]


def _setup(
    model: ChainModel,
    table: Floats,
    free_joints: Iterable[int],
    rigid_joints: Iterable[int] | Mapping[int, float],
    servo_time_constant_s: float,
    pid: Pid | None,
    cycles: int,
    steps_per_cycle: int | None,
    shares: npt.ArrayLike = (),
) -> tuple[Floats, _Setup]:
    """The arguments of the compiled loop, checked: rows (alpha, beta, omega, offset, lag angle, eps), and the rest.

    The lag's answer to a sine is a sine of less amplitude, later.
    """
    kind, stuck = joint_kinds(model.joints, free_joints, rigid_joints)
    if cycles < 1:
        raise BadInputError(f"physics: cannot simulate {cycles} cycles")
    if not (math.isfinite(servo_time_constant_s) and servo_time_constant_s >= 0):
        raise BadInputError(
            f"physics: the servo time constant must be 0 or more, it is {servo_time_constant_s}"
        )
    given = np.asarray(shares, dtype=np.float64)
    if given.shape not in ((0,), (model.joints,)):
        raise BadInputError(f"physics: {given.size} amplitudes do not fit {model.joints} joints")
    share = given.copy() if given.size else np.ones(model.joints)
    gains = np.zeros(3)
    if pid is not None:
        kind[(kind == PRESCRIBED) & np.isnan(stuck)] = TORQUE
        gains[:] = (pid.kp_nm_rad, pid.ki_nm_rad_s, pid.kd_nm_s_rad)
    if steps_per_cycle is None:
        steps_per_cycle = default_steps_per_cycle(model, all_prescribed=bool(np.all(kind == PRESCRIBED)))
    if steps_per_cycle < 8:
        raise BadInputError(f"physics: {steps_per_cycle} steps per cycle are too few; give at least 8")
    late = np.arctan(table[:, 2] * servo_time_constant_s)
    eps = _gait_eps(model, table[:, 0], table[:, 2])
    drives = np.column_stack((table[:, 0] * np.cos(late), table[:, 1:], late, eps))
    slope = STANDARD_GRAVITY_M_S2 * math.sin(model.slope_rad)
    return drives, (model.packed, slope, gains, kind, stuck, share, cycles, steps_per_cycle)


def default_steps_per_cycle(model: ChainModel, *, all_prescribed: bool = True) -> int:
    """Time steps in a cycle that suffice for an error of about 0.1 %."""
    if not all_prescribed:
        return FREE_STEPS_PER_CYCLE
    coulomb = np.any(model.ct0 > 0) or np.any(model.cn0 > 0)
    return COULOMB_STEPS_PER_CYCLE if coulomb else VISCOUS_STEPS_PER_CYCLE


def joint_kinds(
    joints: int, free_joints: Iterable[int], rigid_joints: Iterable[int] | Mapping[int, float]
) -> tuple[Ints, Floats]:
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


def _gait_table(gaits: npt.ArrayLike) -> Floats:
    table = np.atleast_2d(np.asarray(gaits, dtype=np.float64))
    if table.ndim != 2 or table.shape[1] not in (3, 4):
        raise BadInputError(
            f"physics: gaits have shape {table.shape}; expected (G, 4): alpha, beta, omega, offset"
        )
    if table.shape[1] == 3:
        table = np.column_stack((table, np.zeros(len(table))))
    if len(table) == 0:
        raise BadInputError("physics: there is no gait to simulate")
    if not np.all(np.isfinite(table)):
        raise BadInputError("physics: a gait holds a number that is not finite")
    if np.any(table[:, 2] <= 0):
        raise BadInputError(f"physics: omega must be above zero, found {table[:, 2].min()} rad/s")
    return np.ascontiguousarray(table)


def _batch(drives: Floats, setup: _Setup, out: Floats, trace: Floats, threads: int | None = None) -> None:
    """All gaits, eight at once on each core. ``out``: (G, averaged cycles, measures); ``trace``: of the first gait.

    The threads are Python's own: the compiled loop lets the interpreter go, and a program that forks stays safe, which
    it does not with the compiler's own pool.
    """
    blocks = (len(out) + WIDTH - 1) // WIDTH
    workers = min(blocks, threads or _cores())
    if workers == 1:
        run_blocks(0, blocks, drives, *setup, out, trace)
        return
    size = max(1, blocks // (8 * workers))  # small enough that the last chunks end together
    with ThreadPoolExecutor(workers) as pool:
        jobs = [
            pool.submit(run_blocks, first, min(first + size, blocks), drives, *setup, out, trace)
            for first in range(0, blocks, size)
        ]
        try:
            for job in jobs:
                job.result()
        except BaseException:  # above all an interrupt by the user: do not work off what is left
            pool.shutdown(cancel_futures=True)
            raise


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
