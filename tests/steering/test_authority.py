"""However an offset is moved within what ``authority_of`` allows, no limit of the robot is broken."""

from __future__ import annotations

import math

import pytest
from hypothesis import assume, example, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from snakebot.errors import BadInputError
from snakebot.gait import Gait, GaitMotion, OffsetTrack, check_motion
from snakebot.robot import Robot, load_robot
from snakebot.steering.authority import Authority, authority_of

ROBOT = load_robot("penn_state")


def limited(angle_deg: float, speed_rad_s: float, acceleration_rad_s2: float) -> Robot:
    limits = ROBOT.limits.model_copy(
        update={
            "angle_deg": angle_deg,
            "speed_rad_s": speed_rad_s,
            "acceleration_rad_s2": acceleration_rad_s2,
        }
    )
    return ROBOT.model_copy(update={"limits": limits})


# A peak of the ramp at the end that stands between two samples.
@example(5.0, 2.0, 0.0, 2.0, 1.25, 1.75, 0.0, [0.0, 0.0, -1.0])
@hypothesis_settings(max_examples=40)
@given(
    st.floats(5, 60), st.floats(0.5, 5), st.floats(-10, 10), st.floats(1.02, 3), st.floats(1.02, 3),
    st.floats(0.3, 3), st.floats(-0.5, 0.5), st.lists(st.floats(-3, 3), min_size=3, max_size=6),
)  # fmt: skip
def test_no_limit_is_broken(
    alpha: float, omega: float, offset: float, speed: float, acceleration: float, ramp_s: float, start: float,
    wanted: list[float],
) -> None:  # fmt: skip
    gait = Gait.from_degrees(alpha, 80, omega, offset)
    robot = limited(
        alpha + 15, speed * gait.alpha_rad * omega + 0.5, acceleration * gait.alpha_rad * omega**2 + 0.5
    )
    motion = GaitMotion(gait, 5, 2 * ramp_s + 7 * gait.period_s, ramp_s, [start] * 5)
    try:
        check_motion(motion, robot)
    except BadInputError:
        assume(False)
    try:
        room = authority_of(motion, robot)
    except BadInputError:
        assume(False)
    track = motion.steering = OffsetTrack()
    track.change(0.0, min(max(wanted[0], room.low_rad), room.high_rad), 0.0)
    t_s = ramp_s
    for offset_rad in wanted[1:]:
        track.change(t_s, room.limited(offset_rad, track.target_rad), room.blend_s)
        t_s += room.blend_s
    check_motion(motion, robot)
    assert track.settled_s <= motion.duration_s - ramp_s


def test_the_whole_room_of_the_joints_is_offered() -> None:
    motion = GaitMotion(Gait.from_degrees(80, 80, 2), 5, 20, 2)
    room = authority_of(motion, ROBOT)
    assert math.degrees(room.high_rad) == pytest.approx(15, abs=0.01)  # 95 less 80 degrees
    assert math.degrees(room.low_rad) == pytest.approx(-15, abs=0.01)
    wide = authority_of(GaitMotion(Gait.from_degrees(37, 80, 2), 5, 20, 2), ROBOT)
    assert math.degrees(wide.high_rad) == pytest.approx(30)


def test_the_gaits_own_offset_takes_of_it() -> None:
    room = authority_of(GaitMotion(Gait.from_degrees(80, 80, 2, 5), 5, 20, 2), ROBOT)
    assert math.degrees(room.high_rad) == pytest.approx(10, abs=0.01)


def test_from_outside_the_room_the_way_back_is_no_longer_than_a_step() -> None:
    room = Authority(low_rad=-0.1, high_rad=0.1, step_rad=0.05, blend_s=1.0)  # of a gait that came in mid-run
    assert room.limited(0.0, 0.4) == pytest.approx(0.35)
    assert room.limited(-1.0, -0.4) == pytest.approx(-0.35)
    assert room.limited(0.5, 0.12) == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("gait", "limits", "why"),
    [
        ((94.5, 80, 2), (95, 8, 60), "to steer with"),
        ((60, 80, 2), (95, 2 * math.radians(60) + 1e-3, 60), "no change of its offset"),
    ],
)
def test_no_room_is_refused_in_one_line(
    gait: tuple[float, float, float], limits: tuple[float, float, float], why: str
) -> None:
    robot = limited(*limits)
    with pytest.raises(BadInputError, match=why) as refused:
        authority_of(GaitMotion(Gait.from_degrees(*gait), 5, 30, 8), robot)
    assert "\n" not in str(refused.value)
