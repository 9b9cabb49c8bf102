"""Web sockets of the page itself: the newest state goes out, wishes come in."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

import orjson
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from snakebot.view.picture import Picture, Seen

SUBPROTOCOL = "snakebot.view.1"
FRAMES_PER_S = 30.0  # a page is sent at most so many; a slow one gets fewer, each the newest
MOST_ROWS = 400  # in one frame: what a page has missed beyond that is thinned
_BEAT_S = 0.25  # a page hears from us at least so often: after 1 s of silence it says so in red
_FOR_ALL = ("stop", "ramp_down")  # nobody needs to be the driver to end a motion
_MOST_WISHES = 16  # that are being answered at once; persons have one or two

Ask = Callable[[Mapping[str, Any]], Awaitable[str | None]]  # a wish; why it was refused, or None


class Pages:
    """All open pages.

    One of them drives (the first that came, or that asked when nobody did); the others watch. Anybody may stop.

    Args:
        about: what each is told first.
        ask: hands a wish to the run.
        all_gone: called when the last page has closed.
    """

    def __init__(
        self, picture: Picture, about: Mapping[str, Any], ask: Ask, all_gone: Callable[[], Awaitable[None]]
    ) -> None:
        self._picture = picture
        self._about = about
        self._runs = 0
        self._ask = ask
        self._all_gone = all_gone
        self._open: list[ServerConnection] = []
        self._driver: ServerConnection | None = None
        self._ended = False
        self._wishes: set[asyncio.Task[None]] = set()
        self.changed = asyncio.Event()  # set when the picture has

    def begin(self, about: Mapping[str, Any]) -> None:
        """Another run: all pages are told what it is."""
        self._about = about
        self._runs += 1

    async def end(self) -> None:
        """Send each page the last state, and close it. A page that does not take it is left."""
        self._ended = True
        self.changed.set()
        await asyncio.gather(*(connection.wait_closed() for connection in list(self._open)))

    async def serve(self, connection: ServerConnection) -> None:
        """Serve one page until it goes."""
        self._open.append(connection)
        if self._driver is None:
            self._driver = connection
        sender = asyncio.create_task(self._send(connection))
        try:
            async for text in connection:
                with contextlib.suppress(ValueError):
                    wish = orjson.loads(text)
                    if isinstance(wish, dict):
                        await self._take(connection, wish)
        except ConnectionClosed:
            pass
        finally:
            sender.cancel()
            self._open.remove(connection)
            if self._driver is connection:
                self._driver = None
            if not self._open and not self._ended:
                await self._all_gone()

    async def _take(self, connection: ServerConnection, wish: dict[str, Any]) -> None:
        """Answer each wish on its own: a stop waits for no answer, and goes out if its page closes at once."""
        if len(self._wishes) >= _MOST_WISHES:
            await self._obey(connection, wish)
            return
        task = asyncio.create_task(self._obey(connection, wish))
        self._wishes.add(task)
        task.add_done_callback(self._wishes.discard)

    async def _obey(self, connection: ServerConnection, wish: dict[str, Any]) -> None:
        if wish.get("do") == "drive":
            if self._driver is None:
                self._driver = connection
            return
        refused: str | None = "another page drives this run: this one watches"
        if wish.get("do") in _FOR_ALL or self._driver is connection:
            refused = await self._ask(wish)
        reply = {"type": "reply", "id": wish.get("id"), "do": wish.get("do"), "refused": refused}
        with contextlib.suppress(ConnectionClosed):
            await connection.send(orjson.dumps(reply).decode())

    async def _send(self, connection: ServerConnection) -> None:
        picture, seen, runs = self._picture, Seen(), -1
        with contextlib.suppress(ConnectionClosed):
            while True:
                if runs != self._runs:
                    runs = self._runs
                    await connection.send(orjson.dumps({"type": "hello", **self._about}).decode())
                ended = self._ended  # what is sent now is the last
                frame = picture.frame(seen, MOST_ROWS)
                frame["drives"] = self._driver is connection
                frame["free"] = self._driver is None
                frame["pages"] = len(self._open)
                await connection.send(orjson.dumps(frame).decode())
                if ended:
                    await connection.close(1001)
                    return
                await asyncio.sleep(1 / FRAMES_PER_S)
                with contextlib.suppress(TimeoutError):
                    async with asyncio.timeout(_BEAT_S):
                        await self.changed.wait()
