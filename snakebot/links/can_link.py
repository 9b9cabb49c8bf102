"""A board on a CAN bus, through any interface that python-can knows."""

from __future__ import annotations

import contextlib
import errno
import logging
import math
import os
from collections.abc import Sequence
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any, Literal

from firmware_protocol.frame import Frame
from snakebot.errors import BadInputError, LostBoardError, NoBoardError, SnakebotError
from snakebot.links import multicast
from snakebot.links.base import Link
from snakebot.links.capacity import can_frames_per_s
from snakebot.links.port import CanPort
from snakebot.links.serial_link import open_error, set_low_latency
from snakebot.links.slcan import SlcanDecoder, format_all
from snakebot.links.stream import STUCK_S, FdStream
from snakebot.links.stream_link import StreamLink
from snakebot.nearest import did_you_mean

if TYPE_CHECKING:
    import can

Role = Literal["Host", "Onlooker", "Board"]

_DEFAULTS: dict[str, dict[str, Any]] = {
    "slcan": {"sleep_after_open": 0, "timeout": 0},
}
_ECHOES = ("udp_multicast",)  # every sender hears its own frames
_BUS_OFF = 0x40  # in the identifier of a SocketCAN error frame
_FRAME_OVERHEAD_BYTES = 6  # 47 bits around the payload; the statistics count wire bytes roughly


class CanLink(Link):
    """Frames on a bus. Several hosts may listen; who is on the bus cannot be seen, only that nobody speaks.

    A bus has no end that could close: a board that goes away is silent. LostBoardError is raised when the interface
    itself goes: unplugged, down, bus-off, or no node acknowledging.

    Args:
        port: how the link calls itself.
        bus: an open python-can bus, which the link closes.
        hears: identifiers to take, where the interface hands back our own frames; None takes all.
        frames_per_s: how many frames the bus carries at most; infinity for one that is only in memory.
    """

    def __init__(
        self,
        port: str,
        bus: can.BusABC,
        hears: frozenset[int] | None = None,
        frames_per_s: float = math.inf,
    ) -> None:
        import can

        super().__init__(port, frames_per_s)
        self._bus = bus
        self._hears = hears
        self._closed = False
        self._message = can.Message
        self._error = can.CanError

    def send(self, frames: Sequence[Frame]) -> None:
        """Queue all frames, in order.

        Raises:
            LostBoardError: the interface is gone or its queue stays full for 80 ms.
        """
        self._check()
        for frame in frames:
            self._send(self._message(arbitration_id=frame.id, data=frame.data, is_extended_id=False))
            self.statistics.sent += 1
            self.statistics.bytes_sent += len(frame.data) + _FRAME_OVERHEAD_BYTES

    def _send(self, message: can.Message) -> None:
        deadline_s = monotonic() + STUCK_S
        while True:
            try:
                self._bus.send(message, STUCK_S)
                return
            except (self._error, OSError, ValueError) as error:
                full = _errno(error) == errno.ENOBUFS
                if not full or monotonic() >= deadline_s:
                    raise self._lost(error) from None
            sleep(0.001)  # SocketCAN's queue is ten frames; the bus needs 0.1 ms for each

    def receive(self, timeout_s: float) -> list[Frame]:
        """All frames that are there, after at most ``timeout_s``.

        Raises:
            LostBoardError: the interface is gone or the bus is off.
        """
        self._check()
        deadline_s = monotonic() + timeout_s
        frames: list[Frame] = []
        while True:
            message = self._receive(max(timeout_s, 0.0))
            if message is not None:
                frame = self._take(message)
                if frame is not None:
                    frames.append(frame)
            elif frames or timeout_s <= 0:
                return frames
            timeout_s = 0.0 if frames else deadline_s - monotonic()

    def _receive(self, timeout_s: float) -> can.Message | None:
        try:
            return self._bus.recv(timeout_s)
        except (self._error, OSError) as error:
            if isinstance(error.__cause__, Exception) and not isinstance(error.__cause__, OSError):
                self.statistics.corrupt += 1  # a packet that python-can could not read
                return None
            raise self._lost(error) from None
        except (ValueError, IndexError):
            self.statistics.corrupt += 1
            return None

    def _take(self, message: can.Message) -> Frame | None:
        if message.is_error_frame:
            if message.arbitration_id & _BUS_OFF:
                raise LostBoardError(f"{self.port}: the bus is off: check bit rate, wiring and termination")
            self.statistics.corrupt += 1
            return None
        if message.is_extended_id or message.is_remote_frame or message.is_fd:
            return None  # other nodes' business
        if self._hears is not None and message.arbitration_id not in self._hears:
            return None
        data = bytes(message.data)
        self.statistics.received += 1
        self.statistics.bytes_received += len(data) + _FRAME_OVERHEAD_BYTES
        return Frame(message.arbitration_id, data)

    def close(self) -> None:
        if not self._closed:
            self._closed = True
            with contextlib.suppress(Exception):  # a driver that is gone need not be told
                self._bus.shutdown()

    def _check(self) -> None:
        if self._closed:
            raise LostBoardError(f"{self.port}: the link is closed")

    def _lost(self, error: Exception) -> LostBoardError:
        number = _errno(error)
        if number == errno.ENETDOWN:
            advice = "the interface is down: `ip -details link show` tells why"
        elif number in (errno.ENODEV, errno.ENXIO):
            advice = "the interface is gone: is the adapter plugged in?"
        elif number in (errno.ENOBUFS, errno.EAGAIN) or "buffer full" in str(error):
            advice = "nobody acknowledges our frames: is the board on, is the bus terminated, is the bit rate right?"
        else:
            advice = f"{_one_line(error)}: check adapter, cable and supply"
        return LostBoardError(f"{self.port}: the bus was lost: {advice}")


