"""The clock of a host and a board in one process stands still when the process does, and says so."""

from __future__ import annotations

import threading
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lag_plant import LagPlant
from test_run_loop import GAIT, ROBOT, TAU_S, Memory

from snakebot import clock as clock_module
from snakebot.board import Board
from snakebot.clock import MonotonicClock, StandstillClock
from snakebot.control import RunLoop
from snakebot.gait import GaitMotion
from snakebot.softboard import InProcessLink, SoftBoard

STEP_S = 0.004


class Computer:
    """A machine whose time moves by hand: a sleep moves it to its end, and a stall that begins in it further.

    ``stalls`` are (real time, duration); a stall begins with the first sleep or look that comes after its time.
    """

    def __init__(self, stalls: list[tuple[float, float]] | None = None) -> None:
        self.real_s = 1000.0
        self.look_s = 0.0  # what each look at the time costs
        self.begin_s = self.real_s
        self.stalls = stalls or []

    def monotonic(self) -> float:
        self.real_s += self.look_s
        return self.real_s

    def sleep_until(self, _: MonotonicClock, t_s: float) -> None:
        self.real_s = max(self.real_s, t_s)
        self.stall()

    def stall(self) -> None:
        while self.stalls and self.real_s - self.begin_s >= self.stalls[0][0]:
            self.real_s += self.stalls.pop(0)[1]


@pytest.fixture
def computer(monkeypatch: pytest.MonkeyPatch) -> Computer:
    made = Computer()
    install(made, monkeypatch)
    return made


def install(made: Computer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clock_module, "time", SimpleNamespace(monotonic=made.monotonic))
    monkeypatch.setattr(MonotonicClock, "sleep_until", lambda self, t_s: made.sleep_until(self, t_s))


def test_short_steps_pass_in_full_and_long_ones_as_one_step(computer: Computer) -> None:
    clock = StandstillClock(STEP_S)
    start_s = clock.now_s()
    computer.real_s += 0.003
    assert clock.now_s() - start_s == pytest.approx(0.003)
    computer.real_s += 0.5
    assert clock.now_s() - start_s == pytest.approx(0.003 + STEP_S)
    assert clock.left_out_s == pytest.approx(0.5 - STEP_S)
    computer.real_s += 0.001
    assert clock.now_s() - start_s == pytest.approx(0.004 + STEP_S)


def test_a_sleep_passes_in_full_and_what_it_lasts_longer_as_one_step(computer: Computer) -> None:
    clock = StandstillClock(STEP_S)
    start_s = clock.now_s()
    clock.sleep_until(start_s + 0.05)
    assert clock.now_s() - start_s == pytest.approx(0.05)
    computer.stalls = [(0.06, 1.5)]
    clock.sleep_until(start_s + 0.10)
    assert clock.now_s() - start_s == pytest.approx(0.10 + STEP_S)
    assert clock.left_out_s == pytest.approx(1.5 - STEP_S)
    clock.sleep_until(start_s + 0.12)
    assert clock.now_s() - start_s == pytest.approx(0.12)
    clock.sleep_until(start_s)  # past
    assert clock.now_s() - start_s == pytest.approx(0.12)


