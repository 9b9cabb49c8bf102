"""What a served board does when: the answer first, the world when the wire is quiet, ready when a set-point is due."""

from __future__ import annotations

import gc
import math
import threading
from collections.abc import Callable, Sequence
from itertools import pairwise

import pytest
from board_rig import HOST, StillPlant, bench

from firmware_protocol.assembly import setpoint_messages
from firmware_protocol.catalogue import Mode, ModeRequest, State, decode, encode
from firmware_protocol.frame import Frame
from firmware_protocol.framing import pack_all
from snakebot.clock import VirtualClock
from snakebot.heap import settled_heap
from snakebot.links.base import Link
from snakebot.softboard import SoftBoard, serve
from snakebot.softboard.rehearsal import Rehearsal
from snakebot.softboard.serve import AHEAD_S, IDLE_S, QUIET_S

INTERVAL_S = 0.01


class Script(Link):
    """A wire on which set-points come on time; it notes what the board does in which order."""

    def __init__(self, clock: VirtualClock, stop: threading.Event) -> None:
        super().__init__("script:", math.inf)
        self.clock, self.stop = clock, stop
        self.did: list[tuple[str, float]] = []
        self.said: list[Frame] = []
        self._coming: list[tuple[float, list[Frame]]] = [
            (0.05, [encode(ModeRequest(1, Mode.ARMED, HOST))]),
            *(
                (0.1 + k * INTERVAL_S, [encode(m) for m in setpoint_messages(k, [0.0] * 5, INTERVAL_S)])
                for k in range(20)
            ),
        ]

    def receive(self, timeout_s: float) -> list[Frame]:
        self.did.append(("receive", timeout_s))
        until_s = self.clock.now_s() + timeout_s
        if self._coming and self._coming[0][0] <= until_s:
            at_s, frames = self._coming.pop(0)
            self.clock.sleep_until(at_s)
            self.did.append(("heard", self.clock.now_s()))
            return frames
        self.clock.sleep_until(until_s)
        if not self._coming and self.clock.now_s() > 0.35:
            self.stop.set()
        return []

    def send(self, frames: Sequence[Frame]) -> None:
        self.did.append(("send", self.clock.now_s()))
        self.said += frames

    def close(self) -> None: ...


class Watched(StillPlant):
    """Joints that note when their world goes on."""

    def __init__(self, note: Callable[[float], None]) -> None:
        super().__init__(5)
        self.note = note

    def advance(self, t_s: float) -> None:
        if t_s > self.now_s:
            self.note(t_s)
        super().advance(t_s)


@pytest.fixture
def script() -> Script:
    clock, stop = VirtualClock(), threading.Event()
    wire = Script(clock, stop)
    board = SoftBoard(bench(), plant=Watched(lambda t_s: wire.did.append(("world", t_s))))
    serve(board, wire, clock, stop)
    return wire


def test_every_setpoint_is_answered(script: Script) -> None:
    states = [message for frame in script.said if isinstance(message := decode(frame), State)]
    assert {state.sequence for state in states} >= set(range(1, 20))


def test_after_an_answer_the_wire_is_listened_to_before_the_world_goes_on(script: Script) -> None:
    answers = [index for index, (what, _) in enumerate(script.did[:-2]) if what == "send"]
    assert len(answers) > 20
    for index in answers:
        assert script.did[index + 1] == ("receive", QUIET_S)


def test_the_world_is_brought_up_to_date_just_before_a_setpoint_is_due(script: Script) -> None:
    arrivals = [(index, at_s) for index, (what, at_s) in enumerate(script.did) if what == "heard"]
    for index, at_s in arrivals[3:]:  # the first says when the next one comes
        world_s = [when_s for what, when_s in script.did[:index] if what == "world"][-1]
        assert at_s - world_s == pytest.approx(AHEAD_S, abs=1e-6)


def test_without_setpoints_the_world_lags_no_more_than_the_longest_wait(script: Script) -> None:
    first = next(at_s for what, at_s in script.did if what == "heard")
    world_s = [when_s for what, when_s in script.did if what == "world" and when_s < first]
    assert len(world_s) > 5
    assert max(b - a for a, b in pairwise(world_s)) <= IDLE_S + 1e-9


def test_a_rehearsal_goes_the_way_of_a_setpoint(script: Script) -> None:
    rehearsal = Rehearsal(bench())
    rehearsal.once()
    tick = [frame for frame in script.said if isinstance(decode(frame), State)]
    assert tick
    sizes = {rehearsal.once() for _ in range(300)}
    assert min(sizes) > len(pack_all(tick[:1])), "each is answered, with all that an answer has"


def test_the_heap_is_settled_for_as_long_as_it_matters() -> None:
    gc.unfreeze()  # the suite keeps its own settled
    try:
        with settled_heap():
            assert gc.get_freeze_count() > 1000
            with settled_heap():
                pass
            assert gc.get_freeze_count() > 1000, "the first still needs it"
        assert gc.get_freeze_count() == 0
    finally:
        gc.freeze()
