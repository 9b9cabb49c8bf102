"""What the wire alone cannot show: hardware faults, supplies, lost encoders, stored parameters, stalls."""

from __future__ import annotations

import ctypes
import itertools
import math
from dataclasses import astuple
from typing import Any

import pytest
from core_bench import CoreBench

from firmware_protocol.assembly import setpoint_messages
from firmware_protocol.catalogue import (
    NO_READING,
    Acknowledge,
    Applied,
    BoardHeartbeat,
    ClearRequest,
    Counters,
    EmergencyStop,
    Fault,
    FaultEvent,
    JointMode,
    JointModeRequest,
    JointSupply,
    Measured,
    Message,
    Mode,
    ModeRequest,
    Ping,
    Pong,
    Result,
    State,
    Supply,
    TrimRequest,
    ZeroRequest,
    decode,
    encode,
)
from firmware_protocol.frame import Frame
from firmware_protocol.framing import pack_all

HOST = 7


class Hands:
    """A core on the bench, and a host's hands."""

    def __init__(self, library: Any, joints: int = 5, **more: Any) -> None:
        self.core = CoreBench(library, joints, **more)
        self.library = library
        self.t_s = 0.0
        self.pass_time(0.0)

    def pass_time(self, by_s: float) -> list[Message]:
        self.t_s += by_s
        self.core.step(self.t_s)
        self.library.bench_step()
        return [decode(frame) for frame in self.core.said()]

    def say(self, *messages: Message) -> list[Message]:
        self.core.serial(pack_all([encode(message) for message in messages]))
        return [decode(frame) for frame in self.core.said()]

    def go(self, mode: Mode) -> Result:
        (answer,) = (m for m in self.say(ModeRequest(1, mode, HOST)) if isinstance(m, Acknowledge))
        return answer.result

    def clear(self) -> Result:
        """Clear the latch that the board reports with its next heartbeat."""
        number = kinds(self.pass_time(0.11), FaultEvent)[-1].number
        (answer,) = (m for m in self.say(ClearRequest(2, number, HOST)) if isinstance(m, Acknowledge))
        return answer.result

    def mode(self) -> Mode:
        return Mode(self.library.bench_mode())

    def fault(self, code: Fault, joint: int = 0, detail: int = 0) -> list[Message]:
        self.library.simulated_joints_fault(int(code), joint, detail)
        return self.pass_time(0.0)

    def powered(self) -> list[bool]:
        return [not math.isnan(self.core.target_rad(joint)) for joint in range(1, self.core.joints + 1)]


def kinds(said: list[Message], kind: type) -> list[Any]:
    return [message for message in said if isinstance(message, kind)]


@pytest.mark.parametrize("code", [Fault.SERVO, Fault.OVERCURRENT, Fault.UNDERVOLTAGE])
def test_a_hardware_fault_freezes_then_relaxes(bench_library: Any, code: Fault) -> None:
    hands = Hands(bench_library)
    hands.go(Mode.ARMED)
    (event,) = kinds(hands.fault(code, 3, -12), FaultEvent)
    assert (event.code, event.joint, event.detail) == (code, 3, -12)
    assert hands.mode() is Mode.FAULT
    assert all(hands.powered())
    assert not kinds(hands.fault(code, 3, -12), FaultEvent), (
        "it is sent when it is entered, and with heartbeats"
    )
    hands.pass_time(2.001)
    assert not any(hands.powered())
    hands.fault(Fault.NONE)
    assert hands.clear() is Result.OK


def test_a_hardware_fault_of_a_disarmed_board_keeps_it_without_power(bench_library: Any) -> None:
    hands = Hands(bench_library)
    hands.fault(Fault.OVERTEMPERATURE)
    assert hands.mode() is Mode.DISARMED
    assert hands.go(Mode.ARMED) is Result.FAULTY
    hands.pass_time(0.0)
    assert hands.mode() is Mode.DISARMED
    assert not any(hands.powered()), "it still is too hot"
    hands.fault(Fault.NONE)
    assert hands.go(Mode.ARMED) is Result.OK