def open_can(port: CanPort, role: Role = "Host") -> Link:
    """Open a bus.

    Args:
        port: interface, channel and options.
        role: whose messages we send: on interfaces that hand back our own frames only the other's are taken. An
            onlooker sends no set-points, and takes those of the host.

    Raises:
        BadInputError: no such interface, or it does not take these options.
        NoBoardError: it cannot be opened; the message says what to do.
    """
    import can

    name = str(port)
    logging.getLogger("can").addHandler(logging.NullHandler())  # its troubles come back as exceptions
    if port.interface not in can.VALID_INTERFACES:
        hint = did_you_mean(port.interface, can.VALID_INTERFACES)
        hint = hint or f"; python-can has {', '.join(sorted(can.VALID_INTERFACES))}"
        raise BadInputError(f"port {name}: no CAN interface {port.interface!r}{hint}")
    options = {key: can.util.cast_from_string(value) for key, value in port.options}
    if port.interface == "slcan" and os.name == "posix":
        return _open_slcan(port, options)
    bus = (_open_multicast if port.interface == "udp_multicast" else _open_bus)(port, options)
    hears = _ids_to_hear(role) if port.interface in _ECHOES else None
    return CanLink(name, bus, hears, can_frames_per_s(port))


def _open_multicast(port: CanPort, options: dict[str, Any]) -> can.BusABC:
    to_others = multicast.is_open(str(port), options)
    bus = _open_bus(port, options)
    if not to_others:
        try:
            multicast.keep_within_this_computer(str(port), bus, port.channel)
        except NoBoardError:
            bus.shutdown()
            raise
    return bus


def _open_slcan(port: CanPort, options: dict[str, Any]) -> StreamLink:
    """python-can opens the adapter; then its line is read and written in whole batches.

    python-can reads a byte at a time and waits for the line to drain after each frame.
    """
    lock = _lock(port)
    try:
        bus: Any = _open_bus(port, options)
    except SnakebotError:
        lock.close()
        raise
    line = bus.serialPortOrig

    def close() -> None:
        with contextlib.suppress(Exception):  # the adapter may be gone
            bus.shutdown()
        line.close()
        lock.close()

    return StreamLink(
        str(port),
        FdStream(line.fileno(), close),
        format_all,
        SlcanDecoder(),
        can_frames_per_s(port),
        set_low_latency(line),
    )


def _lock(port: CanPort) -> contextlib.ExitStack:
    """Have the adapter for us alone before python-can's first word would disturb who has it now."""
    import fcntl

    path = port.channel.partition("@")[0]
    lock = contextlib.ExitStack()
    if "://" in path:
        return lock
    try:
        fd = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        lock.callback(os.close, fd)
        fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        lock.close()
        raise NoBoardError(f"{port}: {open_error(error, path)}") from None
    return lock


def _open_bus(port: CanPort, options: dict[str, Any]) -> can.BusABC:
    import can

    name = str(port)
    channel: Any = can.util.cast_from_string(port.channel)
    try:
        return can.Bus(
            interface=port.interface,
            channel=channel if isinstance(channel, int) else port.channel,
            ignore_config=True,
            **{**_DEFAULTS.get(port.interface, {}), **options},
        )
    except TypeError as error:
        raise BadInputError(f"port {name}: {port.interface} does not take these options: {error}") from None
    except ValueError as error:
        raise BadInputError(f"port {name}: {_one_line(error)}") from None
    except Exception as error:  # drivers raise what they like
        raise NoBoardError(f"{name}: {_why_not(error, port)}") from None


def _why_not(error: Exception, port: CanPort) -> str:
    import can

    number = _errno(error)
    if port.interface == "socketcan":
        if number == errno.ENODEV:
            return (
                f"no such interface: `sudo ip link set {port.channel} up type can bitrate 1000000` brings it up "
                "once the adapter is plugged in"
            )
        if number == errno.EAFNOSUPPORT:
            return (
                "this kernel has no CAN: `sudo modprobe can can_raw`, or use can:slcan or can:udp_multicast"
            )
    if port.interface == "udp_multicast" and number in (errno.ENODEV, errno.ENETUNREACH):
        return "no route for multicast: `sudo ip route add 239.0.0.0/8 dev lo` makes one within this computer"
    if isinstance(error.__cause__, OSError) and port.interface in ("slcan", "seeedstudio", "robotell"):
        return open_error(error.__cause__, port.channel)
    if isinstance(error, can.CanInterfaceNotImplementedError | ImportError | NameError):
        return f"python-can's {port.interface} cannot be used here: {_one_line(error)}"
    return f"cannot be opened: {_one_line(error)}"


def _ids_to_hear(role: Role) -> frozenset[int]:
    """Identifiers of the messages that the other side sends."""
    from firmware_protocol.catalogue import Latch, Setpoint, database, frame_id

    if role == "Onlooker":
        return _ids_to_hear("Host") | {frame_id(Setpoint), frame_id(Latch)}
    return frozenset(message.frame_id for message in database().messages if role not in message.senders)


def _errno(error: BaseException) -> int | None:
    """The system's error number behind what python-can raised."""
    seen: BaseException | None = error
    while seen is not None:
        number = getattr(seen, "errno", None) or getattr(seen, "error_code", None)
        if isinstance(number, int):
            return number
        seen = seen.__cause__
    return None


def _one_line(error: BaseException) -> str:
    cause = f" ({error.__cause__})" if isinstance(error.__cause__, OSError) else ""
    return " ".join(f"{error}{cause}".split())
