"""Each fault of the hardware by its own code, joint and value; and when arming asks for it."""

from __future__ import annotations

from firmware_protocol.catalogue import LATCHES, NOBODY, BoardHeartbeat, Fault, FaultEvent, Mode, Result
from snakebot.conformance.bench import Bench
from snakebot.conformance.case import case
from snakebot.conformance.violations import expect

_OF_HARDWARE = tuple(f for f in Fault if f not in (Fault.NONE, Fault.WATCHDOG, Fault.EMERGENCY_STOP))
_DETAILS = (32767, -32768, 1, -1, 256, 0)  # ends of 16 bits, and either byte by itself


@case(
    "Every fault of the hardware is told by its own code, joint, value and number; what comes after it without them.",
    needs=("fail",),
)
def tells_every_fault(bench: Bench) -> None:
    fail = bench.lab.fail
    assert fail is not None
    latch = bench.stop().number
    for number, code in enumerate(_OF_HARDWARE):
        joint, detail = (number * 7) % (bench.joints + 1), _DETAILS[number % len(_DETAILS)]
        bench.fresh()
        bench.enter(Mode.HOLDING if number % 2 else Mode.ARMED)
        fail(code, joint, detail)
        event = bench.wait(FaultEvent, 0.05)
        fail(Fault.NONE, 0, 0)
        seen = (event.code, event.joint, event.detail)
        expect(
            seen == (code, joint, detail),
            f"{code.name.lower()} of joint {joint}, {detail}, was told as {event}",
        )
        latch = (latch + 1) % LATCHES
        expect(
            event.number == latch, f"{code.name.lower()} has latch {event.number}, not the next one, {latch}"
        )
        again = bench.wait(FaultEvent, 0.15)
        expect(again == event, f"a fault was told as {event}, then as {again}")
        beat = bench.beat()
        expect((beat.mode, beat.fault) == (Mode.FAULT, code), f"{code.name.lower()}: the heartbeat is {beat}")
        if number % 2:
            stop = bench.stop()
            expect(
                (stop.joint, stop.detail) == (0, 0),
                f"a stop after a fault of joint {joint} is told as {stop}",
            )
            latch = (latch + 1) % LATCHES
        bench.make_safe()
        bench.enter(Mode.FAULT)
        event = bench.wait(FaultEvent, 0.15)
        seen = (event.code, event.joint, event.detail)
        expect(
            seen == (Fault.WATCHDOG, 0, 0), f"a watchdog's fault after {code.name.lower()} is told as {event}"
        )
        latch = (latch + 1) % LATCHES
        expect(
            event.number == latch, f"a watchdog's fault has latch {event.number}, not the next one, {latch}"
        )


@case(
    "A fault of the hardware that lasts is looked for last: held, bad_value and forbidden come before faulty.",
    needs=("fail",),
)
def looks_for_faults_last(bench: Bench) -> None:
    fail = bench.lab.fail
    assert fail is not None
    table = (
        (Mode.DISARMED, Mode.ARMED, NOBODY, Result.BAD_VALUE, 0),
        (Mode.DISARMED, Mode.HOLDING, bench.host, Result.FORBIDDEN, 0),
        (Mode.DISARMED, Mode.DISARMED, bench.host, Result.OK, 0),
        (Mode.DISARMED, Mode.ARMED, bench.host, Result.FAULTY, Fault.UNDERVOLTAGE),
        (Mode.STOPPED, Mode.ARMED, bench.host, Result.FORBIDDEN, 0),
        (Mode.FAULT, Mode.ARMED, bench.host, Result.FORBIDDEN, 0),
        (Mode.FAULT, Mode.ARMED, NOBODY, Result.BAD_VALUE, 0),
    )
    for mode, wanted, host, result, detail in table:
        bench.fresh()
        bench.enter(mode)
        fail(Fault.UNDERVOLTAGE, 0, 0)
        answer = bench.go(wanted, host)
        fail(Fault.NONE, 0, 0)
        expect(
            (answer.result, answer.mode, answer.detail) == (result, mode, detail),
            f"{mode.name.lower()}, with a fault that lasts, {wanted.name.lower()} was asked for by {host:x} and "
            f"answered {answer}",
        )


@case(
    "A fault of the hardware that lasts lets the joints relax 2 s after the latch, and is no new one.",
    needs=("fail",),
)
def relaxes_while_a_fault_lasts(bench: Bench) -> None:
    fail = bench.lab.fail
    assert fail is not None
    for first in (Fault.WATCHDOG, Fault.OVERCURRENT):
        bench.fresh()
        bench.enter(Mode.FAULT if first is Fault.WATCHDOG else Mode.ARMED)
        fail(Fault.OVERCURRENT, 1, 5)
        event = bench.wait(FaultEvent, 0.15, code=first)
        bench.heard.clear()
        bench.listen(1.7)
        powered = [m.powered for m in bench.heard if isinstance(m, BoardHeartbeat)]
        expect(
            all(powered),
            f"frozen by {first.name.lower()}, a fault that lasts took the power before 2 s were over",
        )
        bench.listen(0.5)
        beat = bench.beat()
        fail(Fault.NONE, 0, 0)
        expect(
            (beat.mode, beat.powered) == (Mode.FAULT, 0),
            f"2 s after {first.name.lower()}, with a fault of the hardware that lasts, the heartbeat is {beat}",
        )
        events = [m for m in bench.heard if isinstance(m, FaultEvent)]
        expect(
            events and all(m == event for m in events),
            f"{first.name.lower()} was told as {event}, and while a fault of the hardware lasts as {events[-1:]}",
        )