@pytest.mark.parametrize("mode", [Mode.DISARMED, Mode.ARMED, Mode.HOLDING])
def test_the_button_stops_from_any_mode_and_as_long_as_it_is_pressed(bench_library: Any, mode: Mode) -> None:
    hands = Hands(bench_library)
    if mode is not Mode.DISARMED:
        hands.go(Mode.ARMED)
        hands.go(mode)
    (event,) = kinds(hands.fault(Fault.EMERGENCY_STOP), FaultEvent)
    assert event.code is Fault.EMERGENCY_STOP
    assert hands.mode() is Mode.STOPPED
    assert not any(hands.powered())
    assert hands.clear() is Result.OK
    hands.pass_time(0.0)
    assert hands.mode() is Mode.STOPPED
    hands.fault(Fault.NONE)
    assert hands.clear() is Result.OK
    hands.pass_time(0.0)
    assert hands.mode() is Mode.DISARMED


def test_pressing_the_button_again_is_a_stop_of_its_own(bench_library: Any) -> None:
    hands = Hands(bench_library)
    (first,) = kinds(hands.fault(Fault.EMERGENCY_STOP), FaultEvent)
    hands.fault(Fault.NONE)
    (second,) = kinds(hands.fault(Fault.EMERGENCY_STOP), FaultEvent)
    assert (second.number, second.board_time_us) == (first.number + 1, first.board_time_us)
    hands.fault(Fault.NONE)
    hands.say(ClearRequest(3, first.number, HOST))
    assert hands.mode() is Mode.STOPPED


def test_a_stored_trim_that_no_request_can_set_is_none(bench_library: Any) -> None:
    hands = Hands(bench_library)
    hands.say(TrimRequest(1, 1, 0.3, HOST), TrimRequest(2, 2, -0.3, HOST))
    bench_library.bench_stored_trim.restype = ctypes.c_int16
    assert [bench_library.bench_stored_trim(joint) for joint in (0, 1)] == [3000, -3000]
    for joint, steps in ((0, 3001), (2, -32768)):
        bench_library.bench_store_trim(joint, ctypes.c_int16(steps))
    hands.core.reset()
    hands.go(Mode.ARMED)
    for joint, trim_rad in ((1, 0.0), (2, -0.3), (3, 0.0)):
        assert hands.core.target_rad(joint) == pytest.approx(trim_rad, abs=1e-5)


def test_supplies_are_reported_once_a_second_where_they_are_measured(bench_library: Any) -> None:
    hands = Hands(bench_library)
    assert not kinds(hands.pass_time(2.0), Supply)
    bench_library.simulated_joints_supply(True, 7412, -350, 251)
    said = hands.pass_time(2.0)
    assert [astuple(supply) for supply in kinds(said, Supply)] == [pytest.approx((7.412, -0.35, 25.1))] * 2
    assert [m.joint for m in kinds(said, JointSupply)] == [1, 2, 3, 4, 5] * 2


def test_an_encoder_without_reading(bench_library: Any) -> None:
    hands = Hands(bench_library)
    hands.core.place(2, 0.3)
    hands.pass_time(0.1)
    bench_library.simulated_joints_encoder_lost(1, True)
    hands.core.place(2, 0.9)
    said = hands.pass_time(0.1)
    assert kinds(said, Measured)[0].second_counts == NO_READING
    assert kinds(said, Applied)[0].second_rad == pytest.approx(0.3, abs=8e-4), "where it was read last"


def test_a_joint_that_has_never_been_read_gets_no_power(bench_library: Any) -> None:
    hands = Hands(bench_library)
    hands.core.place(2, 0.9)
    bench_library.simulated_joints_encoder_lost(1, True)
    hands.core.reset()
    hands.go(Mode.ARMED)
    assert hands.powered() == [True, False, True, True, True]
    bench_library.simulated_joints_encoder_lost(1, False)
    hands.say(JointModeRequest(2, 2, JointMode.ACTIVE, 0.0, HOST))
    assert all(hands.powered())
    assert hands.core.target_rad(2) == pytest.approx(0.9, abs=8e-4), "it starts where it is"


def test_counts_beyond_16_bits_and_angles_beyond_the_wire(bench_library: Any) -> None:
    hands = Hands(bench_library, 1, counts_per_rev=65535)
    hands.core.place(1, -7.0)
    said = hands.pass_time(0.1)
    assert kinds(said, Measured)[0].first_counts == NO_READING
    assert kinds(said, Applied)[0].first_rad == pytest.approx(-3.2767)


