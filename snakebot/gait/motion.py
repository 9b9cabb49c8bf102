"""Motions a robot can be sent: a gait that starts, changes and ends without a jump, or recorded set-points.

All of them start, change and end along the same blend (``blend``).
"""

from __future__ import annotations

import bisect
import copy
import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.gait.blend import blend, blend_integral, blend_integrals, blends
from snakebot.gait.offset_track import OffsetTrack
from snakebot.gait.wave import Gait

LONGEST_S = 1e8  # three years
LONGEST_RAMP_S = 600.0  # ten minutes; chosen
SHORTEST_BLEND_S = 1e-6  # no clock here is finer; what is shorter changes at once


def check_times(duration_s: float, ramp_s: float) -> None:
    """Raises: BadInputError: a time is negative, not a number, or longer than any run."""
    for name, value, most in (("duration", duration_s, LONGEST_S), ("ramp", ramp_s, LONGEST_RAMP_S)):
        if not 0 <= value <= most:
            raise BadInputError(f"{name} is {value:g} s; it must be zero to {most:g}")


class Motion(ABC):
    """Joint angles as a function of the time since the motion began."""

    joints: int
    duration_s: float  # from the first set-point to the last, ramps included
    repeats = False  # whether what it does after an hour, it has done before, ramps apart
    fastest_rad_s = 0.0  # largest frequency of a sine in it, where it is made of sines

    @abstractmethod
    def angles(self, t_s: float) -> list[float]:
        """Set-point of every joint in rad at one time. Constant before 0 and after ``duration_s``."""

    @abstractmethod
    def ended(self, t_s: float) -> Motion:
        """The same motion up to ``t_s``, then brought to rest smoothly: how a run is cut short."""

    def sampled(self, t_s: Floats) -> Floats:
        """Set-points of shape (T, joints)."""
        return np.array([self.angles(t) for t in t_s]).reshape(len(t_s), self.joints)

    def advice(self, limit: str) -> str:
        """What to change where ``limit`` (angle, speed, acceleration, frequency) is broken; or nothing."""
        return ""


@dataclass(frozen=True, slots=True)
class _Change:
    """From ``start_s`` on, the gait's parameters blend to ``gait`` within ``blend_s``."""

    start_s: float
    blend_s: float
    gait: Gait
    phase_rad: float  # of the wave at start_s


