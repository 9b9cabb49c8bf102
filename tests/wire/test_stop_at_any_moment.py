"""An emergency stop that is asked for in the host, at any moment of a run, and a board that cannot be heard."""

from __future__ import annotations

import pytest
from wire_bench import Bench

from firmware_protocol.catalogue import Mode
from snakebot.errors import BoardFaultError, LostBoardError


@pytest.mark.parametrize("at", ["connected", "joint modes", "armed", "streaming", "holding"])
def test_an_emergency_stop_is_obeyed_at_any_moment(at: str) -> None:
    bench = Bench(duration_s=3)
    asked: list[float] = []
    moments = {
        "connected": lambda: bench.board.info is not None,
        "joint modes": lambda: bench.board.info is not None and bench.clock.now_s() > 0.15,
        "armed": lambda: bench.sim.mode is Mode.ARMED,
        "streaming": lambda: bench.loop.progress.ticks > 100,
        "holding": lambda: bench.sim.mode is Mode.HOLDING,
    }

    def ask() -> None:
        if not asked and moments[at]():
            asked.append(bench.clock.now_s())
            bench.loop.request_emergency_stop()

    bench.link.before = ask
    with pytest.raises(BoardFaultError, match="emergency stop"):
        bench.run()
    assert asked
    assert bench.clock.now_s() < asked[0] + 0.06
    bench.rest_of_life(0.01)
    assert bench.sim.mode is Mode.STOPPED
    assert not any(bench.joints.powered)
    if at in ("connected", "joint modes"):
        assert not any(on for _, _, on in bench.joints.power_changes), "stopped before it had power"


def test_a_board_that_is_not_heard_any_more_is_stopped() -> None:
    bench = Bench(duration_s=20)
    bench.link._to_host = lambda data: b"" if bench.clock.now_s() > 3 else data  # one wire of two is broken
    with pytest.raises(LostBoardError, match="silent"):
        bench.run()
    bench.rest_of_life(0.1)
    assert not any(bench.joints.powered)
    assert bench.sim.mode is Mode.STOPPED
    assert bench.joints.commands[-1][0] < 3.6


def test_a_stop_that_comes_while_a_gait_is_changed_is_not_undone() -> None:
    bench = Bench(duration_s=8)
    loop = bench.loop
    bench.board.connect()

    class Between:
        """The lock of the motion; before a key's change gets it, the loop begins its ramp down."""

        asked = False

        def __enter__(self) -> None:
            if self.asked:
                self.asked = False
                loop._streamed.end(loop.progress.t_s)

        def __exit__(self, *_: object) -> None:
            pass

    lock = Between()
    loop._streamed._changing = lock  # type: ignore[assignment]
    changed: list[float] = []

    def change() -> None:
        if loop.progress.t_s > 3 and not changed:
            changed.append(loop.progress.t_s)
            lock.asked = True
            loop.change_gait(bench.loop.gait, 0.5)  # type: ignore[arg-type]

    bench.link.before = change
    assert loop.run().duration_s < 5
