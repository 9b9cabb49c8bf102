"""A position servo, compiled: from set-point to joint angle through everything that may lie between them.

The signal passes, in this order: wiring, gain and offset; dead band on the error; first-order lag or second-order
response; rate limit; torque limit; dry friction against the position loop; sag by load; backlash. A stage whose
parameter is at its neutral value costs next to nothing. See ``servo_layout`` for the columns.

Set-points are held between ticks, so the response over a step is known in closed form: first order with dead band and
rate limit exactly, second order exactly while neither bites. The step size does not show. A position loop
(``servo_loop``) takes the place of lag and limits where there is one.

Load. ``load_nm`` is the torque that the servo has to exert, positive where it pushes the joint to larger angles. Under
a known load, or with an arm on a bench, sag, dry friction and play that the load takes up are quasi-static here. In a
body they depend on all the rest: ``servo_chain`` works them out with the chain, and leaves them in HELD_BACK.
"""

from __future__ import annotations

import math
from typing import Any

from snakebot.physics.compiled import in_place
from snakebot.physics.servo_layout import (
    ARM_COULOMB_NM,
    ARM_DOWN_RAD,
    ARM_DRAG_NM_S,
    ARM_GRAVITY_NM,
    ARM_INERTIA_KG_M2,
    BACKLASH_LOADED,
    BACKLASH_RAD,
    COMPLIANCE_RAD_NM,
    COULOMB_NM,
    DAMPING_RATIO,
    DEADBAND_HARD,
    DEADBAND_RAD,
    DRAGGED,
    FILTERED,
    FREE_JOINT,
    GAIN,
    HELD_BACK,
    LOCK_RAD,
    LOCKED,
    LOOP_COMPLIANCE_RAD_NM,
    LOOP_STIFFNESS_NM_RAD,
    MOTOR,
    MOTOR_RATE,
    NATURAL_FREQ_RAD_S,
    OFFSET_RAD,
    OUTPUT,
    OUTPUT_RATE,
    POWERED,
    RATE_DROP_PER_NM,
    RATE_DROP_PER_S,
    RATE_LIMIT_RAD_S,
    RIGID_JOINT,
    SIGN,
    SMOOTH,
    SMOOTH_RATE,
    SOURCE,
    TIME_CONSTANT_S,
    TORQUE_LIMIT_NM,
)
from snakebot.physics.servo_loop import loop_step, loop_swing

LOWEST_RATE_SHARE = 0.02  # a sagging rate limit never quite reaches zero


@in_place
def servo_step(state: Any, params: Any, setpoint: Any, load_nm: Any, t: float, dt: float) -> None:
    """Move all joints on by ``dt``, in place.

    Args:
        state: (joints, STATES).
        params: (joints, PARAMETERS).
        setpoint: (joints,) in force over the whole step, rad; NaN: the servo is off.
        load_nm: (joints,) torque that each servo bears, see the module.
        t: time since the run began, s; only the sagging rate limit asks for it.
        dt: above zero.
    """
    for j in range(state.shape[0]):
        _joint_step(state[j], params[j], setpoint[int(params[j, SOURCE])], load_nm[j], t, dt)


@in_place
def is_free(params: Any, setpoint: Any, j: int) -> bool:
    """Whether joint ``j`` swings without torque: broken, or without a set-point."""
    if params[j, LOCKED] == RIGID_JOINT:
        return False
    return params[j, LOCKED] == FREE_JOINT or math.isnan(setpoint[int(params[j, SOURCE])])


