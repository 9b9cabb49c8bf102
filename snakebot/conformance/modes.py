"""Modes and who may change them; the emergency stop, from anyone, always."""

from __future__ import annotations

import itertools

from firmware_protocol.catalogue import (
    NOBODY,
    Acknowledge,
    BoardHeartbeat,
    EmergencyStop,
    Fault,
    FaultEvent,
    InfoRequest,
    InfoSerial,
    Mode,
    ModeRequest,
    Result,
    frame_id,
)
from firmware_protocol.frame import Frame
from snakebot.conformance.bench import Bench, growth
from snakebot.conformance.case import case
from snakebot.conformance.violations import expect

ALLOWED = {
    (Mode.DISARMED, Mode.ARMED),
    (Mode.ARMED, Mode.HOLDING),
    (Mode.ARMED, Mode.DISARMED),
    (Mode.HOLDING, Mode.ARMED),
    (Mode.HOLDING, Mode.DISARMED),
}


def _wanted(start: Mode, wanted: Mode) -> tuple[Result, Mode]:
    """The result, and the mode after it."""
    if wanted in (Mode.STOPPED, Mode.FAULT):
        return Result.BAD_VALUE, start
    if wanted is start or (start, wanted) in ALLOWED:
        return Result.OK, wanted
    return Result.FORBIDDEN, start


@case("Every transition of the table is answered ok, every other one forbidden, stopped and fault bad_value.")
def keeps_the_table_of_modes(bench: Bench) -> None:
    for start, wanted in itertools.product(Mode, Mode):
        bench.fresh()
        bench.enter(start)
        answer = bench.go(wanted)
        result, mode = _wanted(start, wanted)
        expect(
            (answer.result, answer.mode, answer.detail) == (result, mode, 0),
            f"{start.name.lower()} to {wanted.name.lower()} was answered {answer.result.name.lower()} "
            f"(mode {answer.mode.name.lower()}, detail {answer.detail}), "
            f"not {result.name.lower()} (mode {mode.name.lower()}, detail 0)",
        )


@case("The holder stands in the heartbeat; other hosts' requests are answered held.")
def is_held_by_one(bench: Bench) -> None:
    bench.must_go(Mode.ARMED)
    bench.must_go(Mode.HOLDING)
    beat = bench.beat()
    expect(beat.holder == bench.host, f"the heartbeat names holder {beat.holder:08x}, not {bench.host:08x}")
    expect(beat.powered == 1, "a holding board has power for its servos")
    for mode in Mode:
        answer = bench.go(mode, bench.other)
        expect(
            (answer.result, answer.mode) == (Result.HELD, Mode.HOLDING),
            f"another host's request for {mode.name.lower()} was answered {answer}",
        )
    bench.send(InfoRequest(bench.other))
    bench.wait(InfoSerial)  # everyone may ask
    bench.must_go(Mode.DISARMED)
    expect(bench.beat().holder == NOBODY, "a disarmed board is nobody's")
    bench.must_go(Mode.ARMED, bench.other)
    expect(bench.go(Mode.DISARMED).result is Result.HELD, "the host that held it before is another host now")
    bench.must_go(Mode.DISARMED, bench.other)


@case("Host 0 is nobody: its requests are bad_value.")
def refuses_nobody(bench: Bench) -> None:
    for mode in (Mode.DISARMED, Mode.ARMED, Mode.HOLDING):
        answer = bench.go(mode, NOBODY)
        expect(answer.result is Result.BAD_VALUE, f"host 0 was answered {answer}")
    expect(bench.beat().mode is Mode.DISARMED, "host 0 armed the board")


