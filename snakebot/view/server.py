"""The process that serves the page of a run, or of several one after the other: ``python -m snakebot.view.server FD``.

``FD`` is a socket of packets from the run (``messages``); the first says where to serve and what the run is. The
process ends when the run's end of it closes, as soon as the pages have been told.
"""

from __future__ import annotations

import asyncio
import contextlib
import http
import ipaddress
import itertools
import os
import signal
import socket
import sys
from collections.abc import Mapping
from typing import Any

from websockets.asyncio.server import Server as WebSocketServer
from websockets.asyncio.server import ServerConnection, serve
from websockets.http11 import Request, Response
from websockets.typing import Subprotocol

from snakebot.view import foxglove, pages
from snakebot.view.files import Doorkeeper, answer, refusal
from snakebot.view.messages import STATUS, ViewPacket, pack, unpack
from snakebot.view.picture import Picture

# Bytes from the run to the server's process; chosen: a tick of 16 joints has some kB.
_LARGEST_PACKET = 1 << 18
_LARGEST_WISH = 4096  # bytes: a page asks for little
_MOST_CONNECTIONS = 64  # pages, viewers and requests at one time: nobody needs more
_FAREWELL_S = 0.5  # the pages hear how the run ended before we go
_REPLY_S = 5.0  # a gait for a long run takes its time to be checked
# A stop does not wait behind ordinary work; the loop and the board, which are urgent, come before us.
_NICE = -10
_GONE = "its process has gone; the board's watchdog stops the joints"


def is_loopback(address: str) -> bool:
    """Whether only this computer can reach what listens there."""
    if address == "localhost":
        return True
    try:
        return ipaddress.ip_address(address.strip("[]")).is_loopback
    except ValueError:
        return False


def name_for_others(address: str) -> str:
    """What to open in a browser: in the place of "every address" (0.0.0.0, ::) the one that others reach us by."""
    try:
        anywhere = ipaddress.ip_address(address.strip("[]"))
    except ValueError:
        return address
    if not anywhere.is_unspecified:
        return address
    family, beyond = (
        (socket.AF_INET, "192.0.2.1") if anywhere.version == 4 else (socket.AF_INET6, "2001:db8::1")
    )
    with contextlib.suppress(OSError), socket.socket(family, socket.SOCK_DGRAM) as probe:
        probe.connect(
            (beyond, 9)
        )  # an address of documentation: nothing is sent, only the way there is looked up
        return str(probe.getsockname()[0])
    return socket.gethostname()


class Server:
    """The pages and viewers of one run.

    Args:
        about: what a page is told first.
        ask: hands a wish to the run; why it was refused, or None.
        stop_on_close: ramp down when the last page has gone.
    """

    def __init__(self, about: Mapping[str, Any], ask: pages.Ask, *, stop_on_close: bool = False) -> None:
        self.picture = Picture(int(about["joints"]))
        self._ask = ask
        self._stop_on_close = stop_on_close
        self._viewers = foxglove.Viewers(str(about["title"]))
        self._pages = pages.Pages(self.picture, about, ask, self._all_gone)
        self._door: Doorkeeper | None = None
        self._server: WebSocketServer | None = None

    def take(self, packet: ViewPacket) -> None:
        """Take in one record of the run."""
        with contextlib.suppress(ValueError, KeyError, TypeError):  # a damaged record is left out
            self.picture.take(packet)
        self._viewers.take(packet)
        self._pages.changed.set()
        self._pages.changed.clear()

    def begin(self, about: Mapping[str, Any]) -> None:
        """Another run begins: its pages stay open."""
        self.picture.begin_again(int(about["joints"]))
        self._pages.begin(about)

    def begin_again(self) -> None:
        """A recording is looked at from another moment."""
        self.picture.begin_again()

    async def end(self) -> None:
        """Nothing more comes: take no new page, tell those that are open."""
        if self._server is not None:
            self._server.close(close_connections=False)  # the next run may have the port
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_FAREWELL_S):
                await self._pages.end()

    @contextlib.asynccontextmanager
    async def listening(self, address: str, port: int, token: str) -> Any:
        """Serve; the address to open is what the block gets.

        Raises:
            OSError: that address and port cannot be had.
        """
        wanted = None if is_loopback(address) else token
        async with serve(
            self._connection,
            address,
            port,
            process_request=self._request,
            subprotocols=[Subprotocol(name) for name in (pages.SUBPROTOCOL, *foxglove.SUBPROTOCOLS)],
            select_subprotocol=_chosen,
            compression=None,  # on this computer it would cost more than it saves
            max_size=_LARGEST_WISH,
            max_queue=4,
            server_header=None,
        ) as server:
            self._server = server
            listens_on = next(iter(server.sockets)).getsockname()[1]
            self._door = Doorkeeper(address, listens_on, wanted)
            name = name_for_others(address)
            shown = f"[{name}]" if ":" in name else name
            yield f"http://{shown}:{listens_on}/" + (f"?token={wanted}" if wanted is not None else "")

    def _request(self, connection: ServerConnection, request: Request) -> Response | None:
        assert self._door is not None
        if self._server is not None and len(self._server.connections) > _MOST_CONNECTIONS:
            return refusal(http.HTTPStatus.SERVICE_UNAVAILABLE, "too many pages are open")
        why = self._door.refuses(request)
        if why is not None:
            return refusal(http.HTTPStatus.FORBIDDEN, why)
        if request.headers.get("Upgrade", "").lower() == "websocket":
            return None
        return answer(request)

    async def _connection(self, connection: ServerConnection) -> None:
        if connection.subprotocol == pages.SUBPROTOCOL:
            await self._pages.serve(connection)
        elif connection.subprotocol is not None:
            await self._viewers.serve(connection)

    async def _all_gone(self) -> None:
        if self._stop_on_close:
            await self._ask({"do": "ramp_down"})


