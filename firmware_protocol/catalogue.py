"""The messages of ``snakebot.dbc`` as typed, frozen dataclasses.

The DBC is the one definition: identifiers, bit positions, scales and ranges come from it through cantools. A class here
only gives a message's signals names and types; a test holds the two against each other.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, fields
from enum import IntEnum
from functools import cache
from importlib.resources import files
from operator import attrgetter
from typing import Any, ClassVar

from cantools.database.can import Database
from cantools.database.can import Message as DbcMessage

from firmware_protocol.dbc import read_dbc
from firmware_protocol.enumerations import Fault as Fault
from firmware_protocol.enumerations import JointMode as JointMode
from firmware_protocol.enumerations import LimitKind as LimitKind
from firmware_protocol.enumerations import Mode as Mode
from firmware_protocol.enumerations import Result as Result
from firmware_protocol.enumerations import StopReason as StopReason
from firmware_protocol.frame import Frame, ProtocolError
from firmware_protocol.packing import Layout

PROTOCOL_MAJOR = 2
PROTOCOL_MINOR = 0
MAX_JOINTS = 16
NO_READING = -32768  # in Measured: this joint has no encoder reading
NOBODY = 0  # as holder: no host has armed the board
# Largest trim. A servo horn sits on a spline of 21 to 25 teeth: the nearest tooth is at most 0.15 rad off, and the
# servo's own centre about as much again. More is a horn on the wrong tooth.
MAX_TRIM_RAD = 0.3
LATCHES = 64  # numbers of a latch before they begin again


class Message:
    """Base of all messages; a subclass has the name of its message in the DBC."""

    __slots__ = ()
    enums: ClassVar[dict[str, type[IntEnum]]] = {}


@dataclass(frozen=True, slots=True)
class EmergencyStop(Message):
    enums: ClassVar[dict[str, type[IntEnum]]] = {"reason": StopReason}
    reason: StopReason = StopReason.USER
    host: int = 0


@dataclass(frozen=True, slots=True)
class FaultEvent(Message):
    enums: ClassVar[dict[str, type[IntEnum]]] = {"code": Fault}
    code: Fault
    joint: int = 0  # 0: not one joint's
    number: int = 0  # of the latch
    detail: int = 0
    board_time_us: int = 0


@dataclass(frozen=True, slots=True)
class Setpoint(Message):
    sequence: int  # low 12 bits
    group: int
    first_rad: float
    second_rad: float
    third_rad: float


@dataclass(frozen=True, slots=True)
class Latch(Message):
    sequence: int
    joints: int
    interval_s: float  # since the set-point before, as the host planned it
    crc32: int


@dataclass(frozen=True, slots=True)
class State(Message):
    enums: ClassVar[dict[str, type[IntEnum]]] = {"mode": Mode}
    sequence: int  # of the set-point that this answers
    sample: int
    mode: Mode
    board_time_us: int


@dataclass(frozen=True, slots=True)
class Measured(Message):
    sample: int
    group: int
    first_counts: int
    second_counts: int
    third_counts: int


@dataclass(frozen=True, slots=True)
class Applied(Message):
    sample: int
    group: int
    first_rad: float
    second_rad: float
    third_rad: float


@dataclass(frozen=True, slots=True)
class HostHeartbeat(Message):
    host: int
    counter: int


@dataclass(frozen=True, slots=True)
class BoardHeartbeat(Message):
    enums: ClassVar[dict[str, type[IntEnum]]] = {"mode": Mode, "fault": Fault}
    boot_id: int
    mode: Mode
    powered: int
    simulated: int
    fault: Fault
    holder: int


@dataclass(frozen=True, slots=True)
class ModeRequest(Message):
    enums: ClassVar[dict[str, type[IntEnum]]] = {"mode": Mode}
    token: int
    mode: Mode
    host: int


@dataclass(frozen=True, slots=True)
class JointModeRequest(Message):
    enums: ClassVar[dict[str, type[IntEnum]]] = {"mode": JointMode}
    token: int
    joint: int  # from 1
    mode: JointMode
    angle_rad: float
    host: int


@dataclass(frozen=True, slots=True)
class LimitRequest(Message):
    enums: ClassVar[dict[str, type[IntEnum]]] = {"kind": LimitKind}
    token: int
    joint: int
    kind: LimitKind
    value: float  # rad, rad/s or rad/s2
    host: int


@dataclass(frozen=True, slots=True)
class TrimRequest(Message):
    token: int
    joint: int
    trim_rad: float
    host: int


@dataclass(frozen=True, slots=True)
class ZeroRequest(Message):
    token: int
    joint: int
    zero_counts: int
    host: int


@dataclass(frozen=True, slots=True)
class ClearRequest(Message):
    token: int
    number: int  # of the latch, as FaultEvent has it
    host: int


@dataclass(frozen=True, slots=True)
class JointLimits(Message):
    joint: int
    angle_rad: float
    speed_rad_s: float
    acceleration_rad_s2: float


@dataclass(frozen=True, slots=True)
class Acknowledge(Message):
    enums: ClassVar[dict[str, type[IntEnum]]] = {"result": Result, "mode": Mode}
    token: int
    result: Result
    mode: Mode
    request: int  # identifier of the message that is answered
    detail: int
    host: int  # whose request it was


@dataclass(frozen=True, slots=True)
class Ping(Message):
    nonce: int


@dataclass(frozen=True, slots=True)
class Pong(Message):
    nonce: int
    board_time_us: int


@dataclass(frozen=True, slots=True)
class InfoRequest(Message):
    host: int


@dataclass(frozen=True, slots=True)
class InfoProtocol(Message):
    protocol_major: int
    protocol_minor: int
    joints: int
    simulated: int
    catalogue_hash: int


@dataclass(frozen=True, slots=True)
class InfoFirmware(Message):
    firmware_major: int
    firmware_minor: int
    firmware_patch: int
    watchdog_ms: int
    counts_per_rev: int
    boot_id: int


@dataclass(frozen=True, slots=True)
class InfoSerial(Message):
    serial_number: int


@dataclass(frozen=True, slots=True)
class Supply(Message):
    voltage_v: float
    current_a: float
    temperature_c: float


@dataclass(frozen=True, slots=True)
class JointSupply(Message):
    joint: int
    current_a: float
    temperature_c: float


@dataclass(frozen=True, slots=True)
class Counters(Message):
    received: int
    corrupt: int
    dropped: int
    clamped: int


@dataclass(frozen=True, slots=True)
class PosePosition(Message):
    sample: int
    x_m: float
    y_m: float


@dataclass(frozen=True, slots=True)
class PoseMotion(Message):
    sample: int
    heading_rad: float
    speed_m_s: float


MESSAGES: dict[str, type[Message]] = {cls.__name__: cls for cls in Message.__subclasses__()}


def dbc_text() -> str:
    """The catalogue as it stands in the DBC file; it is stored with every run log."""
    return (files("firmware_protocol") / "snakebot.dbc").read_text(encoding="utf-8")


@cache
def database() -> Database:
    """The DBC, read once."""
    return read_dbc(dbc_text())


@cache
def catalogue_hash() -> int:
    """First 32 bits of the SHA-256 of the DBC, line ends normalised: what both ends compare in the handshake."""
    text = dbc_text().replace("\r\n", "\n")
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "big")


class _Codec:
    """One message's class beside its layout, looked up once."""

    __slots__ = ("cls", "enums", "id", "layout", "values")

    def __init__(self, cls: type[Message], definition: DbcMessage) -> None:
        self.cls = cls
        names = [field.name for field in fields(cls)]  # type: ignore[arg-type]
        self.layout = Layout(definition, names)
        self.id = definition.frame_id
        self.values: Callable[[Message], tuple[float, ...]] = (
            attrgetter(*names) if len(names) > 1 else lambda message: (getattr(message, names[0]),)
        )
        self.enums = [
            (names.index(name), {int(item): item for item in enum}) for name, enum in cls.enums.items()
        ]


