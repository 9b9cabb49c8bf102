"""Bus servos behind the board, in virtual time: what happens to one is a fault, in words; and what they tell."""

from __future__ import annotations

import pytest
from rigs import Rig, bench, emulated
from standing_servos import AT, arm, both, rig_of

from firmware_protocol.catalogue import Fault, FaultEvent, JointSupply, Mode, Supply
from firmware_protocol.servo_trouble import ServoTrouble
from snakebot.errors import LostBoardError
from snakebot.servobus.emulated import EmulatedServo
from snakebot.servobus.models import MODELS
from snakebot.servobus.troubles import words
from snakebot.softboard.hardware import HardwareFault


def fault_of(rig: Rig) -> FaultEvent:
    """The fault that the board reports, with its joint and value."""
    return rig.bench.wait(FaultEvent, 1.0)


def overheat(servo: EmulatedServo) -> None:
    servo.temperature_c = 88.0


def sag(servo: EmulatedServo) -> None:
    servo.supply_v = 3.1


def jam(servo: EmulatedServo) -> None:
    servo.held_load = 0.97


def let_go(servo: EmulatedServo) -> None:
    servo.set("torque_enable", 0)
    servo.changed = True


def restart(servo: EmulatedServo) -> None:
    servo.power_cycle()


def unplug(servo: EmulatedServo) -> None:
    servo.powered = False


@pytest.mark.parametrize("model", ["sts3215", "xl330", "xl430"])
@pytest.mark.parametrize(
    ("harm", "code", "told"),
    [
        (overheat, Fault.OVERTEMPERATURE, "joint 3: the servo is too hot: 88 degC"),
        (sag, Fault.UNDERVOLTAGE, "joint 3: the servo's supply is outside its limits: 3.1 V"),
        (jam, Fault.OVERCURRENT, "joint 3: the servo is overloaded: 97 % of its torque"),
        (let_go, Fault.SERVO, "joint 3: the servo has switched its torque off by itself"),
        (restart, Fault.SERVO, "joint 3: the servo has lost its supply and started again"),
        (unplug, Fault.SERVO, "joint 3: the servo has not answered for five cycles"),
    ],
)
def test_what_happens_to_a_servo_is_a_fault_with_joint_and_value(
    model: str, harm: object, code: Fault, told: str
) -> None:
    rig = rig_of(model)
    here = arm(rig)
    rig.stream(0.2, here)
    harm(rig.servos[2])  # type: ignore[operator]
    rig.bench.heard.clear()
    for _ in range(300):
        rig.stream(0.01, here)
        if rig.board.mode is Mode.FAULT:
            break
    event = fault_of(rig)
    assert (event.code, event.joint) == (code, 3)
    said = words(HardwareFault(event.code, event.joint, event.detail))
    assert said.startswith(told)
    frozen = [s.get("goal_position") for s in rig.servos]
    rig.stream(0.1, [angle + 0.1 for angle in here])
    assert [s.get("goal_position") for s in rig.servos][:2] == frozen[:2], "all freeze"
    rig.bench.listen(2.5)
    assert not any(servo.driving for servo in rig.servos if servo.powered), "then nobody has power"


@pytest.mark.parametrize(
    ("model", "left"), [("sts3215", ("torque_limit", 999)), ("xl330", ("bus_watchdog", 5))]
)
def test_a_restart_is_told_after_a_killed_host_left_its_settings(model: str, left: tuple[str, int]) -> None:
    robot = bench()
    bus = emulated(model, robot=robot)
    for servo in bus.servos:
        servo.set(*left)
    rig = Rig(bus, robot)
    here = arm(rig)
    rig.stream(0.2, here)
    rig.servos[2].power_cycle()
    rig.stream(0.3, here)
    assert rig.plant.fault() == HardwareFault(Fault.SERVO, 3, ServoTrouble.POWER_CYCLED)


def test_a_tripped_bus_watchdog_is_a_fault_and_the_next_run_clears_it() -> None:
    rig = rig_of("xl330")
    here = arm(rig)
    rig.stream(0.1, here)
    rig.servos[2].set("bus_watchdog", -1)
    rig.stream(0.08, here)
    event = fault_of(rig)
    assert (event.code, event.joint, event.detail) == (Fault.SERVO, 3, ServoTrouble.BUS_WATCHDOG)
    rig.bench.fresh()
    here = rig.bench.arm()
    rig.stream(0.1, here)
    assert rig.board.mode is Mode.ARMED


