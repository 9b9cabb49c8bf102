"""The contract of links on udp_multicast between two processes, in a network namespace that hears nobody else."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import pytest
from link_contract import LinkContract, Wire

from firmware_protocol.frame import Frame
from snakebot.links import Link, open_link

PORT = "can:udp_multicast/239.74.163.2"
INSIDE = "SNAKEBOT_TEST_INSIDE_NAMESPACE"
NETWORK = "ip link set lo up && ip route add 239.0.0.0/8 dev lo"


def namespace() -> list[str] | None:
    """How to start a command in a network of its own, or None where that cannot be."""
    if shutil.which("unshare") is None or shutil.which("ip") is None:
        return None
    for how in (["unshare", "-rn"], ["unshare", "-n"]):
        if subprocess.run([*how, "sh", "-c", NETWORK], capture_output=True, check=False).returncode == 0:
            return how
    return None


def test_the_contract_holds_between_two_processes() -> None:
    how = namespace()
    if how is None:
        pytest.skip(
            "no network namespace can be made here (unshare, ip, or the right to use them is missing)"
        )
    here = Path(__file__)
    command = f'{NETWORK} && exec "$0" -m pytest "$1" -q -p no:cacheprovider -k TestUdpMulticast'
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
    assert f"{len(contract) - 2} passed, 2 skipped" in result.stdout, result.stdout


def far_end(pipe: Connection) -> None:
    """The board's process: does what it is told over a pipe."""
    from snakebot.links.can_link import open_can
    from snakebot.links.port import CanPort

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
        super().__init__(PORT)
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
