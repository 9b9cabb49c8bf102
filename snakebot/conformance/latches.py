"""Stops and faults that stay: each has a number, and only a request that names it leads out."""

from __future__ import annotations

from firmware_protocol.catalogue import (
    LATCHES,
    NOBODY,
    Acknowledge,
    BoardHeartbeat,
    ClearRequest,
    Fault,
    FaultEvent,
    Mode,
    ModeRequest,
    Result,
)
from snakebot.conformance.bench import Bench
from snakebot.conformance.case import case
from snakebot.conformance.violations import expect


def _still(bench: Bench, mode: Mode, after: str) -> None:
    beat = bench.beat()
    expect(beat.mode is mode, f"after {after} the board is {beat.mode.name.lower()}, not {mode.name.lower()}")
    expect(beat.fault is not Fault.NONE, f"after {after} the fault is gone")


@case("ClearRequest with the latch's number, from anyone, leads from stopped and from fault to disarmed.")
def clears_by_number(bench: Bench) -> None:
    for mode in (Mode.STOPPED, Mode.FAULT):
        bench.fresh()
        bench.enter(mode)
        number = bench.wait(FaultEvent, 0.5).number
        answer = bench.clear(number, NOBODY)
        expect(answer.result is Result.BAD_VALUE, f"host 0 was answered {answer}")
        answer = bench.clear(number, bench.other)
        expect((answer.result, answer.mode) == (Result.OK, Mode.DISARMED), f"to clear was answered {answer}")
        beat = bench.beat()
        expect(
            (beat.mode, beat.fault, beat.holder, beat.powered) == (Mode.DISARMED, Fault.NONE, NOBODY, 0),
            f"after clearing: {beat}",
        )
        bench.heard.clear()
        bench.listen(0.25)
        events = [m for m in bench.heard if isinstance(m, FaultEvent)]
        expect(not events, "FaultEvents came after the latch was cleared")


@case("Each fault and each emergency stop raises the number; repeated FaultEvents keep it.")
def numbers_its_latches(bench: Bench) -> None:
    first = bench.stop().number
    again = bench.wait(FaultEvent, 0.5).number
    expect(again == first, f"the number went from {first} to {again} without a stop")
    second = bench.stop().number
    expect(second == (first + 1) % LATCHES, f"a stop has number {second}, the one before {first}")
    bench.clear(second)
    bench.enter(Mode.FAULT)
    third = bench.wait(FaultEvent, 0.5).number
    expect(third == (second + 1) % LATCHES, f"a fault has number {third}, the stop before it {second}")
    fourth = bench.stop().number
    expect(fourth == (third + 1) % LATCHES, f"a stop has number {fourth}, the fault before it {third}")
    for _ in range(LATCHES):
        last = bench.stop().number
    expect(last == fourth, f"{LATCHES} stops took the number from {fourth} to {last}: it has 6 bits")


@case("A clear that names an older latch, or none there was, is forbidden: a late one undoes no newer stop.")
def keeps_newer_stops(bench: Bench) -> None:
    for mode in (Mode.STOPPED, Mode.FAULT):
        bench.fresh()
        bench.enter(mode)
        older = bench.wait(FaultEvent, 0.5).number
        number = bench.stop().number
        for wrong in (older, *((number + further) % LATCHES for further in range(1, LATCHES))):
            answer = bench.clear(wrong)
            expect(
                (answer.result, answer.mode) == (Result.FORBIDDEN, Mode.STOPPED),
                f"latch {number}: a request to clear {wrong} was answered {answer}",
            )
            _still(bench, Mode.STOPPED, "a clear of another number")
    bench.clear(number)
    request = ClearRequest(bench.token(), number, bench.host)
    answer = bench.ask(request)
    expect(
        (answer.result, answer.mode) == (Result.OK, Mode.DISARMED),
        f"to clear once more was answered {answer}",
    )
    bench.stop()
    answer = bench.ask(request)  # it was on its way all the time
    expect(answer.result is Result.FORBIDDEN, f"a late clear of the stop before was answered {answer}")
    _still(bench, Mode.STOPPED, "a late clear")


