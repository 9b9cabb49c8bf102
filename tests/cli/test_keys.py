"""Keys that change a running gait."""

from __future__ import annotations

import math

import pytest

from snakebot.cli.keys import press
from snakebot.control.progress import Progress, TrackingSoFar
from snakebot.errors import BadInputError
from snakebot.gait import Gait


class Loop:
    """What of a run loop the keys use."""

    def __init__(self) -> None:
        self.progress = Progress(10, TrackingSoFar(5, 1))
        self.stops: list[str] = []
        self.gaits: list[Gait] = []

    def request_stop(self) -> None:
        self.stops.append("stop")

    def request_emergency_stop(self) -> None:
        self.stops.append("emergency")

    def change_gait(self, gait: Gait, blend_s: float) -> None:
        if gait.alpha_rad > 1.2:
            raise BadInputError("joint 1: the motion asks for angle 70 deg")
        self.gaits.append(gait)


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
    press(loop, GAIT, "q")  # type: ignore[arg-type]
    press(loop, GAIT, " ")  # type: ignore[arg-type]
    press(loop, GAIT, "?")  # type: ignore[arg-type]
    assert loop.stops == ["stop", "emergency"]
    assert loop.gaits == []


def test_a_change_that_is_refused_is_noted_and_the_gait_stays() -> None:
    loop = Loop()
    gait = press(loop, Gait.from_degrees(68, 80, 2), "A")  # type: ignore[arg-type]
    assert gait == Gait.from_degrees(68, 80, 2)
    assert "joint 1" in loop.progress.note
    assert press(loop, Gait(0, 0, 0.05), "w").omega_rad_s == 0.05  # type: ignore[arg-type]  # no negative omega
