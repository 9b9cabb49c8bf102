"""What an emulated servo does by itself: its profile, its torque limit, its supply, its wire."""

from __future__ import annotations

import math

import pytest
from rigs import bench, emulated

from snakebot.physics import servo_layout as layout
from snakebot.servobus.dynamixel import Dynamixel, pack
from snakebot.servobus.emulated import EmulatedServo
from snakebot.servobus.feetech import Feetech
from snakebot.servobus.models import model_named


def driven(model: str, joints: int = 1, **more: object):  # type: ignore[no-untyped-def]
    bus = emulated(model, robot=bench(joints), **more)  # type: ignore[arg-type]
    bus.advance(0.01)
    for servo in bus.servos:
        servo.write(servo.model["torque_enable"].address, b"\1")
    bus.advance(0.02)
    return bus


def send(servo: EmulatedServo, name: str, value: int) -> int:
    return servo.write(servo.model[name].address, servo.model.pack(name, value))


@pytest.mark.parametrize("model", ["sts3215", "xl330"])
def test_a_motion_profile_limits_speed_and_none_does_not(model: str) -> None:
    bus = driven(model)
    (servo,) = bus.servos
    counts = round(1.0 / servo.model["profile_velocity"].unit)  # 1 rad/s
    send(servo, "profile_velocity", counts)
    send(servo, "goal_position", 3000)
    start = servo.get("present_position")
    bus.advance(0.52)
    moved_rad = (servo.get("present_position") - start) * servo.model.rad_per_count
    assert moved_rad == pytest.approx(0.5, abs=0.06)
    send(servo, "profile_velocity", 0)
    bus.advance(0.8)
    assert servo.get("present_position") == pytest.approx(3000, abs=2)


def test_a_profile_accelerates_and_brakes() -> None:
    bus = driven("xl330")
    (servo,) = bus.servos
    unit = servo.model["profile_acceleration"].unit
    send(servo, "profile_acceleration", round(4.0 / unit))  # 4 rad/s2
    send(servo, "goal_position", 2048 + round(1.0 / servo.model.rad_per_count))
    places = []
    for step in range(1, 121):
        bus.advance(0.02 + 0.01 * step)
        places.append((servo.get("present_position") - 2048) * servo.model.rad_per_count)
    # from rest to rest over 1 rad at 4 rad/s2 takes 1 s; in the middle it is fastest, at 2 rad/s
    middle = places[54] - places[44]
    assert middle == pytest.approx(0.2, abs=0.04)
    assert places[9] < 0.05
    assert places[-1] == pytest.approx(1.0, abs=0.01)


def test_the_torque_limit_register_limits_the_torque() -> None:
    """And overload leaves it its protective torque."""
    bus = emulated("sts3215", robot=bench(1), effects=["torque_limit:limit_nm=2.94"])
    assert bus.chain is not None
    plant = bus.chain.plant
    bus.advance(0.01)
    (servo,) = bus.servos
    send(servo, "torque_enable", 1)
    send(servo, "torque_limit", 100)
    bus.advance(0.02)
    assert plant._rows[0, layout.TORQUE_LIMIT_NM] == pytest.approx(0.294)
    servo.held_load = 0.95
    bus.advance(0.1)
    bus.advance(1.9)
    assert servo.get("hardware_error") == 0
    bus.advance(2.2)
    assert servo.get("hardware_error") & 1 << 5, "overload, for longer than its protection time"
    send(servo, "torque_limit", 1000)
    bus.advance(2.21)
    assert plant._rows[0, layout.TORQUE_LIMIT_NM] == pytest.approx(0.2 * 2.94), "its protective torque"


def test_a_servo_without_supply_says_nothing_and_forgets() -> None:
    bus = driven("sts3215")
    (servo,) = bus.servos
    send(servo, "torque_limit", 500)
    send(servo, "profile_velocity", 7)
    servo.powered = False
    assert bus.feed(Feetech().ping(1), 0.1) == b""
    servo.power_cycle()
    servo.powered = True
    assert bus.feed(Feetech().ping(1), 0.2)
    assert (servo.get("torque_limit"), servo.get("profile_velocity"), servo.driving) == (1000, 0, False)


def test_a_dynamixel_that_is_overloaded_switches_off_until_it_is_rebooted() -> None:
    bus = driven("xl330")
    (servo,) = bus.servos
    servo.held_load = 1.0
    bus.advance(0.5)
    assert servo.driving
    bus.advance(2.0)
    assert not servo.driving
    assert send(servo, "torque_enable", 1) & 0x7F, "refused"
    servo.held_load = 0.0
    bus.feed(Dynamixel().reboot(1), 2.1)
    bus.advance(2.2)
    assert servo.get("hardware_error") == 0
    assert send(servo, "torque_enable", 1) == 0
    assert servo.driving


def test_stored_registers_outlive_the_supply_and_locked_ones_do_not() -> None:
    servo = EmulatedServo(model_named("sts3215"), 1)
    send(servo, "position_p_gain", 20)
    servo.power_cycle()
    assert servo.get("position_p_gain") == 32, "the lock was on"
    send(servo, "lock", 0)
    send(servo, "position_p_gain", 20)
    servo.power_cycle()
    assert servo.get("position_p_gain") == 20


def test_a_position_is_told_within_the_turn() -> None:
    bus = emulated("sts3215", robot=bench(1), zero_counts=[100], start_rad=[-0.5])
    bus.advance(0.01)
    counts = 100 - 0.5 * 4096 / (2 * math.pi)
    assert bus.servos[0].get("present_position") == pytest.approx(counts % 4096, abs=1)


def test_unknown_instructions_and_short_packets_are_not_answered() -> None:
    bus = driven("xl330")
    for code in (0x02, 0x82, 0x8A, 0x83, 0x03, 0x77):
        assert bus.feed(pack(1, code), 0.1) in (b"", Dynamixel().answer(1, 0, b""))
        assert bus.feed(pack(1, code, b"\0"), 0.1) in (b"", Dynamixel().answer(1, 0, b""))
