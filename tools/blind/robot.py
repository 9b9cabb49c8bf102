"""The stand-in for reality: a robot that shares no code with the product's physics or effects.

Body and servos are in ``chain``; here are its numbers, its board (wire, clock, set-point register) and its sensors.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import radians
from typing import Any

import numpy as np

from blind.chain import JOINT_ROWS, LINK_ROWS, Chain, Floats

JOINTS = 5  # of the robot that the built-in description holds; others have more or fewer
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


@dataclass(frozen=True)
class Build:
    """What the user's simulation believes of a robot, and how fast it is commanded and read.

    All are as long and heavy as the built-in one, cut into as many links: its servos would not move a longer one.
    """

    joints: int = JOINTS
    lag_s: float = NOMINAL_LAG_S
    rate_hz: float = 100.0

    @property
    def link(self) -> dict[str, float]:
        """The numbers of each link."""
        share = (JOINTS + 1) / (self.joints + 1)
        return {row: round(share * value, 4) for row, value in NOMINAL_LINK.items()}


def _joint_table(build: Build) -> Floats:
    lighter = (
        min(1.0, (JOINTS + 1) / (build.joints + 1)) ** 1.5
    )  # links want less damping, or a step overshoots
    servo = {**_SERVO, "lag_s": build.lag_s - LOOP_LAG_S, "gear_nm_s_rad": lighter * _SERVO["gear_nm_s_rad"]}
    return np.array([[servo.get(row, 0.0)] * build.joints for row in JOINT_ROWS])


def _link_table(build: Build) -> Floats:
    return np.array([[build.link[row]] * (build.joints + 1) for row in LINK_ROWS], dtype=float)


@dataclass
class Parameters:
    """All numbers of one real robot. Effects change them; ``joint`` and ``link`` give one row to write to."""

    joints: Floats = field(default_factory=lambda: _joint_table(Build()))
    links: Floats = field(default_factory=lambda: _link_table(Build()))
    ground: Floats = field(default_factory=lambda: np.array([0.0, 0.0, 10.0, 0.0, 0.0]))
    mixing: Floats = field(
        default_factory=lambda: np.eye(JOINTS)
    )  # set-point that arrives = mixing @ commanded
    delay_s: Floats = field(default_factory=lambda: np.zeros(JOINTS))  # of each joint, beside the wire
    nominal_lag_s: float = NOMINAL_LAG_S  # that the user's simulation believes
    latency_s: float = WIRE_S
    latency_jitter_s: float = 0.0
    loss: float = 0.0
    clock_ppm: float = 0.0
    reading_gain: Floats = field(default_factory=lambda: np.ones(JOINTS))
    reading_offset_rad: Floats = field(default_factory=lambda: np.zeros(JOINTS))
    reading_wave_rad: Floats = field(default_factory=lambda: np.zeros((2, JOINTS)))  # amplitude, phase
    reading_noise_rad: Floats = field(default_factory=lambda: np.zeros(JOINTS))
    quantised: bool = True
    pose_noise_m: float = 0.0
    pose_noise_rad: float = 0.0

    @classmethod
    def of(cls, build: Build) -> Parameters:
        """Those of a nominal robot."""
        k = build.joints
        return cls(
            joints=_joint_table(build), links=_link_table(build), mixing=np.eye(k), delay_s=np.zeros(k),
            nominal_lag_s=build.lag_s, reading_gain=np.ones(k), reading_offset_rad=np.zeros(k),
            reading_wave_rad=np.zeros((2, k)), reading_noise_rad=np.zeros(k),
        )  # fmt: skip

    @property
    def joint_count(self) -> int:
        return int(self.joints.shape[1])

    def joint(self, row: str) -> Floats:
        values: Floats = self.joints[JOINT_ROWS.index(row)]
        return values

    def link(self, row: str) -> Floats:
        values: Floats = self.links[LINK_ROWS.index(row)]
        return values

    def copy(self) -> Parameters:
        arrays: dict[str, Any] = {k: v.copy() for k, v in vars(self).items() if isinstance(v, np.ndarray)}
        return replace(self, **arrays)

    def noiseless(self) -> Parameters:
        """The same robot read by perfect sensors over a steady wire."""
        clean = self.copy()
        clean.reading_noise_rad[:] = 0.0
        clean.pose_noise_m = clean.pose_noise_rad = clean.latency_jitter_s = 0.0
        clean.quantised = False
        return clean


# What a healthy robot may be off by: one standard deviation, and nothing is cut off. Shares, but for the wire in
# seconds. They are what a session says of a robot whose numbers nobody has measured (the contract of sessions).
TOLERANCE = {"mass": 0.03, "friction": 0.05, "lag": 0.06, "wire": 0.001}
ALIKE = 0.8  # share of the variance that links, or joints, of one robot have in common: they are of one batch


def _factors(rng: np.random.Generator, spread: float, count: int) -> Floats:
    """Factors (count,) about one, normal with this standard deviation; none is below a tenth."""
    common, own = rng.normal(), rng.normal(size=count)
    return np.asarray(np.maximum(1 + spread * (ALIKE**0.5 * common + (1 - ALIKE) ** 0.5 * own), 0.1))


def real_robot(rng: np.random.Generator, build: Build | None = None) -> Parameters:
    """A healthy robot: everything off within the tolerance, sensors noisy, gears with a trace of play."""
    build = build or Build()
    p, k = Parameters.of(build), build.joints
    p.link("mass_kg")[:] *= _factors(rng, TOLERANCE["mass"], k + 1)
    for row in ("ct", "cn", "ct0", "cn0"):
        p.link(row)[:] *= _factors(rng, TOLERANCE["friction"], k + 1)
    # a wire cannot be early: what would be stays at nothing
    p.latency_s, p.latency_jitter_s = max(0.0, WIRE_S + TOLERANCE["wire"] * rng.normal()), 0.0002
    p.joint("lag_s")[:] += build.lag_s * (_factors(rng, TOLERANCE["lag"], k) - 1)
    p.joint("play_rad")[:] = np.radians(rng.uniform(0.0, 0.05, k))
    p.joint("coulomb_nm")[:] = rng.uniform(0.003, 0.02, k)
    p.ground[4] = rng.uniform(0.0, 0.002)  # the supply gives way a little when all motors pull
    p.clock_ppm = rng.normal(0.0, 20.0)
    p.reading_noise_rad[:] = np.radians(rng.uniform(0.03, 0.06))
    p.pose_noise_m, p.pose_noise_rad = 0.001, radians(0.1)
    return p


@dataclass(frozen=True)
class Recording:
    """What a lab has after a run: times, commands, readings, pose."""

    t_s: Floats
    command_rad: Floats
    encoder_rad: Floats
    pose: Floats


class Robot:
    """``run`` streams commands to it and reads it at the same ticks; the board's clock is its own."""

    def __init__(self, parameters: Parameters) -> None:
        self.parameters = parameters
        self._chain = Chain(parameters.links)

    def run(self, t_s: Floats, command_rad: Floats, rng: np.random.Generator) -> Recording:
        p = self.parameters
        ticks = t_s.size
        wire_s = p.latency_s + p.latency_jitter_s * np.abs(rng.normal(size=ticks))
        arrival = np.maximum.accumulate(t_s * (1 + p.clock_ppm * 1e-6) + wire_s)
        there = rng.random(ticks) >= p.loss
        there[0] = True
        setpoint = command_rad @ p.mixing.T
        if p.quantised:
            setpoint = np.round(setpoint / SETPOINT_STEP_RAD) * SETPOINT_STEP_RAD
        arrival, setpoint = _each_late(arrival[there], setpoint[there], p.delay_s)
        angle, sway, pose = self._chain.run(p.joints, p.ground, arrival, setpoint, np.ascontiguousarray(t_s))
        wave, phase = p.reading_wave_rad
        reading = p.reading_gain * (angle + sway) + p.reading_offset_rad + wave * np.sin(angle + phase)
        reading = reading + p.reading_noise_rad * rng.normal(size=reading.shape)
        if p.quantised:
            count = 2 * np.pi / COUNTS_PER_REV
            reading = np.round(reading / count) * count
        scatter = np.array([p.pose_noise_m, p.pose_noise_m, p.pose_noise_rad])
        return Recording(t_s, command_rad, reading, pose + scatter * rng.normal(size=pose.shape))