def _chosen(connection: ServerConnection, offered: Any) -> Subprotocol | None:
    known = (pages.SUBPROTOCOL, *foxglove.SUBPROTOCOLS)
    return next((Subprotocol(name) for name in known if name in offered), None)


class _Run:
    """The run at the other end of the socket."""

    def __init__(self, end: socket.socket) -> None:
        self._end = end
        self._numbers = itertools.count(1)
        self._replies: dict[int, asyncio.Future[str | None]] = {}

    async def first(self) -> dict[str, Any]:
        return unpack(await asyncio.get_running_loop().sock_recv(self._end, _LARGEST_PACKET)).values()

    async def say(self, values: Mapping[str, Any]) -> None:
        await asyncio.get_running_loop().sock_sendall(self._end, pack(STATUS, 0, values))

    async def ask(self, wish: Mapping[str, Any]) -> str | None:
        number = next(self._numbers)
        reply: asyncio.Future[str | None] = asyncio.get_running_loop().create_future()
        self._replies[number] = reply
        try:
            await self.say({**wish, "id": number})
            async with asyncio.timeout(_REPLY_S):
                return await reply
        except (OSError, TimeoutError):
            return "the run does not answer: use `snakebot stop`, or the robot's power switch"
        finally:
            del self._replies[number]

    async def records(self, server: Server) -> None:
        """Take in what the run sends until it goes."""
        loop = asyncio.get_running_loop()
        while True:
            try:
                packet = unpack(await loop.sock_recv(self._end, _LARGEST_PACKET))
            except (OSError, ValueError):
                return
            values = packet.values() if packet.channel_id == STATUS else {}
            if "reply" in values:
                waiting = self._replies.get(values["reply"]["id"])
                if waiting is not None and not waiting.done():
                    waiting.set_result(values["reply"]["refused"])
            elif "begin" in values:
                server.begin(values["begin"])
            else:
                server.take(packet)


async def _main(fd: int) -> None:
    end = socket.socket(fileno=fd)
    end.setblocking(False)
    run = _Run(end)
    wanted = await run.first()
    server = Server(wanted["about"], run.ask, stop_on_close=wanted["stop_on_close"])
    try:
        async with server.listening(wanted["address"], wanted["port"], wanted["token"]) as url:
            await run.say({"url": url})
            await run.records(server)
            if not server.picture.status.get("ended"):
                server.take(unpack(pack(STATUS, 0, {"ended": True, "how": _GONE})))
            await server.end()
            os._exit(0)  # nothing is left to save, and a page that reads nothing must not keep us
    except OSError as error:
        why = error.strerror or str(error)
        with contextlib.suppress(OSError):
            await run.say(
                {"error": f"{wanted['address']} port {wanted['port']}: {why}; give another with --view-port"}
            )


if __name__ == "__main__":
    for number in (signal.SIGINT, signal.SIGHUP, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # the run decides when we end: its end of the socket closes
    with contextlib.suppress(OSError):  # only root may, and whom the computer's limits allow it (ulimit -e)
        os.setpriority(os.PRIO_PROCESS, 0, _NICE)
    asyncio.run(_main(int(sys.argv[1])))
