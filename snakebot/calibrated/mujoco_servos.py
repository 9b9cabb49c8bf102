"""Servos of a robot as MuJoCo has them: an actuator for each joint, and what the callbacks read of it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats
from snakebot.effects.effect import Affine
from snakebot.effects.library.clock_drift import Drift
from snakebot.effects.library.command_delay import Delay
from snakebot.effects.library.command_loss import Loss
from snakebot.physics import servo_layout as layout
from snakebot.physics.servo_grip import SOFT_DAMPING, STIFF_RAD_S

if TYPE_CHECKING:
    from snakebot.effects.stages import Stages

# Natural frequency of a stiff joint on its motor; chosen: a lag of 1.25 ms, which is taken off the servo's own.
STIFF_MOTOR_RAD_S = 800.0
STIFF_DAMPING = 0.5  # its damping ratio
NONE = 1e9  # a limit that there is not, as in the callbacks


@dataclass(frozen=True)
class ExportedServo:
    """One joint's servo.

    Attributes:
        joint: 0-based, that it is on.
        source: 0-based, number of the set-point that drives it.
        stiffness_nm_rad, damping_nm_s_rad: between motor and joint.
        brake_nm_s_rad, coulomb_nm: of the joint itself, against rest.
        numbers: what the callbacks read, by name.
        native: whether MJCF alone says all of it; the callbacks then leave it alone.
        broken: without torque.
        stuck_rad: angle at which the joint is stuck; None where it is not.
    """

    joint: int
    source: int
    stiffness_nm_rad: float
    damping_nm_s_rad: float
    brake_nm_s_rad: float
    coulomb_nm: float
    numbers: dict[str, float]
    native: bool
    broken: bool
    stuck_rad: float | None


def servos_of(stages: Stages, inertia_kg_m2: Floats, *, smooth: bool) -> list[ExportedServo]:
    """Servos in the order of their set-points.

    Args:
        inertia_kg_m2: (joints,) that each joint feels.
        smooth: whether the chain follows its motors smoothed, which MJCF alone does not say.
    """
    late = stages.late_s + sum(f.delay_s for f in stages.link_filters() if isinstance(f, Delay))
    rows = stages.servo_rows
    made = [_servo(j, row, float(late[j]), float(inertia_kg_m2[j]), smooth) for j, row in enumerate(rows)]
    return sorted(made, key=lambda servo: servo.source)


def _servo(joint: int, row: Floats, delay_s: float, inertia: float, smooth: bool) -> ExportedServo:
    stiff_loop = float(row[layout.LOOP_STIFFNESS_NM_RAD])
    give = float(row[layout.LOOP_COMPLIANCE_RAD_NM] + row[layout.COMPLIANCE_RAD_NM])
    coulomb, brake = float(row[layout.COULOMB_NM]), 0.0
    limit = float(row[layout.TORQUE_LIMIT_NM])
    if stiff_loop > 0:
        give += 1.0 / stiff_loop
        coulomb += float(row[layout.LOOP_COULOMB_NM])
        brake = float(row[layout.LOOP_DAMPING_NM_S] + row[layout.LOOP_VISCOUS_NM_S])
        limit = min(limit, float(row[layout.LOOP_LIMIT_NM]))
    soft = give > 0
    slope = float(row[layout.RATE_DROP_PER_NM])
    line = slope > 0
    frequency, ratio = STIFF_MOTOR_RAD_S, STIFF_DAMPING
    if soft:
        ratio = SOFT_DAMPING
    gives_way = smooth and not soft and (line or limit < math.inf)
    stiffness = 1.0 / give if soft else inertia * frequency**2
    damping = 0.0 if stiff_loop > 0 else 2.0 * ratio * math.sqrt(stiffness * inertia)
    rate = float(row[layout.RATE_LIMIT_RAD_S])
    lead = damping / stiffness
    tau = float(row[layout.TIME_CONSTANT_S])
    numbers = {
        "delay_s": delay_s,
        "gain": float(row[layout.GAIN] * row[layout.SIGN]),
        "offset_rad": float(row[layout.OFFSET_RAD]),
        "deadband_rad": float(row[layout.DEADBAND_RAD]),
        "deadband_hard": float(row[layout.DEADBAND_HARD]),
        "time_constant_s": tau,
        "natural_freq_rad_s": float(row[layout.NATURAL_FREQ_RAD_S]),
        "damping_ratio": float(row[layout.DAMPING_RATIO]),
        "rate_limit_rad_s": NONE if line else min(rate, NONE),
        "rate_drop_per_s": float(row[layout.RATE_DROP_PER_S]),
        "backlash_rad": float(row[layout.BACKLASH_RAD]),
        "lead_s": lead,
        "torque_limit_nm": min(limit, NONE),
        "stall_nm": 1.0 / slope if line else NONE,
        "no_load_rad_s": rate if line else NONE,
        "stiff_nm_rad": stiffness,
        "weak_nm_rad": inertia * STIFF_RAD_S**2 if gives_way else 0.0,
        "weak_nm_s_rad": 2.0 * inertia * STIFF_RAD_S if gives_way else 0.0,
    }
    plain = delay_s == 0 and numbers["rate_limit_rad_s"] == NONE
    plain = plain and not any(numbers[k] for k in ("deadband_rad", "natural_freq_rad_s", "backlash_rad"))
    locked = row[layout.LOCKED]
    return ExportedServo(
        joint=joint,
        source=int(row[layout.SOURCE]),
        stiffness_nm_rad=stiffness,
        damping_nm_s_rad=damping,
        brake_nm_s_rad=brake,
        coulomb_nm=coulomb,
        numbers=numbers,
        native=plain and not soft and not smooth and tau >= lead,
        broken=bool(locked == layout.FREE_JOINT),
        stuck_rad=float(row[layout.LOCK_RAD]) if locked == layout.RIGID_JOINT else None,
    )


def not_expressed(stages: Stages) -> list[str]:
    """What the exported model leaves out of this robot, a sentence each."""
    rows, said = stages.servo_rows, []

    def joints(column: int, neutral: float = 0.0) -> str:
        found = np.flatnonzero(rows[:, column] != neutral) + 1
        return ", ".join(map(str, found)) if found.size else ""

    for link_filter in stages.link_filters():
        if isinstance(link_filter, Loss):
            said.append(
                f"command_loss: leave out a set-point with probability {link_filter.probability:g} in your own loop"
            )
        elif isinstance(link_filter, Drift):
            said.append("clock_drift: set-points come when your own loop writes them")
        elif not isinstance(link_filter, Delay):
            said.append(f"{type(link_filter).__name__}: a filter on set-points that is written in Python")
    said += [
        f"{type(f).__name__}: a state in front of the servo that is written in Python"
        for f in stages.servo_filters()
    ]
    said += [
        f"{type(f).__name__}: a filter on readings that is neither gain, offset nor noise"
        for f in stages.sensor_filters()
        if not isinstance(f, Affine) and not _only_noise(f)
    ]
    if numbers := joints(layout.BACKLASH_LOADED):
        said.append(f"backlash on joint {numbers}: the load does not push the joint through its play")
    both = (rows[:, layout.NATURAL_FREQ_RAD_S] > 0) & (rows[:, layout.TIME_CONSTANT_S] > 0)
    if both.any():
        said.append(
            f"servo_lag on joint {', '.join(map(str, np.flatnonzero(both) + 1))}: not in front of a second order"
        )
    for column, what in (
        (layout.LOAD_FRICTION, "friction that comes with the load"),
        (layout.DRIVE_FRICTION_PER_NM, "friction that comes with the drive's torque"),
        (layout.LOOP_BREAKAWAY_NM, "a breakaway torque above the friction in motion"),
    ):
        if numbers := joints(column):
            said.append(f"position_loop on joint {numbers}: no {what}")
    said.append(
        "a servo that is off (no set-point): MuJoCo takes no NaN; a joint of joint_free has no torque at all"
    )
    return said


def _only_noise(sensor_filter: object) -> bool:
    """Whether a filter leaves the mean of readings as it is."""
    probe = np.linspace(-1.0, 1.0, 5)[:, None]
    mean = sensor_filter.batch(np.arange(5.0), probe)  # type: ignore[attr-defined]
    return bool(np.array_equal(np.broadcast_to(mean, probe.shape), probe))


# Where a number of an effect stands in the exported model; {j}: the joints.
IN_SERVO = {
    (
        "command_delay",
        "delay_s",
    ): "delay_s of numeric servo_{j}; at most what is in the file, which has kept room",
    ("rate_limit", "limit_rad_s"): "rate_limit_rad_s of numeric servo_{j}",
    ("voltage_sag", "initial_rad_s"): "rate_limit_rad_s of numeric servo_{j}",
    ("voltage_sag", "drop_per_s"): "rate_drop_per_s of numeric servo_{j}",
    ("second_order", "natural_freq_rad_s"): "natural_freq_rad_s of numeric servo_{j}",
    ("second_order", "damping_ratio"): "damping_ratio of numeric servo_{j}",
    ("deadband", "width_deg"): "deadband_rad of numeric servo_{j}, in rad",
    ("backlash", "width_deg"): "backlash_rad of numeric servo_{j}, in rad",
    ("torque_limit", "limit_nm"): "forcerange of the actuator on joint_{j}: -value value",
    (
        "compliance",
        "stiffness_nm_rad",
    ): "gainprm 0 and minus biasprm 1 of the actuator on joint_{j}; lead_s of numeric "
    "servo_{j} is minus biasprm 2 over it",
    ("joint_friction", "coulomb_nm"): "frictionloss of joint_{j}",
    (
        "joint_friction",
        "stiffness_nm_rad",
    ): "gainprm 0 and minus biasprm 1 of the actuator on joint_{j}; lead_s of "
    "numeric servo_{j} is minus biasprm 2 over it",
    ("encoder_gain", "gain"): "numeric encoder_gain, entry {j}",
    ("encoder_offset", "offset_deg"): "numeric encoder_offset_rad, entry {j}, in rad",
    ("encoder_noise", "std_deg"): "numeric encoder_noise_rad, entry {j}, in rad",
    ("payload", "mass_kg"): "inertial of the link: mass",
}
