"""Boards of another version: the suite says so, and the host's handshake fails with both sides named."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from boards import sim_in_process

import snakebot.softboard.reports as simulated
from firmware_protocol import catalogue
from firmware_protocol.catalogue import catalogue_hash
from snakebot.board import Board
from snakebot.clock import VirtualClock
from snakebot.conformance import Verdict, cases, run_case
from snakebot.errors import NoBoardError
from snakebot.robot import load_robot
from snakebot.softboard import InProcessLink, SoftBoard

OTHER_HASH = catalogue_hash() ^ 0xFF


def test_a_board_that_says_another_minor_version_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """With this host's catalogue that cannot be; the host goes on, since older ends may ignore what was added."""
    other = catalogue.PROTOCOL_MINOR + 1
    monkeypatch.setattr(simulated, "msg", SimpleNamespace(**{**vars(catalogue), "PROTOCOL_MINOR": other}))
    (case,) = (case for case in cases() if case.name == "identifies_itself")
    with sim_in_process() as bench:
        outcome = run_case(case, bench)
    assert outcome.verdict is Verdict.FAILED
    assert f"speaks {catalogue.PROTOCOL_MAJOR}.{other}" in outcome.detail


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("catalogue_hash", lambda: OTHER_HASH, (f"{catalogue_hash():08x}", f"{OTHER_HASH:08x}")),
        ("PROTOCOL_MAJOR", 9, ("protocol 2", "9")),
    ],
)
def test_another_version_is_named(
    name: str, value: object, words: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    catalogue_of_the_board = SimpleNamespace(**{**vars(catalogue), name: value})
    monkeypatch.setattr(simulated, "msg", catalogue_of_the_board)
    (case,) = (case for case in cases() if case.name == "identifies_itself")
    with sim_in_process() as bench:
        outcome = run_case(case, bench)
    assert outcome.verdict is Verdict.FAILED
    clock = VirtualClock()
    with (
        InProcessLink(SoftBoard(load_robot("penn_state")), clock) as link,
        pytest.raises(NoBoardError) as refused,
    ):
        Board(link, clock).connect()
    for word in words:
        assert word in outcome.detail
        assert word in str(refused.value)
