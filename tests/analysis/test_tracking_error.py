"""TE (37), errors and hysteresis against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from signals import rate_limited, times, with_play

from snakebot.analysis.tracking import hysteresis, tracking


@given(omega=st.floats(0.5, 6), delay=st.floats(0, 0.3), alpha=st.floats(0.1, 1.5))
def test_pure_delay(omega: float, delay: float, alpha: float) -> None:
    """A delay d turns the error into a sine of amplitude 2 alpha sin(omega d / 2): TE = sqrt(2) |sin(omega
    d / 2)|."""
    t = np.linspace(0, 5 * 2 * math.pi / omega, 2001)[:-1]
    found = tracking(alpha * np.sin(omega * (t - delay)), alpha * np.sin(omega * t), alpha)
    assert found.te == pytest.approx(math.sqrt(2) * abs(math.sin(omega * delay / 2)), abs=1e-9)
    assert found.max_rad == pytest.approx(2 * alpha * abs(math.sin(omega * delay / 2)), abs=1e-4)


@given(omega=st.floats(0.5, 6), tau=st.floats(0.001, 0.5))
def test_first_order_lag(omega: float, tau: float) -> None:
    """1 - H = j omega tau / (1 + j omega tau): TE = omega tau / sqrt(2 (1 + (omega tau)^2))."""
    t = np.linspace(0, 5 * 2 * math.pi / omega, 2001)[:-1]
    x = omega * tau
    measured = np.sin(omega * t - math.atan(x)) / math.hypot(1, x)
    found = tracking(measured, np.sin(omega * t), 1.0)
    assert found.te == pytest.approx(x / math.sqrt(2 * (1 + x * x)), rel=1e-9)


def test_rate_limited_sine() -> None:
    """Fully limited: a triangle of peak p = pi R/(2 omega) behind by g = acos(p/A).

    TE^2 = 1/2 + p^2/(3 A^2) - (8 p / (pi^2 A)) cos g, from the mean squares of sine and triangle and their
    product."""
    amplitude, omega, limit = 1.0, 2.0, 0.7
    t = times(14 * math.pi, 2000)
    command = amplitude * np.sin(omega * t)
    steady = t > 4 * math.pi
    found = tracking(rate_limited(t, command, limit)[steady], command[steady], amplitude)
    peak = math.pi * limit / (2 * omega)
    behind = math.acos(peak / amplitude)
    expected = 0.5 + peak**2 / 3 - 8 * peak / math.pi**2 * math.cos(behind)
    assert found.te == pytest.approx(math.sqrt(expected), rel=3e-3)


def test_lost_samples_are_left_out_not_counted_as_zero() -> None:
    command = np.zeros(10)
    measured = np.full(10, 0.2)
    measured[::2] = np.nan
    found = tracking(measured, command, 0.5)
    assert (found.rms_rad, found.te) == pytest.approx((0.2, 0.4))
    assert found.samples == 5


def test_nothing_known_is_nan_not_zero() -> None:
    assert math.isnan(tracking(np.full(4, np.nan), np.zeros(4), 1.0).te)
    assert math.isnan(tracking(np.ones(4), np.zeros(4), 0.0).te)


def test_delay_is_lag_without_hysteresis() -> None:
    t = times(8 * math.pi, 500)
    found = hysteresis(t, 0.8 * np.sin(2 * (t - 0.01)), 0.8 * np.sin(2 * t), cycles=8)
    assert found.lag_s == pytest.approx(0.01, rel=1e-3)
    assert abs(found.half_width_rad) < 1e-4
    assert abs(found.loop) < 0.02


def test_play_is_hysteresis_without_lag() -> None:
    """Play holds the output back by half its width against the motion, whatever the speed."""
    t = times(16 * math.pi, 1000)
    command = 0.8 * np.sin(2 * t)
    found = hysteresis(t, with_play(command, 0.04), command, cycles=16)
    assert found.half_width_rad == pytest.approx(0.02, rel=0.15)
    assert abs(found.lag_s) < 0.002


def test_an_error_of_gain_encloses_the_whole_ellipse() -> None:
    t = np.arange(0, 4 * math.pi, 0.002)
    command = np.sin(2 * t)
    assert abs(hysteresis(t, 0.9 * command, command, cycles=4).loop) == pytest.approx(1, abs=0.01)


def test_offset_is_the_constant() -> None:
    t = times(20, 100)
    command = 0.5 * np.sin(2 * t)
    assert hysteresis(t, command + 0.03, command).constant_rad == pytest.approx(0.03, abs=1e-6)


def test_no_motion_has_no_hysteresis() -> None:
    t = times(2, 50)
    assert math.isnan(hysteresis(t, np.zeros_like(t), np.zeros_like(t)).lag_s)
    assert hysteresis(t, np.full_like(t, np.nan), np.sin(t)).samples == 0
