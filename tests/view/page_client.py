"""What a page does, without a browser: for tests of the server."""

from __future__ import annotations

import json
import time
from contextlib import ExitStack
from typing import Any

from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin, Subprotocol

PAGE = Subprotocol("snakebot.view.1")


def socket_url(url: str) -> str:
    return url.replace("http", "ws", 1)


def armed(message: dict[str, object]) -> bool:
    status = message.get("status")
    return isinstance(status, dict) and status.get("mode") == "armed"


class PageClient:
    """One page's connection."""

    def __init__(self, url: str, origin: str | None = None) -> None:
        self._stack = ExitStack()
        self.connection: ClientConnection = self._stack.enter_context(
            connect(
                socket_url(url),
                subprotocols=[PAGE],
                origin=Origin(origin or url.split("/?")[0].rstrip("/")),
                compression=None,
                max_size=None,
            )
        )
        self.hello = self.read()

    def read(self, timeout_s: float = 5.0) -> dict[str, Any]:
        message = json.loads(self.connection.recv(timeout_s))
        assert isinstance(message, dict)
        return message

    def until(self, wanted: Any, timeout_s: float = 10.0) -> dict[str, Any]:
        """The first message that ``wanted`` says yes to."""
        deadline = time.monotonic() + timeout_s
        while time.monotonic() < deadline:
            message = self.read()
            if wanted(message):
                return message
        raise AssertionError("what was waited for did not come")

    def frame(self) -> dict[str, Any]:
        return self.until(lambda message: message["type"] == "frame")

    def ask(self, **wish: Any) -> str | None:
        """Ask for something; why it was refused, or None."""
        self.connection.send(json.dumps({**wish, "id": 1}))
        refused: str | None = self.until(lambda message: message["type"] == "reply")["refused"]
        return refused

    def close(self) -> None:
        self._stack.close()