@in_place
def _joint_step(s: Any, p: Any, setpoint: float, load_in: float, t: float, dt: float) -> None:
    before = s[OUTPUT]
    if p[LOCKED] == RIGID_JOINT:
        s[OUTPUT] = p[LOCK_RAD]
        s[OUTPUT_RATE] = (s[OUTPUT] - before) / dt
        return
    if p[LOCKED] == FREE_JOINT or math.isnan(setpoint):
        s[POWERED] = 0.0
        if p[LOOP_STIFFNESS_NM_RAD] > 0.0:
            s[OUTPUT], s[OUTPUT_RATE] = loop_swing(s[OUTPUT], s[OUTPUT_RATE], p, load_in, dt)
        elif p[ARM_INERTIA_KG_M2] > 0.0:
            _swing(s, p, dt)
        else:
            s[OUTPUT_RATE] = 0.0
        return
    waking = s[POWERED] == 0.0
    load = load_in
    loop = p[LOOP_STIFFNESS_NM_RAD] > 0.0
    if p[ARM_GRAVITY_NM] != 0.0:
        load += p[ARM_GRAVITY_NM] * math.sin((s[OUTPUT] if waking else s[MOTOR]) - p[ARM_DOWN_RAD])
    if waking:
        _wake(s, p, load)

    target = p[GAIN] * p[SIGN] * setpoint + p[OFFSET_RAD]
    if (p[NATURAL_FREQ_RAD_S] > 0.0 or loop) and p[TIME_CONSTANT_S] > 0.0:
        middle = target + (s[FILTERED] - target) * math.exp(-0.5 * dt / p[TIME_CONSTANT_S])
        s[FILTERED] = target + (s[FILTERED] - target) * math.exp(-dt / p[TIME_CONSTANT_S])
        target = middle

    start = s[MOTOR]
    motor_rate = s[MOTOR_RATE]
    if loop:
        s[MOTOR], s[MOTOR_RATE] = loop_step(s[MOTOR], motor_rate, p, target, load_in, dt)
    else:
        s[MOTOR], s[MOTOR_RATE] = _motor(s[MOTOR], motor_rate, p, target, load, t, dt)
    if not loop and p[ARM_INERTIA_KG_M2] > 0.0 and p[TORQUE_LIMIT_NM] < math.inf:
        _limit_torque(s, p, start, motor_rate, load, dt)

    motor = s[MOTOR] + s[HELD_BACK]
    give = p[LOOP_COMPLIANCE_RAD_NM]
    s[DRAGGED] = play(s[DRAGGED], motor - load * give, p[COULOMB_NM] * give)
    centre, slack = s[DRAGGED] - load * p[COMPLIANCE_RAD_NM], 0.5 * p[BACKLASH_RAD]
    if p[BACKLASH_LOADED] > 0.0:  # quasi-static: it rests on the side that bears the load
        s[OUTPUT] = centre if load == 0.0 else centre - math.copysign(slack, load)
    else:
        s[OUTPUT] = play(s[OUTPUT], centre, slack)
    s[OUTPUT_RATE] = (s[OUTPUT] - before) / dt


@in_place
def _wake(s: Any, p: Any, load: float) -> None:
    """A servo that is switched on starts from where its joint is, bearing what hangs on it."""
    s[POWERED] = 1.0
    s[HELD_BACK] = 0.0
    s[DRAGGED] = s[OUTPUT] + load * p[COMPLIANCE_RAD_NM]
    s[MOTOR] = s[DRAGGED] + load * p[LOOP_COMPLIANCE_RAD_NM]
    s[FILTERED] = s[MOTOR]
    moves_on = p[NATURAL_FREQ_RAD_S] > 0.0 or p[LOOP_STIFFNESS_NM_RAD] > 0.0
    s[MOTOR_RATE] = s[OUTPUT_RATE] if moves_on else 0.0
    s[SMOOTH] = s[OUTPUT]
    s[SMOOTH_RATE] = s[OUTPUT_RATE]


@in_place
def play(output: float, centre: float, half_width: float) -> float:
    """The play operator: the output stays where it is unless the centre pulls or pushes it along."""
    if output < centre - half_width:
        return centre - half_width
    if output > centre + half_width:
        return centre + half_width
    return output


@in_place
def _motor(
    x: float, v: float, p: Any, target: float, load: float, t: float, dt: float
) -> tuple[float, float]:
    """Angle and rate of the motor after a step towards ``target``."""
    band, hard = p[DEADBAND_RAD], p[DEADBAND_HARD] > 0.0
    goal, idle = goal_of(x, target, band, hard)
    limit = falling_limit(
        p[RATE_LIMIT_RAD_S],
        p[RATE_DROP_PER_S],
        p[RATE_DROP_PER_NM],
        load if goal > x else -load,
        t + 0.5 * dt,
    )
    if p[NATURAL_FREQ_RAD_S] > 0.0:
        return _second_order(x, v, goal, idle, p[NATURAL_FREQ_RAD_S], p[DAMPING_RATIO], limit, dt)
    new = first_order(x, target, band, hard, p[TIME_CONSTANT_S], limit, dt)
    return new, (new - x) / dt


@in_place
def falling_limit(limit: float, per_s: float, per_nm: float, opposing: float, t: float) -> float:
    """A rate limit after ``t`` seconds, against a load of ``opposing`` N m."""
    if limit < math.inf and (per_s != 0.0 or per_nm != 0.0):
        limit *= max(LOWEST_RATE_SHARE, math.exp(-per_s * t) * (1.0 - per_nm * opposing))
    return limit


