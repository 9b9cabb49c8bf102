"""The watchdog: armed, holding, latched; freeze, then relax. Times are read from the board's own clock."""

from __future__ import annotations

from firmware_protocol.catalogue import (
    BoardHeartbeat,
    Fault,
    FaultEvent,
    HostHeartbeat,
    Mode,
    Result,
    State,
)
from snakebot.conformance.bench import Bench, passed_us
from snakebot.conformance.case import case
from snakebot.conformance.violations import expect

_WATCHDOG_US = 100_000  # 100 ms (PROTOCOL.md)
_EARLY_US = 200  # rounding of a clock
_LATE_US = 5_000  # a main loop that looks every few milliseconds


def in_time(passed: int, wanted: int, what: str) -> None:
    """Raise unless so many microseconds are as many as wanted, to what a clock and a main loop may blur."""
    expect(
        wanted - _EARLY_US <= passed <= wanted + _LATE_US,
        f"{what} came after {passed / 1e3:.1f} ms of the board's clock, not {wanted / 1e3:.0f}",
    )


@case("Armed and no set-point for 100 ms: fault, code watchdog, FaultEvent at once.")
def faults_without_a_setpoint(bench: Bench) -> None:
    bench.sample()
    before = bench.ping().board_time_us
    sent_s = bench.clock.now_s()
    bench.must_go(Mode.ARMED)
    after = bench.ping().board_time_us
    event = bench.wait(FaultEvent, code=Fault.WATCHDOG)
    heard_s = bench.clock.now_s() - sent_s
    expect(
        passed_us(event.board_time_us, before) >= _WATCHDOG_US - _EARLY_US
        and passed_us(event.board_time_us, after) <= _WATCHDOG_US + _LATE_US,
        f"armed between {before} and {after} us, the fault is dated {event.board_time_us} us: not 100 ms later",
    )
    late_s = heard_s - 0.1
    expect(
        late_s <= 3 * bench.tolerance_s + _LATE_US * 1e-6, f"FaultEvent was heard {1e3 * late_s:.0f} ms late"
    )
    expect(bench.beat().mode is Mode.FAULT, "the heartbeat does not say fault")


@case("Set-points feed the watchdog: the fault comes 100 ms after the last one that was executed.")
def setpoints_feed_it(bench: Bench) -> None:
    here = bench.arm()
    bench.stream(0.35, lambda t: here)
    event = bench.wait(FaultEvent, code=Fault.WATCHDOG)
    last = [m for m in bench.heard if isinstance(m, State) and m.mode is Mode.ARMED][-1]
    in_time(passed_us(event.board_time_us, last.board_time_us), _WATCHDOG_US, "the fault")


@case("Heartbeats, pings and stale set-points do not feed the watchdog of an armed board.")
def nothing_else_feeds_it(bench: Bench) -> None:
    here = bench.arm()
    sample = bench.executed(here, "the first one after arming")
    last = sample.state.board_time_us
    for number in range(40):
        bench.send(HostHeartbeat(bench.host, number))
        bench.tick(here, step=0)
        bench.ping()
        events = [m for m in bench.heard if isinstance(m, FaultEvent)]
        if events:
            in_time(passed_us(events[0].board_time_us, last), _WATCHDOG_US, "the fault")
            return
        bench.listen(0.005)
    expect(False, "stale set-points, heartbeats or pings kept an armed board from its fault")


@case("Fault: frozen for 2 s, then without power; latched until somebody clears it.")
def freezes_then_relaxes(bench: Bench) -> None:
    here = bench.arm()
    bench.stream(0.1, lambda t: here)
    event = bench.wait(FaultEvent, code=Fault.WATCHDOG)
    since_s = bench.clock.now_s()
    bench.samples.clear()
    frozen = bench.sample().applied_rad
    bench.tick([angle + 0.02 for angle in here])
    powered_until_s = relaxed_s = None
    while relaxed_s is None:
        beat = bench.beat()
        at_s = bench.clock.now_s() - since_s
        if beat.powered:
            powered_until_s = at_s
            expect(
                at_s < 2.0 + 3 * bench.tolerance_s + 0.02,
                f"the servos have power {at_s:.2f} s after the fault",
            )
            expect(bench.samples[-1].applied_rad == frozen, "the register moved while it was frozen")
        else:
            relaxed_s = at_s
        expect(beat.mode is Mode.FAULT and beat.fault is Fault.WATCHDOG, f"the fault is not latched: {beat}")
    expect(powered_until_s is not None, "the servos lost power at once: a fault freezes for 2 s first")
    expect(
        relaxed_s > 2.0 - 2 * bench.tolerance_s,
        f"the servos lost power {relaxed_s:.2f} s after the fault, not 2 s",
    )
    answer = bench.go(Mode.ARMED)
    expect(
        (answer.result, answer.mode) == (Result.FORBIDDEN, Mode.FAULT),
        f"armed was requested in fault and answered {answer.result.name.lower()}",
    )
    events = [m for m in bench.heard if isinstance(m, FaultEvent)]
    beats = [m for m in bench.heard if isinstance(m, BoardHeartbeat) and m.mode is Mode.FAULT]
    expect(abs(len(events) - len(beats)) <= 2, f"{len(events)} FaultEvents with {len(beats)} heartbeats")
    expect(
        {e.board_time_us for e in events} == {event.board_time_us}, "the fault's time is the one of its entry"
    )
    answer = bench.go(Mode.DISARMED)
    expect(answer.result is Result.FORBIDDEN, f"disarmed was requested in fault and answered {answer}")
    expect(bench.beat().fault is Fault.WATCHDOG, "a request to disarm cleared the fault")
    bench.clear(event.number, bench.other)
    expect(bench.beat().fault is Fault.NONE, "the fault was not cleared")


@case("Holding: the holder's heartbeat keeps it, another host's does not; after 1 s without it: fault.")
def holding_needs_its_holder(bench: Bench) -> None:
    bench.arm()
    bench.must_go(Mode.HOLDING)
    bench.hold_heartbeat(1.3, bench.host)
    expect(bench.beat().mode is Mode.HOLDING, "the holder's heartbeat did not keep the board holding")
    before = bench.ping().board_time_us
    bench.send(HostHeartbeat(bench.host, 99))
    after = bench.ping().board_time_us
    bench.hold_heartbeat(0.9, bench.other)
    event = bench.wait(FaultEvent, 0.4, code=Fault.WATCHDOG)
    expect(
        passed_us(event.board_time_us, before) >= 1_000_000 - _EARLY_US
        and passed_us(event.board_time_us, after) <= 1_000_000 + _LATE_US,
        f"the last heartbeat came between {before} and {after} us, the fault is dated {event.board_time_us} us",
    )


@case("Holding freezes the set-points; armed after it goes on from there, with a new watchdog.")
def holding_freezes(bench: Bench) -> None:
    here = bench.arm()
    bench.stream(0.1, lambda t: here)
    bench.must_go(Mode.HOLDING)
    bench.samples.clear()
    held = bench.sample().applied_rad
    bench.tick([angle + 0.02 for angle in here])
    bench.samples.clear()
    expect(bench.sample().applied_rad == held, "a set-point moved a holding board")
    bench.must_go(Mode.ARMED)
    bench.sequence -= 1000  # the first one after arming is always newer
    sample = bench.executed(list(held), "the first one after holding")
    off = max(abs(a - b) for a, b in zip(sample.applied_rad, held, strict=True))
    expect(off < 2e-4, f"the register jumped by {off:.4f} rad after holding")
