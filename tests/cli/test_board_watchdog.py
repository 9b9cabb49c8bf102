"""``snakebot board sim --watchdog-ms``: the simulated board waits so long for a set-point, and says so."""

from __future__ import annotations

import contextlib
import io
import signal
from collections.abc import Iterator, Sequence

import pytest

from firmware_protocol import catalogue as msg
from firmware_protocol.catalogue import Fault, FaultEvent, InfoFirmware, Mode, decode, encode
from firmware_protocol.frame import Frame
from snakebot import softboard
from snakebot.cli.main import main
from snakebot.softboard import SoftBoard

HOST = 0xA11CE


@pytest.fixture
def boards(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[SoftBoard]]:
    """The boards that commands would serve: they are not, so that time is virtual."""
    made: list[SoftBoard] = []
    monkeypatch.setattr(softboard, "serve", lambda board, *_: made.append(board))
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.getsignal(number) for number in numbers}
    yield made
    for number, handler in before.items():
        signal.signal(number, handler)


def sim(*options: str) -> tuple[int, str]:
    """Status and what is said."""
    said = io.StringIO()
    with (
        contextlib.redirect_stdout(said),
        contextlib.redirect_stderr(said),
        pytest.raises(SystemExit) as ended,
    ):
        main(["board", "sim", *options])
    return int(ended.value.code or 0), said.getvalue()


def heard(frames: Sequence[Frame], kind: type[msg.Message]) -> list[msg.Message]:
    return [message for message in map(decode, frames) if isinstance(message, kind)]


@pytest.mark.parametrize(
    ("options", "watchdog_ms"),
    [
        ([], 100),
        (["--watchdog-ms", "20"], 20),
        (["--watchdog-ms", "255"], 255),
        (["--watchdog-ms", "250", "--fault", "free:3@10s"], 250),
    ],
)
def test_it_waits_so_long(boards: list[SoftBoard], options: list[str], watchdog_ms: int) -> None:
    status, said = sim("--serial", *options)
    assert status == 0, said
    (board,) = boards
    board.advance(0.0)
    board.receive(encode(msg.InfoRequest(HOST)), 0.0)
    (firmware,) = heard(board.advance(0.0), InfoFirmware)
    assert isinstance(firmware, InfoFirmware)
    assert firmware.watchdog_ms == watchdog_ms
    board.receive(encode(msg.ModeRequest(1, Mode.ARMED, HOST)), 0.1)
    board.advance(0.1 + watchdog_ms * 1e-3 - 0.001)
    assert board.mode is Mode.ARMED
    (event, *_) = heard(board.advance(0.1 + watchdog_ms * 1e-3 + 0.001), FaultEvent)
    assert isinstance(event, FaultEvent)
    assert event.code is Fault.WATCHDOG
    assert event.board_time_us - 100_000 == pytest.approx(1000 * watchdog_ms, abs=500)


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--serial", "--watchdog-ms", "19"], "--watchdog-ms 19: give 20 to 255 ms"),
        (["--serial", "--watchdog-ms", "256"], "--watchdog-ms 256: give 20 to 255 ms"),
        (["--feetech", "--watchdog-ms", "100"], "simulated board"),
    ],
)
def test_what_it_cannot_wait_is_one_line(boards: list[SoftBoard], options: list[str], word: str) -> None:
    status, said = sim(*options)
    assert status == 2
    assert word in said
    assert len(said.strip().splitlines()) == 1
    assert not boards
