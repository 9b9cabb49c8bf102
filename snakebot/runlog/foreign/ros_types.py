"""ROS 2 messages: definitions as text (``ros2msg``), and messages in CDR by them. Data only: nothing is compiled.

https://docs.ros.org/en/rolling/Concepts/Basic/About-Interfaces.html; CDR is that of DDS-XTypes 1.3, 7.4.1 (XCDR1).
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np

MAX_TEXT = 1 << 18  # characters of a definition; the longest common ones have some thousand
MAX_DEPTH = 12  # of messages in messages

_HEADER = "std_msgs/Header header\n"
_SEPARATOR = "=" * 80
_STAMPED = (
    f"{_SEPARATOR}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    f"{_SEPARATOR}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
)
JOINT_STATE = "sensor_msgs/msg/JointState"
TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
ARRAY = "std_msgs/msg/Float64MultiArray"
CONTROLLER_STATE = "control_msgs/msg/JointTrajectoryControllerState"
# Definitions of those that a bag may come without: SQLite bags before ROS 2 Iron have none in them.
KNOWN = {
    JOINT_STATE: f"{_HEADER}string[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n{_STAMPED}",
    TRAJECTORY: (
        f"{_HEADER}string[] joint_names\nJointTrajectoryPoint[] points\n"
        f"{_SEPARATOR}\nMSG: trajectory_msgs/JointTrajectoryPoint\nfloat64[] positions\nfloat64[] velocities\n"
        f"float64[] accelerations\nfloat64[] effort\nbuiltin_interfaces/Duration time_from_start\n"
        f"{_SEPARATOR}\nMSG: builtin_interfaces/Duration\nint32 sec\nuint32 nanosec\n{_STAMPED}"
    ),
    ARRAY: (
        f"MultiArrayLayout layout\nfloat64[] data\n"
        f"{_SEPARATOR}\nMSG: std_msgs/MultiArrayLayout\nMultiArrayDimension[] dim\nuint32 data_offset\n"
        f"{_SEPARATOR}\nMSG: std_msgs/MultiArrayDimension\nstring label\nuint32 size\nuint32 stride\n"
    ),
}
_NUMBERS = {
    "bool": "?", "byte": "B", "char": "B", "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i",
    "uint32": "I", "int64": "q", "uint64": "Q", "float32": "f", "float64": "d",
}  # fmt: skip
_FIELD = re.compile(
    r"(?P<type>[A-Za-z][\w/]*)(?:<=\d+)?(?P<array>\[(?P<most><=)?(?P<count>\d*)\])?\s+(?P<name>[A-Za-z]\w*)"
    r"(?P<rest>\s*=.*|\s+.*)?"
)


class DefinitionError(ValueError):
    """A definition, or a message, that is not of the form."""


@dataclass(frozen=True)
class Field:
    name: str
    kind: str  # a key of _NUMBERS, "string", or the full name of a message
    many: bool = False
    fixed: int | None = None  # how many; None: as many as the message says


@dataclass(frozen=True)
class Definition:
    """A message and those in it, by their full names (``package/Type``)."""

    name: str
    fields: dict[str, tuple[Field, ...]]

    def decode(self, data: bytes) -> dict[str, Any]:
        """The message as plain values; arrays of numbers as numpy arrays.

        Raises:
            DefinitionError: the bytes are not such a message.
        """
        if len(data) < 4 or data[0] != 0 or data[1] > 1:
            raise DefinitionError("not plain CDR")
        reader = _Reader(memoryview(data)[4:], "<" if data[1] else ">")
        return reader.message(self, self.name, 0)


def definition(name: str, text: str) -> Definition:
    """Read a definition with all that it needs.

    Raises:
        DefinitionError: not of the form, or a message in it is missing.
    """
    if len(text) > MAX_TEXT:
        raise DefinitionError("a definition longer than any")
    top = _short(name)
    fields: dict[str, tuple[Field, ...]] = {}
    current, lines = top, list[str]()
    for line in [*text.splitlines(), _SEPARATOR]:
        if line.startswith(_SEPARATOR[:40]):
            fields.setdefault(current, _fields(current, lines))
            current, lines = "", []
        elif line.startswith("MSG:") and not current:
            current = _short(line[4:].strip())
        else:
            lines.append(line)
    made = Definition(top, fields)
    _check(made, top, 0, set())
    return made


def _short(name: str) -> str:
    """``package/Type`` of ``package/msg/Type``."""
    parts = name.split("/")
    return f"{parts[0]}/{parts[-1]}" if len(parts) > 1 else name


def _fields(owner: str, lines: list[str]) -> tuple[Field, ...]:
    found = []
    for line in lines:
        text = line.split("#", 1)[0].strip() if "'" not in line and '"' not in line else line.strip()
        if not text or text.startswith("#"):
            continue
        match = _FIELD.fullmatch(text)
        if match is None:
            raise DefinitionError(f"{owner}: cannot read {text[:60]!r}")
        if (match["rest"] or "").lstrip().startswith("="):
            continue  # a constant
        kind = match["type"]
        if kind == "Header":
            kind = "std_msgs/Header"
        elif kind not in _NUMBERS and kind != "string":
            kind = _short(kind) if "/" in kind else f"{owner.split('/')[0]}/{kind}"
        count = int(match["count"][:9]) if match["count"] and not match["most"] else None
        found.append(Field(match["name"], kind, match["array"] is not None, count))
    return tuple(found)


def _check(made: Definition, name: str, depth: int, good: set[str]) -> None:
    if depth > MAX_DEPTH:
        raise DefinitionError(f"{name}: nested too deep")
    if name not in made.fields:
        raise DefinitionError(f"{name}: no definition of it")
    for field in made.fields[name]:
        if field.kind not in _NUMBERS and field.kind != "string" and field.kind not in good:
            _check(made, field.kind, depth + 1, good)
    good.add(name)


class _Reader:
    def __init__(self, data: memoryview, order: str) -> None:
        self._data, self._order, self._at = data, order, 0

    def message(self, made: Definition, name: str, depth: int) -> dict[str, Any]:
        if depth > MAX_DEPTH:
            raise DefinitionError("nested too deep")
        fields = made.fields[name]
        if not fields:
            self._take(1)  # an empty message has one byte
        return {field.name: self._field(made, field, depth) for field in fields}

    def _field(self, made: Definition, field: Field, depth: int) -> Any:
        if not field.many:
            return self._one(made, field.kind, depth)
        count = self._length() if field.fixed is None else field.fixed
        if count > len(self._data) - self._at:  # nothing takes less than a byte
            raise DefinitionError(f"{field.name}: more values than bytes")
        if field.kind in _NUMBERS:
            code = _NUMBERS[field.kind]
            size = struct.calcsize(f"={code}")
            if count:
                self._align(size)
            return np.frombuffer(self._take(count * size), dtype=f"{self._order}{code}")
        return [self._one(made, field.kind, depth) for _ in range(count)]

    def _one(self, made: Definition, kind: str, depth: int) -> Any:
        if kind in _NUMBERS:
            code = _NUMBERS[kind]
            size = struct.calcsize(f"={code}")
            self._align(size)
            return struct.unpack(f"{self._order}{code}", self._take(size))[0]
        if kind == "string":
            raw = bytes(self._take(self._length()))
            return raw.rstrip(b"\0").decode("utf-8", "replace")
        return self.message(made, kind, depth + 1)

    def _length(self) -> int:
        self._align(4)
        return int(struct.unpack(f"{self._order}I", self._take(4))[0])

    def _align(self, size: int) -> None:
        self._at += -self._at % size

    def _take(self, count: int) -> memoryview:
        if count > len(self._data) - self._at:
            raise DefinitionError("ends too early")
        self._at += count
        return self._data[self._at - count : self._at]