@cache
def _codecs() -> tuple[dict[type[Message], _Codec], dict[int, _Codec]]:
    return codecs_of(database())


def codecs_of(read: Database) -> tuple[dict[type[Message], _Codec], dict[int, _Codec]]:
    """The codec of every message, by its class and by its identifier.

    Raises:
        ProtocolError: a DBC that does not define the messages of this version.
    """
    there = {message.name: message for message in read.messages}
    missing = [name for name in MESSAGES if name not in there]
    if missing:
        raise ProtocolError(f"the DBC defines no message {missing[0]}")
    codecs = [_Codec(cls, there[name]) for name, cls in MESSAGES.items()]
    return {codec.cls: codec for codec in codecs}, {codec.id: codec for codec in codecs}


def frame_id(cls: type[Message]) -> int:
    """Identifier of a message's frames."""
    return _codecs()[0][cls].id


def layout(cls: type[Message]) -> Layout:
    """Where a message's signals are, in the order of the class's fields."""
    return _codecs()[0][cls].layout


def encode(message: Message) -> Frame:
    """A message as a frame.

    Raises:
        ProtocolError: a value is outside the range that the DBC gives its signal, or not a number.
    """
    codec = _codecs()[0][type(message)]
    return Frame(codec.id, codec.layout.pack(codec.values(message)))


def encode_values(cls: type[Message], *values: float) -> Frame:
    """A message's values, in the order of its fields, as its frame; for those who have no use for the message.

    Raises:
        ProtocolError: as ``encode``.
    """
    codec = _codecs()[0][cls]
    return Frame(codec.id, codec.layout.pack(values))


def decode(frame: Frame) -> Message:
    """A frame as its message.

    Raises:
        ProtocolError: the identifier is not in the catalogue, the length is not the message's, or an enumeration
            holds a value that has no name.
    """
    codec = _codecs()[1].get(frame.id)
    if codec is None:
        raise ProtocolError(f"{frame}: no message has this identifier")
    if len(frame.data) != codec.layout.length:
        raise ProtocolError(
            f"{frame}: {codec.cls.__name__} has {codec.layout.length} bytes, not {len(frame.data)}"
        )
    values: list[Any] = codec.layout.unpack(frame.data)
    for index, items in codec.enums:
        item = items.get(values[index])
        if item is None:
            raise ProtocolError(f"{frame}: {codec.cls.__name__}: {values[index]} has no name")
        values[index] = item
    return codec.cls(*values)
