"""Modes and timers where the conformance suite cannot look: long times, jumps in time, a reset of broken hardware."""

from __future__ import annotations

import pytest
from board_rig import HOST, OTHER, Rig

from firmware_protocol.catalogue import (
    NOBODY,
    BoardHeartbeat,
    Fault,
    FaultEvent,
    InfoFirmware,
    InfoRequest,
    Mode,
    Result,
    State,
)
from snakebot.softboard.hardware import HardwareFault


def test_stopped_lasts_until_anyone_clears_it() -> None:
    rig = Rig()
    rig.enter(Mode.ARMED)
    rig.stop()
    rig.advance(60.0)
    assert rig.mode() is Mode.STOPPED
    assert rig.go(Mode.DISARMED, OTHER).result is Result.FORBIDDEN
    assert rig.clear(OTHER).result is Result.OK
    beat = [m for m in rig.advance(0.1) if isinstance(m, BoardHeartbeat)][-1]
    assert (beat.mode, beat.fault, beat.holder, beat.powered) == (Mode.DISARMED, Fault.NONE, NOBODY, 0)


def test_timers_run_out_at_their_time_even_when_nobody_looked() -> None:
    rig = Rig()
    rig.go(Mode.ARMED)
    said = rig.advance(3.0)
    changed_s, *changed = rig.plant.changes[-1]
    assert changed_s == pytest.approx(2.1, abs=1e-6)
    assert changed == [5, "free"]
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
    assert rig.mode() is Mode.FAULT


@pytest.mark.parametrize("watchdog_ms", [20, 100, 250])
def test_the_watchdog_waits_as_long_as_the_board_reports(watchdog_ms: int) -> None:
    rig = Rig(watchdog_ms=watchdog_ms)
    assert rig.one(rig.say(InfoRequest(HOST)), InfoFirmware).watchdog_ms == watchdog_ms
    rig.go(Mode.ARMED)
    rig.stream(0.5)
    said = rig.advance(watchdog_ms * 1e-3 - 0.001)
    assert rig.mode() is Mode.ARMED
    assert not [message for message in said if isinstance(message, State)]
    said = rig.advance(0.002)
    assert rig.mode() is Mode.FAULT
    assert rig.one(said, FaultEvent).code is Fault.WATCHDOG
    assert [message for message in said if isinstance(message, State)]  # samples unasked begin


def test_hardware_that_stays_broken_gets_no_power() -> None:
    rig = Rig()
    rig.board.fail(HardwareFault(Fault.SERVO), rig.now_s)
    rig.board.reset(rig.now_s)
    answer = rig.go(Mode.ARMED)
    assert (answer.result, answer.mode, answer.detail) == (Result.FAULTY, Mode.DISARMED, Fault.SERVO)
    rig.advance(1.0)
    assert not [change for change in rig.plant.changes if change[2] == "active"]
    rig.board.fail(HardwareFault(Fault.NONE), rig.now_s)
    assert rig.go(Mode.ARMED).result is Result.OK
