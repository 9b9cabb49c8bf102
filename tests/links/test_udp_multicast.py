"""The contract of links on udp_multicast between two processes, in a network namespace that hears nobody else."""

from __future__ import annotations

import math
import multiprocessing
import os
import shutil
import socket
import struct
import subprocess
import sys
from collections.abc import Iterator, Sequence
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import pytest
from link_contract import FROM_HOST, LinkContract, Wire

from firmware_protocol.frame import Frame
from snakebot.errors import BadInputError, NoBoardError
from snakebot.links import Link, open_link, parse_port
from snakebot.links.can_link import open_can
from snakebot.links.port import CanPort

PORT = "can:udp_multicast/239.74.163.2"
INSIDE = "SNAKEBOT_TEST_INSIDE_NAMESPACE"
HOST_FRAME = Frame(FROM_HOST[0], bytes(8))
NO_LABORATORY = "no second interface can be made here"
NETWORK = "ip link set lo up && ip route add 239.0.0.0/8 dev lo"


def namespace() -> list[str] | None:
    """How to start a command in a network of its own, or None where that cannot be."""
    if shutil.which("unshare") is None or shutil.which("ip") is None:
        return None
    for how in (["unshare", "-rn"], ["unshare", "-n"]):
        if subprocess.run([*how, "sh", "-c", NETWORK], capture_output=True, check=False).returncode == 0:
            return how
    return None


