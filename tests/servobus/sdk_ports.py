"""The vendors' SDKs without a wire: a port that keeps what is written."""

from __future__ import annotations

from typing import Any


class KeptPort:
    """Stands in for a ``PortHandler``: ``written`` has the bytes of the last instruction."""

    def __init__(self, baud: int = 1_000_000) -> None:
        self.written = b""
        self.is_using = False
        self._baud = baud

    def clearPort(self) -> None:  # noqa: N802
        pass

    def writePort(self, packet: Any) -> int:  # noqa: N802
        self.written = bytes(packet)
        return len(packet)

    def readPort(self, length: int) -> list[int]:  # noqa: N802
        return []

    def getBaudRate(self) -> int:  # noqa: N802
        return self._baud

    def setPacketTimeout(self, length: int) -> None:  # noqa: N802
        pass

    def setPacketTimeoutMillis(self, milliseconds: float) -> None:  # noqa: N802
        pass

    def isPacketTimeout(self) -> bool:  # noqa: N802
        return True
