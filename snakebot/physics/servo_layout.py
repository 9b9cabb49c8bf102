"""Where each number of a servo stands in the rows that the compiled kernel reads and writes.

One row a joint. The order of the columns is the order of the signal: wiring, gain and offset, dead band, lag, rate
limit, torque limit, friction, compliance, backlash, what holds the output, and a position loop with inertia, which
takes the place of lag and limits.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from snakebot.arrays import Bools, Floats

# Two times nearer than this are one, a shorter step is none: the grain of the clocks in logs.
TIME_GRAIN_S = 1e-9

# Columns of the parameters, (joints, PARAMETERS).
(
    SOURCE,  # 0-based joint whose set-point drives this one
    SIGN,  # +1, or -1 where the set-point is reversed
    GAIN,  # joint angle over set-point
    OFFSET_RAD,
    DEADBAND_RAD,  # half width
    DEADBAND_HARD,  # 1: outside the band the whole error drives; 0: what it exceeds the band by
    TIME_CONSTANT_S,  # first-order lag; where NATURAL_FREQ is set, a first-order filter in front of it
    NATURAL_FREQ_RAD_S,  # 0: the servo is first order
    DAMPING_RATIO,
    RATE_LIMIT_RAD_S,
    RATE_DROP_PER_S,  # relative fall of the rate limit with time
    RATE_DROP_PER_NM,  # relative fall of the rate limit with opposing load
    TORQUE_LIMIT_NM,
    COULOMB_NM,  # dry friction
    LOOP_COMPLIANCE_RAD_NM,  # 1 / stiffness of the position loop that works against the dry friction
    COMPLIANCE_RAD_NM,  # 1 / stiffness between motor and output
    BACKLASH_RAD,  # full play
    BACKLASH_LOADED,  # 1: the load decides on which side of the play the output lies; 0: friction keeps it where it is
    LOCKED,  # FREE_JOINT, RIGID_JOINT, or DRIVEN
    LOCK_RAD,  # angle of a rigid joint
    ARM_GRAVITY_NM,  # bench only: torque of a horizontal arm
    ARM_DOWN_RAD,  # bench only: joint angle at which the arm hangs
    ARM_INERTIA_KG_M2,  # bench only
    ARM_DRAG_NM_S,  # bench only: viscous friction of the unpowered joint
    ARM_COULOMB_NM,  # bench only: dry friction of the unpowered joint
    LOOP_STIFFNESS_NM_RAD,  # above 0: the servo is a position loop that moves what hangs on it, see servo_loop
    LOOP_DAMPING_NM_S,  # while there is power
    LOOP_LIMIT_NM,  # what stiffness times error comes to at most
    ARMATURE_KG_M2,  # of motor and gear, at the joint
    LOOP_COULOMB_NM,  # dry friction of the gear without load
    LOOP_BREAKAWAY_NM,  # what comes to it at rest ...
    STRIBECK_RAD_S,  # ... and falls off with the speed
    LOOP_VISCOUS_NM_S,  # with power or without
    LOAD_FRICTION,  # dry friction over the torque of the load
    DRIVE_FRICTION_PER_NM,  # dry friction over the square of the drive's torque
) = range(35)
PARAMETERS = 35

DRIVEN, FREE_JOINT, RIGID_JOINT = 0.0, 1.0, 2.0

# Columns of the state, (joints, STATES).
(
    FILTERED,  # set-point behind the first-order filter of a second-order servo
    MOTOR,  # angle of the motor
    MOTOR_RATE,
    SMOOTH,  # what a body's chain follows, and its rate
    SMOOTH_RATE,
    HELD_BACK,  # how far the load keeps the joint of a body from where its motor is
    DRAGGED,  # behind dry friction
    OUTPUT,  # joint angle
    OUTPUT_RATE,  # mean over the last step
    POWERED,  # 1 while the servo has a set-point
) = range(10)
STATES = 10


def nominal_parameters(joints: int, time_constant_s: float) -> Floats:
    """Floats of a servo that is a first-order lag and nothing else."""
    rows = np.zeros((joints, PARAMETERS))
    rows[:, SOURCE] = np.arange(joints)
    rows[:, SIGN] = 1.0
    rows[:, GAIN] = 1.0
    rows[:, TIME_CONSTANT_S] = time_constant_s
    rows[:, DAMPING_RATIO] = 1.0
    rows[:, RATE_LIMIT_RAD_S] = math.inf
    rows[:, TORQUE_LIMIT_NM] = math.inf
    rows[:, LOOP_LIMIT_NM] = math.inf
    rows[:, STRIBECK_RAD_S] = 1.0
    return rows


def state_at_rest(angle_rad: npt.ArrayLike) -> Floats:
    """Floats of servos that have stood at ``angle_rad`` (joints,) for long, unpowered until the first set-point."""
    angle = np.atleast_1d(np.asarray(angle_rad, dtype=np.float64))
    state = np.zeros((angle.size, STATES))
    for column in (FILTERED, MOTOR, SMOOTH, DRAGGED, OUTPUT):
        state[:, column] = angle
    return state


def rest_angle_rad(parameters: Floats, setpoint_rad: npt.ArrayLike) -> Floats:
    """(joints,) where the joints stand when a set-point has been held for long and nothing loads them."""
    setpoint = np.broadcast_to(np.asarray(setpoint_rad, dtype=np.float64), (parameters.shape[0],))
    driven = setpoint[parameters[:, SOURCE].astype(np.int64)]
    angle: Floats = parameters[:, GAIN] * parameters[:, SIGN] * driven + parameters[:, OFFSET_RAD]
    return np.where(parameters[:, LOCKED] == RIGID_JOINT, parameters[:, LOCK_RAD], angle)


def holding_setpoint_rad(parameters: Floats, angle_rad: npt.ArrayLike) -> Floats:
    """(..., joints) set-points that keep the joints at angles (..., joints): ``rest_angle_rad`` the other way round."""
    angle = np.asarray(angle_rad)
    setpoint = np.zeros(angle.shape)
    driven = (angle - parameters[:, OFFSET_RAD]) / (parameters[:, GAIN] * parameters[:, SIGN])
    setpoint[..., parameters[:, SOURCE].astype(np.int64)] = driven
    return setpoint


_LOADED = (RATE_DROP_PER_NM, COULOMB_NM, LOOP_COMPLIANCE_RAD_NM, COMPLIANCE_RAD_NM, LOOP_STIFFNESS_NM_RAD)


def feels_load(parameters: Floats) -> bool:
    """Whether any joint's motion depends on the torque that it bears: on a body it is then that of the whole body."""
    return bool(loaded_joints(parameters).any())


