"""Who holds the board, number by number, and what FaultEvents say of a stop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from firmware_protocol.catalogue import (
    LATCHES,
    NOBODY,
    ClearRequest,
    FaultEvent,
    HostHeartbeat,
    JointMode,
    JointModeRequest,
    LimitKind,
    LimitRequest,
    Message,
    Mode,
    ModeRequest,
    Result,
    TrimRequest,
    ZeroRequest,
)
from snakebot.conformance.bench import Bench, passed_us
from snakebot.conformance.case import case
from snakebot.conformance.violations import expect


@case("A holder is known by all 32 bits of its number.")
def knows_its_holder_by_every_bit(bench: Bench) -> None:
    own = bench.host
    try:
        for host in (1, 0x80000000, 0xFFFFFFFF, 0x00010000, own):
            bench.fresh()
            bench.host = host
            bench.must_go(Mode.ARMED)
            bench.must_go(Mode.HOLDING)
            expect(bench.beat().holder == host, f"the heartbeat does not name holder {host:08x}")
            bench.send(HostHeartbeat(host, 1))
            for bit in range(32):
                stranger = host ^ 1 << bit
                answer = bench.go(Mode.DISARMED, stranger)
                expect(
                    (answer.result, answer.mode, answer.detail) == (Result.HELD, Mode.HOLDING, 0),
                    f"host {stranger:08x} asked a board of {host:08x} to disarm and was answered {answer}",
                )
            bench.must_go(Mode.DISARMED)
            expect(bench.beat().holder == NOBODY, "a disarmed board is nobody's")
    finally:
        bench.host = own


@case("The holder stays the holder through armed, holding and armed, and whoever stops the board.")
def stays_held(bench: Bench) -> None:
    here = bench.arm()
    for mode in (Mode.HOLDING, Mode.ARMED, Mode.HOLDING):
        bench.must_go(mode)
        if mode is Mode.ARMED:
            bench.stream(0.05, lambda t: here)
        answer = bench.go(Mode.DISARMED, bench.other)
        expect((answer.result, answer.mode) == (Result.HELD, mode), f"{mode.name.lower()}: {answer}")
    expect(bench.beat().holder == bench.host, "the holder is lost between armed and holding")


@case("Every request of another host is answered held, armed and holding, and does nothing.")
def holds_against_every_request(bench: Bench) -> None:
    other = bench.other
    requests: list[Callable[[int], Message]] = [
        lambda token: ModeRequest(token, Mode.DISARMED, other),
        lambda token: ModeRequest(token, Mode.HOLDING, other),
        lambda token: JointModeRequest(token, 1, JointMode.FREE, 0.0, other),
        lambda token: LimitRequest(token, 1, LimitKind.SPEED, 0.1, other),
        lambda token: TrimRequest(token, 1, 0.01, other),
        lambda token: ZeroRequest(token, 1, 5, other),
        *(lambda token, number=number: ClearRequest(token, number, other) for number in range(LATCHES)),
        lambda token: JointModeRequest(token, 1, JointMode.FREE, 0.0, NOBODY),
    ]
    for mode in (Mode.ARMED, Mode.HOLDING):
        bench.fresh()
        bench.enter(mode)
        for request in requests:
            message = request(bench.token())
            answer = bench.ask(message)
            expect(
                (answer.result, answer.mode, answer.detail) == (Result.HELD, mode, 0),
                f"{mode.name.lower()}: {message} was answered {answer}",
            )
        expect(
            bench.go(mode).result is Result.OK,
            f"another host's requests changed a board that was {mode.name.lower()}",
        )


@case(
    "A stop has its own FaultEvent: code, no joint, the time of its entry, also after a fault; then none any more."
)
def dates_its_stops(bench: Bench) -> None:
    for start in (Mode.DISARMED, Mode.ARMED, Mode.HOLDING, Mode.FAULT):
        bench.fresh()
        bench.enter(start)
        before = bench.ping().board_time_us
        event = bench.stop()
        after = bench.ping().board_time_us
        expect(
            passed_us(event.board_time_us, before) <= passed_us(after, before),
            f"stopped between {before} and {after} us, the event says {event.board_time_us}",
        )
        expect((event.joint, event.detail) == (0, 0), f"a stop is no joint's: {event}")
        bench.heard.clear()
        bench.listen(0.33)
        events = [m for m in bench.heard if isinstance(m, FaultEvent)]
        expect(len(events) >= 3 and all(m == event for m in events), f"stopped: {event}, then {events}")
        again = bench.stop()
        expect(again == replace(event, number=again.number), f"stopped: {event}, and once more: {again}")
        holder = bench.beat().holder
        expect(
            holder == (NOBODY if start is Mode.DISARMED else bench.host),
            f"stopped, the holder is {holder:08x}",
        )
        bench.make_safe()
        bench.heard.clear()
        bench.listen(0.25)
        expect(
            not any(isinstance(m, FaultEvent) for m in bench.heard),
            "a FaultEvent came after the stop was cleared",
        )


@case(
    "To clear: host 0 is bad_value, another number forbidden, the right one ok; told with the mode after it."
)
def answers_requests_to_clear(bench: Bench) -> None:
    for mode in (Mode.STOPPED, Mode.FAULT):
        bench.fresh()
        bench.enter(mode)
        number = bench.wait(FaultEvent, 0.5).number
        for host, wrong, result, after in (
            (NOBODY, 0, Result.BAD_VALUE, mode),
            (NOBODY, 1, Result.BAD_VALUE, mode),
            (bench.host, 1, Result.FORBIDDEN, mode),
            (bench.other, LATCHES - 1, Result.FORBIDDEN, mode),
            (bench.other, 0, Result.OK, Mode.DISARMED),
            (bench.host, 0, Result.OK, Mode.DISARMED),
        ):
            answer = bench.clear((number + wrong) % LATCHES, host)
            seen = (answer.result, answer.mode, answer.detail, answer.host)
            expect(
                seen == (result, after, 0, host), f"to clear latch {number} + {wrong} was answered {answer}"
            )