@in_place
def goal_of(x: float, target: float, band: float, hard: bool) -> tuple[float, bool]:
    """Where the motor is driven to, and whether it is not driven: within its dead band."""
    error = target - x
    if abs(error) <= band and band > 0.0:
        return x, True
    return target - math.copysign(0.0 if hard else band, error), False


@in_place
def first_order(
    x: float, target: float, band: float, hard: bool, tau: float, limit: float, dt: float
) -> float:
    """Angle of a first-order motor after a step towards ``target``, exact for any ``dt``."""
    goal, idle = goal_of(x, target, band, hard)
    left = _decay(goal - x, tau, limit, dt)
    if hard and not idle and abs(left) < band:
        left = math.copysign(band, target - x)  # at the edge of the band the drive goes off
    return goal - left


@in_place
def _decay(distance: float, tau: float, limit: float, dt: float) -> float:
    """What is left of a distance that a first-order lag with a rate limit runs down, exact for any ``dt``."""
    far = abs(distance)
    edge = limit * tau  # nearer than this the lag is slower than the limit
    if far > edge:
        needed = (far - edge) / limit
        if needed >= dt:
            return math.copysign(far - limit * dt, distance)
        far = edge
        dt -= needed
    if tau > 0.0:
        return math.copysign(far * math.exp(-dt / tau), distance)
    return 0.0


@in_place
def _second_order(
    x: float, v: float, goal: float, idle: bool, wn: float, zeta: float, limit: float, dt: float
) -> tuple[float, float]:
    """x'' = wn^2 (goal - x) - 2 zeta wn x', solved over the step; without drive (``idle``) only the damping is left."""
    decay = zeta * wn
    if idle:
        left = math.exp(-2.0 * decay * dt)
        way = v * dt if decay == 0.0 else v * (1.0 - left) / (2.0 * decay)
        new_x, new_v = x + way, v * left
    else:
        y = x - goal
        shape = zeta * zeta - 1.0
        if abs(shape) < 1e-9:
            c, s_over_w = 1.0, dt
            e = math.exp(-decay * dt)
        elif shape < 0.0:
            w = wn * math.sqrt(-shape)
            c, s_over_w = math.cos(w * dt), math.sin(w * dt) / w
            e = math.exp(-decay * dt)
        else:  # both exponentials apart: cosh alone would overflow on a heavily damped servo
            w = wn * math.sqrt(shape)
            slow, fast = math.exp((w - decay) * dt), math.exp((-w - decay) * dt)
            c, s_over_w = 0.5 * (slow + fast), 0.5 * (slow - fast) / w
            e = 1.0
        new_x = goal + e * (y * c + (v + decay * y) * s_over_w)
        new_v = e * (v * c - (wn * wn * y + decay * v) * s_over_w)
    if limit < math.inf:
        if abs(new_v) > limit:
            new_v = math.copysign(limit, new_v)
        if abs(new_x - x) > limit * dt:
            new_x = x + math.copysign(limit * dt, new_x - x)
    return new_x, new_v


@in_place
def _limit_torque(s: Any, p: Any, start: float, motor_rate: float, load: float, dt: float) -> None:
    """Hold a motor with an arm back to what its torque allows: load, and inertia times acceleration."""
    limit, inertia = p[TORQUE_LIMIT_NM], p[ARM_INERTIA_KG_M2]
    rate = s[MOTOR_RATE] if p[NATURAL_FREQ_RAD_S] > 0.0 else (s[MOTOR] - start) / dt
    needed = load + inertia * (rate - motor_rate) / dt
    if abs(needed) > limit:
        s[MOTOR_RATE] = motor_rate + (math.copysign(limit, needed) - load) * dt / inertia
        s[MOTOR] = start + s[MOTOR_RATE] * dt


@in_place
def _swing(s: Any, p: Any, dt: float) -> None:
    """An unpowered joint with an arm: a pendulum with friction, semi-implicit; dry friction can only stop it."""
    v = s[OUTPUT_RATE]
    inertia = p[ARM_INERTIA_KG_M2]
    v -= dt * p[ARM_GRAVITY_NM] * math.sin(s[OUTPUT] - p[ARM_DOWN_RAD]) / inertia
    v /= 1.0 + dt * p[ARM_DRAG_NM_S] / inertia
    v = math.copysign(max(0.0, abs(v) - dt * p[ARM_COULOMB_NM] / inertia), v)
    s[OUTPUT] += dt * v
    s[OUTPUT_RATE] = v
