"""The board's end of a serial line: a pseudo-terminal that hosts open, or a TCP port that they connect to.

Hosts come and go as they like. What nobody reads is thrown away, as on a line that nobody has plugged in: a board never
waits for a host, and a host that comes later does not read what was said long ago.
"""

from __future__ import annotations

import contextlib
import fcntl
import math
import os
import select
import socket
import struct
import termios
import time
import tty
from collections.abc import Sequence
from dataclasses import dataclass

from firmware_protocol.catalogue import Latch, Setpoint, frame_id
from firmware_protocol.frame import Frame
from firmware_protocol.framing import StreamDecoder, pack_all
from snakebot.errors import NoBoardError
from snakebot.links.base import Link
from snakebot.softboard.modes import WATCHDOG_MS

_CHUNK = 65536  # bytes; a pipe's buffer on Linux
_UNREAD_S = 0.25  # bytes that have waited this long have no reader
_DOUBT_S = 0.05  # nobody has been seen to read for this long: look before the next word, too
_BUSY_S = WATCHDOG_MS / 1000  # silence of a host that speaks with every tick
_MAX_HOSTS = 16  # on one TCP port: nobody needs more
_MAX_WAITING = 1024  # connections that the system keeps for us until the next look at the door
_ADMITTED_AT_ONCE = 64  # a crowd at the door does not keep the board from its work


class PtyEnd(Link):
    """A pseudo-terminal; ``path`` is the device that a host opens as its serial port.

    Raises:
        NoBoardError: the system has no pseudo-terminal left.
    """

    def __init__(self) -> None:
        try:
            self._master, self._slave = os.openpty()
        except OSError as error:
            raise NoBoardError(f"no pseudo-terminal: {error.strerror}") from None
        # The slave stays open here: a master whose last host has gone answers every read with an error.
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.path = os.ttyname(self._slave)
        super().__init__(f"serial:{self.path}", math.inf)
        self._decoder = StreamDecoder().quicken()
        self._waiting = 0  # bytes on their way to the host after the last write
        self._read_s = time.monotonic()  # when somebody last took bytes

    def send(self, frames: Sequence[Frame]) -> None:
        self._write(self._pack(frames))
        self.statistics.sent += len(frames)

    def _pack(self, frames: Sequence[Frame]) -> bytes:
        return pack_all(frames)

    def _unpack(self, data: bytes) -> Sequence[Frame]:
        frames = self._decoder.feed(data)
        self.statistics.corrupt = self._decoder.corrupt
        return frames

    def _write(self, data: bytes) -> None:
        if time.monotonic() - self._read_s > _DOUBT_S and self._unread_for_s() > _UNREAD_S:
            termios.tcflush(self._slave, termios.TCIFLUSH)
        written = 0
        with contextlib.suppress(BlockingIOError):
            written = os.write(self._master, data)
        self._waiting = self._unread()
        self.statistics.bytes_sent += written

    def _unread(self) -> int:
        (count,) = struct.unpack("i", fcntl.ioctl(self._slave, termios.FIONREAD, b"\0\0\0\0"))
        return int(count)

    def _unread_for_s(self) -> float:
        """How long nobody has taken a byte of what waits; zero where none waits."""
        unread = self._unread()
        now_s = time.monotonic()
        if unread == 0 or unread < self._waiting:
            self._read_s = now_s
        return now_s - self._read_s

    def receive(self, timeout_s: float) -> Sequence[Frame]:
        self._unread_for_s()  # looked at here, where nobody waits for an answer
        select.select([self._master], [], [], max(timeout_s, 0.0))
        try:
            data = os.read(self._master, _CHUNK)
        except BlockingIOError:
            return []
        frames = self._unpack(data)
        self.statistics.received += len(frames)
        self.statistics.bytes_received += len(data)
        return frames

    def close(self) -> None:
        for fd in (self._master, self._slave):
            with contextlib.suppress(OSError):
                os.close(fd)


@dataclass(slots=True)
class _Host:
    """One connection."""

    decoder: StreamDecoder
    heard_s: float  # when it came, or last said something that is a frame
    frames: int = 0  # it has said

    def standing(self, now_s: float) -> tuple[bool, bool, int, float]:
        """The host of least standing makes room: who never spoke, then the longest silent, of the busy the newest."""
        busy = now_s - self.heard_s < _BUSY_S
        return self.frames > 0, busy, self.frames if busy else 0, self.heard_s


