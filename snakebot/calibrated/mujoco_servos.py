"""Servos of a robot as MuJoCo has them: an actuator for each joint, and what the callbacks read of it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats
from snakebot.effects.effect import Affine, LinkFilter, SensorFilter, Track
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
    late = stages.late_s + sum(_delay_s(f) or 0.0 for f in stages.link_filters())
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

    for spec in stages.specs:
        effect, robot = spec.effect, stages.robot
        link, sensor = effect.link_filter(spec, robot), effect.sensor_filter(spec, robot)
        more = link is not None and _delay_s(link) is None
        more = more or (sensor is not None and not isinstance(sensor, Affine) and not _only_noise(sensor))
        if more or effect.servo_filter(spec, robot) is not None:
            said.append(f"{spec.name}: {effect.outside_mjcf(spec)}")
    said = list(dict.fromkeys(said))
    if numbers := joints(layout.BACKLASH_LOADED):
        said.append(f"play of joint {numbers}: the load does not push the joint through it")
    both = (rows[:, layout.NATURAL_FREQ_RAD_S] > 0) & (rows[:, layout.TIME_CONSTANT_S] > 0)
    if both.any():
        said.append(
            f"lag of joint {', '.join(map(str, np.flatnonzero(both) + 1))}: not in front of a second order"
        )
    for column, what in (
        (layout.LOAD_FRICTION, "friction that comes with the load"),
        (layout.DRIVE_FRICTION_PER_NM, "friction that comes with the drive's torque"),
        (layout.LOOP_BREAKAWAY_NM, "a breakaway torque above the friction in motion"),
    ):
        if numbers := joints(column):
            said.append(f"position loop of joint {numbers}: no {what}")
    said.append("a servo that is off (no set-point): MuJoCo takes no NaN; a free joint has no torque at all")
    return said


def _delay_s(link_filter: LinkFilter) -> float | None:
    """By how much a filter shifts all set-points alike; None where it does anything else to them."""
    probe = Track(np.array([0.0, 1.0, 3.0]), np.array([[0.0], [1.0], [-1.0]]))
    out = link_filter.batch(probe)
    shift = out.time_s - probe.time_s
    same = np.array_equal(out.setpoint_rad, probe.setpoint_rad) and out.variance_rad2 is None
    return float(shift[0]) if same and np.ptp(shift) < layout.TIME_GRAIN_S else None


def _only_noise(sensor_filter: SensorFilter) -> bool:
    """Whether a filter leaves the mean of readings as it is."""
    probe = np.linspace(-1.0, 1.0, 5)[:, None]
    mean = sensor_filter.batch(np.arange(5.0), probe)
    return bool(np.array_equal(np.broadcast_to(mean, probe.shape), probe))
