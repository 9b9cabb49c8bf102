"""Byte streams under a link: what a file descriptor, or a reader thread where there is none, has to say.

Both raise OSError once the far end has gone, with a text that a user can read.
"""

from __future__ import annotations

import contextlib
import errno
import os
import queue
import select
import socket
import threading
import time
from collections.abc import Callable
from typing import Any, Protocol

_CHUNK = 65536  # bytes; a pipe's buffer on Linux
STUCK_S = 0.08  # a line that takes no byte for this long is not one that can carry a control loop


class StreamEndError(OSError):
    """The far end has closed the stream."""


class Stream(Protocol):
    """Bytes out, bytes in. A read that times out returns no bytes."""

    def write(self, data: bytes) -> None: ...

    def read(self, timeout_s: float) -> bytes: ...

    def close(self) -> None: ...


class FdStream:
    """A non-blocking file descriptor: wait, then one read of all there is. POSIX only.

    It waits in ``select``, whose timeout has microseconds: ``poll`` rounds up to whole milliseconds.

    Args:
        fd: tty, pty or socket.
        close: lets go of what the descriptor belongs to.
    """

    def __init__(self, fd: int, close: Callable[[], None]) -> None:
        os.set_blocking(fd, False)
        self._fd = fd
        self._close = close

    def write(self, data: bytes) -> None:
        sent = self._write_some(data)
        if sent == len(data):
            return
        deadline = time.monotonic() + STUCK_S
        while sent < len(data):
            left_s = deadline - time.monotonic()
            if left_s <= 0:
                raise OSError(
                    errno.ENOBUFS,
                    f"the line has taken no byte for {1e3 * STUCK_S:.0f} ms: is its baud rate too low for this rate?",
                )
            select.select([], [self._fd], [], left_s)
            sent += self._write_some(data[sent:])

    def _write_some(self, data: bytes) -> int:
        try:
            return os.write(self._fd, data)
        except BlockingIOError:
            return 0

    def read(self, timeout_s: float) -> bytes:
        if not select.select([self._fd], [], [], max(timeout_s, 0.0))[0]:
            return b""
        try:
            data = os.read(self._fd, _CHUNK)
        except BlockingIOError:
            return b""
        if not data and self._has_ended():
            raise StreamEndError(errno.EIO, "closed by the other end")
        return data

    def _has_ended(self) -> bool:
        """Whether a read without bytes was the end: always on a socket, only where it is hung up on a tty.

        A tty also gives none where what ``select`` saw was flushed before it was read.
        """
        if not os.isatty(self._fd):
            return True
        line = select.poll()
        line.register(self._fd, 0)  # being hung up is always told
        return bool(line.poll(0))

    def close(self) -> None:
        self._close()


class ThreadStream:
    """A pyserial port without a descriptor (rfc2217://, loop://, Windows), read by a thread.

    Its own reads would do, but changing their timeout talks to the far end. The port's timeout must be short: closing
    waits for it.
    """

    def __init__(self, port: Any) -> None:
        self._port = port
        self._arrived: queue.SimpleQueue[bytes | OSError] = queue.SimpleQueue()
        self._error: OSError | None = None
        self._open = True
        self._thread = threading.Thread(target=self._pump, name=f"read {port.port}", daemon=True)
        self._thread.start()

    def _pump(self) -> None:
        while self._open:
            try:
                data = self._port.read(1)
                waiting = self._port.in_waiting
                if waiting:
                    data += self._port.read(waiting)
            except Exception as error:
                if self._open:
                    self._arrived.put(error if isinstance(error, OSError) else OSError(errno.EIO, str(error)))
                return
            if data:
                self._arrived.put(bytes(data))

    def write(self, data: bytes) -> None:
        if self._error is not None:
            raise self._error
        self._port.write(data)

    def read(self, timeout_s: float) -> bytes:
        if self._error is not None:
            raise self._error
        data = bytearray()
        try:
            item = self._arrived.get(timeout=timeout_s) if timeout_s > 0 else self._arrived.get_nowait()
            while True:
                if isinstance(item, OSError):
                    self._error = item
                    break
                data += item
                item = self._arrived.get_nowait()
        except queue.Empty:
            pass
        if not data and self._error is not None:
            raise self._error
        return bytes(data)

    def close(self) -> None:
        self._open = False
        self._port.close()
        self._thread.join(timeout=1.0)


def connect_tcp(host: str, port: int, timeout_s: float) -> FdStream:
    """A stream over TCP that holds nothing back.

    Raises:
        OSError: nobody listens there, or the name is unknown.
    """
    connection = socket.create_connection((host, port), timeout=timeout_s)
    return tcp_stream(connection)


def tcp_stream(connection: socket.socket) -> FdStream:
    """A connected socket as a stream."""
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def close() -> None:
        with contextlib.suppress(OSError):  # the far end may have been faster
            connection.shutdown(socket.SHUT_RDWR)
        connection.close()

    return FdStream(connection.fileno(), close)