@both
@pytest.mark.parametrize("harm", [let_go, restart])
def test_a_trouble_of_having_power_is_over_when_there_is_none(model: str, harm: object) -> None:
    """Who clears the fault and arms at once is not refused for what was wrong before."""
    rig = rig_of(model)
    here = arm(rig)
    rig.stream(0.2, here)
    harm(rig.servos[2])  # type: ignore[operator]
    for _ in range(50):
        rig.stream(0.01, here)
        if rig.board.mode is Mode.FAULT:
            break
    plant = rig.plant
    assert plant.fault() is not None
    for number in range(1, 6):
        plant.set_joint_mode(number, "free")
    plant.advance(1e3)
    assert plant.fault() is None


@both
def test_a_board_with_an_ill_servo_is_not_armed(model: str) -> None:
    rig = rig_of(model)
    rig.bench.fresh()
    rig.bench.listen(0.3)
    rig.servos[1].temperature_c = 90.0
    rig.bench.listen(0.3)
    rig.bench.go(Mode.ARMED)
    assert rig.board.mode is not Mode.ARMED
    assert not any(servo.driving for servo in rig.servos)


def test_a_joint_that_is_turned_beyond_its_limit_gets_no_power() -> None:
    robot = bench(limits={"angle_deg": 40})
    bus = emulated("sts3215", robot=robot, start_rad=AT)
    rig = Rig(bus, robot)
    rig.bench.fresh()
    assert bus.chain is not None
    bus.chain._zero[2] += 700  # by hand: 61 deg
    rig.bench.listen(0.3)
    rig.bench.heard.clear()
    rig.bench.go(Mode.ARMED)
    assert rig.board.mode is not Mode.ARMED
    fault = rig.plant.fault()
    assert fault is not None
    assert words(fault) == "joint 3: stands at 67.2 deg, beyond its limit: turn it back by hand"


@both
def test_a_line_that_is_cut_while_the_host_listens_is_a_lost_board(model: str) -> None:
    """Not the fault that the board tells of it: whoever notices first, the run ends in one way."""
    rig = rig_of(model)
    here = arm(rig)
    rig.stream(0.2, here)
    rig.bench.heard.clear()
    rig.line.cut = True
    with pytest.raises(LostBoardError, match="the line was lost"):
        rig.bench.listen(0.5)
    assert not [message for message in rig.bench.heard if isinstance(message, FaultEvent)]


@both
def test_a_line_that_is_cut_ends_the_run_and_is_told(model: str) -> None:
    rig = rig_of(model)
    here = arm(rig)
    rig.stream(0.2, here)
    rig.line.cut = True
    with pytest.raises(LostBoardError, match=r"the line was lost: .* check adapter, cable and supply"):
        rig.stream(0.2, here)
    rig.link.close()
    for _ in range(200):
        rig.clock.sleep_until(rig.clock.now_s() + 0.005)
        rig.bus.advance(rig.clock.now_s())
    if model == "xl330":
        assert {s.get("bus_watchdog") for s in rig.servos} == {-1}, "the servos have stopped by themselves"
    assert all(servo.driving for servo in rig.servos), "they hold: nobody can tell them otherwise"


def test_telemetry_comes_once_a_second() -> None:
    rig = rig_of("xl430")
    rig.stream(0.2, arm(rig))
    rig.servos[3].held_load = 0.5
    rig.servos[3].temperature_c = 41.0
    rig.bench.heard.clear()
    rig.stream(1.2, AT)
    supply = rig.bench.wait(Supply, 1.5)
    joints = {m.joint: m for m in rig.bench.heard if isinstance(m, JointSupply)}
    assert supply.voltage_v == pytest.approx(12.0)
    assert joints[4].temperature_c == pytest.approx(41.0)
    assert joints[4].current_a == pytest.approx(0.5 * MODELS["xl430"].stall_current_a, rel=0.01)
