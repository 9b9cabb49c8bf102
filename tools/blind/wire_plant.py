"""The blind robot behind a board: what ``snakebot.softboard`` asks of the joints behind it (``JointPlant``).

The board brings protocol, limiter and watchdog; servos, body, ground, sensors and the delays behind the board are the
blind robot's own.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Literal

import numpy as np

from blind import chain as ch
from blind.chain import Chain, Floats
from blind.robot import COUNTS_PER_REV, SETPOINT_STEP_RAD, Parameters

_SPEED_OVER_S = 1e-4


class BlindPlant:
    """One blind robot on one clock, which starts at zero. All joints hold the straight pose at first.

    Args:
        parameters: what the robot is like, its faults among it.
        seed: of noise, jitter and lost set-points.
    """

    def __init__(self, parameters: Parameters, seed: int = 0) -> None:
        self._p = parameters
        self._rng = np.random.default_rng(seed)
        chain = Chain(parameters.links)
        warm = chain.start(parameters.joints)  # compiled here: the first tick must not wait for a compiler
        k = parameters.joints.shape[1]
        warm.go_on(parameters.joints, parameters.ground, np.zeros(1), np.zeros((1, k)), np.array([0.01]))
        ch._pose(warm.data.qpos, parameters.links, np.zeros(3))
        self._going = chain.start(parameters.joints)
        self._joints = parameters.joints.copy()  # who has no power is written into it
        self._now_s = 0.0
        self._arrival_s: deque[float] = deque()
        self._coming: deque[Floats] = deque()
        self._last_arrival_s = 0.0
        self._commanded = False

    @property
    def clock_ppm(self) -> float:
        """By how much the board's clock runs fast."""
        return self._p.clock_ppm

    def command(self, t_s: float, setpoint_rad: Sequence[float]) -> None:
        """A set-point for all joints leaves the board; it takes hold after the robot's latency, or is lost."""
        p = self._p
        lost = self._commanded and self._rng.random() < p.loss
        self._commanded = True
        if lost:
            return
        there = p.mixing @ np.asarray(setpoint_rad, dtype=np.float64)
        if p.quantised:
            there = np.round(there / SETPOINT_STEP_RAD) * SETPOINT_STEP_RAD
        late_s = p.latency_s + p.latency_jitter_s * abs(self._rng.normal())
        self._last_arrival_s = max(self._last_arrival_s, t_s + late_s)
        self._arrival_s.append(self._last_arrival_s)
        self._coming.append(there)

    def set_joint_mode(self, joint: int, mode: Literal["active", "free"], /) -> None:
        """``active`` holds the angle at which the joint stands until the next set-point; ``free`` has no power."""
        j, state = joint - 1, self._going.state
        if mode == "free":
            self._joints[ch.FREE, j] = 1.0
            return
        self._joints[ch.FREE, j] = self._p.joints[ch.FREE, j]
        angle = float(self._going.data.qpos[3 + j])
        row = self._joints[:, j]
        motor = angle - row[ch.OFFSET]
        for _ in range(3):  # the gear's eccentricity is small
            motor = angle - row[ch.OFFSET] - row[ch.ECC] * np.sin(row[ch.ECC_N] * motor + row[ch.ECC_PHASE])
        state[ch.MOTOR, j] = state[ch.HELD, j] = state[ch.SHAPED, j] = motor
        state[[ch.RATE, ch.INTEGRAL_STATE, ch.SHAPED_RATE], j] = 0.0

    def advance(self, t_s: float) -> None:
        """Let the world go on until ``t_s``."""
        self._now_s = max(self._now_s, t_s)
        if self._now_s < self._going.moment[0]:
            return  # it stands at most one step ahead
        arrival = np.array(self._arrival_s, dtype=np.float64)
        coming = np.array(self._coming, dtype=np.float64).reshape(arrival.size, self._joints.shape[1])
        *_, taken = self._going.go_on(self._joints, self._p.ground, arrival, coming, np.array([self._now_s]))
        for _ in range(taken):
            self._arrival_s.popleft()
            self._coming.popleft()

    def _stands(self) -> tuple[Floats, float]:
        """Generalised positions now, and by how much the chain is behind."""
        data = self._going.data
        behind_s = self._now_s - float(self._going.moment[0])
        return data.qpos + behind_s * data.qvel, behind_s

    def encoder_counts(self) -> list[int]:
        """What the encoders say now; noise differs from call to call."""
        p, state = self._p, self._going.state
        where, behind_s = self._stands()
        angle = where[3:]
        sway = state[ch.SWAY] + behind_s * state[ch.SWAY_RATE]
        wave, phase = p.reading_wave_rad
        reading = p.reading_gain * (angle + sway) + p.reading_offset_rad + wave * np.sin(angle + phase)
        reading = reading + p.reading_noise_rad * self._rng.normal(size=reading.shape)
        return [int(count) for count in np.round(reading * COUNTS_PER_REV / (2 * np.pi))]

    def pose(self) -> tuple[float, float, float, float]:
        """Centre of mass x, y (m), mean heading (rad), forward speed (m/s), as a camera would see them."""
        p, here, ahead = self._p, np.zeros(3), np.zeros(3)
        where, _ = self._stands()
        ch._pose(where, p.links, here)
        ch._pose(where + _SPEED_OVER_S * self._going.data.qvel, p.links, ahead)
        vx, vy = (ahead - here)[:2] / _SPEED_OVER_S
        speed = vx * np.cos(here[2]) + vy * np.sin(here[2])
        x, y, heading = here + np.array(
            [p.pose_noise_m, p.pose_noise_m, p.pose_noise_rad]
        ) * self._rng.normal(size=3)
        return float(x), float(y), float(heading), float(speed)
