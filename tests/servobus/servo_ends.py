"""Emulated servos on a pseudo-terminal, and the command line as a user calls it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from rigs import emulated, on_a_pty

from snakebot.cli.main import main
from snakebot.servobus.emulated.end import ServoBusEnd


@pytest.fixture(params=["sts3215", "xl330"])
def end(request: pytest.FixtureRequest) -> Iterator[ServoBusEnd]:
    with on_a_pty(emulated(request.param)) as end:
        yield end


@pytest.fixture
def sts() -> Iterator[ServoBusEnd]:
    with on_a_pty(emulated("sts3215")) as end:
        yield end


def call(*words: str) -> int:
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert isinstance(ended.value.code, int)
    return ended.value.code
