"""Bus servos behind the board, in virtual time: what is refused before any of them gets power."""

from __future__ import annotations

import math

import pytest
from rigs import Rig, bench, emulated
from standing_servos import AT, arm, both

from snakebot.errors import BadInputError, BoardFaultError, NoBoardError
from snakebot.robot import JointServo
from snakebot.servobus.emulated import EmulatedServo
from snakebot.servobus.models import model_named


@pytest.mark.parametrize(("model", "firmware"), [("xl430", 30), ("xm430", 37)])
def test_no_bus_watchdog_is_refused_unless_it_is_accepted(model: str, firmware: int) -> None:
    robot = bench()
    bus = emulated(model, robot=robot)
    bus.servos[1].set("firmware", firmware)
    with pytest.raises(BadInputError, match=r"joint 2 \(servo 2\).*--no-servo-watchdog"):
        Rig(bus, robot)
    rig = Rig(emulated(model, robot=robot), robot, watchdog=False)
    here = arm(rig)
    rig.stream(0.1, here)
    assert {s.get("bus_watchdog") for s in rig.servos} == {0}
    assert "no bus watchdog" in rig.board.warnings[0]


@both
def test_a_joint_beyond_its_limit_is_refused_with_angle_and_limit(model: str) -> None:
    robot = bench(limits={"angle_deg": 20})
    with pytest.raises(
        BoardFaultError, match=r"joint 5 \(servo 5\) stands at -22.9 deg, beyond its limit of 20.0 deg"
    ):
        Rig(emulated(model, robot=robot, start_rad=AT), robot)


@both
def test_a_range_across_the_end_of_a_turn_is_refused(model: str) -> None:
    robot = bench(joints=2)
    servos = [JointServo(id=1), JointServo(id=2, zero_counts=100)]
    with pytest.raises(
        BadInputError, match=r"joint 2 \(servo 2\): its range of .* crosses the end of the servo's turn"
    ):
        Rig(emulated(model, robot=robot, zero_counts=[2048, 100]), robot, servos=servos)


def test_across_the_wrap_angles_are_read_on() -> None:
    """Straight at 3900 counts, 20 deg away is at 32 counts: read as 20 deg, and refused as a goal."""
    robot = bench(joints=1, limits={"angle_deg": 15})
    bus = emulated("sts3215", robot=robot, zero_counts=[3900], start_rad=[0.2])
    rig = Rig(bus, robot, servos=[JointServo(id=1, zero_counts=3900)])
    joint = rig.board.joints[0]
    assert joint.angle_rad(32) == pytest.approx((32 + 4096 - 3900) * 2 * math.pi / 4096)
    assert joint.angle_rad(3800) == pytest.approx(-100 * 2 * math.pi / 4096)


def test_a_servo_in_another_mode_is_refused() -> None:
    robot = bench()
    bus = emulated("xl330", robot=robot)
    bus.servos[3].set("operating_mode", 1)
    with pytest.raises(
        BadInputError, match=r"joint 4 \(servo 4\) is in operating mode 1: set it to 3 \(position\)"
    ):
        Rig(bus, robot)


def test_a_servos_own_angle_limits_that_are_too_tight_are_refused() -> None:
    robot = bench()
    bus = emulated("sts3215", robot=robot)
    bus.servos[1].set("min_position", 1500)
    with pytest.raises(
        BadInputError, match=r"its own angle limits are 1500 to 4095 counts, .* need 967 to 3129"
    ):
        Rig(bus, robot)


def test_a_servo_with_an_error_is_refused_at_the_start() -> None:
    robot = bench()
    bus = emulated("xl330", robot=robot)
    bus.servos[0].temperature_c = 95.0
    bus.advance(0.01)
    with pytest.raises(BoardFaultError, match=r"joint 1: the servo is too hot: 95 degC"):
        Rig(bus, robot)


def test_missing_wrong_and_found_ids_are_told_in_one_line() -> None:
    robot = bench()
    bus = emulated("sts3215", robot=robot, ids=[1, 2, 3, 8, 9])
    servos = [JointServo(id=n, model="scs0009" if n == 2 else "sts3215") for n in range(1, 6)]
    with pytest.raises(NoBoardError) as told:
        Rig(bus, robot, servos=servos)
    line = str(told.value)
    assert "servos 1, 2, 3, 4, 5 were expected" in line
    assert "4, 5 do not answer" in line
    assert "2 is sts3215, not scs0009" in line
    assert "found: 1 (sts3215), 2 (sts3215), 3 (sts3215), 8 (sts3215), 9 (sts3215)" in line


def test_two_servos_of_one_id_are_told() -> None:
    robot = bench()
    bus = emulated("sts3215", robot=robot, ids=[1, 2, 3, 3, 5], start_rad=AT)
    bus.servos[3].set("model_number", 1284)
    with pytest.raises(NoBoardError, match="damaged answers came too: two servos of one id"):
        Rig(bus, robot)


@both
def test_two_servos_of_one_id_that_say_the_same_of_themselves_are_told(model: str) -> None:
    """A sixth servo, not yet given an id of its own: all five are there, but one place is said twice."""
    robot = bench()
    bus = emulated(model, robot=robot)
    twin = EmulatedServo(model_named(model), 5)
    twin.position_counts = 1500.0
    twin.show()
    bus.servos.append(twin)
    with pytest.raises(NoBoardError, match=r"joint 5 \(servo 5\) stopped .*: two servos of this id"):
        Rig(bus, robot)


def test_a_wrong_bit_rate_is_told() -> None:
    robot = bench()
    bus = emulated("xl330", robot=robot)
    for servo in bus.servos:
        servo.set("baud_rate", 1)
    rate = Rig.line_baud
    try:
        Rig.line_baud = 1_000_000
        with pytest.raises(
            NoBoardError, match="nobody answers at 1000000 baud: is the supply on, and is this the bit rate"
        ):
            Rig(bus, robot)
    finally:
        Rig.line_baud = rate
