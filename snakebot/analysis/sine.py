"""Least-squares sines: amplitude, phase, harmonics, and the frequency where nobody wrote it down.

A joint that follows its set-point is a sine at the gait's frequency (27). The fit needs no uniform sampling
and no whole number of cycles; samples that are lost (``nan``) are left out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Floats

MAX_HARMONICS = 9  # of a fit; chosen, a servo filters out what is beyond
MIN_CONDITION = 1e-8  # of the normal equations: a window of a tenth of a cycle determines no sine
MIN_CYCLES = 1.5  # fewer do not tell a slow sine from a drift
PERIODIC_SHARE = 0.9  # of the command's variance that a periodic fit must explain


@dataclass(frozen=True)
class SineFit:
    """``y(t) = offset + sum_h amplitude_h sin(h omega t + phase_h)``, fitted by least squares.

    ``amplitudes`` and ``phases_rad`` hold one value a harmonic, the fundamental first; the unit of
    ``offset``, ``amplitudes`` and ``residual_rms`` is that of the data.
    """

    omega_rad_s: float
    offset: float
    amplitudes: Floats
    phases_rad: Floats
    residual_rms: float
    samples: int

    @property
    def amplitude(self) -> float:
        """Of the fundamental."""
        return float(self.amplitudes[0])

    @property
    def phase_rad(self) -> float:
        """Of the fundamental, at t = 0."""
        return float(self.phases_rad[0])

    @property
    def thd(self) -> float:
        """Total harmonic distortion: rms of the harmonics from the second on, over that of the
        fundamental."""
        if not self.amplitude > 0:
            return math.nan
        return float(np.sqrt(np.sum(self.amplitudes[1:] ** 2)) / self.amplitude)

    def evaluate(self, t_s: Floats) -> Floats:
        """The fitted curve at times ``t_s`` (N,)."""
        order = np.arange(1, len(self.amplitudes) + 1)
        angle = self.omega_rad_s * np.asarray(t_s)[:, None] * order + self.phases_rad
        return np.asarray(self.offset + np.sin(angle) @ self.amplitudes, dtype=np.float64)


def usable_harmonics(t_s: Floats, omega_rad_s: float, most: int = MAX_HARMONICS) -> int:
    """How many harmonics of ``omega_rad_s`` the samples can tell apart: up to 0.8 of half the sampling
    rate."""
    steps = np.diff(t_s)
    if len(steps) == 0 or omega_rad_s <= 0:
        return 1
    nyquist = math.pi / float(np.median(steps))
    return int(np.clip(math.floor(0.8 * nyquist / omega_rad_s), 1, most))


def fit_sine(t_s: Floats, y: Floats, omega_rad_s: float, harmonics: int = 1) -> SineFit | None:
    """Fit a sine and its first ``harmonics`` to one signal.

    Args:
        t_s: times (N,), in s, rising, not necessarily uniform.
        y: signal (N,), ``nan`` where it is not known.
        omega_rad_s: the fundamental.
        harmonics: 1 fits the sine alone.

    Returns:
        ``None`` when too few samples are left to determine the fit.
    """
    good = np.isfinite(y)
    unknowns = 1 + 2 * harmonics
    if int(good.sum()) < unknowns + 1 or not (omega_rad_s > 0 and math.isfinite(omega_rad_s)):
        return None
    t, values = np.asarray(t_s)[good], np.asarray(y)[good]
    design = _design(t, omega_rad_s, harmonics)
    gram = design.T @ design  # well conditioned for sines that the samples can tell apart; others are refused
    eigenvalues = np.linalg.eigvalsh(gram)
    if eigenvalues[0] <= MIN_CONDITION * eigenvalues[-1]:
        return None
    coefficients = np.linalg.solve(gram, design.T @ values)
    residual = values - design @ coefficients
    in_phase, quadrature = coefficients[1::2], coefficients[2::2]
    return SineFit(
        omega_rad_s=float(omega_rad_s),
        offset=float(coefficients[0]),
        amplitudes=np.hypot(in_phase, quadrature),
        phases_rad=np.arctan2(quadrature, in_phase),
        residual_rms=float(np.sqrt(np.mean(residual**2))),
        samples=len(values),
    )


def wrap_rad(angle_rad: float) -> float:
    """The same angle in (-pi, pi]."""
    return float(math.pi - (math.pi - angle_rad) % (2 * math.pi))


def estimate_omega(t_s: Floats, command_rad: Floats) -> float | None:
    """The fundamental of a periodic command, in rad/s, from the command alone.

    The start and the end of a run are left out (amplitude is ramped there). ``None`` for a command that is
    not periodic: steps, chirps, noise, fewer than 1.5 cycles, no motion.

    Args:
        t_s: times (N,).
        command_rad: set-points (N, k), ``nan`` = servo off.
    """
    known = np.isfinite(command_rad).any(axis=1)
    if known.sum() < 8:
        return None
    first, last = np.flatnonzero(known)[[0, -1]]
    span = t_s[last] - t_s[first]
    window = (t_s >= t_s[first] + 0.25 * span) & (t_s <= t_s[last] - 0.1 * span)
    t = t_s[window]
    moving = [
        column
        for column in command_rad[window].T
        if np.isfinite(column).mean() > 0.5 and np.nanstd(column) > 1e-6
    ]
    if len(t) < 8 or not moving:
        return None
    guess = _spectral_peak(t, moving)
    duration = t[-1] - t[0]
    if guess is None or guess * duration / (2 * math.pi) < MIN_CYCLES * 0.8:
        return None
    half_bin = math.pi / duration
    omega = _refine(t, moving, max(guess - half_bin, 0.3 * guess), guess + half_bin)
    enough = omega * duration / (2 * math.pi) >= MIN_CYCLES
    order = usable_harmonics(t, omega, 5)
    periodic = 1 - _misfit(t, moving, omega, order) >= PERIODIC_SHARE
    return omega if enough and periodic else None


def _design(t_s: Floats, omega_rad_s: float, harmonics: int) -> Floats:
    angle = omega_rad_s * t_s[:, None] * np.arange(1, harmonics + 1)
    design = np.empty((len(t_s), 1 + 2 * harmonics))
    design[:, 0] = 1.0
    design[:, 1::2] = np.sin(angle)
    design[:, 2::2] = np.cos(angle)
    return design


def _spectral_peak(t_s: Floats, signals: list[Floats]) -> float | None:
    step = float(np.median(np.diff(t_s)))
    if step <= 0:
        return None
    grid = np.arange(t_s[0], t_s[-1], step)
    size = 8 * len(grid)
    power = np.zeros(size // 2 + 1)
    for signal in signals:
        good = np.isfinite(signal)
        even = np.interp(grid, t_s[good], signal[good])
        power += np.abs(np.fft.rfft((even - even.mean()) * np.hanning(len(grid)), size)) ** 2
    power[: 8 if len(power) > 16 else 1] = 0.0  # below one cycle in the window
    return float(2 * math.pi * np.argmax(power) / (size * step)) if power.max() > 0 else None


def _misfit(t_s: Floats, signals: list[Floats], omega_rad_s: float, harmonics: int) -> float:
    """Share of the signals' variance that the fit leaves."""
    left = total = 0.0
    for signal in signals:
        fit = fit_sine(t_s, signal, omega_rad_s, harmonics)
        good = np.isfinite(signal)
        total += float(np.var(signal[good]) * good.sum())
        left += fit.residual_rms**2 * fit.samples if fit else float(np.var(signal[good]) * good.sum())
    return left / total if total > 0 else 1.0


def _refine(t_s: Floats, signals: list[Floats], low: float, high: float) -> float:
    """Golden-section search for the frequency with the least misfit of a single sine."""
    golden = (math.sqrt(5) - 1) / 2
    a, b = high - golden * (high - low), low + golden * (high - low)
    fa, fb = _misfit(t_s, signals, a, 1), _misfit(t_s, signals, b, 1)
    while high - low > 1e-7 * high:
        if fa < fb:
            high, b, fb = b, a, fa
            a = high - golden * (high - low)
            fa = _misfit(t_s, signals, a, 1)
        else:
            low, a, fa = a, b, fb
            b = low + golden * (high - low)
            fb = _misfit(t_s, signals, b, 1)
    return (low + high) / 2
