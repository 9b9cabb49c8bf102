"""Sine fits and harmonics against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from signals import rate_limited, times

from snakebot.analysis.sine import estimate_omega, fit_sine, usable_harmonics, wrap_rad


@given(
    amplitude=st.floats(0.01, 2),
    phase=st.floats(-3.1, 3.1),
    offset=st.floats(-1, 1),
    omega=st.floats(0.5, 8),
    seed=st.integers(0, 10),
)
def test_recovers_a_sine_from_irregular_times_with_gaps(
    amplitude: float, phase: float, offset: float, omega: float, seed: int
) -> None:
    t = times(17.3, 60, jitter_s=0.005, seed=seed)
    y = offset + amplitude * np.sin(omega * t + phase)
    y[np.random.default_rng(seed).random(len(t)) < 0.3] = np.nan
    fit = fit_sine(t, y, omega)
    assert fit is not None
    assert fit.amplitude == pytest.approx(amplitude, rel=1e-9)
    assert wrap_rad(fit.phase_rad - phase) == pytest.approx(0, abs=1e-8)
    assert fit.offset == pytest.approx(offset, abs=1e-9)
    assert fit.residual_rms < 1e-9
    assert np.allclose(fit.evaluate(t)[np.isfinite(y)], y[np.isfinite(y)])


def test_first_order_lag_gain_and_phase() -> None:
    """|H| = 1/sqrt(1 + (omega tau)^2), arg H = -atan(omega tau), on a lag integrated sample by sample."""
    tau, omega = 0.12, 4.0
    t = times(30, 2000)
    command = np.sin(omega * t)
    y = np.zeros_like(t)
    decay = math.exp(-(t[1] - t[0]) / tau)
    for i in range(1, len(t)):  # exact for an input that is linear between samples
        dt = t[1] - t[0]
        slope = (command[i] - command[i - 1]) / dt
        y[i] = decay * y[i - 1] + (1 - decay) * command[i - 1] + slope * (dt - tau * (1 - decay))
    steady = t > 5
    fit = fit_sine(t[steady], y[steady], omega)
    assert fit is not None
    assert fit.amplitude == pytest.approx(1 / math.hypot(1, omega * tau), rel=1e-5)
    assert fit.phase_rad == pytest.approx(-math.atan(omega * tau), abs=1e-5)


@pytest.mark.parametrize("share", [0.2, 0.35, 0.5])
def test_rate_limit_on_a_sine_gives_a_triangle(share: float) -> None:
    """Below 0.537 A omega the limit is always active: a triangle of peak pi R / (2 omega), A1 = 4 R / (pi
    omega), behind by acos(pi R / (2 A omega)), with odd harmonics 1/h^2 (describing function of a rate
    limiter)."""
    amplitude, omega = 1.1, 3.0
    limit = share * amplitude * omega
    t = times(12 * 2 * math.pi / omega, 2000)
    y = rate_limited(t, amplitude * np.sin(omega * t), limit)
    steady = t > 6 * 2 * math.pi / omega
    fit = fit_sine(t[steady], y[steady], omega, harmonics=9)
    assert fit is not None
    assert fit.amplitude == pytest.approx(4 * limit / (math.pi * omega), rel=2e-3)
    assert -fit.phase_rad == pytest.approx(math.acos(math.pi * limit / (2 * amplitude * omega)), abs=4e-3)
    assert fit.amplitudes[2] / fit.amplitude == pytest.approx(1 / 9, rel=5e-3)
    assert fit.amplitudes[4] / fit.amplitude == pytest.approx(1 / 25, rel=2e-2)
    assert fit.amplitudes[1] / fit.amplitude < 2e-3
    assert fit.thd == pytest.approx(math.sqrt(1 / 3**4 + 1 / 5**4 + 1 / 7**4 + 1 / 9**4), rel=5e-3)


def test_square_wave_thd() -> None:
    """Odd harmonics 1/h: with those up to the ninth, THD = sqrt(1/9 + 1/25 + 1/49 + 1/81)."""
    omega = 2 * math.pi
    t = times(10, 1000) + 0.0005
    fit = fit_sine(t, np.sign(np.sin(omega * t)), omega, harmonics=9)
    assert fit is not None
    assert fit.amplitude == pytest.approx(4 / math.pi, rel=1e-3)
    assert fit.thd == pytest.approx(math.sqrt(1 / 9 + 1 / 25 + 1 / 49 + 1 / 81), rel=2e-3)


def test_too_little_data_is_no_fit() -> None:
    t = times(1, 10)
    assert fit_sine(t, np.full_like(t, np.nan), 2.0) is None
    assert fit_sine(t[:3], np.sin(t[:3]), 2.0) is None
    assert fit_sine(t, np.sin(t), 0.0) is None
    assert fit_sine(t, np.sin(t), math.nan) is None


@settings(max_examples=25)
@given(omega=st.floats(0.6, 9), phase=st.floats(0, 6))
def test_estimates_the_frequency_of_a_gait(omega: float, phase: float) -> None:
    t = times(max(4 * 2 * math.pi / omega, 6), 100, jitter_s=0.002)
    ramp = np.minimum(t * omega / (2 * math.pi), 1)  # amplitude comes in over one cycle
    command = np.stack([ramp * np.sin(omega * t + phase + i * 1.4) for i in range(3)], axis=1)
    command[:, 1] = np.nan  # one servo is off
    found = estimate_omega(t, command)
    assert found == pytest.approx(omega, rel=5e-3)


@pytest.mark.parametrize("kind", ["step", "chirp", "noise", "still", "off", "half a cycle"])
def test_what_is_not_periodic_has_no_frequency(kind: str) -> None:
    t = times(20, 50)
    rng = np.random.default_rng(3)
    y = {
        "step": (t > 8).astype(float),
        "chirp": np.sin(0.3 * t**2),
        "noise": np.repeat(rng.choice([-1.0, 1.0], len(t) // 20), 20),
        "still": np.zeros_like(t),
        "off": np.full_like(t, np.nan),
        "half a cycle": np.sin(math.pi * t / 20),
    }[kind]
    assert estimate_omega(t, y[:, None]) is None


@pytest.mark.parametrize("shape", ["triangle", "square"])
def test_periodic_need_not_mean_sinusoidal(shape: str) -> None:
    t = times(20, 100)
    y = np.sign(np.sin(2.5 * t)) if shape == "square" else np.arcsin(np.sin(2.5 * t))
    assert estimate_omega(t, y[:, None]) == pytest.approx(2.5, rel=2e-3)


def test_harmonics_stay_below_the_sampling_rate() -> None:
    assert usable_harmonics(times(10, 10), 2 * math.pi) == 4
    assert usable_harmonics(times(10, 1000), 1.0) == 9
    assert usable_harmonics(times(10, 2), 6.0) == 1


@given(st.floats(-50, 50))
def test_wrapped_angle_is_the_same_angle(angle: float) -> None:
    wrapped = wrap_rad(angle)
    assert -math.pi < wrapped <= math.pi + 1e-12
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)