def test_trims_and_zeros_are_stored_when_they_change_and_kept_over_a_reset(bench_library: Any) -> None:
    hands = Hands(bench_library)
    for _ in range(3):
        hands.say(TrimRequest(1, 2, 0.05, HOST), ZeroRequest(2, 3, 77, HOST))
    assert bench_library.bench_saves() == 2, "flash wears out"
    hands.core.reset()
    said = hands.pass_time(0.1)
    assert kinds(said, Measured)[0].third_counts == -77
    hands.go(Mode.ARMED)
    assert hands.core.target_rad(2) == pytest.approx(0.05, abs=1e-4)
    assert hands.core.target_rad(3) == pytest.approx(-77 * 2 * math.pi / 8192, abs=1e-4)


def test_a_reset_takes_the_power(bench_library: Any) -> None:
    hands = Hands(bench_library)
    hands.go(Mode.ARMED)
    hands.core.reset()
    assert not any(hands.powered())
    assert hands.mode() is Mode.DISARMED


def test_boot_ids_are_never_zero_and_never_the_one_before(bench_library: Any) -> None:
    hands = Hands(bench_library)
    seen = []
    for _ in range(300):
        hands.core.reset()
        seen += [m.boot_id for m in kinds(hands.pass_time(0.1), BoardHeartbeat)][-1:]
    assert 0 not in seen
    assert all(a != b for a, b in itertools.pairwise(seen))
    assert len(set(seen)) > 280


def test_a_free_joint_has_no_pulses(bench_library: Any) -> None:
    hands = Hands(bench_library)
    hands.say(JointModeRequest(1, 4, JointMode.FREE, 0.0, HOST))
    hands.go(Mode.ARMED)
    assert hands.powered() == [True, True, True, False, True]
    hands.core.place(4, -0.4)
    hands.pass_time(0.01)
    hands.say(JointModeRequest(2, 4, JointMode.ACTIVE, 0.0, HOST))
    assert hands.core.target_rad(4) == pytest.approx(-0.4, abs=8e-4), "it starts where it is"


def test_both_carriers_are_heard_and_hear(bench_library: Any) -> None:
    hands = Hands(bench_library)
    before = bench_library.bench_can_sent()
    hands.core.can([encode(Ping(5))])
    assert [m.nonce for m in kinds([decode(f) for f in hands.core.said()], Pong)] == [5]
    assert bench_library.bench_can_sent() == before + 1
    hands.core.can([Frame(1, b"")])
    assert hands.mode() is Mode.STOPPED


def test_a_processor_that_was_elsewhere_for_long_does_not_make_up_for_it(bench_library: Any) -> None:
    """Ten seconds without a turn of the main loop: the watchdog has gone first, and the beats start again."""
    hands = Hands(bench_library)
    hands.go(Mode.ARMED)
    bench_library.bench_time(10_000_000)
    hands.core.serial(pack_all([encode(message) for message in setpoint_messages(1, [0.5] * 5, 0.01)]))
    said = [decode(frame) for frame in hands.core.said()]
    assert kinds(said, FaultEvent)[0].board_time_us == 100_000
    assert hands.mode() is Mode.FAULT
    assert not any(hands.powered()), "more than 2 s after the fault"
    assert not [m for m in kinds(said, State) if m.sequence == 1]
    assert len(kinds(said, BoardHeartbeat)) <= 2
    assert len(kinds(said, Counters)) <= 2


def test_sixteen_joints_and_everything_at_once_fit_into_the_output(bench_library: Any) -> None:
    hands = Hands(bench_library, 16)
    bench_library.simulated_joints_supply(True, 7400, 100, 250)
    hands.say(EmergencyStop())
    said = hands.pass_time(1.0)
    assert len(kinds(said, JointSupply)) == 16
    assert len(kinds(said, Applied)) == 6 * 10


def test_a_flood_is_taken_in_bounded_turns(bench_library: Any) -> None:
    hands = Hands(bench_library)
    pings = pack_all([encode(Ping(number)) for number in range(100)])
    bench_library.bench_serial(pings, len(pings))
    hands.library.bench_step()
    said = [decode(frame) for frame in hands.core.said()]
    assert [m.nonce for m in kinds(said, Pong)] == list(range(100))
    for number in range(100):
        frame = encode(Ping(number))
        bench_library.bench_can(frame.id, frame.data, len(frame.data))
    hands.library.bench_step()
    assert len(kinds([decode(frame) for frame in hands.core.said()], Pong)) == 100
