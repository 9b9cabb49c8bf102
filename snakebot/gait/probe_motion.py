"""A probe as a motion: smoothly to its middle, its pattern in whole cycles, smoothly to straight.

Triangles and steps are moves from rest to rest with bounded speed and acceleration, so they begin and end at rest of
themselves; a sine rises and falls with the ramps, as a gait does.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.gait.blend import blend_integrals, blends
from snakebot.gait.motion import Motion, check_times
from snakebot.gait.probe import Probe

CHANGE_S = 1.0  # from one frequency of a sine to the next, at most
MOST_CYCLES = 20_000  # of one run; each is kept as a few numbers


class ProbeMotion(Motion):
    """A probe with a smooth start from the posture the robot is in, and a smooth end.

    The first ``ramp_s`` lead from ``start_rad`` to the middle, the last ``ramp_s`` to straight. In between lie as many
    whole cycles as fit, then rest (a sine goes on).
    """

    repeats = True

    def __init__(
        self,
        probe: Probe,
        joints: int,
        duration_s: float,
        ramp_s: float,
        start_rad: Sequence[float] | None = None,
    ) -> None:
        """
        Raises:
            BadInputError: a time is negative or not a number, or not one cycle fits; a joint that does not exist.
        """
        check_times(duration_s, ramp_s)
        self.probe = probe
        self.joints = joints
        self.duration_s = duration_s
        self.ramp_s = ramp_s
        self.start_rad = np.zeros(joints) if start_rad is None else np.asarray(start_rad, dtype=np.float64)
        self._moved = list(probe.joint_indices(joints))
        self.fastest_rad_s = max(probe.omega_rad_s, default=0.0)
        span_s = duration_s - 2 * ramp_s
        once_s = probe_span_s(probe, 1)
        if span_s < once_s * (1 - 1e-9):
            raise BadInputError(
                f"{probe}: one cycle takes {once_s:.3g} s, and {duration_s:g} s with two ramps of {ramp_s:g} s "
                "have no room for it: lengthen --duration or shorten --ramp"
            )
        cycles = 1 + (span_s - once_s) / (probe_span_s(probe, 2) - once_s)
        self._way: Callable[[Floats], Floats]
        if probe.kind == "sine":
            self._way = _Sine(probe, span_s / len(probe.omega_rad_s))
        elif cycles > MOST_CYCLES:
            raise BadInputError(f"{probe}: {cycles:.0f} cycles in {duration_s:g} s; at most {MOST_CYCLES}")
        else:
            self._way = _Moves(probe, _waypoints(probe, int(cycles * (1 + 1e-9))))

    def angles(self, t_s: float) -> list[float]:
        row: list[float] = self.sampled(np.array([t_s]))[0].tolist()
        return row

    def sampled(self, t_s: Floats) -> Floats:
        t = np.clip(t_s, 0.0, self.duration_s)
        way = np.zeros((t.size, self.joints))
        way[:, self._moved] = (self.probe.offset_rad + self._way(t - self.ramp_s))[:, None]
        if self.ramp_s > 0:
            rise = blends(t / self.ramp_s)[:, None]
            fall = blends((self.duration_s - t) / self.ramp_s)[:, None]
            way = fall * (self.start_rad + rise * (way - self.start_rad))
        return way

    def ended(self, t_s: float) -> ProbeMotion:
        """The ramp down begins at ``t_s``, unless it has begun already."""
        other = copy.copy(self)
        other.duration_s = min(self.duration_s, t_s + self.ramp_s)
        return other

    def advice(self, limit: str) -> str:
        if limit == "angle":
            return ": lower amplitude_deg or offset_deg of --probe"
        if limit == "frequency":
            return ": lower omega_rad_s of --probe"
        if self.probe.kind == "sine":
            return ": lower omega_rad_s or amplitude_deg of --probe, or lengthen --ramp"
        return f": lower {'rate_deg_s' if limit == 'speed' else 'acceleration_rad_s2'} of --probe, or lengthen --ramp"


def probe_span_s(probe: Probe, cycles: float) -> float:
    """How long so many cycles take between the ramps; a cycle is that of a sine's slowest frequency.

    Args:
        cycles: a whole number, unless the probe is a sine.
    """
    if probe.kind == "sine":
        return cycles * len(probe.omega_rad_s) * 2 * math.pi / min(probe.omega_rad_s)
    at, total = 0.0, 0.0
    for to in _waypoints(probe, int(cycles)):
        total += _move_s(probe, abs(to - at)) + _hold_s(probe)
        at = to
    return total


def _waypoints(probe: Probe, cycles: int) -> list[float]:
    """Angles from the middle at which the pattern turns or rests; it begins and ends in the middle."""
    far = probe.amplitude_rad
    if probe.kind == "triangle":
        return [far, -far] * cycles + [0.0]
    sizes = [far * (number + 1) / probe.steps for number in range(probe.steps)]
    return [point for size in sizes for point in (size, 0.0, -size, 0.0)] * cycles


def _hold_s(probe: Probe) -> float:
    return probe.hold_s if probe.kind == "steps" else 0.0


def _peak_rad_s(probe: Probe, distance_rad: float) -> float:
    """Speed of a move between speeding up and braking."""
    return min(probe.rate_rad_s, math.sqrt(probe.acceleration_rad_s2 * distance_rad))


def _move_s(probe: Probe, distance_rad: float) -> float:
    if distance_rad <= 0:
        return 0.0
    peak = _peak_rad_s(probe, distance_rad)
    return distance_rad / peak + peak / probe.acceleration_rad_s2 if peak > 0 else math.inf


class _Moves:
    """Moves from rest to rest through waypoints, as stretches of constant acceleration."""

    def __init__(self, probe: Probe, points: Sequence[float]) -> None:
        accelerate = probe.acceleration_rad_s2
        stretches: list[tuple[float, float, float, float]] = []  # start time, angle, speed, acceleration
        t = at = 0.0
        for to in points:
            distance, sign = abs(to - at), math.copysign(1.0, to - at)
            if distance > 0:
                peak = _peak_rad_s(probe, distance)
                speeding = peak / accelerate
                cruising = distance / peak - speeding
                used = 0.5 * peak * speeding
                stretches.append((t, at, 0.0, sign * accelerate))
                stretches.append((t + speeding, at + sign * used, sign * peak, 0.0))
                stretches.append((t + speeding + cruising, to - sign * used, sign * peak, -sign * accelerate))
                t += 2 * speeding + cruising
            stretches.append((t, to, 0.0, 0.0))
            t += _hold_s(probe)
            at = to
        self._t, self._angle, self._speed, self._acceleration = np.array(stretches).T

    def __call__(self, t_s: Floats) -> Floats:
        row = np.maximum(np.searchsorted(self._t, t_s, side="right") - 1, 0)
        since = np.maximum(t_s - self._t[row], 0.0)
        angle: Floats = self._angle[row] + since * (self._speed[row] + 0.5 * since * self._acceleration[row])
        return angle


class _Sine:
    """A sine whose frequency goes from one value to the next without a jump of phase or of speed."""

    def __init__(self, probe: Probe, dwell_s: float) -> None:
        self._amplitude = probe.amplitude_rad
        self._omega = probe.omega_rad_s
        self._span_s = min(CHANGE_S, 0.5 * dwell_s)
        self._changes = [
            (dwell_s * (number + 1), new - old) for number, (old, new) in enumerate(pairwise(self._omega))
        ]

    def __call__(self, t_s: Floats) -> Floats:
        phase = self._omega[0] * t_s
        for start_s, more in self._changes:
            phase = phase + more * self._span_s * blend_integrals((t_s - start_s) / self._span_s)
        angle: Floats = self._amplitude * np.sin(phase)
        return angle
