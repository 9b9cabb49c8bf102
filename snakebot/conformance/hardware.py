"""Encoders that are lost, hardware that fails, supplies that are measured: where a lab can do that to the board."""

from __future__ import annotations

import itertools

from firmware_protocol.catalogue import (
    LATCHES,
    BoardHeartbeat,
    Counters,
    Fault,
    FaultEvent,
    JointSupply,
    Mode,
    Result,
    Supply,
)
from snakebot.conformance.bench import Bench, passed_us
from snakebot.conformance.case import case
from snakebot.conformance.lag import angles_of, expect_no_power, expect_power, read_now, throw, went_on
from snakebot.conformance.violations import expect


def _shares(bench: Bench, before: list[float], side: float) -> list[float]:
    now = angles_of(bench, read_now(bench))
    return [side * (b - a) / bench.nudge_rad for a, b in zip(before, now, strict=True)]


def _stream_away(bench: Bench, side: float) -> None:
    here = bench.arm()
    bench.stream(0.3, lambda t: [angle + side * bench.nudge_rad for angle in here])
    bench.must_go(Mode.DISARMED)


@case(
    "A joint whose encoder has given no angle since the reset gets no power, the others do; once it was read it does.",
    needs=("reset", "lose_encoder"),
)
def unread_joints_get_no_power(bench: Bench) -> None:
    lose = bench.lab.lose_encoder
    assert lose is not None
    for joint in range(1, bench.joints + 1):
        bench.fresh()
        side = 1.0 if joint % 2 else -1.0
        before = angles_of(bench, read_now(bench))
        lose(joint, True)
        try:
            bench.start_anew()
            counts = read_now(bench).measured_counts
            missing = [number for number, c in enumerate(counts, start=1) if c is None]
            expect(
                missing == [joint], f"the encoder of joint {joint} is lost, no reading of joints {missing}"
            )
            _stream_away(bench, side)
        finally:
            lose(joint, False)
        others = [other != joint for other in range(1, bench.joints + 1)]
        shares = _shares(bench, before, side)
        expect_power(shares, others, f"joint {joint} unread since the reset", moving=False)
        bench.samples.clear()
        before = angles_of(bench, read_now(bench))
        _stream_away(bench, -side)
        expect_power(_shares(bench, before, -side), [True] * bench.joints, f"joint {joint} read at last")


@case(
    "A joint whose encoder is lost while it has power keeps it; its samples say that there is no reading.",
    needs=("lose_encoder",),
)
def lost_encoders_are_told(bench: Bench) -> None:
    lose = bench.lab.lose_encoder
    assert lose is not None
    for joint in range(1, bench.joints + 1):
        bench.fresh()
        thrown = throw(bench, 1.0 if joint % 2 else -1.0)
        lose(joint, True)
        try:
            bench.must_go(Mode.HOLDING)
            counts = read_now(bench).measured_counts
            missing = [number for number, c in enumerate(counts, start=1) if c is None]
            expect(
                missing == [joint], f"the encoder of joint {joint} is lost, no reading of joints {missing}"
            )
        finally:
            lose(joint, False)
        expect_power(went_on(bench, thrown), [True] * bench.joints, f"the encoder of joint {joint} was lost")


@case(
    "A fault of the hardware freezes an armed or holding board at once: its code, joint and detail, its time.",
    needs=("fail",),
)
def freezes_at_a_hardware_fault(bench: Bench) -> None:
    fail = bench.lab.fail
    assert fail is not None
    for mode, (code, joint, detail) in (
        (Mode.ARMED, (Fault.SERVO, bench.joints, -7)),
        (Mode.HOLDING, (Fault.OVERTEMPERATURE, 0, 1234)),
    ):
        bench.fresh()
        thrown = throw(bench, 1.0)
        if mode is Mode.HOLDING:
            bench.must_go(Mode.HOLDING)
        before = bench.ping().board_time_us
        fail(code, joint, detail)
        try:
            event = bench.wait(FaultEvent, 0.05, code=code)
        finally:
            fail(Fault.NONE, 0, 0)
        after = bench.ping().board_time_us
        expect((event.joint, event.detail) == (joint, detail), f"{code.name.lower()} was told as {event}")
        expect(
            passed_us(event.board_time_us, before) <= passed_us(after, before),
            f"it began between {before} and {after} us, the event says {event.board_time_us}",
        )
        expect_power(went_on(bench, thrown), [True] * bench.joints, f"frozen by {code.name.lower()}")
        beat = bench.beat()
        expect((beat.mode, beat.fault, beat.powered) == (Mode.FAULT, code, 1), f"the heartbeat: {beat}")
        bench.listen(2.0)
        beat = bench.beat()
        expect(
            (beat.mode, beat.fault, beat.powered) == (Mode.FAULT, code, 0), f"2 s later the heartbeat: {beat}"
        )


