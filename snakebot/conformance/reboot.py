"""A reset in mid-run: everything is forgotten, and the host can tell."""

from __future__ import annotations

import itertools

from firmware_protocol.catalogue import JointMode, Mode, Result, State
from snakebot.conformance.bench import Bench
from snakebot.conformance.case import case
from snakebot.conformance.violations import expect


def _press(bench: Bench) -> None:
    assert bench.reset is not None
    bench.reset()


@case("A reset draws a new boot id, disarms, and makes all joints active.", needs=("reset",))
def forgets_at_a_reset(bench: Bench) -> None:
    before = bench.beat().boot_id
    expect(bench.set_joint_mode(1, JointMode.RIGID_HERE).result is Result.OK, "rigid_here was refused")
    here = bench.arm()
    bench.stream(0.1, lambda t: here)
    _press(bench)
    _, firmware, _ = bench.identify()
    expect(firmware.boot_id != before, f"the boot id is {before} before and after a reset")
    beat = bench.beat()
    expect(
        (beat.mode, beat.powered, beat.boot_id) == (Mode.DISARMED, 0, firmware.boot_id),
        f"the heartbeat after a reset is {beat}",
    )
    bench.samples.clear()
    here = bench.arm()
    there = [here[0] + (0.01 if here[0] < 0 else -0.01), *here[1:]]
    last = bench.stand_at(there, 0.3, "the stream after a reset")
    expect(abs(last.applied_rad[0] - there[0]) < 2e-4, "a joint was still rigid after a reset")


@case("Boot ids differ from one reset to the next; counters start again.", needs=("reset",))
def starts_again_at_a_reset(bench: Bench) -> None:
    seen = []
    for _ in range(4):
        _press(bench)
        seen.append(bench.identify()[1].boot_id)
    alike = any(a == b for a, b in itertools.pairwise(seen))
    expect(not alike and len(set(seen)) >= 3, f"boot ids after four resets: {seen}: they must be drawn anew")
    sent = bench.sent
    _press(bench)
    bench.identify()
    counters = bench.counters()
    expect(
        counters.received <= bench.sent - sent,
        f"Counters.received is {counters.received} after a reset and {bench.sent - sent} frames",
    )
    numbers = [m.sample for m in bench.heard if isinstance(m, State)][-1:]
    expect(all(number < 200 for number in numbers), f"sample numbers after a reset: {numbers}")


@case(
    "A boot id is never 0 and never the one before, whatever is drawn.",
    needs=("reset", "draw"),
)
def draws_another_boot_id(bench: Bench) -> None:
    draw = bench.lab.draw
    assert draw is not None

    def boot(drawn: int) -> int:
        draw([drawn])
        _press(bench)
        return bench.identify()[1].boot_id

    for wanted in (1, 2, 3, 0xFFFF):
        now = boot(wanted)
        if now != wanted:  # it was that one already
            now = boot(wanted)
        expect(now == wanted, f"{wanted} was drawn, the boot id is {now}")
        for drawn in (wanted, 0, 0x10000, wanted):
            before, now = now, boot(drawn)
            expect(
                now not in (0, before),
                f"{drawn} was drawn at a reset of a board with boot id {before}: it is {now} now",
            )
            expect(bench.beat().boot_id == now, "the heartbeat after a reset has another boot id")


@case(
    "There are 20 ms of credit at a reset: the first set-point is executed, however soon it comes.",
    needs=("reset",),
)
def has_credit_at_a_reset(bench: Bench) -> None:
    _press(bench)
    bench.identify()
    bench.begin()
    here = bench.arm()
    bench.executed(here, "the first one, just after a reset", 0.01)
    bench.make_safe()
    bench.begin()
    _press(bench)
    here = bench.arm()  # from the sample that comes at once: no time has passed
    bench.executed(here, "the first one, at once after a reset", 0.01)
