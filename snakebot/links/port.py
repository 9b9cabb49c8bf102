"""``--port``: one grammar for every link.

============================================= =====================================================================
``sim:``                                      the simulated board, in this process
``serial:DEVICE[?baud=...&rtscts=...&dtr=...]`` a serial port: ``serial:/dev/ttyUSB0?baud=1000000``, ``serial:COM4``
``serial:URL``                                any pyserial URL: ``serial:socket://127.0.0.1:5555``,
                                              ``serial:rfc2217://host:2217``
``can:INTERFACE/CHANNEL[?option=...&...]``    any python-can interface: ``can:socketcan/can0``,
                                              ``can:slcan//dev/ttyACM0?bitrate=1000000``,
                                              ``can:udp_multicast/239.74.163.2``
``feetech:DEVICE[?baud=...&ids=1-5]``         Feetech bus servos on a serial adapter; the board runs in the command
``dynamixel:DEVICE[?baud=...&ids=1,2,7-9]``   the same for Dynamixel X servos
============================================= =====================================================================

A bare device path, ``COM`` port or pyserial URL is taken as serial.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from snakebot.errors import BadInputError

DEFAULT_BAUD = 1_000_000  # bit/s; what the reference firmware sets
_SERIAL_EXAMPLE = "serial:/dev/ttyUSB0?baud=1000000"
_CAN_EXAMPLE = "can:socketcan/can0 or can:slcan//dev/ttyACM0?bitrate=1000000"
_BARE_SERIAL = re.compile(r"/|\./|~/|COM\d+$|[a-z0-9]+://", re.IGNORECASE)
_URL = re.compile(r"[a-z][a-z0-9+]*://", re.IGNORECASE)
_SWITCH = {"0": False, "1": True, "off": False, "on": True, "false": False, "true": True}
_HIGHEST_ID = 252  # of a servo, in both families
_SERIAL_OPTIONS = ("baud", "rtscts", "dtr")


@dataclass(frozen=True, slots=True)
class SimPort:
    """The simulated board in this process."""

    def __str__(self) -> str:
        return "sim:"


@dataclass(frozen=True, slots=True)
class SerialPort:
    """A serial device or a pyserial URL.

    ``dtr`` is the level of the DTR line from the moment of opening; None leaves it to the driver, which raises it.
    Boards that reset on DTR want False.
    """

    device: str
    baud: int = DEFAULT_BAUD
    rtscts: bool = False
    dtr: bool | None = None

    @property
    def is_url(self) -> bool:
        return _URL.match(self.device) is not None

    def __str__(self) -> str:
        options = []
        if self.baud != DEFAULT_BAUD:
            options.append(f"baud={self.baud}")
        if self.rtscts:
            options.append("rtscts=1")
        if self.dtr is not None:
            options.append(f"dtr={self.dtr:d}")
        return f"serial:{self.device}" + _query(options, "&" if "?" in self.device else "?")


@dataclass(frozen=True, slots=True)
class CanPort:
    """A channel of a python-can interface; the options are handed to it by name."""

    interface: str
    channel: str
    options: tuple[tuple[str, str], ...] = ()

    def __str__(self) -> str:
        return f"can:{self.interface}/{self.channel}" + _query(f"{k}={v}" for k, v in self.options)


@dataclass(frozen=True, slots=True)
class ServoPort:
    """Servos that share a serial line, without a board: one in this program drives them.

    ``ids`` are those of the joints, in their order; empty: as the robot's description says.
    """

    family: Literal["feetech", "dynamixel"]
    device: str
    baud: int = DEFAULT_BAUD
    ids: tuple[int, ...] = ()

    @property
    def line(self) -> SerialPort:
        """The line under it."""
        return SerialPort(self.device, self.baud)

    def __str__(self) -> str:
        options = [f"baud={self.baud}"] if self.baud != DEFAULT_BAUD else []
        if self.ids:
            options.append("ids=" + ",".join(map(str, self.ids)))
        return f"{self.family}:{self.device}" + _query(options)


Port = SimPort | SerialPort | CanPort | ServoPort
SERVO_FAMILIES = ("feetech", "dynamixel")


def parse_port(text: str) -> Port:
    """What a ``--port`` means. Nothing is opened; whether an interface exists is seen when it is.

    Raises:
        BadInputError: not in the grammar. One line with an example.
    """
    if any(ord(c) < 32 or ord(c) == 127 for c in text):
        raise BadInputError(f"port {text!r}: holds a control character; an example: {_SERIAL_EXAMPLE}")
    kind, colon, rest = text.partition(":")
    if colon and kind.lower() == "sim":
        if rest:
            raise BadInputError(
                f"port {text!r}: sim: takes nothing after the colon, --effect changes the board"
            )
        return SimPort()
    if colon and kind.lower() == "serial":
        return _serial(text, rest)
    if colon and kind.lower() == "can":
        return _can(text, rest)
    if colon and kind.lower() in SERVO_FAMILIES:
        return _servos(text, kind.lower(), rest)
    if _BARE_SERIAL.match(text):
        return _serial(text, text)
    raise BadInputError(
        f"port {text!r}: must begin with sim:, serial:, can:, feetech: or dynamixel:, "
        f"for example {_SERIAL_EXAMPLE} or can:socketcan/can0"
    )


def _serial(text: str, rest: str) -> SerialPort:
    device, _, query = rest.partition("?")
    if not device or (device.endswith("://") and device != "loop://"):
        raise BadInputError(f"port {text!r}: names no device; an example: {_SERIAL_EXAMPLE}")
    ours: dict[str, str] = {}
    others = []
    for key, value, part in _options(query):
        if key in _SERIAL_OPTIONS:
            if value is None:
                raise BadInputError(f"port {text!r}: {key} needs a value; an example: {_SERIAL_EXAMPLE}")
            ours[key] = value
        elif key == "file" and device.lower().startswith("spy://"):
            raise BadInputError(f"port {text!r}: file= would write over that file; spy:// prints without it")
        elif _URL.match(device):
            others.append(part)  # pyserial's URLs have options of their own
        else:
            raise BadInputError(
                f"port {text!r}: unknown option {key!r}; a serial port takes {', '.join(_SERIAL_OPTIONS)}, "
                f"for example {_SERIAL_EXAMPLE}"
            )
    return SerialPort(
        device + _query(others),
        _baud(text, ours.get("baud")),
        bool(_switch(text, "rtscts", ours.get("rtscts"))),
        _switch(text, "dtr", ours.get("dtr")),
    )


def _can(text: str, rest: str) -> CanPort:
    where, _, query = rest.partition("?")
    interface, _, channel = where.partition("/")
    if not interface or not channel:
        raise BadInputError(f"port {text!r}: must be can:INTERFACE/CHANNEL, for example {_CAN_EXAMPLE}")
    options: dict[str, str] = {}
    for key, value, _part in _options(query):
        if not key.isidentifier() or not value or key in ("interface", "channel"):
            raise BadInputError(f"port {text!r}: options are name=value; an example: {_CAN_EXAMPLE}")
        options[key] = value
    return CanPort(interface, channel, tuple(options.items()))


def _servos(text: str, family: str, rest: str) -> ServoPort:
    example = f"{family}:/dev/ttyUSB0?baud=1000000&ids=1-5"
    device, _, query = rest.partition("?")
    if not device or "://" in device:
        raise BadInputError(f"port {text!r}: must name a serial device; an example: {example}")
    given: dict[str, str] = {}
    for key, value, _part in _options(query):
        if key not in ("baud", "ids") or not value:
            raise BadInputError(f"port {text!r}: takes baud=... and ids=...; an example: {example}")
        given[key] = value
    ids = _ids(text, given["ids"], example) if "ids" in given else ()
    return ServoPort(family, device, _baud(text, given.get("baud")), ids)  # type: ignore[arg-type]


def _ids(text: str, value: str, example: str) -> tuple[int, ...]:
    ids: list[int] = []
    for part in value.split(","):
        match = re.fullmatch(r"([0-9]{1,3})(?:-([0-9]{1,3}))?", part)
        if match is None:
            raise BadInputError(
                f"port {text!r}: ids {value!r} must be like 1-5 or 1,2,7; an example: {example}"
            )
        first, last = int(match[1]), int(match[2] or match[1])
        ids += range(first, last + 1)
        if not first <= last <= _HIGHEST_ID or len(set(ids)) != len(ids):
            raise BadInputError(f"port {text!r}: ids {value!r}: 0 to {_HIGHEST_ID}, rising, each once")
    return tuple(ids)


def _options(query: str) -> list[tuple[str, str | None, str]]:
    """(name, value, as it was written) of each option."""
    found: list[tuple[str, str | None, str]] = []
    for part in query.split("&"):
        if part:
            key, equals, value = part.partition("=")
            found.append((key, value if equals else None, part))
    return found


def _query(options: Iterable[str], lead: str = "?") -> str:
    parts = list(options)
    return lead + "&".join(parts) if parts else ""


def _baud(text: str, value: str | None) -> int:
    if value is None:
        return DEFAULT_BAUD
    if not re.fullmatch(r"[0-9]{1,9}", value) or int(value) == 0:
        raise BadInputError(
            f"port {text!r}: baud {value!r} must be a whole number; an example: {_SERIAL_EXAMPLE}"
        )
    return int(value)


def _switch(text: str, name: str, value: str | None) -> bool | None:
    if value is None:
        return None
    if value.lower() not in _SWITCH:
        raise BadInputError(f"port {text!r}: {name} {value!r} must be 0 or 1")
    return _SWITCH[value.lower()]