@case(
    "Acknowledge names the host whose request it answers: two that ask at once with one token know who has it."
)
def answers_each_host(bench: Bench) -> None:
    token = bench.token()
    bench.send(ModeRequest(token, Mode.ARMED, bench.host), ModeRequest(token, Mode.ARMED, bench.other))
    bench.ping()
    answers = {m.host: m.result for m in bench.heard if isinstance(m, Acknowledge)}
    expect(
        answers == {bench.host: Result.OK, bench.other: Result.HELD},
        f"two hosts asked to arm, {bench.host:08x} first: the answers are {answers}",
    )


@case("A request that comes twice is answered twice, and does no harm.")
def takes_repeated_requests(bench: Bench) -> None:
    request = ModeRequest(77, Mode.ARMED, bench.host)
    first, second = bench.ask(request), bench.ask(request)
    expect(first == second, f"the same request was answered {first}, then {second}")


@case("Emergency stop from any mode, with any payload, from anyone: no power, FaultEvent, stopped.")
def stops_from_any_mode(bench: Bench) -> None:
    for mode in Mode:
        for payload in (b"", b"\xff", b"\x00" * 5, b"\xff" * 8):
            bench.fresh()
            bench.enter(mode)
            bench.heard.clear()
            bench.send_frames([Frame(frame_id(EmergencyStop), payload)])
            event = bench.wait(FaultEvent, 0.3, code=Fault.EMERGENCY_STOP)
            answer = bench.go(Mode.ARMED)
            expect(
                (answer.result, answer.mode) == (Result.FORBIDDEN, Mode.STOPPED),
                f"after a stop from {mode.name.lower()} with payload {payload.hex() or 'none'} "
                f"arming was answered {answer}; {event}",
            )
    beat = bench.beat()
    expect(
        (beat.mode, beat.powered, beat.fault) == (Mode.STOPPED, 0, Fault.EMERGENCY_STOP),
        f"the heartbeat of a stopped board is {beat}",
    )


@case(
    "An emergency stop has no wrong length: it is received, and never counted as corrupt, stopped already or not."
)
def counts_no_stop_as_corrupt(bench: Bench) -> None:
    before, sent_before = bench.counters(), bench.sent
    for length in range(9):
        bench.send_frames([Frame(frame_id(EmergencyStop), bytes(range(length)))])
    after = bench.counters()
    grown = growth(after.corrupt, before.corrupt)
    expect(grown == 0, f"of 9 emergency stops of 0 to 8 bytes {grown} were counted as corrupt")
    received, sent = growth(after.received, before.received), bench.sent - sent_before
    expect(received == sent, f"{sent} frames were sent, Counters.received grew by {received}")


@case("Every emergency stop is answered by a FaultEvent; its time is that of the first.")
def answers_every_stop(bench: Bench) -> None:
    times = []
    for _ in range(3):
        bench.send(EmergencyStop())
        times.append(bench.wait(FaultEvent, 0.3, code=Fault.EMERGENCY_STOP).board_time_us)
        bench.listen(0.01)
    expect(len(set(times)) == 1, f"the stop is dated {times} us: its time is the one of the entry")


@case("Stopped lasts: no request for a mode leads out of it.")
def stays_stopped(bench: Bench) -> None:
    bench.arm()
    bench.stop()
    bench.tick([0.0] * bench.joints)
    for mode in (Mode.DISARMED, Mode.ARMED, Mode.HOLDING):
        for host in (bench.host, bench.other):
            answer = bench.go(mode, host)
            expect(
                answer.result is Result.FORBIDDEN,
                f"{mode.name.lower()} was requested of a stopped board and answered {answer}",
            )
    bench.heard.clear()
    said = bench.listen(0.35)
    beats = [m for m in said if isinstance(m, BoardHeartbeat)]
    events = [m for m in said if isinstance(m, FaultEvent)]
    expect(
        beats
        and all(m.mode is Mode.STOPPED and not m.powered and m.fault is Fault.EMERGENCY_STOP for m in beats),
        f"heartbeats after a stop: {beats}",
    )
    expect(len(events) >= len(beats) - 1, "FaultEvent comes with every heartbeat until the stop is cleared")
