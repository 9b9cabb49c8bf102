"""One robot on wheels: its numbers, how a healthy one is drawn, and a run of it with wire and sensors."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from math import radians

import numpy as np
from blind.robot import COUNTS_PER_REV, Recording

from blind_wheels.body import WHEEL_RADIUS_M, Body, Floats
from blind_wheels.drive import FULL_DUTY, ROWS, SHAFT_COUNTS, SHIFT, Driven

LINKS_FROM_TO = (4, 10)
RATES_HZ = (50.0, 100.0)  # at which a host commands and reads
DROPOUT_S = 0.15  # mean length of a moment without contact


@dataclass
class Wheeled:
    """Everything about one robot. Faults change it."""

    body: Body
    joints: Floats  # rows of ``drive.ROWS``
    battery: Floats  # V at rest, ohm, A of the electronics
    bearings: Floats  # (3, wheels): dry Nm, more at rest Nm, rad/s over which that goes
    rate_hz: float
    latency_s: float
    jitter_s: float
    zero_rad: Floats  # (k,) where the lab's zero of each encoder is off
    noise_rad: float
    magnet: Floats  # (2, k) how far off the axis a magnet sits, in its radii, and which way, rad
    dropouts_hz: Floats  # (k,) of each joint's connector
    pose_noise_m: float = 0.001
    pose_noise_rad: float = radians(0.1)
    quantised: bool = True

    @property
    def joint_count(self) -> int:
        return int(self.joints.shape[1])

    def joint(self, row: str) -> Floats:
        values: Floats = self.joints[ROWS.index(row)]
        return values

    def copy(self) -> Wheeled:
        return copy.deepcopy(self)

    def noiseless(self) -> Wheeled:
        """The same robot read by perfect sensors over a steady wire."""
        clean = self.copy()
        clean.noise_rad = clean.pose_noise_m = clean.pose_noise_rad = clean.jitter_s = 0.0
        clean.quantised = False
        return clean

    def run(self, t_s: Floats, command_rad: Floats, rng: np.random.Generator) -> Recording:
        """Commanded and read at the same ticks, from rest and straight."""
        wire = self.latency_s + self.jitter_s * np.abs(rng.normal(size=t_s.size))
        gaps = self._gaps(float(t_s[-1]), rng)
        angle, pose, _ = Driven(self.body).run(
            self.joints,
            self.battery,
            self.bearings,
            np.maximum.accumulate(t_s + wire),
            command_rad,
            t_s,
            gaps,
        )
        reading = self._field(angle) + self.zero_rad + self.noise_rad * rng.normal(size=angle.shape)
        if self.quantised:
            count = 2 * np.pi / COUNTS_PER_REV
            reading = np.round(reading / count) * count
        scatter = np.array([self.pose_noise_m, self.pose_noise_m, self.pose_noise_rad])
        return Recording(t_s, command_rad, reading, pose + scatter * rng.normal(size=pose.shape))

    def led(self, speed_m_s: tuple[float, float], seconds: float, rate_hz: float) -> tuple[Floats, Floats]:
        """Pose (T, 3) and what the scale shows (T, 2), N: led by the hand along and across its straight body."""
        t = np.arange(round(seconds * rate_hz)) / rate_hz
        still = np.zeros((t.size, self.joint_count))
        _, pose, force = Driven(self.body).run(
            self.joints, self.battery, self.bearings, t, still, t, np.zeros((0, 3)), np.array(speed_m_s)
        )
        return pose, force

    def _field(self, angle: Floats) -> Floats:
        """What a field sensor reads of a magnet beside its axis; the lab has zeroed it in the straight pose."""
        off, way = self.magnet

        def seen(q: Floats) -> Floats:
            return np.asarray(
                np.arctan2(np.sin(q) + off * np.sin(way), np.cos(q) + off * np.cos(way)), dtype=float
            )

        return np.asarray(seen(angle) - seen(np.zeros(off.size)))

    def _gaps(self, until_s: float, rng: np.random.Generator) -> Floats:
        """(g, 3): joint, begin, end of the moments without contact in one run."""
        found = []
        for j in np.flatnonzero(self.dropouts_hz):
            t = float(rng.exponential(1 / self.dropouts_hz[j]))
            while t < until_s:
                long = float(rng.exponential(DROPOUT_S))
                found.append((float(j), t, t + long))
                t += long + float(rng.exponential(1 / self.dropouts_hz[j]))
        return np.array(found).reshape(-1, 3)


def healthy_robot(rng: np.random.Generator) -> Wheeled:
    """One that works as it was built: parts differ by what parts of one order differ by."""
    least, most = LINKS_FROM_TO
    n = least + int((most - least + 1) * rng.random() ** 2)  # short ones more often: they are quicker to run
    k = n - 1

    def parts(value: float, spread: float, *shape: int) -> Floats:
        return np.asarray(value * np.maximum(1 + spread * rng.normal(size=shape), 0.3))

    volts, ohm, ratio = float(rng.choice([11.1, 12.0, 14.8])), 0.6, float(rng.choice([150, 200, 250]))
    kt = volts / (ratio * float(rng.uniform(6.0, 8.0)))  # no load at 6 to 8 rad/s
    lag_s = float(np.exp(rng.uniform(np.log(0.02), np.log(0.05))))
    full_at = lag_s * volts / (kt * ratio)  # rad of error that ask for full duty
    counts = full_at / (2 * np.pi / SHAFT_COUNTS)
    servo = {
        "kp": np.full(k, round((FULL_DUTY << SHIFT) / counts)),
        "kd": np.full(k, round(float(rng.uniform(0.0, 1.0)) * (FULL_DUTY << SHIFT) / counts)),
        "period_s": parts(1 / float(rng.choice([250.0, 333.0, 500.0])), 0.005, k),
        "phase_s": rng.uniform(0.0, 0.002, k),
        "dead_zone": np.full(k, int(rng.integers(4, 12))),
        "ohm": parts(ohm, 0.03, k),
        "tau_s": parts(float(rng.uniform(4e-4, 1.2e-3)), 0.05, k),
        "kt_nm_a": parts(kt, 0.02, k),
        "ratio": np.full(k, ratio),
        "warming_k_a2s": np.full(k, 0.05),
        "trim_rad": np.radians(0.03) * rng.normal(size=k),
        "worn_width_rad": np.full(k, 0.05),
    }
    joints = np.array([servo.get(row, np.zeros(k)) for row in ROWS], dtype=float)
    mass = float(rng.uniform(0.25, 0.45))
    share_n = (
        float(rng.uniform(0.25, 0.6)) * mass * 9.80665 / 10
    )  # drag of a rolling link, N: little of its grip
    grip = float(rng.uniform(0.7, 0.9))
    body = Body(
        half_length_m=round(float(rng.uniform(0.055, 0.08)), 4),
        mass_kg=parts(mass, 0.02, n),
        grip=parts(grip, 0.03, n, 2),
        grease_nm_s=parts(float(rng.uniform(0.2, 0.6)) * WHEEL_RADIUS_M**2 / 2, 0.1, n, 2),
        rotor_kg_m2=parts(3e-7 * ratio**2, 0.02, k),
        gear_nm=parts(float(rng.uniform(0.03, 0.08)), 0.1, k),
        cable_nm_rad=parts(float(rng.uniform(0.005, 0.03)), 0.2, k),
    )
    dry = parts(share_n * WHEEL_RADIUS_M / 2, 0.08, 2 * n)
    return Wheeled(
        body, joints, np.array([volts, 0.08, 0.1]), np.array([dry, 0.1 * dry, np.full(2 * n, 2.0)]),
        rate_hz=float(rng.choice(RATES_HZ)), latency_s=float(rng.uniform(0.001, 0.003)), jitter_s=0.0002,
        zero_rad=np.radians(0.03) * rng.normal(size=k), noise_rad=radians(float(rng.uniform(0.03, 0.05))),
        magnet=np.zeros((2, k)), dropouts_hz=np.zeros(k),
    )  # fmt: skip