def loaded_joints(parameters: Floats) -> Bools:
    """(joints,) whether the motion depends on the torque that the joint bears."""
    limited: Bools = np.isfinite(parameters[:, TORQUE_LIMIT_NM])
    return limited | (parameters[:, _LOADED] > 0).any(axis=1) | loose(parameters)


def loose(parameters: Floats) -> Bools:
    """(joints,) whether the output swings in the play of its gears as the load wants it to."""
    swings: Bools = (parameters[:, BACKLASH_RAD] > 0) & (parameters[:, BACKLASH_LOADED] > 0)
    return swings


def half_swing_rad(parameters: Floats) -> Floats:
    """(joints,) half of the play in which the output swings as the load wants it to; zero where it is not ``loose``."""
    return np.where(loose(parameters), 0.5 * parameters[:, BACKLASH_RAD], 0.0)


def needs_fine_steps(parameters: Floats) -> bool:
    """Whether the closed forms of the kernel do not hold over a whole set-point on some joint, see ``fine_joints``."""
    return bool(fine_joints(parameters).any())


def fine_joints(parameters: Floats) -> Bools:
    """(joints,) whether the closed forms of the kernel do not hold over a whole set-point: it must step inside it."""
    second = parameters[:, NATURAL_FREQ_RAD_S] > 0
    bent = (
        (parameters[:, TIME_CONSTANT_S] > 0)
        | (parameters[:, DEADBAND_RAD] > 0)
        | np.isfinite(parameters[:, RATE_LIMIT_RAD_S])
        | (parameters[:, BACKLASH_RAD] > 0)
        | (parameters[:, COULOMB_NM] > 0)
    )
    arm = parameters[:, ARM_INERTIA_KG_M2] > 0
    return np.asarray(loaded_joints(parameters) | (second & bent) | arm)
