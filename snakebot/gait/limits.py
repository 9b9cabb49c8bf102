"""Limits of a joint: checked over a whole motion before anything moves, and enforced on every set-point.

``check_motion`` refuses a motion with the joint, the demanded and the allowed value. ``SlewLimiter`` is the second
line: the rule of PROTOCOL.md by which both the host (on what it sends) and the simulated board (on what it executes)
keep angle, speed and acceleration, whatever the motion asks for.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from snakebot.errors import BadInputError
from snakebot.gait.motion import Motion
from snakebot.robot import Robot

WIRE_STEP_RAD = 1e-4  # resolution of an angle on the wire; rounding must not look like a broken limit
CREDIT_SLACK_S = 0.020  # by how much a set-point may come early after a late one
MIN_INTERVAL_S = 0.0005
MAX_GAP = 4
_ENOUGH_S = 3600.0  # of a wave: what comes after repeats it
_PIECE_S = 400.0  # checked at once: memory stays small
_CHECK_STEP_S = 0.002  # samples of the check before the run; finer than any tick


def check_motion(motion: Motion, robot: Robot, t_from_s: float = 0.0) -> None:
    """Refuse a motion that would ask a joint for more than the robot's description allows.

    Speed and acceleration are finite differences of the set-points over 2 ms, over the whole motion.

    Raises:
        BadInputError: the first joint and limit broken, with the demanded and the allowed value.
    """
    if motion.joints != robot.joints:
        raise BadInputError(f"the motion has {motion.joints} joints, robot {robot.name!r} has {robot.joints}")
    for begin_s, end_s in _stretches(motion, t_from_s):
        _check_stretch(motion, robot, begin_s, end_s)


def _stretches(motion: Motion, t_from_s: float) -> Iterator[tuple[float, float]]:
    """The whole motion piece by piece; of one that repeats itself for more than two hours, an hour at each end."""
    end_s = max(motion.duration_s, t_from_s)
    if motion.repeats and end_s - t_from_s > 2 * _ENOUGH_S:
        yield from _pieces(t_from_s, t_from_s + _ENOUGH_S)
        yield from _pieces(end_s - _ENOUGH_S, end_s)
    else:
        yield from _pieces(t_from_s, end_s)


def _pieces(begin_s: float, end_s: float) -> Iterator[tuple[float, float]]:
    count = max(1, math.ceil((end_s - begin_s) / _PIECE_S))
    for number in range(count):
        yield begin_s + number * _PIECE_S, min(begin_s + (number + 1) * _PIECE_S, end_s)


def _check_stretch(motion: Motion, robot: Robot, begin_s: float, end_s: float) -> None:
    steps = max(math.ceil((end_s - begin_s) / _CHECK_STEP_S), 1)
    t = begin_s + _CHECK_STEP_S * np.arange(-2, steps + 3, dtype=np.float64)
    angles = motion.sampled(t)
    speed = np.diff(angles, axis=0) / _CHECK_STEP_S
    acceleration = np.diff(speed, axis=0) / _CHECK_STEP_S
    checks = (
        ("angle", "deg", np.degrees(angles), np.degrees(robot.angle_limit_rad)),
        ("speed", "rad/s", speed, np.asarray(robot.speed_limit_rad_s)),
        ("acceleration", "rad/s2", acceleration, np.asarray(robot.acceleration_limit_rad_s2)),
    )
    for name, unit, values, limit in checks:
        worst = np.abs(values).max(axis=0)
        over = np.flatnonzero(worst > limit * (1 + 1e-6))
        if over.size:
            joint = int(over[np.argmax(worst[over] / limit[over])])
            raise BadInputError(
                f"joint {joint + 1}: the motion asks for {name} {worst[joint]:.4g} {unit}, "
                f"robot {robot.name!r} allows {limit[joint]:.4g} {unit}{motion.advice(name)}"
            )


class SlewLimiter:
    """Keeps a stream of set-points within each joint's limits, by the rule in PROTOCOL.md."""

    def __init__(
        self,
        angle_rad: Sequence[float],
        speed_rad_s: Sequence[float],
        acceleration_rad_s2: Sequence[float],
    ) -> None:
        self.angle_rad = list(angle_rad)
        self.speed_rad_s = list(speed_rad_s)
        self.acceleration_rad_s2 = list(acceleration_rad_s2)
        self.reset([0.0] * len(self.angle_rad))

    def reset(self, angles_rad: Sequence[float]) -> None:
        """Start again, at rest, from these angles."""
        self.applied_rad = list(angles_rad)
        self._speed = [0.0] * len(self.applied_rad)
        self._credit_s = CREDIT_SLACK_S

    def execute(
        self, target_rad: Sequence[float], interval_s: float, gap: int, elapsed_s: float
    ) -> tuple[tuple[float, ...], int] | None:
        """Take one set-point.

        Args:
            target_rad: the set-point of each joint.
            interval_s: time since the set-point before, as the sender planned it.
            gap: step of the sequence number (1 when nothing was lost).
            elapsed_s: time since the set-point before on the executing side's own clock.

        Returns:
            What is executed and how many joints a limit changed, or None if the set-point comes too early.
        """
        declared = interval_s * min(max(gap, 1), MAX_GAP)
        credit = min(self._credit_s + elapsed_s, declared + CREDIT_SLACK_S)
        dt = min(declared, credit)
        if dt < MIN_INTERVAL_S:
            return None
        self._credit_s = credit - dt
        clamped = 0
        for joint, target in enumerate(target_rad):
            clamped += self._step(joint, target, dt)
        return tuple(self.applied_rad), clamped

    def follow(self, joint: int, angle_rad: float) -> None:
        """A joint without power: its register follows where the joint is."""
        self.applied_rad[joint] = angle_rad
        self._speed[joint] = 0.0

    def _step(self, joint: int, target: float, dt: float) -> bool:
        angle, speed, acceleration = (
            self.angle_rad[joint],
            self.speed_rad_s[joint],
            self.acceleration_rad_s2[joint],
        )
        applied = self.applied_rad[joint]
        slack = WIRE_STEP_RAD / dt
        want = (min(max(target, -angle), angle) - applied) / dt
        want = min(max(want, -speed - slack), speed + slack)
        # Braking by acceleration * dt a tick, from v, takes v^2 / (2 acceleration) + v dt / 2 of the way to the end.
        room = max(0.0, angle - applied if want > 0 else angle + applied)
        brake = acceleration * dt
        stop = max(min(room / dt, brake), math.sqrt(2 * acceleration * room) - brake / 2) + slack
        want = min(max(want, -stop), stop)
        band = brake + 2 * slack
        before = self._speed[joint]
        v = min(max(want, before - band), before + band)
        v = min(max(v, -speed - slack), speed + slack)
        bound = max(angle, abs(applied))
        self.applied_rad[joint] = min(max(applied + v * dt, -bound), bound)
        self._speed[joint] = v
        return abs(self.applied_rad[joint] - target) > WIRE_STEP_RAD / 2