class GaitMotion(Motion):
    """A gait with a smooth start from the posture the robot is in, live changes, and a smooth end.

    For ``ramp_s`` the motion blends from ``start_rad`` into the wave; for the last ``ramp_s`` it blends into
    ``end_rad`` (straight when not given). In between it is exactly eq. (27), phase counted from the motion's start.

    Attributes:
        steering: a further offset of all joints, which whoever steers changes while the motion runs; this motion and
            those that are made of it share it.
    """

    repeats = True

    def __init__(
        self,
        gait: Gait,
        joints: int,
        duration_s: float,
        ramp_s: float,
        start_rad: Sequence[float] | None = None,
        end_rad: Sequence[float] | None = None,
    ) -> None:
        """
        Raises:
            BadInputError: a time is negative or not a number, or the ramps do not fit into the duration.
        """
        check_times(duration_s, ramp_s)
        if not duration_s >= 2 * ramp_s:
            raise BadInputError(
                f"a run of {duration_s:g} s has no room for two ramps of {ramp_s:g} s: "
                "lengthen --duration or shorten --ramp"
            )
        gait.of_joints(joints)  # as many as there are, or a refusal
        self.joints = joints
        self.duration_s = duration_s
        self.ramp_s = ramp_s
        self.start_rad = list(start_rad) if start_rad is not None else [0.0] * joints
        self.end_rad = list(end_rad) if end_rad is not None else [0.0] * joints
        self.steering: OffsetTrack | None = None
        self._changes = [_Change(0.0, 0.0, gait, 0.0)]

    @property
    def gait(self) -> Gait:
        """The gait that was asked for last."""
        return self._changes[-1].gait

    @property
    def fastest_rad_s(self) -> float:  # type: ignore[override]  # read only, unlike the base's constant
        return max(change.gait.omega_rad_s for change in self._changes)

    @property
    def settled_s(self) -> float:
        """From when on the gait that was asked for last is reached whole."""
        return self._changes[-1].start_s + self._changes[-1].blend_s

    def unchanged_from(self, t_s: float) -> GaitMotion:
        """The same motion without a change that begins only at ``t_s`` or later."""
        other = copy.copy(self)
        other._changes = [
            change for number, change in enumerate(self._changes) if not number or change.start_s < t_s
        ]
        return other

    def changed(self, t_s: float, gait: Gait, blend_s: float) -> GaitMotion:
        """The same motion, which goes over to another gait from ``t_s`` on, within ``blend_s`` and without a jump.

        The phase of the wave goes on; amplitude, phase difference, frequency and offset blend.

        Raises:
            BadInputError: ``t_s`` lies before the end of the last change.
        """
        last = self._changes[-1]
        if t_s < last.start_s + last.blend_s or (len(self._changes) > 1 and t_s <= last.start_s):
            raise BadInputError(f"the last change of gait ends only at {last.start_s + last.blend_s:.2f} s")
        gait.of_joints(self.joints)
        phase, _ = self._wave(t_s)
        blend_s = blend_s if blend_s > SHORTEST_BLEND_S else 0.0
        other = copy.copy(self)
        other._changes = [*self._changes, _Change(t_s, blend_s, gait, phase)]
        return other

    def ended(self, t_s: float) -> GaitMotion:
        """The ramp down begins at ``t_s``, unless it has begun already."""
        other = copy.copy(self)
        other.duration_s = min(self.duration_s, t_s + self.ramp_s)
        return other

    def advice(self, limit: str) -> str:
        if limit == "angle":
            return ": lower --alpha or --offset"
        if limit == "frequency":
            return ": lower --omega"
        return ": lower --omega or --alpha, or lengthen --ramp"

    def _wave(self, t_s: float) -> tuple[float, Gait]:
        """Phase of joint 1 (rad) and the blended gait at one time."""
        index = bisect.bisect_right(self._changes, t_s, key=lambda change: change.start_s) - 1
        change = self._changes[max(index, 0)]
        new = change.gait
        since = t_s - change.start_s
        if index <= 0 or change.blend_s <= 0:
            return change.phase_rad + new.omega_rad_s * since, new
        old = self._changes[index - 1].gait
        s = since / change.blend_s
        share = blend(s)
        omega_gain = (new.omega_rad_s - old.omega_rad_s) * change.blend_s * blend_integral(s)
        phase = change.phase_rad + old.omega_rad_s * since + omega_gain
        if share >= 1:
            return phase, new
        mixed = replace(
            new,
            alpha_rad=old.alpha_rad + share * (new.alpha_rad - old.alpha_rad),
            beta_rad=old.beta_rad + share * (new.beta_rad - old.beta_rad),
            omega_rad_s=old.omega_rad_s + share * (new.omega_rad_s - old.omega_rad_s),
            offset_rad=old.offset_rad + share * (new.offset_rad - old.offset_rad),
        )
        if old.shares != new.shares:
            pairs = zip(old.of_joints(self.joints), new.of_joints(self.joints), strict=True)
            mixed = replace(mixed, shares=tuple(a + share * (b - a) for a, b in pairs))
        return phase, mixed

    def angles(self, t_s: float) -> list[float]:
        t = min(max(t_s, 0.0), self.duration_s)
        phase, gait = self._wave(t)
        offset = gait.offset_rad + (self.steering.at(t) if self.steering is not None else 0.0)
        alpha, beta = gait.alpha_rad, gait.beta_rad
        if gait.shares:
            wave = [offset + s * alpha * math.sin(phase + i * beta) for i, s in enumerate(gait.shares)]
        else:
            wave = [offset + alpha * math.sin(phase + i * beta) for i in range(self.joints)]
        rise = blend(t / self.ramp_s) if self.ramp_s > 0 else 1.0
        fall = blend((self.duration_s - t) / self.ramp_s) if self.ramp_s > 0 else 1.0
        if rise < 1:
            wave = [a + rise * (w - a) for a, w in zip(self.start_rad, wave, strict=True)]
        if fall < 1:
            wave = [a + fall * (w - a) for a, w in zip(self.end_rad, wave, strict=True)]
        return wave

    def sampled(self, t_s: Floats) -> Floats:
        """As ``angles`` at each time. All at once: the limits of a long run are checked while the robot moves."""
        t = np.clip(t_s, 0.0, self.duration_s)
        starts = [change.start_s for change in self._changes]
        index = np.maximum(np.searchsorted(starts, t, side="right") - 1, 0)
        wave = np.empty((len(t), self.joints))
        for number, change in enumerate(self._changes):
            here = index == number
            old = self._changes[max(number - 1, 0)].gait
            wave[here] = _blended_wave(t[here] - change.start_s, change, old, number > 0, self.joints)
        if self.steering is not None:
            wave += self.steering.sampled(t)[:, None]
        if self.ramp_s > 0:
            for since, posture in ((t, self.start_rad), (self.duration_s - t, self.end_rad)):
                ramp = since < self.ramp_s
                share = blends(since[ramp] / self.ramp_s)[:, None]
                wave[ramp] = posture + share * (wave[ramp] - posture)
        return wave


