"""CAN over UDP multicast stays within this computer unless the port says ``?network=1``.

python-can joins the group on whatever interface the routes name, and takes what is sent to its UDP port on any.
"""

from __future__ import annotations

import contextlib
import errno
import os
import socket
import sys
from typing import TYPE_CHECKING, Any

from snakebot.errors import BadInputError, NoBoardError

if TYPE_CHECKING:
    import can

OPTION = "network"

_IPV4 = "239.74.163.2"  # python-can's own
_IP_BOUND_IF = 25  # <netinet/in.h> of macOS; Python has no name for it
_MOST_HEARD = 10_000  # datagrams that can have come between opening and binding


def is_open(port: str, options: dict[str, Any]) -> bool:
    """Take our option from those of python-can: whether the bus is to reach other computers.

    Raises:
        BadInputError: it is neither 0 nor 1.
    """
    wanted = options.pop(OPTION, 0)
    if wanted not in (0, 1):
        raise BadInputError(
            f"port {port}: {OPTION}={wanted}: 1 opens the bus to other computers, 0 keeps it here"
        )
    return bool(wanted)


def keep_within_this_computer(port: str, bus: can.BusABC, group: str) -> None:
    """Bind an open bus to the loopback interface, and forget what it has heard before that.

    Raises:
        NoBoardError: this system cannot do that, or not with this group; the bus is still open.
    """
    try:
        with socket.socket(fileno=os.dup(bus.fileno())) as sock:
            _bind(sock, group)
            for _ in range(_MOST_HEARD):
                with contextlib.suppress(BlockingIOError):
                    sock.recv(1, socket.MSG_DONTWAIT)
                    continue
                break
    except (OSError, AttributeError) as error:  # Windows has neither way
        why = error.strerror if isinstance(error, OSError) else f"not on {sys.platform}"
        raise NoBoardError(
            f"{port}: cannot be kept within this computer ({why}); ?{OPTION}=1 opens it to the network, "
            "where whoever reaches this computer can drive the board"
        ) from None


def _bind(sock: socket.socket, group: str) -> None:
    """Send to, hear and be a member of the group on the loopback interface only.

    Raises:
        OSError: it cannot be done.
    """
    if sock.family != socket.AF_INET:  # Linux carries no IPv6 multicast over its loopback interface
        raise OSError(
            errno.EADDRNOTAVAIL, f"an IPv6 group does not go over the loopback interface: take {_IPV4}"
        )
    if sys.platform == "darwin":
        sock.setsockopt(socket.IPPROTO_IP, _IP_BOUND_IF, socket.if_nametoindex("lo0"))
    else:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, b"lo\0")
    here, anywhere, address = (socket.inet_aton(text) for text in ("127.0.0.1", "0.0.0.0", group))
    sock.setsockopt(socket.IPPROTO_IP, socket.IP_DROP_MEMBERSHIP, address + anywhere)
    sock.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, address + here)
    sock.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, here)
