"""Bus servos behind the board, in virtual time: how they are given power, set, driven, and let go."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
from rigs import Rig, bench, emulated
from standing_servos import AT, arm, both, rig_of

from firmware_protocol.catalogue import Mode
from snakebot.errors import BadInputError
from snakebot.robot import JointServo


@both
def test_power_comes_where_the_joints_are(model: str) -> None:
    """Goals are at the positions before torque is on; nothing moves."""
    rig = rig_of(model)
    before = [servo.get("present_position") for servo in rig.servos]
    for servo in rig.servos:
        servo.set("goal_position", 0)  # what a run before has left
    seen: list[tuple[int, int]] = []
    feed = rig.bus.feed

    def watched(data: bytes, *rest: Any) -> bytes:
        said = feed(data, *rest)
        seen.extend((s.get("goal_position"), s.get("present_position")) for s in rig.servos if s.driving)
        return said

    rig.bus.feed = watched  # type: ignore[method-assign, assignment]
    here = arm(rig)
    assert here == pytest.approx(AT, abs=0.002)
    rig.stream(0.3, here)
    assert all(servo.driving for servo in rig.servos)
    assert seen
    assert all(abs(goal - present) <= 1 for goal, present in seen)
    assert [servo.get("present_position") for servo in rig.servos] == pytest.approx(before, abs=1)


@both
def test_goals_follow_direction_and_zero(model: str) -> None:
    robot = bench()
    zeros, directions = [2000, 2100, 2048, 1900, 2200], [1, -1, 1, -1, 1]
    servos = [
        JointServo(id=n, model=model, direction=d, zero_counts=z)  # type: ignore[arg-type]
        for n, (d, z) in enumerate(zip(directions, zeros, strict=True), 1)
    ]
    bus = emulated(model, robot=robot, start_rad=AT, zero_counts=zeros, direction=directions)
    rig = Rig(bus, robot, servos=servos)
    here = arm(rig)
    assert here == pytest.approx(AT, abs=0.002)
    there = [angle + 0.1 for angle in here]
    rig.stream(0.5, there)
    counts = [z + d * a * 4096 / (2 * math.pi) for z, d, a in zip(zeros, directions, there, strict=True)]
    assert [servo.get("goal_position") for servo in rig.servos] == pytest.approx(counts, abs=1)
    assert rig.bench.samples[-1].applied_rad == pytest.approx(there, abs=2e-4)


@both
def test_the_servos_own_profile_is_none_while_armed_and_comes_back(model: str) -> None:
    robot = bench()
    bus = emulated(model, robot=robot, start_rad=AT)
    for servo in bus.servos:
        servo.set("profile_velocity", 111)
        servo.set("profile_acceleration", 7)
    rig = Rig(bus, robot)
    here = arm(rig)
    rig.stream(0.1, here)
    assert {s.get("profile_velocity") for s in rig.servos} == {0}
    assert {s.get("profile_acceleration") for s in rig.servos} == {0}
    assert "joint 1: profile_velocity 111 -> 0" in rig.board.about()["changed"]
    rig.bench.must_go(Mode.DISARMED)
    rig.bench.listen(0.1)
    assert not any(servo.driving for servo in rig.servos)
    assert {s.get("profile_velocity") for s in rig.servos} == {111}
    assert {s.get("profile_acceleration") for s in rig.servos} == {7}
    rig.link.close()


def test_gains_and_delays_are_for_the_log() -> None:
    rig = rig_of("sts3215")
    first = rig.board.about()["servos"][0]
    assert first["model"] == "sts3215"
    assert first["firmware"] == "3.9"
    assert (first["position_p_gain"], first["position_d_gain"], first["position_i_gain"]) == (32, 32, 0)
    assert first["return_delay"] == 250


def test_the_bus_watchdog_is_set_fed_and_cleared() -> None:
    rig = rig_of("xl330")
    here = arm(rig)
    rig.stream(0.1, here)
    assert {s.get("bus_watchdog") for s in rig.servos} == {5}
    rig.bench.must_go(Mode.HOLDING)
    rig.bench.hold_heartbeat(0.6, rig.bench.host)
    assert {s.get("bus_watchdog") for s in rig.servos} == {5}, "fed while the board holds"
    rig.bench.must_go(Mode.DISARMED)
    rig.bench.listen(0.1)
    assert {s.get("bus_watchdog") for s in rig.servos} == {0}


def test_a_bus_watchdog_that_a_killed_host_left_is_set_again_and_cleared() -> None:
    """Killed while the joints relaxed: no torque, but the watchdog still set."""
    robot = bench()
    bus = emulated("xl330", robot=robot, start_rad=AT)
    for servo in bus.servos:
        servo.set("bus_watchdog", 5)
    rig = Rig(bus, robot)
    rig.stream(0.1, arm(rig))
    assert {s.get("bus_watchdog") for s in rig.servos} == {5}
    rig.bench.must_go(Mode.DISARMED)
    rig.bench.listen(0.1)
    assert {s.get("bus_watchdog") for s in rig.servos} == {0}


def test_a_servo_that_cannot_be_told_a_torque_limit_is_named() -> None:
    robot = bench()
    servos = [JointServo(id=n, torque_limit=0.5) for n in range(1, 6)]
    warnings = Rig(emulated("scs0009", robot=robot), robot, servos=servos).board.warnings
    assert "100 % of their torque" in warnings[0]
    assert "joint 1 (servo 1): a scs0009 has no register for torque_limit: 0.5" in warnings[1]


def test_a_feetech_servo_is_told_how_hard_it_may_push() -> None:
    robot = bench()
    servos = [JointServo(id=n, torque_limit=0.5) for n in range(1, 6)]
    rig = Rig(emulated("sts3215", robot=robot), robot, servos=servos)
    assert "50 %" in rig.board.warnings[0]
    rig.stream(0.1, arm(rig))
    assert {s.get("torque_limit") for s in rig.servos} == {499}
    rig.bench.must_go(Mode.DISARMED)
    rig.bench.listen(0.1)
    assert {s.get("torque_limit") for s in rig.servos} == {1000}


def test_a_dynamixel_is_limited_by_its_pwm() -> None:
    robot = bench()
    servos = [JointServo(id=n, torque_limit=0.4) for n in range(1, 6)]
    rig = Rig(emulated("xl330", robot=robot), robot, servos=servos)
    rig.stream(0.1, arm(rig))
    assert {s.get("goal_pwm") for s in rig.servos} == {354}
    rig.bench.must_go(Mode.DISARMED)
    rig.bench.listen(0.1)
    assert {s.get("goal_pwm") for s in rig.servos} == {885}


@pytest.mark.parametrize(("model", "turns"), [("sts3215", 3), ("sts3215", -2), ("xl330", 4), ("xl330", -3)])
def test_a_servo_that_counts_turns_is_driven_in_the_turn_in_which_it_is(model: str, turns: int) -> None:
    robot = bench(joints=2)
    bus = emulated(model, robot=robot, start_rad=[0.2, -0.2])
    for servo in bus.servos:
        if model == "sts3215":
            servo.set("min_position", 0)
            servo.set("max_position", 0)
        else:
            servo.set("operating_mode", 4)
        servo.turn_counts = -4096.0 * turns
        servo.show()
    assert bus.servos[0].get("present_position") == pytest.approx(2048 + 130 + 4096 * turns, abs=1)
    rig = Rig(bus, robot)
    here = arm(rig)
    assert here == pytest.approx([0.2, -0.2], abs=0.002)
    rig.stream(0.5, [0.3, -0.1])
    assert bus.servos[0].get("goal_position") == pytest.approx(
        2048 + 0.3 * 4096 / 2 / math.pi + 4096 * turns, abs=1
    )
    assert rig.bench.sample().applied_rad == pytest.approx([0.3, -0.1], abs=2e-4)


@both
def test_armed_right_after_it_was_relaxed_a_joint_keeps_its_power(model: str) -> None:
    """What was still to be confirmed of the last relaxing is not done to the next arming."""
    rig = rig_of(model)
    here = arm(rig)
    rig.stream(0.1, here)
    plant = rig.plant
    for number in range(1, 6):
        plant.set_joint_mode(number, "free")
    for number in range(1, 6):
        plant.set_joint_mode(number, "active")
    plant.command(1e3, here)
    assert all(servo.driving for servo in rig.servos)
    for _ in range(20):
        rig.clock.sleep_until(rig.clock.now_s() + 0.01)
        plant.advance(1e3)
    assert all(servo.driving for servo in rig.servos)


@both
def test_a_joint_that_does_not_hear_that_it_is_to_relax_is_told_until_it_does(model: str) -> None:
    rig = rig_of(model)
    here = arm(rig)
    rig.stream(0.1, here)
    clean = rig.bus.to_servos
    rig.bus.to_servos = lambda packets: b""
    rig.bench.stop()
    rig.clock.sleep_until(rig.clock.now_s() + 0.2)
    assert all(servo.driving for servo in rig.servos)
    rig.bus.to_servos = clean
    rig.bench.listen(0.3)
    assert not any(servo.driving for servo in rig.servos)


def test_a_rate_that_is_refused_is_above_the_one_that_is_named() -> None:
    """Not "--rate 100: ... at most 100 Hz"."""
    rig = rig_of("sts3215")
    rig.board.start = replace(rig.board.start, cycle_s=0.8 / 99.7)
    assert 99 < rig.board.start.max_rate_hz < 100
    with pytest.raises(BadInputError, match=r"--rate 100: .* at most 99 Hz"):
        rig.board.check_rate(100.0)