@case("A fault of the hardware leaves a board alone that nobody holds.", needs=("fail",))
def a_hardware_fault_needs_power(bench: Bench) -> None:
    fail = bench.lab.fail
    assert fail is not None
    for mode, fault in (
        (Mode.DISARMED, Fault.NONE),
        (Mode.STOPPED, Fault.EMERGENCY_STOP),
        (Mode.FAULT, Fault.WATCHDOG),
    ):
        bench.fresh()
        bench.enter(mode)
        bench.heard.clear()
        fail(Fault.OVERCURRENT, 1, 5)
        try:
            bench.listen(0.25)
        finally:
            fail(Fault.NONE, 0, 0)
        beats = [m for m in bench.heard if isinstance(m, BoardHeartbeat)]
        expect(
            beats and all((m.mode, m.fault) == (mode, fault) for m in beats),
            f"a hardware fault while {mode.name.lower()} made the heartbeat {beats}",
        )
        events = [m for m in bench.heard if isinstance(m, FaultEvent) and m.code is Fault.OVERCURRENT]
        expect(not events, f"a hardware fault while {mode.name.lower()} was told: {events}")


@case(
    "The button for an emergency stop stops from any mode, and is told once and with every heartbeat.",
    needs=("fail",),
)
def has_a_button(bench: Bench) -> None:
    fail = bench.lab.fail
    assert fail is not None
    for mode in (Mode.DISARMED, Mode.ARMED, Mode.HOLDING, Mode.FAULT):
        bench.fresh()
        bench.enter(mode)
        before = bench.ping().board_time_us
        bench.heard.clear()
        fail(Fault.EMERGENCY_STOP, 0, 0)
        try:
            event = bench.wait(FaultEvent, 0.05, code=Fault.EMERGENCY_STOP)
            bench.listen(0.25)
        finally:
            fail(Fault.NONE, 0, 0)
        late_us = passed_us(event.board_time_us, before)
        expect(late_us < 20_000, f"pressed at {before} us, the event says {event}")
        bench.ping()
        beats = [m for m in bench.heard if isinstance(m, BoardHeartbeat)]
        events = [m for m in bench.heard if isinstance(m, FaultEvent)]
        stopped = [m for m in beats if m.mode is Mode.STOPPED]
        expect(
            stopped and not stopped[-1].powered, f"the button was pressed while {mode.name.lower()}: {beats}"
        )
        expect(
            len(stopped) <= len(events) <= len(stopped) + 2,
            f"a button that was held down was told {len(events)} times with {len(stopped)} heartbeats",
        )

    def press() -> None:
        fail(Fault.EMERGENCY_STOP, 0, 0)
        bench.wait(FaultEvent, 0.05, code=Fault.EMERGENCY_STOP)
        fail(Fault.NONE, 0, 0)

    expect_no_power(bench, press, "after the button was pressed")


@case(
    "While the button is held down the board stops again as soon as the stop is cleared, with a new number.",
    needs=("fail",),
)
def a_button_held_down_stops_again(bench: Bench) -> None:
    fail = bench.lab.fail
    assert fail is not None
    fail(Fault.EMERGENCY_STOP, 0, 0)
    first = bench.wait(FaultEvent, 0.05, code=Fault.EMERGENCY_STOP)
    answer = bench.clear(first.number)
    second = bench.wait(FaultEvent, 0.15, code=Fault.EMERGENCY_STOP)
    expect(
        second.number != first.number,
        f"cleared ({answer}) with the button held down, latch {second.number} is the same",
    )
    expect(bench.beat().mode is Mode.STOPPED, "a board whose button is held down is not stopped")
    fail(Fault.NONE, 0, 0)
    bench.clear(second.number)
    expect(bench.beat().mode is Mode.DISARMED, "the button was released and the stop cleared")


