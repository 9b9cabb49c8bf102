"""An offset that changes while the motion runs: smooth, the same one by one as all at once, shared by what comes of a
motion."""

from __future__ import annotations

import numpy as np
import pytest

from snakebot.gait import Gait, GaitMotion, OffsetTrack

GAIT = Gait.from_degrees(37, 80, 2, 3)


def steered() -> tuple[GaitMotion, OffsetTrack]:
    motion, track = GaitMotion(GAIT, 5, 20, 2, [0.1] * 5), OffsetTrack()
    motion.steering = track
    track.change(0.0, 0.05, 0.0)
    track.change(3.0, -0.2, 1.0)
    track.change(4.0, 0.3, 2.0)
    return motion, track


def test_one_by_one_and_all_at_once_are_the_same() -> None:
    motion, _ = steered()
    t = np.linspace(-1, 21, 2201)
    np.testing.assert_allclose(motion.sampled(t), [motion.angles(at) for at in t.tolist()], atol=1e-12)


def test_it_is_added_to_the_wave_and_ramped_with_it() -> None:
    motion, track = steered()
    plain = GaitMotion(GAIT, 5, 20, 2, [0.1] * 5)
    for t in (2.0, 3.4, 5.0, 10.0, 17.9):
        np.testing.assert_allclose(np.subtract(motion.angles(t), plain.angles(t)), track.at(t), atol=1e-12)
    assert motion.angles(0.0) == plain.angles(0.0)
    assert motion.angles(20.0) == pytest.approx(plain.angles(20.0))
    assert track.at(10.0) == 0.3


def test_nothing_jumps_in_angle_speed_or_acceleration() -> None:
    motion, _ = steered()
    angles = motion.sampled(np.arange(0, 20, 0.001))
    for order, most in ((1, 3e-3), (2, 1e-5), (3, 2e-7)):
        assert np.abs(np.diff(angles, n=order, axis=0)).max() < most


def test_a_changed_and_an_ended_motion_are_steered_on() -> None:
    motion, track = steered()
    changed = motion.changed(8.0, Gait.from_degrees(20, 80, 3), 1.0).ended(12.0)
    track.change(7.0, 0.0, 1.0)
    assert changed.angles(9.5) == pytest.approx(
        GaitMotion(GAIT, 5, 20, 2, [0.1] * 5).changed(8.0, Gait.from_degrees(20, 80, 3), 1.0).angles(9.5)
    )


def test_a_change_waits_for_the_one_before() -> None:
    _, track = steered()
    with pytest.raises(ValueError, match="ends only at 6 s"):
        track.change(5.0, 0.0, 1.0)


def test_a_long_run_forgets_what_is_past() -> None:
    track = OffsetTrack()
    for number in range(1000):
        track.change(2.0 * number, 0.1 * (number % 3), 1.0)
    assert len(track._changes) == 64
    assert track.at(1991.5) == pytest.approx(0.1 * (995 % 3))
