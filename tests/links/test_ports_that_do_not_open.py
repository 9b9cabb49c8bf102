"""What a port that cannot be opened is answered: one line, the right exit status, what to do."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from snakebot.errors import BadInputError, NoBoardError, SnakebotError
from snakebot.links import open_link


@pytest.fixture
def closed_port() -> Iterator[int]:
    """A TCP port that nobody listens on: it is bound, so that nobody else does either."""
    with socket.socket() as bound:
        bound.bind(("127.0.0.1", 0))
        yield bound.getsockname()[1]


@pytest.mark.parametrize(
    ("port", "kind", "text"),
    [
        ("serial:/dev/there-is-none", NoBoardError, "no such device.*board list"),
        ("serial:/dev/null", NoBoardError, "not a serial device"),
        ("serial:/", NoBoardError, "not a serial device"),
        ("serial:socket://127.0.0.1", BadInputError, "socket://HOST:PORT"),
        ("serial:socket://127.0.0.1:port", BadInputError, "socket://HOST:PORT"),
        ("serial:socket://no-such-host.invalid:1", NoBoardError, "cannot connect"),
        ("serial:nonsense://x", BadInputError, "nonsense"),
        ("serial:loop://?nonsense=1", BadInputError, "option"),
        ("can:slcn/x", BadInputError, "did you mean slcan"),
        ("can:nonsense/x", BadInputError, "python-can has .*socketcan"),
        ("can:slcan//dev/there-is-none", NoBoardError, "no such device"),
        ("can:slcan//dev/null", NoBoardError, "not a serial device"),
        ("can:socketcan/there-is-none", NoBoardError, "ip link|no CAN"),
        ("can:socketcand/can0", BadInputError, "host"),
        ("can:udp_multicast/1.2.3.4", NoBoardError, "cannot be opened"),
        ("can:usb2can/x", NoBoardError, "usb2can cannot be used here"),
    ],
)
def test_one_line_that_says_what_to_do(port: str, kind: type[SnakebotError], text: str) -> None:
    with pytest.raises(kind, match=text) as caught:
        open_link(port).close()
    assert "\n" not in str(caught.value)
    assert port in str(caught.value)


def test_nobody_listens(closed_port: int) -> None:
    with pytest.raises(NoBoardError, match=r"cannot connect.*refused"):
        open_link(f"socket://127.0.0.1:{closed_port}")


def test_a_file_is_no_port(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("")
    for port in (f"serial:{file}", f"can:slcan/{file}"):
        with pytest.raises(NoBoardError, match="not a serial device"):
            open_link(port)


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may open everything")
def test_no_permission_names_the_group(tmp_path: Path) -> None:
    file = tmp_path / "locked"
    file.write_text("")
    file.chmod(0)
    with pytest.raises(NoBoardError, match="usermod -aG"):
        open_link(f"serial:{file}")


def test_a_speed_that_slcan_does_not_have() -> None:
    from snakebot.softboard.slcan_end import SlcanEnd

    end = SlcanEnd()
    with pytest.raises(SnakebotError, match="bitrate"):
        open_link(f"can:slcan/{end.path}?bitrate=123")
    open_link(end.port).close()  # and the adapter is free again
    end.close()
