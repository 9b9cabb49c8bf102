"""Motions of hours: their limits are checked to the end, and in bounded memory."""

from __future__ import annotations

import numpy as np
import pytest

from snakebot.errors import BadInputError
from snakebot.gait import Gait, GaitMotion, SampledMotion, check_motion
from snakebot.robot import load_robot

ROBOT = load_robot("penn_state")


def recorded(peak_at_s: float, peak_rad: float) -> SampledMotion:
    t_s = np.arange(0.0, 6000.0, 1.0)
    angles = np.zeros((t_s.size, ROBOT.joints))
    angles[:, 2] = peak_rad * np.exp(-(((t_s - peak_at_s) / 20) ** 2))
    return SampledMotion(t_s, angles, 2.0)


@pytest.mark.parametrize("peak_at_s", [100.0, 4500.0, 5900.0])
def test_a_recorded_motion_is_checked_to_its_end(peak_at_s: float) -> None:
    with pytest.raises(BadInputError, match="joint 3: the motion asks for angle 171"):
        check_motion(recorded(peak_at_s, 3.0), ROBOT)


def test_the_end_of_a_long_gait_is_checked() -> None:
    """It ends far out, and quickly."""
    gait = Gait.from_degrees(10, 80, 0.01)
    far = [0.0, 0.0, 1.6, 0.0, 0.0]
    check_motion(GaitMotion(gait, ROBOT.joints, 20_000, 10), ROBOT)
    with pytest.raises(BadInputError, match="joint 3"):
        check_motion(GaitMotion(gait, ROBOT.joints, 20_000, 0.2, end_rad=far), ROBOT)


def test_a_recorded_motion_sampled_is_what_is_sent() -> None:
    rng = np.random.default_rng(1)
    motion = SampledMotion(
        np.cumsum(rng.uniform(0.01, 0.1, 50)), rng.normal(size=(50, 3)), 0.5, [0.3, -0.2, 0.1]
    )
    t_s = np.linspace(-0.5, motion.duration_s + 0.5, 400)
    np.testing.assert_allclose(motion.sampled(t_s), [motion.angles(t) for t in t_s], atol=1e-12)


@pytest.mark.parametrize(("duration_s", "ramp_s"), [(1e12, 2.0), (float("inf"), 2.0), (1e7, 20_000.0)])
def test_what_no_run_lasts_is_refused(duration_s: float, ramp_s: float) -> None:
    with pytest.raises(BadInputError, match="must be zero to"):
        GaitMotion(Gait.from_degrees(10, 80, 1), ROBOT.joints, duration_s, ramp_s)
