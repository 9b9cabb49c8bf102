"""Limits of a joint: checked over a whole motion before anything moves, and enforced on every set-point.

``check_motion`` refuses a motion with the joint, the demanded and the allowed value. ``SlewLimiter`` is the second
line: the rule of PROTOCOL.md by which both the host (on what it sends) and the simulated board (on what it executes)
keep angle, speed and acceleration, whatever the motion asks for.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

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
_ROUNDING_RAD = 1e-6  # of a path's own arithmetic: an end of the bracket lies on the edge of the slack
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
    """Keeps a stream of set-points within each joint's limits, by the rule in PROTOCOL.md.

    What is executed is never further than the slack from a path that keeps speed and acceleration exactly. Which path
    that is, rounded set-points leave open. Of all that are as near as that to everything executed so far, the limiter
    keeps the slowest and the fastest (a mixture of the two is one of them, too), and changes a set-point only when
    none of them can come near it.

    Args:
        angle_rad, speed_rad_s, acceleration_rad_s2: the limits, one a joint.
        slack_rad: how far rounding may take a set-point from a path within the limits.
    """

    def __init__(
        self,
        angle_rad: Sequence[float],
        speed_rad_s: Sequence[float],
        acceleration_rad_s2: Sequence[float],
        *,
        slack_rad: float = WIRE_STEP_RAD,
    ) -> None:
        self.angle_rad = list(angle_rad)
        self.speed_rad_s = list(speed_rad_s)
        self.acceleration_rad_s2 = list(acceleration_rad_s2)
        self._slack_rad = slack_rad
        self.reset([0.0] * len(self.angle_rad))

    def reset(self, angles_rad: Sequence[float]) -> None:
        """Start again, at rest, from these angles."""
        self.applied_rad = list(angles_rad)
        self._paths = [_at_rest(angle) for angle in self.applied_rad]
        self._target_rad = list(angles_rad)
        self._credit_s = CREDIT_SLACK_S
        self._dt_before_s = 0.0  # none yet: the first tick counts as after one of its own length

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
        self._dt_before_s = dt
        return tuple(self.applied_rad), clamped

    def follow(self, joint: int, angle_rad: float) -> None:
        """A joint without power: its register follows where the joint is."""
        self.applied_rad[joint] = self._target_rad[joint] = angle_rad
        self._paths[joint] = _at_rest(angle_rad)

    def _step(self, joint: int, wanted: float, dt: float) -> bool:
        angle, acceleration = self.angle_rad[joint], self.acceleration_rad_s2[joint]
        target = _clamp(wanted, -angle, angle)
        # A speed here is the mean over its tick: between the middles of two ticks lies half of each.
        change = acceleration * ((self._dt_before_s or dt) + dt) / 2
        tick = _Tick(dt, angle, self.speed_rad_s[joint], acceleration, change)
        slow, fast = self._paths[joint]
        within = self._slack_rad + _ROUNDING_RAD
        behind = abs(self.applied_rad[joint] - self._target_rad[joint]) > 2 * _ROUNDING_RAD
        if not behind:
            near, other = self._bracket(slow, fast, target, tick)
            if abs(other.angle - target) < abs(near.angle - target):
                near, other = other, near
            if abs(near.angle - target) > within:
                behind = True
            elif abs(other.angle - target) > within:
                other = near
        if behind:
            start = fast if target > fast.angle else slow
            near = other = _chase(start, target, (target - self._target_rad[joint]) / dt, tick)
        self._paths[joint] = (near, other) if near.speed <= other.speed else (other, near)
        self._target_rad[joint] = target
        executed = _clamp(target, near.angle - self._slack_rad, near.angle + self._slack_rad)
        self.applied_rad[joint] = executed
        return abs(executed - wanted) > WIRE_STEP_RAD / 2

    def _bracket(self, slow: _Path, fast: _Path, target: float, tick: _Tick) -> tuple[_Path, _Path]:
        """The slowest and the fastest way on that end within the slack of the target, or as near as they come."""
        low, high = target - self._slack_rad, target + self._slack_rad
        spread = fast.speed - slow.speed + (fast.angle - slow.angle) / tick.dt
        from_slow, from_fast = slow, fast
        if spread > 0:  # of all mixtures the one that comes to its edge by all the change that it may make
            from_slow = _mixture(
                slow, fast, ((low - slow.angle) / tick.dt - slow.speed + tick.change) / spread
            )
            from_fast = _mixture(
                slow, fast, ((high - slow.angle) / tick.dt - slow.speed - tick.change) / spread
            )
        return (
            _go(from_slow, (low - from_slow.angle) / tick.dt, tick),
            _go(from_fast, (high - from_fast.angle) / tick.dt, tick),
        )


class _Path(NamedTuple):
    angle: float  # rad
    speed: float  # rad/s, mean over the last tick


class _Tick(NamedTuple):
    """One tick of one joint."""

    dt: float  # s
    angle: float  # limits: rad, rad/s, rad/s^2
    speed: float
    acceleration: float
    change: float  # of speed that it may make, rad/s


def _clamp(value: float, low: float, high: float) -> float:
    return low if value < low else high if value > high else value


def _at_rest(angle_rad: float) -> tuple[_Path, _Path]:
    return _Path(angle_rad, 0.0), _Path(angle_rad, 0.0)


def _mixture(slow: _Path, fast: _Path, share: float) -> _Path:
    """Limits are convex: what lies between two paths that keep them is a path that keeps them."""
    share = _clamp(share, 0.0, 1.0)
    return _Path(
        slow.angle + share * (fast.angle - slow.angle), slow.speed + share * (fast.speed - slow.speed)
    )


def _stopping(room: float, tick: _Tick) -> float:
    """Largest speed of this tick from which braking ends within the room (rad), whatever the ticks' lengths."""
    half = tick.acceleration * tick.dt / 2
    if room <= half * tick.dt:
        return room / tick.dt
    return math.sqrt(2 * tick.acceleration * room) - half


def _go(start: _Path, want: float, tick: _Tick) -> _Path:
    """From ``start`` with the speed nearest to ``want`` that the limits allow."""
    fastest = _stopping(max(0.0, tick.angle - start.angle if want > 0 else tick.angle + start.angle), tick)
    want = _clamp(want, -fastest, fastest)
    want = _clamp(want, start.speed - tick.change, start.speed + tick.change)
    speed = _clamp(want, -tick.speed, tick.speed)
    end = start.angle + speed * tick.dt
    bound = max(tick.angle, abs(start.angle))
    if abs(end) > bound:  # only where a limit was tightened, or arithmetic rounds
        end = math.copysign(bound, end)
        speed = (end - start.angle) / tick.dt
    return _Path(end, speed)


def _chase(start: _Path, target: float, target_speed: float, tick: _Tick) -> _Path:
    """Towards a target out of reach, so that both would come to rest at one place if both began to brake."""
    u = _clamp(target_speed, -tick.speed, tick.speed)
    half = tick.acceleration * tick.dt / 2
    way = max(0.0, abs(u) - half) ** 2 / (2 * tick.acceleration)
    room = target + math.copysign(way, u) - start.angle
    return _go(start, math.copysign(_stopping(abs(room), tick), room), tick)
