"""The steady part of a run is found where it was put."""

from __future__ import annotations

import math

import numpy as np
import pytest
from signals import times

from snakebot.analysis.steady import find_steady_state
from snakebot.arrays import Floats

OMEGA = 2 * math.pi  # one cycle a second


def wave(t: Floats, joints: int = 3, amplitude: float = 1.0, phase: float = 0.0) -> Floats:
    return amplitude * np.sin(OMEGA * t[:, None] + phase + np.arange(joints) * 1.2)


def test_ramps_at_both_ends_are_left_out() -> None:
    t = times(12, 100)
    envelope = np.clip(t / 2, 0, 1) * np.clip((12 - t) / 1, 0, 1)
    command = envelope[:, None] * wave(t)
    found = find_steady_state(t, command, np.roll(command, 4, axis=0), OMEGA)
    assert found.settled
    assert 1.4 <= found.start_s <= 3.1
    assert 10 <= found.end_s <= 11.6
    assert found.duration_s == pytest.approx(found.cycles, abs=1e-6)


def test_a_transient_of_the_joints_is_left_out_even_when_the_command_is_steady() -> None:
    t = times(12, 100)
    measured = wave(t) * (1 - 0.6 * np.exp(-t / 1.5))[:, None]
    found = find_steady_state(t, wave(t), measured, OMEGA)
    assert found.settled
    assert found.start_s > 2.5
    assert found.end_s == pytest.approx(t[-1], abs=0.6)


def test_a_body_still_speeding_up_is_left_out() -> None:
    t = times(20, 50)
    distance = np.cumsum(0.1 * (1 - np.exp(-t / 2))) * 0.02
    position = np.stack([distance, np.zeros_like(t)], axis=1)
    with_body = find_steady_state(t, wave(t), wave(t), OMEGA, position)
    without = find_steady_state(t, wave(t), wave(t), OMEGA)
    assert with_body.start_s > without.start_s + 2


def test_noise_does_not_stop_it() -> None:
    t = times(20, 100)
    rng = np.random.default_rng(1)
    measured = wave(t, amplitude=0.3) + rng.normal(0, 0.03, (len(t), 3))
    measured[rng.random(measured.shape) < 0.1] = np.nan
    found = find_steady_state(t, wave(t, amplitude=0.3), measured, OMEGA)
    assert found.settled
    assert found.cycles >= 8


def test_a_run_that_never_settles_says_so() -> None:
    t = times(16, 100)
    measured = wave(t) * np.exp(-t / 4)[:, None]
    found = find_steady_state(t, wave(t), measured, OMEGA)
    assert not found.settled
    assert "no stretch is steady" in found.reason


def test_too_short_and_not_periodic_use_all_there_is() -> None:
    t = times(2.2, 100)
    assert "only" in find_steady_state(t, wave(t), wave(t), OMEGA).reason
    found = find_steady_state(t, wave(t), wave(t), None)
    assert found.start_s == pytest.approx(0)
    assert (found.cycles, found.settled) == (0, False)


def test_servos_off_throughout() -> None:
    t = times(5, 50)
    nothing = np.full((len(t), 2), np.nan)
    found = find_steady_state(t, nothing, nothing, None)
    assert found.mask(t).sum() > 0
    assert not find_steady_state(t, nothing, nothing, OMEGA).settled


def test_free_joint_that_flaps_elsewhere_leaves_a_usable_window() -> None:
    t = times(12, 100)
    measured = wave(t)
    measured[:, 1] = 0.0
    found = find_steady_state(t, wave(t), measured, OMEGA)
    assert found.settled


def test_a_gait_too_fast_for_the_samples_costs_no_memory() -> None:
    t = times(20, 100)
    found = find_steady_state(t, wave(t), wave(t), 1e9)
    assert not found.settled
    assert found.cycles == 0
    assert "too fast for the samples" in found.reason
