"""Keys that change a running gait."""

from __future__ import annotations

import io
import math
import os
import threading
from collections.abc import Iterator

import pytest

from snakebot.cli.keys import end, listening, press, shown
from snakebot.control.progress import Progress, TrackingSoFar
from snakebot.errors import BadInputError
from snakebot.gait import Gait


class Loop:
    """What of a run loop the keys use."""

    def __init__(self) -> None:
        self.progress = Progress(10, TrackingSoFar(5, 1))
        self.stops: list[str] = []
        self.gaits: list[Gait] = []
        self.changed = threading.Semaphore(0)
        self.stopped = threading.Event()
        self.may_check = threading.Event()
        self.may_check.set()

    @property
    def gait(self) -> Gait | None:
        return self.gaits[-1] if self.gaits else None

    @property
    def end_asked(self) -> bool:
        return "stop" in self.stops

    def request_stop(self) -> None:
        self.stops.append("stop")

    def request_emergency_stop(self) -> None:
        self.stops.append("emergency")
        self.stopped.set()

    def change_gait(self, gait: Gait, blend_s: float = 0.0) -> None:
        self.may_check.wait(20)
        if gait.alpha_rad > 1.2:
            raise BadInputError("joint 1: the motion asks for angle 70 deg")
        self.gaits.append(gait)
        self.changed.release()


@pytest.fixture
def typed(monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """Where what is written comes from the keyboard."""
    ours, theirs = os.openpty()
    with io.FileIO(theirs) as keyboard:
        monkeypatch.setattr("sys.stdin", keyboard)
        yield ours
    os.close(ours)


GAIT = Gait.from_degrees(66, 80, 2)


@pytest.mark.parametrize(
    ("key", "name", "value"),
    [
        ("a", "alpha_rad", math.radians(64)),
        ("A", "alpha_rad", math.radians(68)),
        ("b", "beta_rad", math.radians(78)),
        ("W", "omega_rad_s", 2.1),
        ("O", "offset_rad", math.radians(1)),
    ],
)
def test_a_letter_lowers_and_its_capital_raises(key: str, name: str, value: float) -> None:
    loop = Loop()
    assert getattr(press(loop, GAIT, key), name) == pytest.approx(value)  # type: ignore[arg-type]
    assert getattr(loop.gaits[-1], name) == pytest.approx(value)


def test_q_stops_and_the_space_bar_is_the_emergency_stop() -> None:
    loop = Loop()
    for text in ("q", " ", "?", "aaq "):
        end(loop, text)  # type: ignore[arg-type]
    assert loop.stops == ["stop", "emergency", "emergency", "stop"]
    assert loop.gaits == []


def test_the_emergency_stop_does_not_wait_for_a_gait_that_is_being_checked(typed: int) -> None:
    loop = Loop()
    loop.may_check.clear()
    with listening(loop, GAIT):  # type: ignore[arg-type]
        os.write(typed, b"aaa")
        os.write(typed, b" ")
        assert loop.stopped.wait(20)
        assert loop.gaits == []
        loop.may_check.set()


def test_keys_in_quick_succession_add_up_and_arrows_are_no_letters(typed: int) -> None:
    loop = Loop()
    loop.progress.ticks = 1
    with listening(loop, GAIT):  # type: ignore[arg-type]
        os.write(typed, b"\x1b[A\x1bOBaa\x1b[1;5Aab")  # arrow up, arrow down, a, a, Ctrl and arrow up, a, b
        for _ in range(4):
            assert loop.changed.acquire(timeout=20)
    assert len(loop.gaits) == 4
    assert loop.gaits[-1].alpha_rad == pytest.approx(math.radians(60))
    assert loop.gaits[-1].beta_rad == pytest.approx(math.radians(78))


def test_a_key_goes_out_from_what_the_page_asked_for() -> None:
    loop = Loop()
    loop.progress.ticks = 1
    loop.change_gait(Gait.from_degrees(30, 80, 2))
    assert press(loop, GAIT, "A").alpha_rad == pytest.approx(math.radians(32))  # type: ignore[arg-type]


def test_a_motion_that_is_no_gait_has_the_keys_that_end_it(typed: int) -> None:
    loop = Loop()
    with listening(loop, None):  # type: ignore[arg-type]
        os.write(typed, b"a ")
        assert loop.stopped.wait(20)
    assert loop.gaits == []
    assert shown(None).startswith("space bar EMERGENCY STOP")
    assert "alpha" not in shown(None)


def test_a_change_that_is_refused_is_noted_and_the_gait_stays() -> None:
    loop = Loop()
    gait = press(loop, Gait.from_degrees(68, 80, 2), "A")  # type: ignore[arg-type]
    assert gait == Gait.from_degrees(68, 80, 2)
    assert "joint 1" in loop.progress.note
    assert press(loop, Gait(0, 0, 0.05), "w").omega_rad_s == 0.05  # type: ignore[arg-type]  # no negative omega
