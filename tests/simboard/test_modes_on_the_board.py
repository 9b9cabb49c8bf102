"""Every row of the table of modes in PROTOCOL.md, who may ask, and what the watchdog does when."""

from __future__ import annotations

import itertools

import pytest
from board_rig import HOST, OTHER, Rig

from firmware_protocol.catalogue import (
    NOBODY,
    BoardHeartbeat,
    Fault,
    FaultEvent,
    HostHeartbeat,
    InfoRequest,
    InfoSerial,
    Mode,
    Ping,
    Pong,
    Result,
)
from firmware_protocol.frame import Frame

ALLOWED = {
    (Mode.DISARMED, Mode.ARMED),
    (Mode.ARMED, Mode.HOLDING),
    (Mode.ARMED, Mode.DISARMED),
    (Mode.HOLDING, Mode.ARMED),
    (Mode.HOLDING, Mode.DISARMED),
    (Mode.STOPPED, Mode.DISARMED),
    (Mode.FAULT, Mode.DISARMED),
}


@pytest.mark.parametrize(("start", "wanted"), list(itertools.product(Mode, Mode)))
def test_table_of_transitions(start: Mode, wanted: Mode) -> None:
    rig = Rig()
    rig.enter(start)
    answer = rig.go(wanted)
    if wanted in (Mode.STOPPED, Mode.FAULT):
        assert (answer.result, answer.detail) == (Result.BAD_VALUE, 0)
        assert rig.board.mode is start
    elif wanted is start or (start, wanted) in ALLOWED:
        assert (answer.result, answer.detail) == (Result.OK, wanted)
        assert rig.board.mode is wanted
    else:
        assert (answer.result, answer.detail) == (Result.FORBIDDEN, start)
        assert rig.board.mode is start


@pytest.mark.parametrize(("start", "wanted"), list(itertools.product(Mode, Mode)))
def test_another_host_is_answered_held_while_armed_or_holding(start: Mode, wanted: Mode) -> None:
    rig = Rig()
    rig.enter(start)
    answer = rig.go(wanted, OTHER)
    if start in (Mode.ARMED, Mode.HOLDING):
        assert (answer.result, answer.detail) == (Result.HELD, HOST)
        assert rig.board.mode is start
    else:
        assert answer.result is not Result.HELD


@pytest.mark.parametrize("start", Mode)
def test_emergency_stop_from_every_mode_with_any_payload(start: Mode) -> None:
    for payload in (b"", b"\xff", b"\x00" * 5, b"\xff" * 8):
        rig = Rig()
        rig.enter(start)
        rig.board.receive(Frame(1, payload), rig.now_s)
        event = rig.one(rig.advance(0.0), FaultEvent)
        assert event.code is Fault.EMERGENCY_STOP
        assert rig.board.mode is Mode.STOPPED
        assert set(rig.plant.modes) == {"free"}


def test_stopped_lasts_until_anyone_disarms() -> None:
    rig = Rig()
    rig.enter(Mode.ARMED)
    rig.stop()
    rig.advance(60.0)
    assert rig.board.mode is Mode.STOPPED
    assert rig.go(Mode.DISARMED, OTHER).result is Result.OK
    beat = [m for m in rig.advance(0.1) if isinstance(m, BoardHeartbeat)][-1]
    assert (beat.mode, beat.fault, beat.holder, beat.powered) == (Mode.DISARMED, Fault.NONE, NOBODY, 0)


def test_host_zero_cannot_arm() -> None:
    rig = Rig()
    answer = rig.go(Mode.ARMED, NOBODY)
    assert (answer.result, answer.detail) == (Result.BAD_VALUE, 0)
    assert rig.board.mode is Mode.DISARMED


def test_holder_stands_in_the_heartbeat_until_disarmed() -> None:
    rig = Rig()
    rig.advance(0.05)
    for mode, holder in ((Mode.ARMED, HOST), (Mode.HOLDING, HOST), (Mode.DISARMED, NOBODY)):
        rig.go(mode)
        beat = [m for m in rig.advance(0.0999) if isinstance(m, BoardHeartbeat)][-1]
        assert (beat.mode, beat.holder) == (mode, holder)
        assert beat.powered == (mode is not Mode.DISARMED)
        assert beat.simulated == 1


def test_everyone_may_ping_and_ask_while_another_holds() -> None:
    rig = Rig()
    rig.enter(Mode.ARMED)
    assert rig.one(rig.say(Ping(77)), Pong).nonce == 77
    assert rig.one(rig.say(InfoRequest(OTHER)), InfoSerial).serial_number == 1


def test_armed_without_a_setpoint_faults_after_100_ms() -> None:
    rig = Rig()
    rig.advance(0.03)  # away from the heartbeats
    rig.go(Mode.ARMED)
    rig.advance(0.0999)
    assert rig.board.mode is Mode.ARMED
    event = rig.one(rig.advance(0.0002), FaultEvent)
    assert event.code is Fault.WATCHDOG
    assert event.board_time_us == pytest.approx(130_000, abs=2)
    assert rig.board.mode is Mode.FAULT


def test_setpoints_feed_the_watchdog_and_heartbeats_do_not() -> None:
    rig = Rig()
    rig.go(Mode.ARMED)
    rig.stream(0.5)
    assert rig.board.mode is Mode.ARMED
    for _ in range(10):
        rig.advance(0.0099)
        rig.say(HostHeartbeat(HOST, 1))
    assert rig.board.mode is Mode.ARMED
    rig.advance(0.0011)
    assert rig.board.mode is Mode.FAULT