def test_a_handler_that_raises_in_mid_sleep_leaves_a_clock_that_goes_on(
    computer: Computer, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = StandstillClock(STEP_S)
    start_s = clock.now_s()

    def interrupted(*_: Any) -> None:
        computer.real_s += 0.01
        clock.now_s()  # of the handler
        raise KeyboardInterrupt

    monkeypatch.setattr(MonotonicClock, "sleep_until", interrupted)
    with pytest.raises(KeyboardInterrupt):
        clock.sleep_until(start_s + 10)
    assert clock.now_s() - start_s == pytest.approx(0.01)
    computer.real_s += 1.0  # the rest of the sleep was not slept: this is a standstill
    assert clock.now_s() - start_s == pytest.approx(0.01 + STEP_S)


def test_looks_of_handlers_in_mid_sleep_do_not_make_it_a_standstill(
    computer: Computer, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = StandstillClock(STEP_S)
    start_s = clock.now_s()
    seen: list[float] = []

    def disturbed(_self: MonotonicClock, t_s: float) -> None:
        for _ in range(3):
            computer.real_s += 0.01
            seen.append(clock.now_s() - start_s)
        computer.real_s = t_s

    monkeypatch.setattr(MonotonicClock, "sleep_until", disturbed)
    clock.sleep_until(start_s + 0.05)
    assert seen == pytest.approx([0.01, 0.02, 0.03])
    assert clock.now_s() - start_s == pytest.approx(0.05)
    assert clock.left_out_s == 0


def test_a_look_from_another_thread_moves_nothing_and_does_not_run_ahead(computer: Computer) -> None:
    clock = StandstillClock(STEP_S)
    start_s = clock.now_s()
    seen: list[float] = []

    def look() -> None:
        thread = threading.Thread(target=lambda: seen.append(clock.now_s() - start_s))
        thread.start()
        thread.join()

    for _ in range(3):
        computer.real_s += 0.1
        look()
    assert seen == pytest.approx([STEP_S] * 3)
    assert clock.left_out_s == 0
    assert clock.now_s() - start_s == pytest.approx(STEP_S)
    assert clock.left_out_s == pytest.approx(0.3 - STEP_S)


def test_a_sleep_ends_though_its_end_is_rounded_down(computer: Computer) -> None:
    clock = StandstillClock(STEP_S)
    computer.real_s += 50.0  # the computer's time is then of coarser grain than the clock's
    rounded = 0
    for number in range(1, 2000):
        computer.real_s += 0.1 / number
        until_s = clock.now_s() + 1e-3 / number
        rounded += (until_s + clock.left_out_s) - clock.left_out_s < until_s
        clock.sleep_until(until_s)
        assert clock.now_s() >= until_s
    assert rounded  # else this shows nothing


STEPS = st.lists(
    st.tuples(st.sampled_from(["work", "sleep", "other thread"]), st.floats(0, 2), st.floats(0, 0.02)),
    max_size=30,
)


@settings(deadline=None, max_examples=150)
@given(STEPS)
def test_it_never_goes_back_and_leaves_out_no_more_than_it_must(
    steps: list[tuple[str, float, float]],
) -> None:
    with pytest.MonkeyPatch.context() as monkeypatch:
        computer = Computer()
        install(computer, monkeypatch)
        clock = StandstillClock(STEP_S)
        before_s = clock.now_s()
        for what, stall_s, asked_s in steps:
            if what == "sleep":
                computer.stalls = [(0.0, stall_s)]
                clock.sleep_until(before_s + asked_s)
                allowed_s = asked_s + STEP_S
            else:
                computer.real_s += stall_s
                allowed_s = STEP_S
            if what == "other thread":
                clock._driver += 1
                assert before_s <= clock.now_s() <= before_s + allowed_s + 1e-9
                clock._driver -= 1
            now_s = clock.now_s()
            assert before_s <= now_s <= before_s + allowed_s + 1e-9
            assert now_s + clock.left_out_s == pytest.approx(computer.real_s)
            if what != "sleep" and stall_s <= STEP_S:
                assert now_s - before_s == pytest.approx(stall_s)
            before_s = now_s


class Bench:
    """A run on the simulated board of this process, on this computer."""

    def __init__(self, computer: Computer, *, rate_hz: float = 100, duration_s: float = 6) -> None:
        self.clock = StandstillClock(min(0.005, 0.4 / rate_hz))
        self.link = InProcessLink(SoftBoard(ROBOT, plant=LagPlant(ROBOT.joints, TAU_S)), self.clock)
        board = Board(self.link, self.clock)
        board.connect()
        self.memory = Memory()
        computer.begin_s, computer.look_s = computer.real_s, 1e-7
        self.loop = RunLoop(
            board,
            ROBOT,
            lambda start: GaitMotion(GAIT, ROBOT.joints, duration_s, 1, start),
            rate_hz=rate_hz,
            clock=self.clock,
            amplitude_rad=GAIT.alpha_rad,
            recorder=self.memory,
        )


@pytest.mark.parametrize("rate_hz", [20, 100, 500])
@pytest.mark.parametrize("stall_s", [0.06, 0.12, 0.3, 1.5, 600.0])
def test_no_tick_is_late_by_a_standstill_and_no_watchdog_runs_out(
    computer: Computer, rate_hz: float, stall_s: float
) -> None:
    bench = Bench(computer, rate_hz=rate_hz, duration_s=3)
    computer.stalls = [(time_s, stall_s) for time_s in (1.0, 1.0 + stall_s + 0.003, 2.0 + 2 * stall_s)]
    result = bench.loop.run()
    progress = result.progress
    assert result.ended == "finished"
    assert (progress.late, progress.skipped, progress.lost) == (0, 0, 0)
    assert progress.standstill.times in (2, 3)
    step_s = min(0.005, 0.4 / rate_hz)
    assert progress.standstill.total_s == pytest.approx(3 * stall_s, abs=3 * step_s + 1e-3)
    times_s = np.array([tick.t_s for tick in bench.memory.ticks])
    np.testing.assert_allclose(times_s, np.arange(len(times_s)) / rate_hz, atol=2 * step_s + 1e-4)


def test_standstills_are_told_in_the_log_and_ticks_keep_the_wall_clock(computer: Computer) -> None:
    bench = Bench(computer)
    computer.stalls = [(2.0, 0.2), (4.5, 0.12)]
    progress = bench.loop.run().progress
    assert str(progress.standstill) == "this computer stood still 2 times, 0.31 s in all, the longest 0.20 s"
    told = [event for event in bench.memory.events if event.kind == "standstill"]
    assert [event.data["times"] for event in told] == [1, 2]
    assert told[0].message == "this computer stood still once, for 0.20 s"
    wall_s = np.diff([tick.host_time_ns for tick in bench.memory.ticks]) * 1e-9
    assert sorted(wall_s)[-2:] == pytest.approx([0.13, 0.21], abs=0.006)


def test_many_standstills_make_few_events(computer: Computer) -> None:
    bench = Bench(computer)
    computer.stalls = [(0.02 * number, 0.015) for number in range(1, 300)]
    progress = bench.loop.run().progress
    told = [event for event in bench.memory.events if event.kind == "standstill"]
    assert progress.standstill.times > 100
    assert 2 <= len(told) <= 8
    assert told[-1].data["total_s"] == progress.standstill.total_s


def test_what_is_left_out_before_the_first_tick_is_not_told(computer: Computer) -> None:
    bench = Bench(computer)
    make_motion = bench.loop._make_motion

    def slow(start: Any) -> Any:
        computer.real_s += 0.8
        return make_motion(start)

    bench.loop._make_motion = slow
    assert bench.loop.run().progress.standstill.times == 0
    assert "standstill" not in bench.memory.kinds


def test_a_simulation_slower_than_real_time_is_told_and_not_hidden(computer: Computer) -> None:
    """One computation of 14 ms a tick, at 100 Hz: each tick is one standstill."""
    bench = Bench(computer)
    integrate = bench.link.board.integrate

    def slow(now_s: float) -> None:
        computer.real_s += 0.014
        integrate(now_s)

    bench.link.board.integrate = slow  # type: ignore[method-assign]
    progress = bench.loop.run().progress
    assert progress.standstill.times > 500
    assert progress.standstill.total_s > 0.05 * progress.t_s


def test_a_host_that_is_late_by_many_short_steps_is_late(computer: Computer) -> None:
    """Steps below what counts as a standstill pass in full: the clock is no licence to be slow."""
    bench = Bench(computer)
    computer.look_s = 0.001
    progress = bench.loop.run().progress
    assert progress.standstill.times == 0
    assert progress.late > 100
    assert progress.often_late


@settings(deadline=None, max_examples=100)
@given(
    st.lists(
        st.tuples(st.booleans(), st.floats(0, 0.02), st.lists(st.none() | st.floats(0, 1), max_size=6)),
        min_size=1,
        max_size=12,
    )
)
def test_a_signals_handler_may_look_at_any_moment(
    steps: list[tuple[bool, float, list[float | None]]],
) -> None:
    """A handler interrupts the loop's thread in mid-look: just before or after the look has read the time.

    Each step is a look or a sleep of so long, and says for the following moments whether a signal comes, after what
    time.
    """
    with pytest.MonkeyPatch.context() as monkeypatch:
        computer = Computer()
        install(computer, monkeypatch)
        clock = StandstillClock(STEP_S)
        seen = [clock.now_s()]
        signals: list[float | None] = []
        handling: list[bool] = []

        def moment() -> None:
            if handling or not signals or (passes_s := signals.pop(0)) is None:
                return
            computer.real_s += passes_s
            handling.append(True)
            look()
            handling.pop()

        def look() -> None:
            highest_s = max(seen)
            now_s = clock.now_s()
            assert now_s >= highest_s - 1e-9
            seen.append(now_s)

        def monotonic() -> float:
            moment()
            real_s = computer.real_s
            moment()
            return real_s

        monkeypatch.setattr(clock_module, "time", SimpleNamespace(monotonic=monotonic))
        for sleeps, step_s, coming in steps:
            signals[:] = coming
            if sleeps:
                wanted_s = max(seen) + step_s
                clock.sleep_until(wanted_s)
                assert clock.now_s() >= wanted_s - 1e-9
            else:
                computer.real_s += step_s
            look()
        assert clock.now_s() + clock.left_out_s == pytest.approx(computer.real_s)