@pytest.mark.slow
@pytest.mark.real_time
def test_the_contract_holds_between_two_processes_and_strangers_are_not_heard() -> None:
    how = namespace()
    if how is None:
        pytest.skip(
            "no network namespace can be made here (unshare, ip, or the right to use them is missing)"
        )
    here = Path(__file__)
    command = f'{NETWORK} && exec "$0" -m pytest "$1" -q -rs -p no:cacheprovider -k "TestUdp or TestWho"'
    result = subprocess.run(
        [*how, "sh", "-c", command, sys.executable, str(here)],
        cwd=here.parent.parent.parent,
        env={**os.environ, INSIDE: "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    contract = [name for name in dir(LinkContract) if name.startswith("test_")]
    hears = 0 if NO_LABORATORY in result.stdout else 10
    expected = f"{len(contract) - 2 + hears} passed, {2 + 10 - hears} skipped"
    assert expected in result.stdout, result.stdout


def far_end(pipe: Connection) -> None:
    """The board's process: does what it is told over a pipe."""
    link: Link | None = None
    while True:
        what, argument = pipe.recv()
        answer = None
        if what == "open":
            link = open_can(CanPort("udp_multicast", "239.74.163.2"), role="Board")
        elif what == "end":
            return
        assert link is not None
        if what == "send":
            link.send([Frame(*frame) for frame in argument])
        elif what == "receive":
            answer = [tuple(frame) for frame in link.receive(argument)]
        elif what == "close":
            link.close()
        pipe.send(answer)


class FarEnd(Link):
    """The board's end, in the other process."""

    def __init__(self, pipe: Connection) -> None:
        super().__init__(PORT, math.inf)
        self._pipe = pipe
        self._ask("open")

    def _ask(self, what: str, argument: object = None) -> Any:
        self._pipe.send((what, argument))
        return self._pipe.recv()

    def send(self, frames: Sequence[Frame]) -> None:
        self._ask("send", [tuple(frame) for frame in frames])

    def receive(self, timeout_s: float) -> list[Frame]:
        return [Frame(*frame) for frame in self._ask("receive", timeout_s)]

    def close(self) -> None:
        self._ask("close")


class TestUdpMulticast(LinkContract):
    __test__ = INSIDE in os.environ

    @pytest.fixture(scope="class")
    def other_process(self) -> Iterator[Connection]:
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe()
        process = context.Process(target=far_end, args=(theirs,))
        process.start()
        yield ours
        ours.send(("end", None))
        process.join(10.0)
        process.kill()

    @pytest.fixture
    def wire(self, other_process: Connection) -> Iterator[Wire]:
        board = FarEnd(other_process)
        host = open_link(PORT)
        yield Wire(host, board)
        host.close()
        board.close()


class TestWhoHears:
    """In a network with a second interface, as towards a laboratory."""

    __test__ = INSIDE in os.environ
    GROUP, UDP_PORT = "239.74.163.2", 43113

    @pytest.fixture(autouse=True)
    def laboratory(self) -> Iterator[None]:
        commands = (
            "ip link add lab0 type veth peer name lab1 && ip addr add 192.0.2.1/24 dev lab0 && "
            "ip link set lab0 up && ip link set lab1 up && ip route replace 239.0.0.0/8 dev lab0"
        )
        if subprocess.run(["sh", "-c", commands], capture_output=True, check=False).returncode:
            pytest.skip(NO_LABORATORY)
        yield
        subprocess.run(["sh", "-c", "ip link del lab0; ip route replace 239.0.0.0/8 dev lo"], check=True)

    def stranger(self, to: str) -> None:
        """A frame of a host's, as another computer of that network would put it on the wire."""
        import can
        from can.interfaces.udp_multicast.utils import pack_message

        data = pack_message(
            can.Message(arbitration_id=HOST_FRAME.id, data=HOST_FRAME.data, is_extended_id=False)
        )
        udp = struct.pack("!HHHH", 5000, self.UDP_PORT, 8 + len(data), 0) + data
        addresses = socket.inet_aton("192.0.2.9") + socket.inet_aton(to)
        head = struct.pack("!BBHHHBBH", 0x45, 0, 20 + len(udp), 0, 0, 1, socket.IPPROTO_UDP, 0) + addresses
        total = sum(struct.unpack("!10H", head))
        total = (total & 0xFFFF) + (total >> 16)
        checked = head[:10] + struct.pack("!H", ~((total & 0xFFFF) + (total >> 16)) & 0xFFFF) + head[12:]
        target = b"\x01\x00\x5e\x4a\xa3\x02"
        if to != self.GROUP:
            found = subprocess.run(
                ["ip", "-o", "link", "show", "lab0"], capture_output=True, text=True, check=True
            )
            target = bytes.fromhex(found.stdout.split("link/ether ")[1][:17].replace(":", ""))
        with socket.socket(socket.AF_PACKET, socket.SOCK_RAW) as sock:
            sock.bind(("lab1", 0))
            sock.send(target + bytes(6) + b"\x08\x00" + checked + udp)

    def receive(self, link: Link) -> list[Frame]:
        heard: list[Frame] = []
        for _ in range(20):
            heard += link.receive(0.02)
        return heard

    @pytest.mark.parametrize(("option", "heard"), [("", 0), ("?network=0", 0), ("?network=1", 1)])
    @pytest.mark.parametrize("to", ["239.74.163.2", "192.0.2.1"])
    def test_only_who_is_asked_for(self, option: str, heard: int, to: str) -> None:
        port = parse_port(f"can:udp_multicast/{self.GROUP}{option}")
        assert isinstance(port, CanPort)
        board = open_can(port, role="Board")
        self.stranger(to)
        assert self.receive(board) == [HOST_FRAME] * heard
        board.close()

    def test_two_on_this_computer_hear_each_other(self) -> None:
        board = open_can(CanPort("udp_multicast", self.GROUP), role="Board")
        host = open_link(PORT)
        host.send([HOST_FRAME])
        assert self.receive(board) == [HOST_FRAME]
        host.close()
        board.close()

    def test_a_group_that_would_not_stay_here_is_refused(self) -> None:
        subprocess.run(["sh", "-c", "ip -6 route add ff15::/16 dev lab0"], check=True)
        with pytest.raises(NoBoardError, match=r"IPv6 group .* take 239.74.163.2"):
            open_link("can:udp_multicast/ff15:7079::1")
        open_link("can:udp_multicast/ff15:7079::1?network=1").close()

    @pytest.mark.parametrize("option", ["network=2", "network=x"])
    def test_another_value_is_refused(self, option: str) -> None:
        with pytest.raises(BadInputError, match="1 opens the bus to other computers"):
            open_link(f"{PORT}?{option}")
