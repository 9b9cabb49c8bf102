"""A main loop that hangs: the hardware watchdog of the Cortex-M example resets the board, and its joints are off."""

from __future__ import annotations

import socket
import time
from pathlib import Path

from boards import ahead_of_others, connected, free_port, qemu_with_monitor

from firmware_protocol.catalogue import BoardHeartbeat, Mode
from snakebot.clock import MonotonicClock
from snakebot.conformance import Bench
from snakebot.links import open_link

RAM = 0x20006000  # free: above the data, below the stack
ENDLESS_LOOP = "fee7"  # b . (Thumb), as it lies in memory
PROGRAM_COUNTER = 15
PATIENCE_S = 10.0


class Debugger:
    """As much of GDB's remote protocol as it takes to send a processor astray."""

    def __init__(self, port: int) -> None:
        self._socket = connected(port)
        self._socket.settimeout(PATIENCE_S)

        self._heard = ""

    def ask(self, words: str, answer: str = "OK") -> None:
        """Send a command, and wait for an answer that begins so."""
        checksum = sum(words.encode()) % 256
        self._socket.sendall(f"${words}#{checksum:02x}".encode())
        while not (said := self._packet()).startswith(answer):
            assert said.startswith("T"), f"{words!r} was answered {said!r}"  # T: where it stopped

    def _packet(self) -> str:
        while len(self._heard.partition("#")[2]) < 2:
            self._heard += self._socket.recv(4096).decode()
        self._socket.sendall(b"+")
        packet, _, rest = self._heard.partition("#")
        self._heard = rest[2:]
        return packet.partition("$")[2]

    def go_on(self) -> None:
        self._socket.sendall(b"$c#63")

    def close(self) -> None:
        self._socket.close()


def hang(monitor: socket.socket) -> Debugger:
    """The processor runs in a loop of one instruction from now on; the world around it goes on."""
    port = free_port()
    monitor.sendall(f"gdbserver tcp:127.0.0.1:{port}\n".encode())
    debugger = Debugger(port)
    debugger.ask("qXfer:features:read:target.xml:0,ffb", "l")  # before this, no register can be set
    debugger.ask(f"M{RAM:x},2:{ENDLESS_LOOP}")  # it stands since the debugger is there
    debugger.ask(f"P{PROGRAM_COUNTER:x}={RAM.to_bytes(4, 'little').hex()}")
    debugger.go_on()
    return debugger


def test_a_hung_main_loop_resets_the_board_with_its_joints_off(cortex_m_image: Path) -> None:
    with ahead_of_others(), qemu_with_monitor(cortex_m_image) as (port, monitor), open_link(port) as link:
        bench = Bench(link, MonotonicClock(), tolerance_s=0.03)
        bench.fresh()
        before = bench.beat()
        bench.enter(Mode.HOLDING)
        debugger = hang(monitor)
        try:
            deadline = time.monotonic() + PATIENCE_S
            beat = before
            while beat.boot_id == before.boot_id:
                assert time.monotonic() < deadline, "the board did not reset"
                beats = [m for m in bench.listen(0.05) if isinstance(m, BoardHeartbeat)]
                beat = beats[-1] if beats else beat
            assert (beat.mode, beat.powered, beat.holder) == (Mode.DISARMED, 0, 0)
            bench.fresh()
            bench.must_go(Mode.ARMED)
        finally:
            debugger.close()
