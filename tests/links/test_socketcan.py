"""The contract of links on SocketCAN, where this kernel has a virtual CAN bus and lets us make one.

Elsewhere: ``tools/vcan_guest`` runs these tests in an emulated Linux that has one.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
from collections.abc import Iterator

import pytest
from link_contract import FROM_HOST, LONG_S, LinkContract, Wire

from firmware_protocol.frame import Frame
from snakebot.doctor.port import check_socketcan
from snakebot.errors import LostBoardError, NoBoardError
from snakebot.links import open_link, parse_port
from snakebot.links.can_link import open_can
from snakebot.links.port import CanPort

NAME = f"snake{os.getpid() % 100000}"
PORT = f"can:socketcan/{NAME}"


def ip(*arguments: str) -> bool:
    if shutil.which("ip") is None:
        return False
    return subprocess.run(["ip", *arguments], capture_output=True, check=False).returncode == 0


@pytest.fixture(scope="module")
def bus() -> Iterator[None]:
    if not ip("link", "add", "dev", NAME, "type", "vcan"):
        pytest.skip(
            "no virtual CAN bus can be made here (kernel module vcan, and the right to add an interface)"
        )
    yield
    ip("link", "del", NAME)


@pytest.fixture
def up(bus: None) -> None:
    assert ip("link", "set", NAME, "up", "txqueuelen", "100")


@pytest.mark.usefixtures("up")
class TestSocketcan(LinkContract):
    @pytest.fixture
    def wire(self) -> Iterator[Wire]:
        port = parse_port(PORT)
        assert isinstance(port, CanPort)
        board, host = open_can(port, role="Board"), open_link(PORT)

        def cut() -> None:
            ip("link", "set", NAME, "down")

        yield Wire(host, board, cut)
        host.close()
        board.close()

    def test_what_a_host_sends_on_a_bus_that_is_down(self, wire: Wire) -> None:
        ip("link", "set", NAME, "down")
        with pytest.raises(LostBoardError, match="interface is down"):
            wire.host.send([Frame(FROM_HOST[0], b"")])

    def test_a_bus_that_goes_down_says_what_to_look_at(self, wire: Wire) -> None:
        ip("link", "set", NAME, "down")
        with pytest.raises(LostBoardError, match="interface is down"):
            wire.host.receive(LONG_S)


@pytest.mark.usefixtures("up")
def test_doctor_looks_at_the_interface() -> None:
    assert [finding.status for finding in check_socketcan(NAME)] == ["ok"]
    ip("link", "set", NAME, "down")
    (finding,) = check_socketcan(NAME)
    assert finding.status == "fail"


@pytest.mark.usefixtures("bus")
def test_an_interface_that_is_down_or_not_there_is_not_opened() -> None:
    ip("link", "set", NAME, "down")
    with contextlib.suppress(NoBoardError), open_link(PORT) as link, pytest.raises(LostBoardError):
        link.send([Frame(FROM_HOST[0], b"")])  # Linux binds to an interface that is down
    with pytest.raises(NoBoardError, match="ip link set"):
        open_link("can:socketcan/there-is-none")
