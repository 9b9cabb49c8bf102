"""Cables pulled, boards rebooted and hung, hosts stalled and killed, at random moments: the board is safe in 100 ms."""

from __future__ import annotations

import random
from collections import Counter, defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from wire_bench import Bench

from firmware_protocol.catalogue import EmergencyStop, Mode, encode
from snakebot.errors import BoardFaultError, HostLateError, LostBoardError, SnakebotError
from snakebot.softboard.modes import WATCHDOG_MS

WATCHDOG_S = WATCHDOG_MS * 1e-3
STEP_S = 0.0105  # a tick and the rounding of the virtual clock


class Killed(BaseException):
    """The host's process is gone in the middle of a line of code."""


def pulled(bench: Bench) -> None:
    bench.link.unplug()


def rebooted(bench: Bench) -> None:
    bench.sim.reset(bench.clock.now_s())


def hung(bench: Bench) -> None:
    """The board's wire is silent both ways; its watchdog, which is hardware, still runs."""
    bench.link._to_board = bench.link._to_host = lambda data: b""


def one_way(bench: Bench) -> None:
    """The host hears the board; the board hears nothing."""
    bench.link._to_board = lambda data: b""


def stopped_2_s(bench: Bench) -> None:
    """SIGSTOP: the board goes on, the host does not."""
    bench.clock.sleep_until(bench.clock.now_s() + 2.0)


def killed(bench: Bench) -> None:
    bench.link.unplug()  # what the loop does on its way out reaches nobody
    raise Killed


def stopped_from_elsewhere(bench: Bench) -> None:
    bench.sim.receive(encode(EmergencyStop(host=77)), bench.clock.now_s())


def terminated(bench: Bench) -> None:
    bench.loop.request_stop()


EXPECTED: dict[Callable[[Bench], None], tuple[type[BaseException], ...]] = {
    pulled: (LostBoardError,),
    rebooted: (BoardFaultError,),
    hung: (LostBoardError,),
    one_way: (BoardFaultError,),
    stopped_2_s: (BoardFaultError,),
    killed: (Killed,),
    stopped_from_elsewhere: (BoardFaultError,),
    terminated: (),
}
STATUS = {LostBoardError: 4, BoardFaultError: 5, HostLateError: 7}


def disconnect(
    how: Callable[[Bench], None], at_s: float, seed: int, recorder: Any = None
) -> tuple[str, float]:
    """One run that this happens to; how it ended, and after how long (s) the board's joints stood or had no power.

    Asserts that this was in time.
    """
    bench = Bench(None, seed, duration_s=3, ramp_s=0.5, recorder=recorder)
    happened: list[float] = []

    def strike() -> None:
        if not happened and bench.loop.progress.ticks and bench.clock.now_s() >= began[0] + at_s:
            happened.append(bench.clock.now_s())
            how(bench)

    began = [0.0]
    bench.board.connect()
    began[0] = bench.clock.now_s()
    bench.link.before = strike
    try:
        ended = bench.loop.run().ended
    except EXPECTED[how] as error:
        ended = type(error).__name__
        fault: BaseException = error
    else:
        fault = Killed()
        assert how is terminated, f"{how.__name__} went unnoticed"
    if isinstance(fault, SnakebotError):
        assert fault.exit_status == STATUS[type(fault)]
        assert len(str(fault).splitlines()) == 1
    bench.link.before = None
    assert happened, "nothing happened"
    bench.rest_of_life(max(0.0, happened[0] + WATCHDOG_S - bench.clock.now_s()))
    if how is not terminated:
        assert bench.sim.mode in (Mode.FAULT, Mode.STOPPED, Mode.DISARMED, Mode.HOLDING), bench.sim.mode
    safe_s = max(0.0, bench.sim._machine.fault_since_s - happened[0]) if how is not rebooted else 0.0
    assert safe_s <= WATCHDOG_S + 1e-6
    bench.rest_of_life(3.0)
    assert not any(bench.joints.powered)
    assert bench.sim.mode is not Mode.ARMED
    if how is not terminated:
        rows = [(t, row) for t, row in bench.joints.commands if t > happened[0] + WATCHDOG_S]
        frozen = np.array([row for _, row in rows])
        assert not len(frozen) or np.ptp(frozen, axis=0).max() < 1e-9, "it moved after the watchdog's time"
    return ended, safe_s


def strike_all(times: int, seed: int) -> Counter[str]:
    """``times`` disconnects, the kinds in turn, at random moments of a run."""
    draw = random.Random(seed)
    kinds = list(EXPECTED)
    ends: Counter[str] = Counter()
    worst_s: dict[str, float] = defaultdict(float)
    for count in range(times):
        how = kinds[count % len(kinds)]
        ended, safe_s = disconnect(how, draw.uniform(0.05, 2.5), count)
        what = f"{how.__name__}: {ended}"
        ends[what] += 1
        worst_s[what] = max(worst_s[what], safe_s)
    for what, count in sorted(ends.items()):
        ramped = what.startswith(terminated.__name__)
        how_safe = "ramped down" if ramped else f"frozen or off after at most {1e3 * worst_s[what]:.0f} ms"
        print(f"{count:4} {what}; {how_safe}")
    return ends


def test_disconnects_at_random_moments() -> None:
    ends = strike_all(24, 1)
    assert sum(ends.values()) == 24


@pytest.mark.slow
def test_two_hundred_disconnects_at_random_moments() -> None:
    assert sum(strike_all(200, 2).values()) == 200


@pytest.mark.parametrize("how", [pulled, hung, killed, stopped_2_s])
def test_the_log_of_a_run_that_was_cut_off_reads(how: Callable[[Bench], None], tmp_path: Path) -> None:
    from snakebot.robot import load_robot
    from snakebot.runlog import RunWriter, read_log

    path = tmp_path / "cut.mcap"
    writer = RunWriter(path, load_robot("penn_state"), {})
    disconnect(how, 1.5, 1, writer)
    writer.close()
    run = read_log(path).to_run()
    assert 100 < len(run.t_s) < 200
    assert np.isfinite(run.command_rad).all()