@case("A request to disarm that is on its way when the stop comes leaves the stop.")
def late_disarm_keeps_the_stop(bench: Bench) -> None:
    bench.arm()
    late = ModeRequest(bench.token(), Mode.DISARMED, bench.host)
    bench.stop()
    bench.send(late)
    answer = bench.wait(Acknowledge, token=late.token)
    expect(
        (answer.result, answer.mode) == (Result.FORBIDDEN, Mode.STOPPED), f"to disarm was answered {answer}"
    )
    _still(bench, Mode.STOPPED, "a late request to disarm")


@case("To clear while another host drives is held; while its holder drives it changes nothing.")
def clears_nothing_while_armed(bench: Bench) -> None:
    number = bench.stop().number
    bench.clear(number)
    bench.must_go(Mode.ARMED)
    bench.must_go(Mode.HOLDING)
    answer = bench.clear(number, bench.other)
    expect(answer.result is Result.HELD, f"another host's clear was answered {answer}")
    answer = bench.clear(number)
    expect(
        (answer.result, answer.mode) == (Result.OK, Mode.HOLDING), f"the holder's clear was answered {answer}"
    )
    beat = bench.beat()
    expect((beat.mode, beat.holder) == (Mode.HOLDING, bench.host), f"to clear led out of holding: {beat}")


@case(
    "A fault of the hardware that lasts: arming is answered faulty, with the fault, and no joint gets power.",
    needs=("fail",),
)
def arms_no_faulty_hardware(bench: Bench) -> None:
    fail = bench.lab.fail
    assert fail is not None
    for code in (Fault.SERVO, Fault.OVERTEMPERATURE):
        fail(code, 0, 0)
        answer = bench.go(Mode.ARMED)
        expect(
            (answer.result, answer.mode, answer.detail) == (Result.FAULTY, Mode.DISARMED, code),
            f"with a lasting fault {code.name.lower()} arming was answered {answer}",
        )
        bench.heard.clear()
        bench.listen(0.25)
        beats = [m for m in bench.heard if isinstance(m, BoardHeartbeat)]
        expect(beats and not any(m.powered for m in beats), f"it got power all the same: {beats}")
    fail(Fault.NONE, 0, 0)
    bench.must_go(Mode.ARMED)
    fail(Fault.OVERCURRENT, 0, 0)
    event = bench.wait(FaultEvent, code=Fault.OVERCURRENT)
    bench.clear(event.number)
    answer = bench.go(Mode.ARMED)
    expect(answer.result is Result.FAULTY, f"its fault was cleared, and lasts: arming was answered {answer}")


@case(
    "A fault is left by its own number only, of all 64, frozen and once it has relaxed; a stop takes it then, too."
)
def keeps_faults_from_other_numbers(bench: Bench) -> None:
    bench.enter(Mode.FAULT)
    number = bench.wait(FaultEvent, 0.5).number
    for powered in (1, 0):
        for wrong in ((number + further) % LATCHES for further in range(1, LATCHES)):
            answer = bench.clear(wrong)
            expect(
                (answer.result, answer.mode) == (Result.FORBIDDEN, Mode.FAULT),
                f"fault {number}, power {powered}: a request to clear {wrong} was answered {answer}",
            )
        _still(bench, Mode.FAULT, "clears of every other number")
        if powered:
            bench.listen(2.0)
            expect(not bench.beat().powered, "2 s after a fault the joints have power")
    stop = bench.stop()
    expect(
        stop.number == (number + 1) % LATCHES, f"a stop after fault {number} relaxed has number {stop.number}"
    )
    _still(bench, Mode.STOPPED, "a stop of a fault that had relaxed")
    answer = bench.clear(stop.number)
    expect((answer.result, answer.mode) == (Result.OK, Mode.DISARMED), f"to clear was answered {answer}")
