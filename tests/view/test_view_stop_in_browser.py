"""STOP, pressed in Chromium, by what the board itself says: its own clock, its reason, its joints without power."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import pytest
from viewed_run import viewed
from visits import NEEDED, Visit

from firmware_protocol.catalogue import (
    BoardHeartbeat,
    Fault,
    FaultEvent,
    Message,
    Mode,
    State,
    decode,
)
from firmware_protocol.frame import ProtocolError
from snakebot.errors import EXIT_BOARD_FAULT
from snakebot.links import open_link
from snakebot.runlog import read_log

Said = TypeVar("Said", bound=Message)
pytestmark = [pytest.mark.slow, pytest.mark.real_time, NEEDED]


@contextmanager
def hearing(port: str) -> Iterator[list[Message]]:
    """What a board says from now on, to anybody on its line."""
    heard: list[Message] = []
    done = threading.Event()

    def listen() -> None:
        with open_link(port) as link:
            while not done.is_set():
                for frame in link.receive(0.05):
                    try:
                        heard.append(decode(frame))
                    except ProtocolError:
                        continue

    thread = threading.Thread(target=listen)
    thread.start()
    try:
        yield heard
    finally:
        done.set()
        thread.join()


def of(heard: list[Message], kind: type[Said]) -> list[Said]:
    return [message for message in list(heard) if isinstance(message, kind)]


@pytest.mark.parametrize("how", ["click", "space bar", "a page that only watches"])
def test_the_board_says_that_its_joints_are_without_power(
    how: str, browser: Any, board: tuple[str, ...], tmp_path: Path
) -> None:
    with hearing(board[1]) as heard, viewed(tmp_path / "run.mcap", *board) as run:
        visit = Visit(browser, run.url)
        visit.wait("parseFloat(document.getElementById('clock').textContent) > 2.5")
        before = of(heard, State)[-1]
        assert before.mode is Mode.ARMED
        if how == "space bar":
            visit.page.keyboard.press("Space")
        elif how == "click":
            visit.page.locator("#stop").click()
        else:
            watching = Visit(browser, run.url)
            watching.wait("document.getElementById('drive').textContent.includes('Another page drives')")
            before = of(heard, State)[-1]
            watching.page.locator("#stop").click()
        assert run.ends() == EXIT_BOARD_FAULT
        for _ in range(100):
            if [beat for beat in of(heard, BoardHeartbeat) if beat.mode is Mode.STOPPED]:
                break
            visit.page.wait_for_timeout(50)
    stop = of(heard, FaultEvent)[0]
    assert stop.code is Fault.EMERGENCY_STOP  # not the watchdog, which would have come for want of set-points
    beats = of(heard, BoardHeartbeat)
    assert beats[-1].mode is Mode.STOPPED
    assert beats[-1].powered == 0
    assert any(beat.powered for beat in beats)
    # By the board's clock: it was driven until the stop, and never after it.
    driven = [state.board_time_us for state in of(heard, State) if state.mode is Mode.ARMED]
    assert before.board_time_us <= max(driven) <= stop.board_time_us
    recorded = read_log(run.log).board_time_us
    assert recorded[-1] <= stop.board_time_us
