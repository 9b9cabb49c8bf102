"""A smart servo as a position loop, compiled: a spring to the set-point that must move what hangs on it.

    (I + A) x'' = drive - (damping + viscous) x' - gravity sin(x - down) - load - friction
    drive = stiffness (target - x), cut off at the limit

I and gravity are those of a bench joint's arm, A is the armature: motor and gear as the joint feels them. Damping is
the drive's, back EMF and all, and is there with power alone. Dry friction opposes the motion, or holds the joint:

    friction = coulomb + breakaway exp(-(x' / stribeck)^2) + load_friction |load| + drive_friction drive^2

The last two are what gears lose under load: each tooth is pressed by what it carries. Laws of this kind, with and
without the square, are compared on four servos by M. Duclusaud et al., "Extended Friction Models for the Physics
Simulation of Servo Actuators", arXiv:2410.08650 (2024).

A step solves spring, dampers and inertia in closed form, with gravity and friction as they are in its middle or at its
start; where the joint comes to rest within the step, it is cut there.
"""

from __future__ import annotations

import math
from typing import Any

from snakebot.physics.compiled import in_place
from snakebot.physics.servo_layout import (
    ARM_DOWN_RAD,
    ARM_GRAVITY_NM,
    ARM_INERTIA_KG_M2,
    ARMATURE_KG_M2,
    DEADBAND_RAD,
    DRIVE_FRICTION_PER_NM,
    LOAD_FRICTION,
    LOOP_BREAKAWAY_NM,
    LOOP_COULOMB_NM,
    LOOP_DAMPING_NM_S,
    LOOP_LIMIT_NM,
    LOOP_STIFFNESS_NM_RAD,
    LOOP_VISCOUS_NM_S,
    RATE_LIMIT_RAD_S,
    STRIBECK_RAD_S,
)

LEAST_INERTIA_KG_M2 = 1e-7  # of a joint: that of a bare rotor of a gram, without a gear
PARTS = 3  # stretches of a step: until the joint rests, until it rests again, and to the end


@in_place
def loop_step(x: float, v: float, p: Any, target: float, load: float, dt: float) -> tuple[float, float]:
    """Angle and rate after ``dt`` under power; ``load``: torque on the joint beside that of its arm."""
    error = target - x
    band = p[DEADBAND_RAD]
    if band > 0.0:
        target = x if abs(error) <= band else target - math.copysign(band, error)
    x, v = _move(x, v, p, target, p[LOOP_STIFFNESS_NM_RAD], p[LOOP_DAMPING_NM_S], load, dt)
    limit = p[RATE_LIMIT_RAD_S]
    return x, min(max(v, -limit), limit)


@in_place
def loop_swing(x: float, v: float, p: Any, load: float, dt: float) -> tuple[float, float]:
    """The same without power: gravity and friction alone."""
    return _move(x, v, p, x, 0.0, 0.0, load, dt)


@in_place
def _move(
    x: float, v: float, p: Any, target: float, stiffness: float, damping: float, load: float, dt: float
) -> tuple[float, float]:
    inertia = max(p[ARM_INERTIA_KG_M2] + p[ARMATURE_KG_M2], LEAST_INERTIA_KG_M2)
    drag = damping + p[LOOP_VISCOUS_NM_S]
    limit = p[LOOP_LIMIT_NM]
    left = dt
    for _ in range(PARTS):
        pull = load  # torque of the load, in the middle of the stretch
        if p[ARM_GRAVITY_NM] != 0.0:
            pull += p[ARM_GRAVITY_NM] * math.sin(x + 0.5 * left * v - p[ARM_DOWN_RAD])
        drive = stiffness * (target - x)
        spring = stiffness
        if abs(drive) > limit:
            drive, spring = math.copysign(limit, drive), 0.0
        slow = v / p[STRIBECK_RAD_S]
        friction = p[LOOP_COULOMB_NM] + p[LOOP_BREAKAWAY_NM] * math.exp(-slow * slow)
        friction += p[LOAD_FRICTION] * abs(pull) + p[DRIVE_FRICTION_PER_NM] * drive * drive
        net = drive - pull
        if v == 0.0:
            if abs(net) <= friction:
                return x, 0.0
            way = math.copysign(1.0, net)
        else:
            way = math.copysign(1.0, v)
        net -= way * friction
        new_x, new_v = _glide(x, v, net, spring, drag, inertia, left)
        if new_v * way >= 0.0:
            return new_x, new_v
        # it comes to rest on the way: there friction may hold it, or it turns back
        until = left * v / (v - new_v)
        x, _unused = _glide(x, v, net, spring, drag, inertia, until)
        v = 0.0
        left -= until
        if left <= 1e-9 * dt:
            break
    return x, v


@in_place
def _glide(
    x: float, v: float, net: float, spring: float, drag: float, inertia: float, dt: float
) -> tuple[float, float]:
    """inertia x'' = net - spring (x - x0) - drag x', solved over ``dt``."""
    decay = 0.5 * drag / inertia
    if spring == 0.0:
        if decay * dt < 1e-6:
            a = (net - drag * v) / inertia
            return x + dt * (v + 0.5 * dt * a), v + dt * a
        fall = math.exp(-2.0 * decay * dt)
        end = net / drag
        return x + end * dt + (v - end) * (1.0 - fall) / (2.0 * decay), end + (v - end) * fall
    y = -net / spring  # from where it would come to rest
    square = spring / inertia
    shape = decay * decay - square
    if shape < 0.0:
        w = math.sqrt(-shape)
        e = math.exp(-decay * dt)
        c, s = e * math.cos(w * dt), e * math.sin(w * dt) / w
    elif shape * dt * dt < 1e-12:
        e = math.exp(-decay * dt)
        c, s = e, e * dt
    else:  # both exponentials apart: cosh alone would overflow on a heavily damped servo
        w = math.sqrt(shape)
        up, down = math.exp((w - decay) * dt), math.exp((-w - decay) * dt)
        c, s = 0.5 * (up + down), 0.5 * (up - down) / w
    return x - y + y * c + (v + decay * y) * s, v * c - (square * y + decay * v) * s
