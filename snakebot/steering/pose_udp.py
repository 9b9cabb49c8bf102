"""Poses from a program beside this one, a camera's tracker for example, over UDP: ``udp://127.0.0.1:9000``.

A thread receives; the run takes what has come with a tick and never waits for it. Damage is counted, never an error.
"""

from __future__ import annotations

import contextlib
import ipaddress
import re
import socket
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from snakebot.errors import BadInputError
from snakebot.steering.pose_line import MOST_BYTES, Order, SaidPose, parse_pose
from snakebot.steering.poses import STALE_S

LOOPBACK = "127.0.0.1"
_GRAMMAR = re.compile(r"udp://(?P<host>\[[0-9a-fA-F:.]+\]|[^\[\]/:]*):(?P<port>\d{1,5})/?")
_BUFFER_BYTES = 16 << 10  # of the socket: what a flood leaves in it is at most this old news
_MOST_WAITING = 64  # poses between two ticks; the oldest are left out
_BURST, _REST_S = (
    32,
    0.002,
)  # datagrams at a stretch, and the rest after them: a flood takes no part of a tick
_LOOK_S = 0.2  # the thread sees as often whether it is to end


class UdpAddress(NamedTuple):
    """Where poses are listened for."""

    host: str
    port: int

    @property
    def open_to_others(self) -> bool:
        """Whether other computers can send poses there."""
        return not ipaddress.ip_address(self.host).is_loopback

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"udp://{host}:{self.port}"


def parse_pose_source(text: str) -> UdpAddress:
    """An address of this computer; without one (``udp://:9000``), and for ``localhost``, the loopback.

    Raises:
        BadInputError: not in the grammar.
    """
    found = _GRAMMAR.fullmatch(text)
    wrong = BadInputError(
        f"--pose {text!r}: must be like udp://{LOOPBACK}:9000, an address of this computer and a port"
    )
    if found is None or not 1 <= int(found["port"]) <= 65535:
        raise wrong
    host = found["host"].strip("[]")
    if host in ("", "localhost"):
        host = LOOPBACK
    try:
        ipaddress.ip_address(host)
    except ValueError:
        raise wrong from None
    return UdpAddress(host, int(found["port"]))


class UdpPoses:
    """Poses that come to an address. Receives from its making until ``close``.

    Args:
        now_s: the clock that tells when a pose came.

    Attributes:
        good, bad, old: how many lines were poses, were none, and said nothing newer than those before.

    Raises:
        BadInputError: the address is not this computer's, or taken.
    """

    def __init__(self, address: UdpAddress, now_s: Callable[[], float]) -> None:
        self.good = self.bad = self.old = 0
        self._address = address
        self._now_s = now_s
        self._order = Order()
        self._came_s: float | None = None
        self._waiting: deque[tuple[float, SaidPose]] = deque(maxlen=_MOST_WAITING)
        self._done = threading.Event()
        family = socket.AF_INET6 if ":" in address.host else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        try:
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_BYTES)
            self._socket.settimeout(_LOOK_S)
            self._socket.bind((address.host, address.port))
        except OSError as error:
            self._socket.close()
            raise BadInputError(f"--pose {address}: cannot listen there: {error.strerror or error}") from None
        self._thread = threading.Thread(target=self._receive, name="poses", daemon=True)
        self._thread.start()

    def take(self) -> list[tuple[float, SaidPose]]:
        """What has come since the last call, with the time at which it came. Never waits."""
        taken = []
        for _ in range(len(self._waiting)):
            with contextlib.suppress(IndexError):  # a newer one has pushed the oldest out
                taken.append(self._waiting.popleft())
        return taken

    def __str__(self) -> str:
        return f"--pose {self._address}"

    def close(self) -> None:
        """Receive no more."""
        self._done.set()
        self._thread.join()
        self._socket.close()

    def _receive(self) -> None:
        at_a_stretch = 0
        while not self._done.is_set():
            try:
                data = self._socket.recv(MOST_BYTES + 1)
            except TimeoutError:
                at_a_stretch = 0
                continue
            except OSError:  # an error report of the network: nothing was received
                data = b""
            self._read(data)
            at_a_stretch += 1
            if at_a_stretch >= _BURST:
                at_a_stretch = 0
                time.sleep(_REST_S)

    def _read(self, datagram: bytes) -> None:
        """A datagram may hold several lines; one that is too long was cut."""
        if len(datagram) > MOST_BYTES:
            self.bad += 1
            return
        now_s = self._now_s()
        for line in datagram.splitlines():
            if not line.strip():
                continue
            pose = parse_pose(line)
            if pose is None:
                self.bad += 1
                continue
            silent = self._came_s is not None and now_s - self._came_s > STALE_S
            if not self._order.newer(pose.t_s, after_silence=silent):
                self.old += 1
                continue
            self.good += 1
            self._came_s = now_s
            self._waiting.append((now_s, pose))
