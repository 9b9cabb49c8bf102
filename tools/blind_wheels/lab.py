"""The lab's description of its robot: measured in simple runs while it was healthy, and off by what those are off by.

Lag: one slow sine of all joints, phase against the command, mean over the joints. Friction: the straight robot led by
the hand at a few speeds, along and across, with a scale; a line through the readings. Mass: a scale.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from blind.robot import gait_command

from blind_wheels.body import Floats
from blind_wheels.robot import Wheeled

ALONG_M_S = (0.05, 0.12, 0.25)
ACROSS_M_S = (0.2, 0.3, 0.45)  # faster than a hand that only makes it lean
SCALE_GAIN, SCALE_READING = 0.01, 0.02  # relative: of the scale, and of each reading off a hand that shakes
LED_S, LED_HZ = 0.6, 100.0
SINE_RAD, SINE_RAD_S, SINE_CYCLES = np.radians(15.0), 3.0, 2
MASS_ERROR = 0.004


@dataclass(frozen=True)
class Description:
    """What stands in ``session.yaml``: what the lab believes of each link and servo."""

    links: int
    half_length_m: float
    mass_kg: float
    ct: float
    cn: float
    ct0: float
    cn0: float
    lag_s: float

    @property
    def lines(self) -> list[str]:
        """Of ``session.yaml``, every number but that of the links as wide as in every other."""
        return [
            "robot:",
            f"  links: {self.links}",
            f"  half_length_m: {self.half_length_m:06.4f}",
            f"  link_mass_kg: {self.mass_kg:06.4f}",
            f"  friction: {{ct: {self.ct:08.4f}, cn: {self.cn:08.4f}, ct0: {self.ct0:08.4f}, cn0: {self.cn0:08.4f}}}",
            f"  servo: {{time_constant_s: {self.lag_s:06.4f}}}",
            "  encoder_counts_per_rev: 8192",
        ]


def measured(robot: Wheeled, rng: np.random.Generator) -> Description:
    n = robot.body.links
    gain = 1 + SCALE_GAIN * float(rng.normal())
    ct, ct0 = _line(robot, ALONG_M_S, 0, gain, rng)
    cn, cn0 = _line(robot, ACROSS_M_S, 1, gain, rng)
    mass = float(robot.body.mass_kg.mean()) * (1 + MASS_ERROR * float(rng.normal()))
    return Description(
        n, robot.body.half_length_m, round(mass, 4), round(ct / n, 4), round(cn / n, 4), round(ct0 / n, 4),
        round(cn0 / n, 4), round(_lag(robot, rng), 4),
    )  # fmt: skip


def _line(
    robot: Wheeled, speeds_m_s: tuple[float, ...], axis: int, gain: float, rng: np.random.Generator
) -> tuple[float, float]:
    """Slope, N s/m, and value at rest, N, of the force on the whole robot."""
    found = []
    for wanted in speeds_m_s:
        pose, force = robot.led((wanted, 0.0) if axis == 0 else (0.0, wanted), LED_S, LED_HZ)
        late = slice(pose.shape[0] // 2, None)
        speed = float(np.polyfit(np.arange(pose[late].shape[0]) / LED_HZ, pose[late, axis], 1)[0])
        newton = float(force[late, axis].mean()) * gain * (1 + SCALE_READING * float(rng.normal()))
        found.append((speed, newton))
    x, y = np.array(found).T
    slope, at_rest = np.polyfit(x, y, 1)
    return max(float(slope), 0.01), max(float(at_rest), 0.01)


def _lag(robot: Wheeled, rng: np.random.Generator) -> float:
    """A first-order lag that is as late as the joints are on the mean; half a tick is the held command's own."""
    period_s = 2 * np.pi / SINE_RAD_S
    t = np.arange(round((1.0 + SINE_CYCLES * period_s) * robot.rate_hz)) / robot.rate_hz
    command = gait_command(t, float(SINE_RAD), 1.2, SINE_RAD_S, 1.0, robot.joint_count)
    run = robot.run(t, command, rng)
    late = t >= t[-1] + 0.5 / robot.rate_hz - SINE_CYCLES * period_s
    wave = np.exp(-1j * SINE_RAD_S * t[late])

    def phase(table: Floats) -> Floats:
        return np.asarray(np.angle(wave @ (table[late] - table[late].mean(axis=0))))

    behind = (phase(command) - phase(run.encoder_rad) + np.pi) % (2 * np.pi) - np.pi
    held = 0.5 / robot.rate_hz * SINE_RAD_S
    return float(np.tan(behind.mean() - held) / SINE_RAD_S)