class TcpEnd(Link):
    """A TCP port. Several hosts may be connected (one runs, another stops): all hear the board, the board hears all.

    As on a CAN bus, they hear one another's set-points, too: who looks on sees what the joints are asked for.

    Nobody is turned away, or an emergency stop might be: for a new connection too many, the one goes that has never
    said anything for the longest time, and where all have spoken, the one that has been silent for the longest. A host
    that drives the robot speaks with every tick: it stays, even if a crowd speaks between two of them.

    Args:
        host, port: where to listen; port 0 takes a free one, ``address`` says which.

    Raises:
        NoBoardError: the address cannot be listened on.
    """

    def __init__(self, host: str = "127.0.0.1", port: int = 0) -> None:
        try:
            self._door = socket.create_server((host, port), backlog=_MAX_WAITING)
        except (OSError, OverflowError) as error:
            raise NoBoardError(f"cannot listen on {host}:{port}: {error}") from None
        self._door.setblocking(False)
        self.address: tuple[str, int] = self._door.getsockname()[:2]
        super().__init__(f"serial:socket://{self.address[0]}:{self.address[1]}", math.inf)
        self._hosts: dict[socket.socket, _Host] = {}
        self._setpoint_ids = {frame_id(Setpoint), frame_id(Latch)}

    def send(self, frames: Sequence[Frame]) -> None:
        data = pack_all(frames)
        self._post(list(self._hosts), data)
        self.statistics.sent += len(frames)
        self.statistics.bytes_sent += len(data)

    def _post(self, hosts: Sequence[socket.socket], data: bytes) -> None:
        for host in hosts:
            try:
                whole = host.send(data) == len(data)
            except OSError:
                whole = False
            if not whole:  # gone, or it has not read for megabytes
                self._dismiss(host)

    def receive(self, timeout_s: float) -> Sequence[Frame]:
        ready, _, _ = select.select([self._door, *self._hosts], [], [], max(timeout_s, 0.0))
        if len(ready) == 1 and ready[0] is not self._door:  # as they came: nobody need look at each
            alone = self._listen(ready[0])
            self.statistics.received += len(alone)
            return alone
        frames: list[Frame] = []
        for end in ready:
            if end in self._hosts:
                frames += self._listen(end)
        if self._door in ready:
            frames += self._admit()
        self.statistics.received += len(frames)
        return frames

    def _listen(self, host: socket.socket) -> Sequence[Frame]:
        heard = self._hear(host)
        self._pass_on(host, heard)
        return heard

    def _pass_on(self, speaker: socket.socket, frames: Sequence[Frame]) -> None:
        """Let the others hear the set-points of one host."""
        others = [host for host in self._hosts if host is not speaker]
        if others and (heard := [frame for frame in frames if frame.id in self._setpoint_ids]):
            self._post(others, pack_all(heard))

    def _admit(self) -> Sequence[Frame]:
        """Let in who waits at the door. Returns what the newcomers have said already, and last words of who goes."""
        frames: list[Frame] = []
        with contextlib.suppress(OSError):  # nobody is left, or has gone again
            for _ in range(_ADMITTED_AT_ONCE):
                host, _ = self._door.accept()
                host.setblocking(False)
                host.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self._hosts[host] = _Host(StreamDecoder().quicken(), time.monotonic())
                frames += self._listen(host)
                if len(self._hosts) > _MAX_HOSTS:
                    frames += self._make_room()
        return frames

    def _make_room(self) -> Sequence[Frame]:
        """One host goes. What any of them has said by now counts for it, and is heard."""
        frames = [frame for host in list(self._hosts) if host in self._hosts for frame in self._listen(host)]
        if len(self._hosts) > _MAX_HOSTS:
            now_s = time.monotonic()
            self._dismiss(min(self._hosts, key=lambda host: self._hosts[host].standing(now_s)))
        return frames

    def _hear(self, host: socket.socket) -> Sequence[Frame]:
        try:
            data = host.recv(_CHUNK)
        except BlockingIOError:
            return []
        except OSError:
            data = b""
        if not data:
            self._dismiss(host)
            return []
        known = self._hosts[host]
        corrupt = known.decoder.corrupt
        frames = known.decoder.feed(data)
        if frames:
            known.frames += len(frames)
            known.heard_s = time.monotonic()
        self.statistics.corrupt += known.decoder.corrupt - corrupt
        self.statistics.bytes_received += len(data)
        return frames

    def _dismiss(self, host: socket.socket) -> None:
        del self._hosts[host]
        host.close()

    def close(self) -> None:
        for host in list(self._hosts):
            self._dismiss(host)
        self._door.close()
