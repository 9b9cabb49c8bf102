"""A slow start is called compiling where something is compiled, and nowhere else."""

from __future__ import annotations

import threading

import pytest
from numba import njit

from snakebot.cli import ports
from snakebot.physics import compiled


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ports, "_PATIENCE_S", 0.01)
    monkeypatch.setattr(ports, "_LOOK_S", 0.01)


def test_a_slow_start_without_compiling_says_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with ports.patience(ports.SIM):
        threading.Event().wait(0.3)
    assert capsys.readouterr().err == ""


def test_compiling_is_told_once(capsys: pytest.CaptureFixture[str]) -> None:
    with ports.patience(ports.SIM):
        for _ in range(3):
            threading.Event().wait(0.05)  # not from the start on

            @njit()
            def kernel(x: float) -> float:
                total = 0.0
                for step in range(5):
                    total += x**step / (1.0 + step)
                return total

            kernel(1.5)
    assert capsys.readouterr().err.count("compiling the simulation") == 1
    assert not compiled.compiles()


def test_a_board_elsewhere_compiles_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with ports.patience("serial:/dev/ttyUSB0"):

        @njit()
        def half(x: float) -> float:
            return x / 2.0

        half(2.0)
        threading.Event().wait(0.1)
    assert capsys.readouterr().err == ""