def _each_late(arrival_s: Floats, setpoint_rad: Floats, delay_s: Floats) -> tuple[Floats, Floats]:
    """Times and rows of set-points of which each joint takes its own so much later."""
    if not delay_s.any():
        return arrival_s, setpoint_rad
    times = np.unique(arrival_s[:, None] + delay_s)
    rows = np.zeros((times.size, delay_s.size))
    for j, late in enumerate(delay_s):
        at = np.searchsorted(arrival_s + late, times, side="right") - 1
        rows[:, j] = np.where(at < 0, 0.0, setpoint_rad[at, j])
    return times, rows


def gait_command(
    t_s: Floats,
    alpha_rad: float,
    beta_rad: float,
    omega_rad_s: float,
    ramp_s: float = 1.0,
    joints: int = JOINTS,
) -> Floats:
    """phi_i = alpha sin(omega t + (i - 1) beta), swelling from rest over ``ramp_s``. Shape (T, joints)."""
    return swell(t_s, ramp_s) * alpha_rad * np.sin(omega_rad_s * t_s[:, None] + np.arange(joints) * beta_rad)


def swell(t_s: Floats, ramp_s: float) -> Floats:
    """From nought to one over ``ramp_s``, without a jerk; (T, 1)."""
    s = np.clip(t_s / ramp_s, 0, 1)[:, None]
    return np.asarray(s**3 * (10 - 15 * s + 6 * s**2))
