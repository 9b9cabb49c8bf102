"""One tick of the slew limiter, compiled: the arithmetic of PROTOCOL.md over all joints, and nothing else.

``limits`` keeps the books (credit, limits, what is executed). Importing this module compiles, or loads what was
compiled before: a second the first time, and never within a tick, since only one signature is accepted. No option
that lets the compiler reorder arithmetic is on: the compiled code and the same code as Python agree to the last bit.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

from numba import njit

ROUNDING_RAD = 1e-6  # of a path's own arithmetic: an end of the bracket lies on the edge of the slack
PATH = 4  # columns of ``paths``: angle (rad) and speed (rad/s) of the slowest, then of the fastest

_F = TypeVar("_F", bound=Callable[..., Any])


def _part(function: _F) -> _F:
    """A part of ``step``: compiled with it, and types as Python sees them."""
    compiled: _F = njit(function)
    return compiled


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


@_part
def _clamp(value: float, low: float, high: float) -> float:
    return low if value < low else high if value > high else value


@_part
def _mixture(slow: _Path, fast: _Path, share: float) -> _Path:
    """Limits are convex: what lies between two paths that keep them is a path that keeps them."""
    share = _clamp(share, 0.0, 1.0)
    return _Path(
        slow.angle + share * (fast.angle - slow.angle), slow.speed + share * (fast.speed - slow.speed)
    )


@_part
def _stopping(room: float, tick: _Tick) -> float:
    """Largest speed of this tick from which braking ends within the room (rad), whatever the ticks' lengths."""
    half = tick.acceleration * tick.dt / 2
    if room <= half * tick.dt:
        return room / tick.dt
    return math.sqrt(2 * tick.acceleration * room) - half


@_part
def _go(start: _Path, want: float, tick: _Tick) -> _Path:
    """From ``start`` with the speed nearest to ``want`` that the limits allow."""
    room = tick.angle - start.angle if want > 0 else tick.angle + start.angle
    fastest = _stopping(room if room > 0.0 else 0.0, tick)
    want = _clamp(want, -fastest, fastest)
    want = _clamp(want, start.speed - tick.change, start.speed + tick.change)
    speed = _clamp(want, -tick.speed, tick.speed)
    end = start.angle + speed * tick.dt
    bound = abs(start.angle) if abs(start.angle) > tick.angle else tick.angle
    if abs(end) > bound:  # only where a limit was tightened, or arithmetic rounds
        end = math.copysign(bound, end)
        speed = (end - start.angle) / tick.dt
    return _Path(end, speed)


@_part
def _chase(start: _Path, target: float, target_speed: float, tick: _Tick) -> _Path:
    """Towards a target out of reach, so that both would come to rest at one place if both began to brake."""
    u = _clamp(target_speed, -tick.speed, tick.speed)
    half = tick.acceleration * tick.dt / 2
    over = abs(u) - half if abs(u) > half else 0.0
    way = over * over / (2 * tick.acceleration)
    room = target + math.copysign(way, u) - start.angle
    return _go(start, math.copysign(_stopping(abs(room), tick), room), tick)


@_part
def _bracket(slow: _Path, fast: _Path, low: float, high: float, tick: _Tick) -> tuple[_Path, _Path]:
    """The slowest and the fastest way on that end between ``low`` and ``high``, or as near to them as they come."""
    spread = fast.speed - slow.speed + (fast.angle - slow.angle) / tick.dt
    from_slow, from_fast = slow, fast
    if spread > 0:  # of all mixtures the one that comes to its edge by all the change that it may make
        from_slow = _mixture(slow, fast, ((low - slow.angle) / tick.dt - slow.speed + tick.change) / spread)
        from_fast = _mixture(slow, fast, ((high - slow.angle) / tick.dt - slow.speed - tick.change) / spread)
    return (
        _go(from_slow, (low - from_slow.angle) / tick.dt, tick),
        _go(from_fast, (high - from_fast.angle) / tick.dt, tick),
    )


@_part
def _on_to(
    slow: _Path, fast: _Path, applied: float, target_before: float, target: float, slack: float, tick: _Tick
) -> tuple[_Path, _Path]:
    """The paths after this tick; the one that ends nearer to the target first."""
    if abs(applied - target_before) <= 2 * ROUNDING_RAD:  # what was executed is what was asked for
        near, other = _bracket(slow, fast, target - slack, target + slack, tick)
        if abs(other.angle - target) < abs(near.angle - target):
            near, other = other, near
        within = slack + ROUNDING_RAD
        if abs(near.angle - target) <= within:
            return near, (other if abs(other.angle - target) <= within else near)
    start = fast if target > fast.angle else slow
    near = _chase(start, target, (target - target_before) / tick.dt, tick)
    return near, near


@njit(
    "int64(float64[::1], float64, float64, float64, float64, float64[:, ::1], float64[:, ::1], float64[::1], "
    "float64[::1])",
    cache=True,
)
def step(
    wanted: Any, dt: float, dt_before: float, slack: float, noticed: float,
    limits: Any, paths: Any, target: Any, applied: Any,
) -> int:  # fmt: skip
    """Take all joints one tick on.

    Args:
        wanted: (joints,) set-points, rad.
        dt, dt_before: lengths of this tick and of the one before, s.
        slack: how far rounding may take a set-point from a path within the limits, rad.
        noticed: a smaller change is no work of a limit, rad.
        limits: (3, joints) angle (rad), speed (rad/s), acceleration (rad/s^2).
        paths: (joints, PATH); changed in place, as are the next two.
        target: (joints,) set-points before, within the angle limits, rad.
        applied: (joints,) what was executed, rad.

    Returns:
        How many joints a limit has changed.
    """
    clamped = 0
    for joint in range(wanted.size):
        angle, speed, acceleration = limits[0, joint], limits[1, joint], limits[2, joint]
        # A speed here is the mean over its tick: between the middles of two ticks lies half of each.
        tick = _Tick(dt, angle, speed, acceleration, acceleration * (dt_before + dt) / 2)
        aim = _clamp(wanted[joint], -angle, angle)
        slow = _Path(paths[joint, 0], paths[joint, 1])
        fast = _Path(paths[joint, 2], paths[joint, 3])
        near, other = _on_to(slow, fast, applied[joint], target[joint], aim, slack, tick)
        slow, fast = (near, other) if near.speed <= other.speed else (other, near)
        paths[joint, 0], paths[joint, 1] = slow.angle, slow.speed
        paths[joint, 2], paths[joint, 3] = fast.angle, fast.speed
        target[joint] = aim
        applied[joint] = _clamp(aim, near.angle - slack, near.angle + slack)
        clamped += abs(applied[joint] - wanted[joint]) > noticed
    return clamped
