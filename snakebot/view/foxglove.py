"""The log's channels, live, in Foxglove's web socket protocol: for Foxglove, Lichtblick and PlotJuggler.

The protocol: https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md. Its two names differ in the name only.
"""

from __future__ import annotations

import asyncio
import contextlib
import secrets
import struct
from collections import deque
from typing import Any

import orjson
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from snakebot.runlog import channels
from snakebot.view.messages import STATUS, ViewPacket

SUBPROTOCOLS = ("foxglove.websocket.v1", "foxglove.sdk.v1")
_MESSAGE = struct.Struct("<BIQ")  # opcode, subscription, log time in ns
_MESSAGE_DATA = 1  # opcode of a message, Foxglove's websocket protocol 1
_QUEUED = 4000  # messages that wait for a slow viewer; then the oldest are left out
_CHANNELS = {channel.id: channel for channel in channels.CHANNELS}


class Viewers:
    """All viewers that speak this protocol; they watch, none drives."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._session = secrets.token_hex(8)
        self._open: set[_Viewer] = set()

    def take(self, packet: ViewPacket) -> None:
        """Hand one record on to whoever has asked for its channel."""
        if packet.channel_id != STATUS:
            for viewer in self._open:
                viewer.take(packet)

    async def serve(self, connection: ServerConnection) -> None:
        """Serve one viewer until it goes."""
        viewer = _Viewer(connection)
        self._open.add(viewer)
        sender = asyncio.create_task(viewer.send())
        try:
            await connection.send(orjson.dumps(self._server_info()).decode())
            await connection.send(orjson.dumps(_advertisement()).decode())
            async for text in connection:
                with contextlib.suppress(ValueError, KeyError, TypeError):
                    viewer.obey(orjson.loads(text))
        except ConnectionClosed:
            pass
        finally:
            sender.cancel()
            self._open.discard(viewer)

    def _server_info(self) -> dict[str, Any]:
        return {
            "op": "serverInfo",
            "name": self._name,
            "capabilities": [],
            "supportedEncodings": [channels.MESSAGE_ENCODING],
            "metadata": {},
            "sessionId": self._session,
        }


def _advertisement() -> dict[str, Any]:
    return {
        "op": "advertise",
        "channels": [
            {
                "id": channel.id,
                "topic": channel.topic,
                "encoding": channels.MESSAGE_ENCODING,
                "schemaName": channel.schema_name,
                "schema": channel.schema.decode(),
                "schemaEncoding": channels.SCHEMA_ENCODING,
            }
            for channel in _CHANNELS.values()
        ],
    }


class _Viewer:
    """One connection: which channels it wants, and what waits for it."""

    def __init__(self, connection: ServerConnection) -> None:
        self._connection = connection
        self._subscriptions: dict[int, int] = {}  # subscription -> channel
        self._queue: deque[bytes] = deque(maxlen=_QUEUED)
        self._filled = asyncio.Event()

    def obey(self, request: dict[str, Any]) -> None:
        """
        Raises:
            KeyError, TypeError, ValueError: not a request of the protocol.
        """
        if request["op"] == "subscribe":
            for wanted in request["subscriptions"]:
                if wanted["channelId"] in _CHANNELS and 0 <= int(wanted["id"]) < 1 << 32:
                    self._subscriptions[int(wanted["id"])] = wanted["channelId"]
        elif request["op"] == "unsubscribe":
            for number in request["subscriptionIds"]:
                self._subscriptions.pop(number, None)

    def take(self, packet: ViewPacket) -> None:
        for number, channel_id in self._subscriptions.items():
            if channel_id == packet.channel_id:
                self._queue.append(_MESSAGE.pack(_MESSAGE_DATA, number, packet.log_time_ns) + packet.data)
                self._filled.set()

    async def send(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            while True:
                await self._filled.wait()
                self._filled.clear()
                while self._queue:
                    await self._connection.send(self._queue.popleft())
