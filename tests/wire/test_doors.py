"""What listens, where, and whether it says so."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from snakebot.softboard import TcpEnd

ROOT = Path(__file__).parents[2]
WARNING = "whoever reaches this computer can drive the board"


def test_a_board_on_tcp_is_for_this_computer() -> None:
    end = TcpEnd()
    try:
        assert end.address[0] == "127.0.0.1"
    finally:
        end.close()


@pytest.mark.parametrize(("where", "warned"), [("0", False), ("127.0.0.1:0", False), ("0.0.0.0:0", True)])
def test_a_board_that_more_can_reach_says_so(where: str, warned: bool) -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "snakebot.cli.main", "board", "sim", "--tcp", where],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    port = process.stdout.readline()
    process.send_signal(signal.SIGTERM)
    _, said = process.communicate(timeout=30)
    assert port.startswith("--port serial:socket://" + ("0.0.0.0" if warned else "127.0.0.1"))
    assert (WARNING in said) == warned


def test_nothing_else_listens() -> None:
    """The board's TCP end and the socket for a tracker's poses (of this computer alone, unless told otherwise) are the
    only doors; a new one has to be written down here.
    """
    opens = re.compile(r"create_server|\.bind\(|http\.server|socketserver|start_server")
    found = {
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / "snakebot").rglob("*.py")
        if opens.search(path.read_text(encoding="utf-8"))
    }
    assert found == {"snakebot/softboard/ends.py", "snakebot/steering/pose_udp.py"}
