"""The board's clock drifts, wraps and jumps; the host stalls. Ticks are skipped and counted, never bunched."""

from __future__ import annotations

import random
import time
from typing import Any

import numpy as np
import pytest
from wire_bench import Bench

from snakebot.errors import BoardFaultError


@pytest.mark.parametrize("ppm", [500.0, -500.0])
def test_a_clock_that_drifts_is_measured_and_does_no_harm(ppm: float) -> None:
    bench = Bench(duration_s=10, board={"drift_ppm": ppm})
    result = bench.run()
    assert result.ended == "finished"
    assert result.progress.lost == result.progress.late == 0
    estimate = bench.board.board_clock.estimate()
    assert estimate is not None
    assert estimate[1] == pytest.approx(ppm, abs=5)
    reference = Bench(duration_s=10)
    reference.run()
    assert bench.tracking_error(2, 8) == pytest.approx(reference.tracking_error(2, 8), rel=0.01)


def test_a_clock_that_wraps_in_mid_run_keeps_its_order() -> None:
    bench = Bench(duration_s=6, board={"clock_offset_us": 0xFFFFFFFF - 3_000_000})
    assert bench.run().ended == "finished"
    shown = np.array([tick.board_time_us for tick in bench.memory.ticks if tick.board_time_us is not None])
    assert len(shown) > 590
    steps = np.diff(shown)
    assert steps.min() > 9_000
    assert steps.max() < 11_000


@pytest.mark.parametrize("jump_us", [3_600_000_000, -2_000_000_000, 700_000])
def test_a_board_clock_that_jumps_does_not_end_the_run(jump_us: int) -> None:
    """Only what the wire shows jumps: the board's timers count from its reset."""
    bench = Bench(duration_s=4)
    jumped: list[float] = []

    def jump() -> None:
        clock = bench.sim._clock
        if clock is not None and bench.clock.now_s() > 2 and not jumped:
            jumped.append(bench.clock.now_s())
            clock._offset_us += jump_us

    bench.link.before = jump
    result = bench.run()
    assert jumped
    assert result.ended == "finished"
    assert result.progress.lost == 0
    assert all(tick.t_s >= 0 for tick in bench.memory.ticks)
    np.testing.assert_allclose(np.diff([tick.t_s for tick in bench.memory.ticks]), 0.01, atol=1e-6)


def test_the_hosts_wall_clock_set_back_an_hour_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench(duration_s=3)
    wall_ns = time.time_ns

    def back() -> None:
        if bench.clock.now_s() > 1.5:
            monkeypatch.setattr(time, "time_ns", lambda: wall_ns() - 3_600_000_000_000)

    bench.link.before = back
    assert bench.run().ended == "finished"
    stamps = np.array([tick.host_time_ns for tick in bench.memory.ticks])
    np.testing.assert_allclose(np.diff(stamps), 1e7, atol=10)


def test_a_tick_that_stalls_for_a_second_ends_the_run_without_a_burst() -> None:
    bench = Bench(duration_s=6)
    stalled: list[float] = []

    def stall() -> None:
        if bench.clock.now_s() > 3 and not stalled:
            bench.clock.sleep_until(bench.clock.now_s() + 1.0)
            stalled.append(bench.clock.now_s())

    bench.link.before = stall
    with pytest.raises(BoardFaultError, match="watchdog"):
        bench.run()
    after = [t for t, _ in bench.joints.commands if t >= stalled[0] - 0.001]
    assert len(after) <= 2, f"a burst of {len(after)} set-points"


@pytest.mark.parametrize("seed", range(4))
def test_a_loaded_machine_skips_ticks_and_never_bunches_them(seed: int) -> None:
    """Short stalls as a busy scheduler makes them: up to 45 ms, one in fifty waits."""
    bench = Bench(duration_s=8)
    draw = random.Random(seed)

    def stall() -> None:
        if bench.clock.now_s() > 1 and draw.random() < 0.005:
            bench.clock.sleep_until(bench.clock.now_s() + draw.uniform(0.0, 0.045))

    bench.link.before = stall
    result: Any = bench.run()
    progress = result.progress
    assert progress.late > 0
    assert progress.skipped > 0
    assert progress.ticks + progress.skipped == pytest.approx(801, abs=1)
    sent = np.array([tick.t_s for tick in bench.memory.ticks])
    for width in (2, 5, 10):  # in any stretch of time no more ticks than belong there, and one that was late
        assert (sent[width:] - sent[:-width]).min() > (width - 1) * 0.01 - 0.005
