"""The board's end of a serial line: a pseudo-terminal that hosts open, or a TCP port that they connect to.

Hosts come and go as they like. What nobody reads is thrown away, as on a line that nobody has plugged in: a board never
waits for a host, and a host that comes later does not read what was said long ago.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import select
import socket
import struct
import termios
import time
import tty
from collections.abc import Sequence

from firmware_protocol.frame import Frame
from firmware_protocol.framing import StreamDecoder, pack_all
from snakebot.errors import NoBoardError
from snakebot.links.base import Link

_CHUNK = 65536
_UNREAD_S = 0.25  # bytes that have waited this long have no reader
_MAX_HOSTS = 16  # on one TCP port: nobody needs more, and whoever opens more means no good


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
        super().__init__(f"serial:{self.path}")
        self._decoder = StreamDecoder()
        self._waiting = 0  # bytes on their way to the host after the last write
        self._read_s = time.monotonic()  # when somebody last took bytes

    def send(self, frames: Sequence[Frame]) -> None:
        self._write(self._pack(frames))
        self.statistics.sent += len(frames)

    def _pack(self, frames: Sequence[Frame]) -> bytes:
        return pack_all(frames)

    def _unpack(self, data: bytes) -> list[Frame]:
        frames = self._decoder.feed(data)
        self.statistics.corrupt = self._decoder.corrupt
        return frames

    def _write(self, data: bytes) -> None:
        self._forget_unread()
        written = 0
        with contextlib.suppress(BlockingIOError):
            written = os.write(self._master, data)
        self._waiting = self._unread()
        self.statistics.bytes_sent += written

    def _unread(self) -> int:
        (count,) = struct.unpack("i", fcntl.ioctl(self._slave, termios.FIONREAD, b"\0\0\0\0"))
        return int(count)

    def _forget_unread(self) -> None:
        unread = self._unread()
        now_s = time.monotonic()
        if unread == 0 or unread < self._waiting:
            self._read_s = now_s
        elif now_s - self._read_s > _UNREAD_S:
            termios.tcflush(self._slave, termios.TCIFLUSH)

    def receive(self, timeout_s: float) -> list[Frame]:
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


class TcpEnd(Link):
    """A TCP port. Several hosts may be connected (one runs, another stops): all hear the board, the board hears all.

    Args:
        host, port: where to listen; port 0 takes a free one, ``address`` says which.

    Raises:
        NoBoardError: the address cannot be listened on.
    """

    def __init__(self, host: str = "127.0.0.1", port: int = 0) -> None:
        try:
            self._door = socket.create_server((host, port))
        except (OSError, OverflowError) as error:
            raise NoBoardError(f"cannot listen on {host}:{port}: {error}") from None
        self._door.setblocking(False)
        self.address: tuple[str, int] = self._door.getsockname()[:2]
        super().__init__(f"serial:socket://{self.address[0]}:{self.address[1]}")
        self._hosts: dict[socket.socket, StreamDecoder] = {}

    def send(self, frames: Sequence[Frame]) -> None:
        data = pack_all(frames)
        for host in list(self._hosts):
            try:
                whole = host.send(data) == len(data)
            except OSError:
                whole = False
            if not whole:  # gone, or it has not read for megabytes
                self._dismiss(host)
        self.statistics.sent += len(frames)
        self.statistics.bytes_sent += len(data)

    def receive(self, timeout_s: float) -> list[Frame]:
        ready, _, _ = select.select([self._door, *self._hosts], [], [], max(timeout_s, 0.0))
        frames: list[Frame] = []
        for end in ready:
            if end is self._door:
                self._admit()
            else:
                frames += self._hear(end)
        self.statistics.received += len(frames)
        return frames

    def _admit(self) -> None:
        with contextlib.suppress(OSError):  # it may have gone again
            host, _ = self._door.accept()
            if len(self._hosts) >= _MAX_HOSTS:
                host.close()
                return
            host.setblocking(False)
            host.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._hosts[host] = StreamDecoder()

    def _hear(self, host: socket.socket) -> list[Frame]:
        try:
            data = host.recv(_CHUNK)
        except BlockingIOError:
            return []
        except OSError:
            data = b""
        if not data:
            self._dismiss(host)
            return []
        decoder = self._hosts[host]
        corrupt = decoder.corrupt
        frames = decoder.feed(data)
        self.statistics.corrupt += decoder.corrupt - corrupt
        self.statistics.bytes_received += len(data)
        return frames

    def _dismiss(self, host: socket.socket) -> None:
        del self._hosts[host]
        host.close()

    def close(self) -> None:
        for host in list(self._hosts):
            self._dismiss(host)
        self._door.close()
