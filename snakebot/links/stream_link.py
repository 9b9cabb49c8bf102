"""Frames over a byte stream, whatever the bytes look like: COBS packets or slcan lines."""

from __future__ import annotations

import errno
from collections.abc import Callable, Iterable, Sequence
from time import monotonic
from typing import Protocol

from firmware_protocol.frame import Frame
from firmware_protocol.framing import StreamDecoder
from snakebot.errors import LostBoardError
from snakebot.links.base import Link
from snakebot.links.stream import Stream


class Decoder(Protocol):
    """Cuts a byte stream into frames, and counts what was none."""

    corrupt: int

    def feed(self, data: bytes) -> Sequence[Frame]: ...


class StreamLink(Link):
    """Frames over a byte stream, each batch in one write.

    Args:
        port: how the link calls itself.
        stream: the bytes.
        pack: frames to bytes.
        decoder: bytes to frames.
        frames_per_s: how many frames the line carries at most.
        low_latency: True when the driver was switched to hand every byte on at once, None where it has no such switch.
    """

    def __init__(
        self,
        port: str,
        stream: Stream,
        pack: Callable[[Iterable[Frame]], bytes],
        decoder: Decoder,
        frames_per_s: float,
        low_latency: bool | None = None,
    ) -> None:
        super().__init__(port, frames_per_s)
        self.low_latency = low_latency
        self._stream = stream
        self._pack = pack
        self._decoder = decoder
        self._closed = False

    def send(self, frames: Sequence[Frame]) -> None:
        """Hand all frames to the line in one write.

        Raises:
            LostBoardError: the line is gone, or has taken no byte for 80 ms.
            ProtocolError: a frame that the protocol does not have (a fault of the caller).
        """
        if not frames:
            self._check()
            return
        self.send_bytes(self._pack(frames))
        self.statistics.sent += len(frames)

    def send_bytes(self, data: bytes) -> None:
        """Put bytes on the line as they are: for asking what a board makes of noise.

        Raises:
            LostBoardError: the line is gone.
        """
        self._check()
        try:
            self._stream.write(data)
        except OSError as error:
            raise self._lost(error) from None
        self.statistics.bytes_sent += len(data)

    def receive(self, timeout_s: float) -> Sequence[Frame]:
        """All frames that are there, after at most ``timeout_s``.

        Raises:
            LostBoardError: the line is gone.
        """
        self._check()
        deadline_s = monotonic() + timeout_s
        while True:
            try:
                data = self._stream.read(timeout_s)
            except OSError as error:
                raise self._lost(error) from None
            if data:
                frames = self._decoder.feed(data)
                self.statistics.bytes_received += len(data)
                self.statistics.corrupt = self._decoder.corrupt
                if frames:
                    self.statistics.received += len(frames)
                    return frames
            timeout_s = deadline_s - monotonic()  # half a packet has come, or nothing
            if timeout_s <= 0:
                return []

    def quicken(self) -> None:
        if isinstance(self._decoder, StreamDecoder):
            self._decoder.quicken()

    def close(self) -> None:
        if not self._closed:
            self._closed = True
            self._stream.close()

    def _check(self) -> None:
        if self._closed:
            raise LostBoardError(f"{self.port}: the link is closed")

    def _lost(self, error: OSError) -> LostBoardError:
        reason = error.strerror or str(error)
        if error.errno == errno.ENOBUFS:
            return LostBoardError(f"{self.port}: {reason}")
        return LostBoardError(f"{self.port}: the line was lost: {reason}: check cable and supply")