def _blended_wave(since_s: Floats, change: _Change, old: Gait, gradual: bool, joints: int) -> Floats:
    """Set-points (T, joints) of a wave at times since a change; ``gradual``: from the old gait, else at once."""
    new = change.gait
    if not gradual or change.blend_s <= 0:
        old, s = new, np.ones_like(since_s)
    else:
        s = since_s / change.blend_s
    share = blends(s)
    phase = change.phase_rad + old.omega_rad_s * since_s
    phase = phase + (new.omega_rad_s - old.omega_rad_s) * change.blend_s * blend_integrals(s)

    def mixed(name: str) -> Floats:
        before, after = getattr(old, name), getattr(new, name)
        return np.asarray(before + share * (after - before))[:, None]

    angle = phase[:, None] + np.arange(joints) * mixed("beta_rad")
    amplitude = mixed("alpha_rad")
    if old.shares or new.shares:
        before, after = np.array(old.of_joints(joints)), np.array(new.of_joints(joints))
        amplitude = amplitude * (before + share[:, None] * (after - before))
    return np.asarray(mixed("offset_rad") + amplitude * np.sin(angle))


class SampledMotion(Motion):
    """Recorded set-points sent again, on a cubic through them, entered smoothly from where the robot is."""

    def __init__(
        self,
        t_s: Floats,
        angles_rad: Floats,
        ramp_s: float,
        start_rad: Sequence[float] | None = None,
    ) -> None:
        """
        Args:
            t_s: rising times, shape (T,).
            angles_rad: set-points, shape (T, joints).
            ramp_s: time to move from ``start_rad`` to the first set-point, and from the last one to straight.
            start_rad: posture of the robot; straight when not given.

        Raises:
            BadInputError: nothing to send, times that do not rise, or set-points that are not numbers.
        """
        if len(t_s) < 2 or angles_rad.shape[0] != len(t_s):
            raise BadInputError("a recorded motion needs at least two samples, one row of set-points each")
        if not np.all(np.diff(t_s) > 0):
            raise BadInputError("the times of the recorded motion do not rise")
        if not np.all(np.isfinite(angles_rad)):
            raise BadInputError("the recorded motion has set-points that are no numbers (servo off?)")
        from scipy.interpolate import CubicSpline  # other motions do without

        self.joints = angles_rad.shape[1]
        self.ramp_s = ramp_s
        self._t = t_s - t_s[0]
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                self._path = CubicSpline(self._t, angles_rad, axis=0)
        except ValueError:  # its slopes are no numbers
            raise BadInputError("the recorded motion's set-points lie too far apart to be joined") from None
        self._start = np.zeros(self.joints) if start_rad is None else np.asarray(start_rad, dtype=float)
        self.duration_s = float(self._t[-1]) + 2 * ramp_s

    def angles(self, t_s: float) -> list[float]:
        t = min(max(t_s, 0.0), self.duration_s)
        inner = t - self.ramp_s
        wave = self._path(min(max(inner, 0.0), self._t[-1]))
        if inner < 0:
            wave = self._start + blend(t / self.ramp_s) * (wave - self._start)
        elif inner > self._t[-1]:
            wave = blend((self.duration_s - t) / self.ramp_s) * wave
        angles: list[float] = wave.tolist()
        return angles

    def sampled(self, t_s: Floats) -> Floats:
        t = np.clip(t_s, 0.0, self.duration_s)
        inner = t - self.ramp_s
        wave: Floats = self._path(np.clip(inner, 0.0, self._t[-1]))
        first, last = inner < 0, inner > self._t[-1]
        wave[first] = self._start + blends(t[first] / self.ramp_s)[:, None] * (wave[first] - self._start)
        wave[last] *= blends((self.duration_s - t[last]) / self.ramp_s)[:, None]
        return wave

    def ended(self, t_s: float) -> Motion:
        return SlowedMotion(self, t_s, self.ramp_s)


class SlowedMotion(Motion):
    """A motion whose own time slows down to a stop: it comes to rest on its path, in the posture it then has."""

    def __init__(self, motion: Motion, t_s: float, slowing_s: float) -> None:
        self.joints = motion.joints
        self.duration_s = min(motion.duration_s, t_s + slowing_s)
        self._motion = motion
        self._from_s = t_s
        self._slowing_s = slowing_s

    def angles(self, t_s: float) -> list[float]:
        since = min(max(t_s, 0.0), self.duration_s) - self._from_s
        if since <= 0 or self._slowing_s <= 0:
            return self._motion.angles(min(t_s, self._from_s))
        s = since / self._slowing_s
        return self._motion.angles(self._from_s + self._slowing_s * (s - blend_integral(s)))

    def ended(self, t_s: float) -> Motion:
        return self  # it is ending already
