"""Motions of a session: gaits straight on and turning, two waves at once, sweeps, and joints going from place to place.

Slow ones swing wide and fast ones little, as on a real robot.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from blind.chain import Floats
from blind.robot import gait_command, swell

Kind = Literal["gait", "turning", "two_waves", "sweep", "places"]
GAITS_ALONE = 0.5  # share of the cases whose motions are all gaits; in the others each motion is of any kind
KINDS: tuple[Kind, ...] = ("gait", "turning", "two_waves", "sweep", "places")
WAVES = (0.8, 1.4)  # along the body
FIVE_JOINTS_RAD = np.radians([60.0, 100.0])  # of a gait's phase from joint to joint, with up to five joints
FASTER = 2.0  # at its end, a sweep than at its start
SECOND_WAVE = 1.7  # times as fast, and half as wide
RAMP_S = 1.0


@dataclass(frozen=True)
class Motion:
    """What all joints are commanded. ``omega_rad_s``: how fast, of each kind on its own terms."""

    kind: Kind
    alpha_rad: float
    beta_rad: float
    omega_rad_s: float
    offset_rad: float = 0.0
    seed: int = 0  # of the places

    @property
    def is_gait(self) -> bool:
        return self.kind in ("gait", "turning")

    def command(self, t_s: Floats, joints: int) -> Floats:
        """(T, joints) rad, from rest in the straight pose."""
        alpha, beta, omega = self.alpha_rad, self.beta_rad, self.omega_rad_s
        if self.kind == "places":
            return self._places(t_s, joints)
        if self.kind == "two_waves":
            fast = gait_command(t_s, alpha / 3, -beta, SECOND_WAVE * omega, RAMP_S, joints)
            return gait_command(t_s, 2 * alpha / 3, beta, omega, RAMP_S, joints) + fast
        if self.kind == "sweep":
            phase = omega * (t_s + 0.5 * (FASTER - 1) * t_s**2 / max(float(t_s[-1]), 1e-9))
            wave = np.sin(phase[:, None] + np.arange(joints) * beta)
            return np.asarray(swell(t_s, RAMP_S) * alpha * wave)
        made = gait_command(t_s, alpha, beta, omega, RAMP_S, joints)
        return np.asarray(made + swell(t_s, RAMP_S) * self.offset_rad)

    def _places(self, t_s: Floats, joints: int) -> Floats:
        """Each joint on its own, from place to place in half a cycle, with rests between."""
        rng = np.random.default_rng(self.seed)
        made = np.zeros((t_s.size, joints))
        takes_s = np.pi / self.omega_rad_s
        for j in range(joints):
            at, t0 = 0.0, float(rng.uniform(0.1, 0.8))
            while t0 < t_s[-1]:
                there = float(rng.uniform(-1, 1)) * self.alpha_rad
                made[:, j] += (there - at) * swell(t_s - t0, takes_s)[:, 0]
                at, t0 = there, t0 + takes_s + float(rng.exponential(0.5))
        return made


def draw_motions(rng: np.random.Generator, count: int, joints: int) -> list[Motion]:
    """The motions of one case. The first one is a gait: every lab has run that."""
    alone = rng.random() < GAITS_ALONE
    return [
        _draw(rng, "gait" if alone or number == 0 else KINDS[int(rng.integers(len(KINDS)))], joints)
        for number in range(count)
    ]


def _draw(rng: np.random.Generator, kind: Kind, joints: int) -> Motion:
    omega = float(np.exp(rng.uniform(np.log(1.0), np.log(5.0))))
    if kind == "sweep":
        omega /= FASTER**0.5
    alpha = float(np.radians(min(70.0, rng.uniform(90.0, 150.0) / omega)))
    if joints <= 5:
        beta = float(rng.uniform(*FIVE_JOINTS_RAD))
    else:
        beta = 2 * np.pi * float(rng.uniform(*WAVES)) / joints
        alpha *= 5 / joints  # bends as much along its length
    offset = float(np.radians(rng.uniform(5.0, 15.0)) * rng.choice([-1.0, 1.0])) if kind == "turning" else 0.0
    return Motion(kind, alpha, beta, omega, offset, int(rng.integers(1 << 31)) if kind == "places" else 0)