@case("While the button is held down a clear that is refused makes no new latch.", needs=("fail",))
def a_refused_clear_is_no_press(bench: Bench) -> None:
    fail = bench.lab.fail
    assert fail is not None
    fail(Fault.EMERGENCY_STOP, 0, 0)
    try:
        number = bench.wait(FaultEvent, 0.05, code=Fault.EMERGENCY_STOP).number
        answer = bench.clear((number + 1) % LATCHES)
        expect(answer.result is Result.FORBIDDEN, f"a clear of another latch was answered {answer}")
        bench.heard.clear()
        bench.listen(0.15)
    finally:
        fail(Fault.NONE, 0, 0)
    numbers = {m.number for m in bench.heard if isinstance(m, FaultEvent)}
    expect(numbers == {number}, f"latch {number} was not cleared; after that its events have {numbers}")


@case(
    "A press of the button is one latch, in whatever mode, stopped included: it is told with one number from then on.",
    needs=("fail",),
)
def numbers_a_press_once(bench: Bench) -> None:
    fail = bench.lab.fail
    assert fail is not None
    for mode in Mode:
        bench.fresh()
        before = bench.stop().number
        bench.make_safe()
        bench.enter(mode)
        wanted = (before + 1 + (mode in (Mode.STOPPED, Mode.FAULT))) % LATCHES
        bench.ping()
        bench.heard.clear()
        fail(Fault.EMERGENCY_STOP, 0, 0)
        try:
            bench.wait(FaultEvent, 0.05, code=Fault.EMERGENCY_STOP, number=wanted)
            bench.listen(0.25)
        finally:
            fail(Fault.NONE, 0, 0)
        numbers = {m.number for m in bench.heard if isinstance(m, FaultEvent)}
        expect(
            numbers == {wanted},
            f"the button was pressed while {mode.name.lower()}, after latch {before}: its events have {numbers}",
        )


def _of_joints(measured: tuple[int, int, int], joints: int) -> tuple[int, int, int]:
    """A supply's values where they are those of its joints."""
    millivolts, milliamperes, decidegrees = measured
    total = sum(abs(milliamperes + joint) for joint in range(1, joints + 1))
    return millivolts, total, decidegrees + 2 * joints


@case(
    "Supply and each JointSupply once a second where they are measured, never where not.", needs=("supply",)
)
def tells_its_supply(bench: Bench) -> None:
    supply = bench.lab.supply
    assert supply is not None
    for measured, armed in itertools.product(((11_987, -250, 423), None), (False, True)):
        bench.fresh()
        supply(measured)
        try:
            bench.wait(Counters, 1.6)
            here = bench.arm() if armed else ()
            bench.heard.clear()
            bench.stream(1.8, lambda t, here=here: here) if armed else bench.listen(1.8)  # type: ignore[misc]
            supplies = [m for m in bench.heard if isinstance(m, Supply)]
            of_joints = [m for m in bench.heard if isinstance(m, JointSupply)]
        finally:
            supply(None)
        wanted = 0 if measured is None else len([m for m in bench.heard if isinstance(m, Counters)])
        expect(len(supplies) == wanted, f"{len(supplies)} Supply with {wanted} Counters")
        joints = sorted(m.joint for m in of_joints)
        expect(joints == sorted(list(range(1, bench.joints + 1)) * wanted), f"JointSupply of joints {joints}")
        if measured is not None:
            whole = _of_joints(measured, bench.joints) if bench.lab.supply_is_of_joints else measured
            for told in supplies:
                shown = (1000 * told.voltage_v, 1000 * told.current_a, 10 * told.temperature_c)
                off = max(abs(a - b) for a, b in zip(shown, whole, strict=True))
                expect(off < 1e-3, f"the supply is {whole}, it was told as {shown}")
            for one in of_joints:
                shown_of_joint = (1000 * one.current_a - one.joint, 10 * one.temperature_c - 2 * one.joint)
                off = max(abs(a - b) for a, b in zip(shown_of_joint, measured[1:], strict=True))
                expect(off < 1e-3, f"joint {one.joint} measures what it adds to {measured}, and told {one}")
