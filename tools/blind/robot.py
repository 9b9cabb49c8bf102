"""The stand-in for reality: a robot that shares no code with the product's physics or effects.

Body and servos are in ``chain``; here are its numbers, its board (wire, clock, set-point register) and its sensors.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import radians

import numpy as np

from blind.chain import JOINT_ROWS, LINK_ROWS, Chain, Table

LINKS = 6
JOINTS = LINKS - 1
COUNTS_PER_REV = 8192
SETPOINT_STEP_RAD = 1e-4
WIRE_S = 0.001  # what a command needs from the host to the servo; the lab's 30 ms hold it
# Beyond the position loop's own lag: wire, rotor and load, less what the integral takes. It depends a little on load
# and joint: 0.3 ms either way at the 100 Hz of the cases.
LOOP_LAG_S = WIRE_S - 0.0003

# What the user's simulation believes, and what session.yaml says.
NOMINAL_LINK = {"mass_kg": 1.43, "half_length_m": 0.08, "ct": 0.83, "cn": 51.9, "ct0": 0.49, "cn0": 2.33}
NOMINAL_LAG_S = 0.03

_SERVO = {
    "lag_s": NOMINAL_LAG_S - LOOP_LAG_S, "rate_plus_rad_s": 18.0, "rate_minus_rad_s": 18.0, "loop_nm_s_rad": 5.0,
    "integral_nm_rad": 600.0, "stall_nm": 20.0, "no_load_rad_s": 20.0, "torque_limit_nm": 20.0, "rotor_kg_m2": 2e-3,
    "coulomb_nm": 0.01, "bristle_nm_rad": 200.0, "viscous_nm_s_rad": 0.002, "gear_nm_rad": 1000.0,
    "gear_nm_s_rad": 1.0, "eccentric_turns": 1.0,
}  # fmt: skip


def _joint_table() -> Table:
    return np.array([[_SERVO.get(row, 0.0)] * JOINTS for row in JOINT_ROWS])


@dataclass
class Parameters:
    """All numbers of one real robot. Effects change them; ``joint`` and ``link`` give one row to write to."""

    joints: Table = field(default_factory=_joint_table)
    links: Table = field(
        default_factory=lambda: np.array([[NOMINAL_LINK[row]] * LINKS for row in LINK_ROWS], dtype=float)
    )
    ground: Table = field(default_factory=lambda: np.array([0.0, 0.0, 10.0, 0.0, 0.0]))
    mixing: Table = field(
        default_factory=lambda: np.eye(JOINTS)
    )  # set-point that arrives = mixing @ commanded
    latency_s: float = WIRE_S
    latency_jitter_s: float = 0.0
    loss: float = 0.0
    clock_ppm: float = 0.0
    reading_gain: Table = field(default_factory=lambda: np.ones(JOINTS))
    reading_offset_rad: Table = field(default_factory=lambda: np.zeros(JOINTS))
    reading_wave_rad: Table = field(default_factory=lambda: np.zeros((2, JOINTS)))  # amplitude, phase
    reading_noise_rad: Table = field(default_factory=lambda: np.zeros(JOINTS))
    quantised: bool = True
    pose_noise_m: float = 0.0
    pose_noise_rad: float = 0.0

    def joint(self, row: str) -> Table:
        return self.joints[JOINT_ROWS.index(row)]

    def link(self, row: str) -> Table:
        return self.links[LINK_ROWS.index(row)]

    def copy(self) -> Parameters:
        return Parameters(**{k: v.copy() if isinstance(v, np.ndarray) else v for k, v in vars(self).items()})

    def noiseless(self) -> Parameters:
        """The same robot read by perfect sensors over a steady wire."""
        clean = self.copy()
        clean.reading_noise_rad[:] = 0.0
        clean.pose_noise_m = clean.pose_noise_rad = clean.latency_jitter_s = 0.0
        clean.quantised = False
        return clean


# By how much a healthy robot may be off. The draws are cut there: a lag that is farther off is a gap, not background.
MOST_OFF = {"mass": 0.03, "friction": 0.05, "lag": 0.05}


def _spread(rng: np.random.Generator, common: float, each: float, count: int, most: float) -> Table:
    """Factors (count,) about one, alike but for ``each``; drawn again until none is off by more than ``most``."""
    while True:
        factor = np.exp(common * rng.normal() + each * rng.normal(size=count))
        if np.abs(factor - 1).max() < most:
            return np.asarray(factor)


def real_robot(rng: np.random.Generator) -> Parameters:
    """A robot as it left the workshop: everything a few per cent off, sensors noisy, gears with a trace of play."""
    p = Parameters()
    p.link("mass_kg")[:] *= _spread(rng, 0.015, 0.01, LINKS, MOST_OFF["mass"])
    for row in ("ct", "cn", "ct0", "cn0"):
        p.link(row)[:] *= _spread(rng, 0.025, 0.01, LINKS, MOST_OFF["friction"])
    p.latency_s, p.latency_jitter_s = WIRE_S + rng.uniform(-0.0003, 0.0003), 0.0002
    wire = p.latency_s - WIRE_S + p.latency_jitter_s * (2 / np.pi) ** 0.5  # late in the mean
    room = MOST_OFF["lag"] - abs(wire) / NOMINAL_LAG_S  # wire and servo together keep within the bound
    p.joint("lag_s")[:] += NOMINAL_LAG_S * (_spread(rng, 0.025, 0.01, JOINTS, room) - 1)
    p.joint("play_rad")[:] = np.radians(rng.uniform(0.0, 0.05, JOINTS))
    p.joint("coulomb_nm")[:] = rng.uniform(0.003, 0.02, JOINTS)
    p.ground[4] = rng.uniform(0.0, 0.002)  # the supply gives way a little when all motors pull
    p.clock_ppm = rng.normal(0.0, 20.0)
    p.reading_noise_rad[:] = np.radians(rng.uniform(0.03, 0.06))
    p.pose_noise_m, p.pose_noise_rad = 0.001, radians(0.1)
    return p


@dataclass(frozen=True)
class Recording:
    """What a lab has after a run: times, commands, readings, pose."""

    t_s: Table
    command_rad: Table
    encoder_rad: Table
    pose: Table


class Robot:
    """``run`` streams commands to it and reads it at the same ticks; the board's clock is its own."""

    def __init__(self, parameters: Parameters) -> None:
        self.parameters = parameters
        self._chain = Chain(parameters.links)

    def run(self, t_s: Table, command_rad: Table, rng: np.random.Generator) -> Recording:
        p = self.parameters
        ticks = t_s.size
        wire_s = p.latency_s + p.latency_jitter_s * np.abs(rng.normal(size=ticks))
        arrival = np.maximum.accumulate(t_s * (1 + p.clock_ppm * 1e-6) + wire_s)
        there = rng.random(ticks) >= p.loss
        there[0] = True
        setpoint = command_rad @ p.mixing.T
        if p.quantised:
            setpoint = np.round(setpoint / SETPOINT_STEP_RAD) * SETPOINT_STEP_RAD
        angle, sway, pose = self._chain.run(
            p.joints, p.ground, arrival[there], setpoint[there], np.ascontiguousarray(t_s)
        )
        wave, phase = p.reading_wave_rad
        reading = p.reading_gain * (angle + sway) + p.reading_offset_rad + wave * np.sin(angle + phase)
        reading = reading + p.reading_noise_rad * rng.normal(size=reading.shape)
        if p.quantised:
            count = 2 * np.pi / COUNTS_PER_REV
            reading = np.round(reading / count) * count
        scatter = np.array([p.pose_noise_m, p.pose_noise_m, p.pose_noise_rad])
        return Recording(t_s, command_rad, reading, pose + scatter * rng.normal(size=pose.shape))


def gait_command(
    t_s: Table, alpha_rad: float, beta_rad: float, omega_rad_s: float, ramp_s: float = 1.0
) -> Table:
    """phi_i = alpha sin(omega t + (i - 1) beta), swelling from rest over ``ramp_s``. Shape (T, joints)."""
    s = np.clip(t_s / ramp_s, 0, 1)[:, None]
    swell = s**3 * (10 - 15 * s + 6 * s**2)
    return swell * alpha_rad * np.sin(omega_rad_s * t_s[:, None] + np.arange(JOINTS) * beta_rad)
