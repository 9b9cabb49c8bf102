"""Limits of a joint: checked over a whole motion before anything moves, and enforced on every set-point.

``check_motion`` refuses a motion with the joint, the demanded and the allowed value. ``SlewLimiter`` is the second
line: the rule of PROTOCOL.md by which both the host (on what it sends) and the simulated board (on what it executes)
keep angle, speed and acceleration, whatever the motion asks for.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from copy import copy
from typing import Self

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.gait.motion import Motion
from snakebot.robot import Robot

WIRE_STEP_RAD = 1e-4  # resolution of an angle on the wire; rounding must not look like a broken limit
CREDIT_SLACK_S = 0.020  # by how much a set-point may come early after a late one
MIN_INTERVAL_S = 0.0005  # 0.5 ms (PROTOCOL.md, limits)
MAX_GAP = 4  # set-points that a loss may be bridged over (PROTOCOL.md, limits)
_ENOUGH_S = 3600.0  # of a wave: what comes after repeats it
_PIECE_S = 400.0  # checked at once: memory stays small
CHECK_STEP_S = 0.002  # samples of the check before the run; finer than any tick
# Nyquist frequency of those samples: a faster wave looks like a slow one.
_FASTEST_RAD_S = math.pi / CHECK_STEP_S


def check_motion(motion: Motion, robot: Robot, t_from_s: float = 0.0) -> None:
    """Refuse a motion that would ask a joint for more than the robot's description allows.

    Speed and acceleration are finite differences of the set-points over 2 ms, over the whole motion.

    Raises:
        BadInputError: the first joint and limit broken, with the demanded and the allowed value; or set-points, speeds
            or accelerations that are no finite numbers, or swing faster than those samples can show.
    """
    if motion.joints != robot.joints:
        raise BadInputError(f"the motion has {motion.joints} joints, robot {robot.name!r} has {robot.joints}")
    if not motion.fastest_rad_s < _FASTEST_RAD_S:
        raise BadInputError(
            f"the motion swings at {motion.fastest_rad_s:.4g} rad/s; limits can be checked below "
            f"{_FASTEST_RAD_S:.4g} rad/s{motion.advice('frequency')}"
        )
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
    steps = max(math.ceil((end_s - begin_s) / CHECK_STEP_S), 1)
    t = begin_s + CHECK_STEP_S * np.arange(-2, steps + 3, dtype=np.float64)
    with np.errstate(over="ignore", invalid="ignore"):  # what becomes of it is looked at below
        angles = motion.sampled(t)
        speed = np.diff(angles, axis=0) / CHECK_STEP_S
        acceleration = np.diff(speed, axis=0) / CHECK_STEP_S
    checks = (
        ("angle", "deg", np.degrees(angles), np.degrees(robot.angle_limit_rad)),
        ("speed", "rad/s", speed, np.asarray(robot.speed_limit_rad_s)),
        ("acceleration", "rad/s2", acceleration, np.asarray(robot.acceleration_limit_rad_s2)),
    )
    for name, unit, values, limit in checks:
        wrong = np.argwhere(~np.isfinite(values))
        if wrong.size:
            row, joint = (int(number) for number in wrong[0])
            raise BadInputError(
                f"joint {joint + 1}: the motion's {name} is no finite number at {max(t[row], 0.0):.4g} s"
                f"{motion.advice(name)}"
            )
        worst = np.abs(values).max(axis=0)
        over = np.flatnonzero(worst > limit * (1 + 1e-6))
        if over.size:
            joint = int(over[np.argmax(worst[over] / limit[over])])
            raise BadInputError(
                f"joint {joint + 1}: the motion asks for {name} {worst[joint]:.4g} {unit}, "
                f"robot {robot.name!r} allows {limit[joint]:.4g} {unit}{motion.advice(name)}"
            )


class SlewLimiter:
    """Keeps a stream of set-points within each joint's limits, by the rule in PROTOCOL.md.

    What is executed is never further than the slack from a path that keeps speed and acceleration exactly. Which path
    that is, rounded set-points leave open. Of all that are as near as that to everything executed so far, the limiter
    keeps the slowest and the fastest (a mixture of the two is one of them, too), and changes a set-point only when
    none of them can come near it. ``slew`` has the arithmetic, compiled.

    Args:
        angle_rad, speed_rad_s, acceleration_rad_s2: the limits, one a joint.
        slack_rad: how far rounding may take a set-point from a path within the limits.

    Attributes:
        wanted: (joints,) the set-point that ``execute_wanted`` takes, rad.
        applied: (joints,) what was executed last, rad.
    """

    def __init__(
        self,
        angle_rad: Sequence[float],
        speed_rad_s: Sequence[float],
        acceleration_rad_s2: Sequence[float],
        *,
        slack_rad: float = WIRE_STEP_RAD,
    ) -> None:
        from snakebot.gait import slew  # brings the compiler in: only those who limit need it

        self._compiled_step = slew.step
        self._limits = np.array([angle_rad, speed_rad_s, acceleration_rad_s2], dtype=np.float64)
        self.angle_rad: Floats = self._limits[0]  # views: whoever writes to them changes a limit
        self.speed_rad_s: Floats = self._limits[1]
        self.acceleration_rad_s2: Floats = self._limits[2]
        self._slack_rad = slack_rad
        joints = len(angle_rad)
        self._paths = np.zeros((joints, slew.PATH))
        self.wanted: Floats = np.zeros(joints)
        self.applied: Floats = np.zeros(joints)
        self._target = np.zeros(joints)
        self.reset([0.0] * joints)

    def copy(self) -> Self:
        """Another of the same limits and in the same state."""
        other = copy(self)
        other._limits = self._limits.copy()
        other.angle_rad, other.speed_rad_s, other.acceleration_rad_s2 = other._limits
        other._paths, other._target = self._paths.copy(), self._target.copy()
        other.wanted, other.applied = self.wanted.copy(), self.applied.copy()
        return other

    @property
    def applied_rad(self) -> list[float]:
        """What was executed last, one a joint."""
        applied: list[float] = self.applied.tolist()
        return applied

    def reset(self, angles_rad: Sequence[float]) -> None:
        """Begin, at rest, from these angles, with the credit of a sender that comes on time."""
        for joint, angle in enumerate(angles_rad):
            self.follow(joint, angle)
        self._credit_s = CREDIT_SLACK_S
        self._dt_before_s = 0.0  # none yet: the first tick counts as after one of its own length

    def rest(self, elapsed_s: float) -> None:
        """Stop where it is; ``elapsed_s`` since the last set-point. There is no more credit than this time brings.

        Of the paths near what was executed one stays, and comes to rest: the slack is not granted anew.
        """
        self._credit_s = min(self._credit_s + elapsed_s, CREDIT_SLACK_S)
        self._dt_before_s = 0.0
        self._target[:] = self.applied
        slow, fast = self._paths[:, 0].copy(), self._paths[:, 2].copy()
        nearer = np.where(np.abs(slow - self.applied) <= np.abs(fast - self.applied), slow, fast)
        self._paths[:] = 0.0
        self._paths[:, 0] = self._paths[:, 2] = nearer

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
        self.wanted[:] = target_rad
        clamped = self.execute_wanted(interval_s, gap, elapsed_s)
        return None if clamped is None else (tuple(self.applied.tolist()), clamped)

    def execute_wanted(self, interval_s: float, gap: int, elapsed_s: float) -> int | None:
        """``execute`` for who has put the set-point into ``wanted`` and finds in ``applied`` what is executed."""
        declared = interval_s * min(gap, MAX_GAP)
        credit = min(self._credit_s + elapsed_s, declared + CREDIT_SLACK_S)
        dt = min(declared, credit)
        if dt < MIN_INTERVAL_S:
            return None
        self._credit_s = credit - dt
        clamped = self._compiled_step(
            self.wanted, dt, self._dt_before_s or dt, self._slack_rad, WIRE_STEP_RAD / 2,
            self._limits, self._paths, self._target, self.applied,
        )  # fmt: skip
        self._dt_before_s = dt
        return int(clamped)

    def follow(self, joint: int, angle_rad: float) -> None:
        """A joint without power: its register follows where the joint is."""
        self.applied[joint] = self._target[joint] = angle_rad
        self._paths[joint] = angle_rad, 0.0, angle_rad, 0.0  # at rest, the slowest as the fastest
