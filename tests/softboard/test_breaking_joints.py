"""Joints that break behind the board's back."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from snakebot.softboard.broken import Breakage, BreakingPlant


class Recorder:
    """A plant that writes down what it is told."""

    clock_ppm = 12.0

    def __init__(self) -> None:
        self.log: list[tuple[object, ...]] = []

    def command(self, t_s: float, setpoint_rad: Sequence[float]) -> None:
        self.log.append(("command", t_s, *setpoint_rad))

    def set_joint_mode(self, joint: int, mode: str, hold_rad: float | None = None) -> None:
        self.log.append(("mode", joint, mode, hold_rad))

    def advance(self, t_s: float) -> None:
        self.log.append(("advance", t_s))

    def encoder_counts(self) -> list[int]:
        return [1, 2]

    def pose(self) -> tuple[float, float, float, float]:
        return 1.0, 2.0, 3.0, 4.0


@pytest.fixture
def recorder() -> Recorder:
    return Recorder()


def test_a_joint_breaks_at_its_time_and_stays_broken(recorder: Recorder) -> None:
    plant = BreakingPlant(recorder, [Breakage(1.5, (2,), "rigid")])
    plant.advance(1.0)
    plant.set_joint_mode(2, "active")
    plant.advance(2.0)
    plant.set_joint_mode(2, "free")  # the board may want what it likes
    plant.set_joint_mode(1, "free")
    assert recorder.log == [
        ("advance", 1.0),
        ("mode", 2, "active", None),
        ("advance", 1.5),
        ("mode", 2, "rigid", None),
        ("advance", 2.0),
        ("mode", 1, "free", None),
    ]


def test_a_repaired_joint_is_as_the_board_wants_it_by_then(recorder: Recorder) -> None:
    plant = BreakingPlant(recorder, [Breakage(2.0, (1, 2), "active"), Breakage(1.0, (1,), "free")])
    plant.set_joint_mode(1, "active")
    plant.advance(1.0)
    plant.set_joint_mode(1, "free")
    plant.set_joint_mode(1, "active")
    recorder.log.clear()
    plant.advance(3.0)
    assert recorder.log == [
        ("advance", 2.0),
        ("mode", 1, "active", None),
        ("mode", 2, "free", None),  # the board has not spoken of it: as after a reset
        ("advance", 3.0),
    ]


def test_broken_from_the_start_at_an_angle(recorder: Recorder) -> None:
    plant = BreakingPlant(recorder, [Breakage(0.0, (2,), "rigid", 0.3)])
    plant.advance(0.0)
    assert recorder.log == [("advance", 0.0), ("mode", 2, "rigid", 0.3), ("advance", 0.0)]


def test_all_else_is_the_plants(recorder: Recorder) -> None:
    plant = BreakingPlant(recorder, [])
    plant.command(0.1, [0.2, 0.3])
    assert recorder.log == [("command", 0.1, 0.2, 0.3)]
    assert plant.encoder_counts() == [1, 2]
    assert plant.pose() == (1.0, 2.0, 3.0, 4.0)
    assert plant.clock_ppm == 12.0