def test_fault_freezes_then_relaxes_after_two_seconds_and_stays_latched() -> None:
    rig = Rig()
    rig.go(Mode.ARMED)
    rig.stream(0.3, [0.01, -0.01, 0.0, 0.02, 0.0])
    frozen = rig.plant.commands[-1]
    rig.advance(0.100)
    assert rig.board.mode is Mode.FAULT
    rig.tick([0.5] * 5)  # comes too late: it is dropped
    rig.advance(1.9999)
    assert set(rig.plant.modes) == {"active"}
    assert rig.plant.commands[-1] == frozen
    rig.advance(0.0002)
    assert set(rig.plant.modes) == {"free"}
    rig.advance(10.0)
    assert rig.board.mode is Mode.FAULT
    rig.tick([0.0] * 5)
    assert rig.board.mode is Mode.FAULT
    assert rig.go(Mode.ARMED).result is Result.FORBIDDEN
    assert rig.go(Mode.DISARMED).result is Result.OK


def test_timers_run_out_at_their_time_even_when_nobody_looked() -> None:
    rig = Rig()
    rig.go(Mode.ARMED)
    said = rig.advance(3.0)
    assert rig.plant.changes[-1] == (pytest.approx(2.1, abs=1e-6), 5, "free")
    event = next(m for m in said if isinstance(m, FaultEvent))
    assert event.board_time_us == pytest.approx(100_000, abs=2)


def test_a_late_setpoint_cannot_outrun_the_watchdog() -> None:
    """The host stalls for 150 ms: the board has frozen meanwhile, though nobody asked it."""
    rig = Rig()
    rig.advance(0.03)
    rig.go(Mode.ARMED)
    rig.stream(0.2)
    rig.now_s += 0.150
    said = rig.tick([0.0] * 5)
    assert rig.one(said, FaultEvent).code is Fault.WATCHDOG
    assert rig.board.mode is Mode.FAULT


def test_holding_needs_the_holders_heartbeat_within_a_second() -> None:
    rig = Rig()
    rig.enter(Mode.HOLDING)
    for _ in range(30):
        rig.advance(0.1)
        rig.say(HostHeartbeat(HOST, 0))
    assert rig.board.mode is Mode.HOLDING
    for _ in range(9):
        rig.advance(0.1)
        rig.say(HostHeartbeat(OTHER, 0))
    assert rig.board.mode is Mode.HOLDING
    rig.advance(0.1001)
    assert rig.board.mode is Mode.FAULT
    assert rig.board.next_event_s < rig.now_s + 0.1


def test_holding_drops_setpoints_and_resumes_from_where_it_froze() -> None:
    rig = Rig()
    rig.go(Mode.ARMED)
    rig.stream(0.3, [0.02] * 5)
    rig.go(Mode.HOLDING)
    held = rig.plant.commands[-1][1]
    rig.stream(0.3, [0.5] * 5)
    assert rig.plant.commands[-1][1] == held
    assert rig.go(Mode.ARMED).result is Result.OK
    rig.advance(0.09)
    assert rig.board.mode is Mode.ARMED
    rig.sequence -= 1000  # the first one after arming is always newer
    rig.tick([0.02] * 5)
    assert rig.board.mode is Mode.ARMED
    assert rig.plant.commands[-1][1] == pytest.approx(held, abs=1e-4)


def test_fault_event_comes_with_every_heartbeat_until_cleared() -> None:
    rig = Rig()
    rig.enter(Mode.FAULT)
    said = rig.advance(1.0)
    beats = [m for m in said if isinstance(m, BoardHeartbeat)]
    events = [m for m in said if isinstance(m, FaultEvent)]
    assert len(beats) == len(events) == 10
    assert all(beat.fault is Fault.WATCHDOG for beat in beats)
    assert len({event.board_time_us for event in events}) == 1
    rig.go(Mode.DISARMED)
    assert not [m for m in rig.advance(1.0) if isinstance(m, FaultEvent)]


def test_fault_of_the_hardware_freezes_and_relaxes_like_the_watchdog() -> None:
    rig = Rig()
    rig.go(Mode.ARMED)
    rig.board.fail(Fault.OVERCURRENT, rig.now_s)
    assert rig.one(rig.advance(0.0), FaultEvent).code is Fault.OVERCURRENT
    assert set(rig.plant.modes) == {"active"}
    rig.advance(2.0001)
    assert set(rig.plant.modes) == {"free"}


def test_two_hosts_one_after_the_other() -> None:
    rig = Rig()
    rig.go(Mode.ARMED, HOST)
    assert rig.go(Mode.ARMED, OTHER).result is Result.HELD
    assert rig.go(Mode.DISARMED, OTHER).result is Result.HELD
    assert rig.go(Mode.DISARMED, HOST).result is Result.OK
    assert rig.go(Mode.ARMED, OTHER).result is Result.OK
    answer = rig.go(Mode.HOLDING, HOST)
    assert (answer.result, answer.detail) == (Result.HELD, OTHER)
    rig.stop()
    assert rig.go(Mode.DISARMED, HOST).result is Result.OK
