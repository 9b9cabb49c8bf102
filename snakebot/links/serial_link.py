"""A board on a serial line, or behind anything that pyserial can open: frames in COBS with a CRC."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from firmware_protocol.framing import StreamDecoder, pack_all
from snakebot.errors import BadInputError, NoBoardError
from snakebot.links.capacity import serial_frames_per_s
from snakebot.links.port import SerialPort
from snakebot.links.stream import STUCK_S, FdStream, Stream, ThreadStream, connect_tcp
from snakebot.links.stream_link import StreamLink

_CONNECT_S = 3.0  # for TCP
_READ_S = 0.1  # of pyserial's own reads, where a thread does them


def open_serial(port: SerialPort) -> StreamLink:
    """Open a serial port or a pyserial URL, for us alone.

    Raises:
        BadInputError: the URL or the baud rate is none.
        NoBoardError: no such device, no permission, in use by another program, nobody listens.
    """
    stream, low_latency = open_stream(port, str(port))
    return StreamLink(str(port), stream, pack_all, StreamDecoder(), serial_frames_per_s(port), low_latency)


def open_stream(port: SerialPort, name: str) -> tuple[Stream, bool | None]:
    """The bytes of a serial port, and whether its driver hands them on at once (None: it has no such switch).

    Raises:
        BadInputError, NoBoardError: as ``open_serial``; ``name`` is how messages call the port.
    """
    if port.device.lower().startswith("socket://") and os.name == "posix":
        return _open_tcp(name, port.device), None
    device = _open_pyserial(name, port)
    if not _has_descriptor(device):
        return ThreadStream(device), None
    return FdStream(device.fileno(), device.close), set_low_latency(device)


def _open_tcp(name: str, url: str) -> Stream:
    """pyserial's own socket:// waits 0.3 s when it closes and leaves Nagle's delay on."""
    try:
        parts = urlsplit(url)
        host, number = parts.hostname, parts.port
    except ValueError:
        host, number = None, None
    if host is None or number is None:
        raise BadInputError(f"port {name}: must be socket://HOST:PORT, for example socket://127.0.0.1:5555")
    try:
        return connect_tcp(host, number, _CONNECT_S)
    except (OSError, UnicodeError) as error:
        raise NoBoardError(
            f"{name}: cannot connect: {_reason(error)}: is the board's server running there?"
        ) from None


def _open_pyserial(name: str, port: SerialPort) -> Any:
    import serial

    try:
        device = serial.serial_for_url(
            port.device,
            baudrate=port.baud,
            rtscts=port.rtscts,
            timeout=_READ_S,
            write_timeout=None if port.is_url else STUCK_S,  # rfc2217:// has none
            do_not_open=True,
        )
        if port.dtr is not None:
            device.dtr = port.dtr
        if os.name == "posix":
            device.exclusive = True
        device.open()
    except KeyError:  # pyserial's answer to an option that it does not know
        raise BadInputError(f"port {name}: the URL has an option that pyserial does not know") from None
    except ValueError as error:
        raise BadInputError(f"port {name}: {error}") from None
    except OSError as error:  # SerialException is one
        raise NoBoardError(f"{name}: {open_error(error, port.device)}") from None
    return device


def _has_descriptor(device: Any) -> bool:
    """True for a plain tty. A spy:// port is one too, but must see the bytes go by."""
    return os.name == "posix" and type(device).__module__ == "serial.serialposix"


def set_low_latency(device: Any) -> bool | None:
    """Ask the driver of an open pyserial port to hand bytes on at once (1 ms instead of 16 ms on FTDI adapters).

    Returns:
        True: it does so now. None: it has no such switch, or does not let us.
    """
    try:
        device.set_low_latency_mode(True)
    except (OSError, ValueError, NotImplementedError, AttributeError):
        return None
    return True


def open_error(error: OSError, device: str) -> str:
    """What is wrong with a device that does not open, and what to do."""
    if "exclusively lock" in str(error):
        return "is in use by another program (another run, a terminal program, ModemManager): end that first"
    if "Could not configure port" in str(error):
        return "is not a serial device; `snakebot board list` shows what there is"
    match error.errno:
        case errno.ENOENT | errno.ENODEV | errno.ENXIO:
            return "no such device: is it plugged in? `snakebot board list` shows what is there"
        case errno.EACCES | errno.EPERM:
            return f"no permission: {permission_advice(device)}"
        case errno.EBUSY | errno.EAGAIN:
            return "is in use by another program: end that first"
        case errno.ENOTTY | errno.EISDIR | errno.EINVAL:
            return "is not a serial device; `snakebot board list` shows what there is"
    return f"cannot be opened: {_reason(error)}"


def permission_advice(device: str) -> str:
    """Who may open the device, as one piece of advice."""
    try:
        group = Path(device).group()
    except (OSError, KeyError, NotImplementedError):
        group = "dialout"
    return f"`sudo usermod -aG {group} $USER`, then log in again"


def _reason(error: Exception) -> str:
    return str(getattr(error, "strerror", None) or error)
