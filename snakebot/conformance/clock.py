"""The wrap of the board's clock: every timer runs across it as if it were not there."""

from __future__ import annotations

from collections.abc import Callable

from snakebot.conformance.beats import goes_on_unasked, keeps_its_rates
from snakebot.conformance.bench import Bench, passed_us
from snakebot.conformance.case import case
from snakebot.conformance.feeding import every_mode_has_its_own_watchdog
from snakebot.conformance.limits import bursts_gain_nothing
from snakebot.conformance.limits_tape import keeps_every_joints_limits
from snakebot.conformance.violations import expect
from snakebot.conformance.watchdog import (
    faults_without_a_setpoint,
    freezes_then_relaxes,
    holding_needs_its_holder,
    setpoints_feed_it,
)

_WRAP_US = 1 << 32  # the board's clock has 32 bits of us (PROTOCOL.md)

# Each with the times after the reset at which the clock wraps.
_ACROSS: tuple[tuple[Callable[[Bench], None], tuple[float, ...]], ...] = (
    (faults_without_a_setpoint, (0.11, 0.19)),
    (setpoints_feed_it, (0.15, 0.45, 0.53)),
    (freezes_then_relaxes, (0.32, 1.2, 2.25)),
    (holding_needs_its_holder, (0.5, 1.6, 2.4)),
    (every_mode_has_its_own_watchdog, (0.22, 0.6, 0.82)),
    (keeps_its_rates, (0.1, 1.45, 2.0, 2.05)),
    (goes_on_unasked, (0.15, 0.25)),
    (bursts_gain_nothing, (0.2,)),
)


def _across(bench: Bench, ask: Callable[[Bench], None], wraps_s: tuple[float, ...]) -> None:
    assert bench.lab.reset_at is not None
    for wrap_s in wraps_s:
        start_us = _WRAP_US - round(wrap_s * 1e6)
        bench.lab.reset_at(start_us)
        bench.identify()
        shown_us = bench.ping().board_time_us
        expect(
            passed_us(shown_us, start_us) < 500_000,
            f"the clock was set to {start_us} us at the reset, and shows {shown_us}",
        )
        bench.begin()
        ask(bench)
        bench.fresh()


@case(
    "Watchdogs, relaxing, beats and samples keep their times across the wrap of the clock.",
    needs=("reset_at",),
    long=True,
)
def keeps_time_across_the_wrap(bench: Bench) -> None:
    for ask, wraps_s in _ACROSS:
        _across(bench, ask, wraps_s)


@case("The limiter's credit is right across the wrap of the clock.", needs=("reset_at",))
def limits_across_the_wrap(bench: Bench) -> None:
    _across(bench, keeps_every_joints_limits, (0.8, 3.2))
