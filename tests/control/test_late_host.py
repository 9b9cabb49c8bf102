"""A host whose sleeps end late: it counts and warns, and gives up only where the board's watchdog is near."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from lag_plant import LagPlant
from test_run_loop import GAIT, ROBOT, TAU_S, Memory

from firmware_protocol.catalogue import Mode
from snakebot.board import Board
from snakebot.clock import VirtualClock
from snakebot.control import RunLoop
from snakebot.errors import BadInputError, BoardFaultError, HostLateError
from snakebot.gait import GaitMotion
from snakebot.softboard import InProcessLink, SoftBoard


class LateClock(VirtualClock):
    """Virtual time in which sleeps end late, by ``late_s`` of the time that was asked for."""

    def __init__(self, late_s: Callable[[float], float]) -> None:
        super().__init__()
        self.late_s = late_s

    def sleep_until(self, t_s: float) -> None:
        if t_s > self.now_s():
            super().sleep_until(t_s + self.late_s(t_s))


class Bench:
    """A run on a board that says its watchdog waits ``watchdog_ms``."""

    def __init__(
        self, late_s: Callable[[float], float], *, rate_hz: float = 100, watchdog_ms: int = 100
    ) -> None:
        self.clock = LateClock(late_s)
        self.plant = LagPlant(ROBOT.joints, TAU_S)
        link = InProcessLink(SoftBoard(ROBOT, plant=self.plant), self.clock)
        self.board = Board(link, self.clock)
        self.board.info = replace(self.board.connect(), watchdog_ms=watchdog_ms)
        self.memory = Memory()
        self.loop = RunLoop(
            self.board,
            ROBOT,
            lambda start: GaitMotion(GAIT, ROBOT.joints, 6, 1, start),
            rate_hz=rate_hz,
            clock=self.clock,
            amplitude_rad=GAIT.alpha_rad,
            recorder=self.memory,
        )


def always(late_s: float) -> Callable[[float], float]:
    return lambda t_s: late_s


def at(times_s: list[float], late_s: float) -> Callable[[float], float]:
    """Late once at each of these times."""
    left = [*times_s]

    def late(t_s: float) -> float:
        if left and t_s >= left[0]:
            left.pop(0)
            return late_s
        return 0.0

    return late


@pytest.mark.parametrize(
    ("rate_hz", "late_ms"), [(100, 5.0), (100, 5.5), (100, 9.0), (100, 45.0), (20, 30.0)]
)
def test_sleeps_that_end_late_do_not_end_the_run(rate_hz: float, late_ms: float) -> None:
    bench = Bench(always(late_ms * 1e-3), rate_hz=rate_hz)
    result = bench.loop.run()
    assert result.ended == "finished"
    progress = result.progress
    assert progress.ticks + progress.skipped == pytest.approx(
        6 * rate_hz + 1, abs=2 + late_ms * 1e-3 * rate_hz
    )
    times_s = np.array([tick.t_s for tick in bench.memory.ticks])
    assert np.diff(times_s).max() < 0.1


@pytest.mark.parametrize("late_ms", [5.5, 9.0, 45.0])
def test_late_ticks_are_counted_and_logged_and_warned_of_once(late_ms: float) -> None:
    bench = Bench(always(late_ms * 1e-3))
    progress = bench.loop.run().progress
    warnings = [event for event in bench.memory.events if event.kind == "late"]
    assert len(warnings) == 1
    assert warnings[0].level == "warning"
    assert "ticks start up to" in warnings[0].message
    assert f"{progress.worst_lateness_s * 1e3:.1f} ms" in progress.late_warning
    assert progress.late == sum(tick.late for tick in bench.memory.ticks) > 50


def test_a_few_late_ticks_are_counted_without_a_warning() -> None:
    bench = Bench(at([2.0, 2.2, 2.4, 2.6, 4.0], 0.008))
    progress = bench.loop.run().progress
    assert progress.late == 5
    assert not progress.often_late
    assert "late" not in bench.memory.kinds


def test_one_tick_late_by_more_than_half_the_watchdog_is_counted_and_the_run_goes_on() -> None:
    bench = Bench(at([3.0], 0.06))
    result = bench.loop.run()
    assert result.ended == "finished"
    assert result.progress.late == 1
    assert result.progress.worst_lateness_s == pytest.approx(0.06, abs=0.001)


def test_ticks_always_late_by_more_than_half_the_watchdog_hold_and_relax_the_robot() -> None:
    bench = Bench(lambda t_s: 0.06 if t_s > 3 else 0.0)
    with pytest.raises(HostLateError, match=r"3 ticks .* 50 ms late, .* watchdog waits 100 ms .*--rate"):
        bench.loop.run()
    assert bench.board.mode is Mode.DISARMED
    assert bench.clock.now_s() < 4.0


@pytest.mark.parametrize(
    ("times_s", "ends"),
    [([3.0, 3.3], False), ([3.0, 3.6, 4.2, 4.8], False), ([3.0, 3.3, 3.6], True)],
)
def test_what_counts_is_three_within_a_second(times_s: list[float], ends: bool) -> None:
    bench = Bench(at(times_s, 0.06))
    if ends:
        with pytest.raises(HostLateError):
            bench.loop.run()
    else:
        assert bench.loop.run().ended == "finished"


def test_the_budget_is_that_of_this_boards_watchdog() -> None:
    bench = Bench(lambda t_s: 0.06 if 2 < t_s < 4 else 0.0, watchdog_ms=200)
    assert bench.loop.run().ended == "finished"
    with pytest.raises(HostLateError, match="watchdog waits 60 ms"):
        Bench(always(0.04), watchdog_ms=60).loop.run()


def test_a_stall_longer_than_the_watchdog_says_whose_fault_it_was() -> None:
    with pytest.raises(BoardFaultError, match=r"watchdog stopped .* this computer stood still for 0\.50 s"):
        Bench(at([3.0], 0.5)).loop.run()


def test_a_watchdog_that_the_rate_cannot_feed_is_refused_before_anything_moves() -> None:
    bench = Bench(always(0.0), rate_hz=30, watchdog_ms=50)
    with pytest.raises(BadInputError, match=r"--rate 30: .*50 ms.* 40 Hz or more"):
        bench.loop.run()
    for watchdog_ms in (0, 1):
        bench = Bench(always(0.0), watchdog_ms=watchdog_ms)
        with pytest.raises(BoardFaultError, match=f"watchdog of {watchdog_ms} ms"):
            bench.loop.run()
        assert bench.board.mode is Mode.DISARMED
        assert not bench.memory.ticks
