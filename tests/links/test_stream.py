"""What a descriptor that is ready, and then gives nothing, means."""

from __future__ import annotations

import contextlib
import os
import select
import socket
import termios
import tty
from collections.abc import Iterator
from typing import Any

import pytest
import serial

from snakebot.links import stream
from snakebot.links.stream import FdStream, StreamEndError


@pytest.fixture
def far_and_near() -> Iterator[tuple[int, FdStream]]:
    """The far end of a pseudo-terminal, and a stream on a port that pyserial opened on the other."""
    far, near = os.openpty()
    tty.setraw(near)
    port = serial.Serial(os.ttyname(near), 115200, exclusive=True)
    os.close(near)
    opened = FdStream(port.fileno(), port.close)
    try:
        yield far, opened
    finally:
        opened.close()
        with contextlib.suppress(OSError):  # the test may have
            os.close(far)


class Selecting:
    """Stands where the stream finds ``select``: something happens between what it sees and what is read."""

    def __init__(self, happens: Any) -> None:
        self._happens = happens

    def __getattr__(self, name: str) -> Any:
        return getattr(select, name)

    def select(self, *arguments: Any) -> Any:
        ready = select.select(*arguments)
        self._happens()
        return ready


def test_bytes_flushed_before_they_are_read_do_not_end_a_line(
    far_and_near: tuple[int, FdStream], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A board throws away what nobody has read for a quarter of a second, which can be just when the host reads."""
    far, near = far_and_near
    os.write(far, b"old")
    with monkeypatch.context() as patch:
        patch.setattr(stream, "select", Selecting(lambda: termios.tcflush(near._fd, termios.TCIFLUSH)))
        assert near.read(1.0) == b""
    os.write(far, b"new")
    assert near.read(1.0) == b"new"


def test_a_line_whose_far_end_has_gone_is_lost(far_and_near: tuple[int, FdStream]) -> None:
    far, near = far_and_near
    os.close(far)
    with pytest.raises(OSError, match=r"Input/output error|closed by the other end"):
        near.read(1.0)


def test_a_connection_closed_by_the_far_end_is_lost() -> None:
    far, near = socket.socketpair()
    connection = FdStream(near.fileno(), near.close)
    far.close()
    with pytest.raises(StreamEndError, match="closed by the other end"):
        connection.read(1.0)
    connection.close()
