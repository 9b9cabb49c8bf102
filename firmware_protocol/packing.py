"""One message's signals to and from bytes, as the DBC lays them out.

A control loop packs and unpacks ten frames a tick. What cantools looks up anew each time (ranges, scales, positions) is
looked up once here and written out as one expression a message, the way ``dataclasses`` writes its methods; a test
holds the result against cantools, value by value.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from cantools.database.can import Message as DbcMessage

from firmware_protocol.frame import ProtocolError

_TOLERANCE = 1e-6  # of a signal's scale: a limit that floating point misses by a hair is met


class Field(NamedTuple):
    """Where a signal is, and what it may hold; its methods give Python expressions."""

    name: str
    start: int  # bits
    length: int  # bits
    signed: bool
    low: float
    high: float
    scale: float
    offset: float

    @property
    def plain(self) -> bool:
        """It carries whole numbers as they are."""
        return self.scale == 1 and self.offset == 0

    def fits(self, value: str) -> str:
        return f"{self.low!r} <= {value} <= {self.high!r}"

    def to_raw(self, value: str) -> str:
        return f"round({value})" if self.plain else f"round(({value} - {self.offset!r}) / {self.scale!r})"

    def from_raw(self, raw: str) -> str:
        return raw if self.plain else f"({raw}) * {self.scale!r} + {self.offset!r}"

    def into_bits(self, raw: str) -> str:
        return f"({raw} & {(1 << self.length) - 1:#x}) << {self.start}"

    def out_of_bits(self) -> str:
        raw, sign = f"(bits >> {self.start} & {(1 << self.length) - 1:#x})", 1 << (self.length - 1)
        return f"({raw} ^ {sign:#x}) - {sign:#x}" if self.signed else raw


class Layout:
    """Where a message's signals are, and what they may hold.

    Args:
        definition: the message in the DBC; little-endian integers with a scale, and none of them multiplexed.
        names: the signals in the order in which values are given and returned.

    Attributes:
        length: of the message, bytes.
        fields: where each signal is.
        join: the integers on the wire, in the order of ``names``, to bytes; each is cut to its signal's length.
        split: bytes to the integers on the wire.
        unpack: bytes to the values; those without a scale are whole numbers.

    Raises:
        ProtocolError: a signal is missing, or of another kind.
    """

    def __init__(self, definition: DbcMessage, names: Sequence[str]) -> None:
        self.length = definition.length
        self._name = definition.name
        self.fields = [_field(definition, name) for name in names]
        values = [f"v{index}" for index in range(len(names))]
        pairs = list(zip(self.fields, values, strict=True))
        self.join: Callable[..., bytes] = function(values, self.joined(values))
        fits = " and ".join(field.fits(value) for field, value in pairs) or "True"
        packed = _to_bytes([field.into_bits(field.to_raw(value)) for field, value in pairs], self.length)
        self._pack: Callable[..., bytes | None] = function(values, f"{packed} if {fits} else None")
        raws = [field.out_of_bits() for field in self.fields]
        self.split: Callable[[bytes], list[int]] = _from_bytes(raws)
        self.unpack: Callable[[bytes], list[float]] = _from_bytes(
            [field.from_raw(raw) for field, raw in zip(self.fields, raws, strict=True)]
        )

    def joined(self, raws: Sequence[str]) -> str:
        """What ``join`` does with these expressions, as an expression."""
        pairs = zip(self.fields, raws, strict=True)
        return _to_bytes([field.into_bits(raw) for field, raw in pairs], self.length)

    def pack(self, values: Sequence[float]) -> bytes:
        """Values, in the order of ``names``, as bytes.

        Raises:
            ProtocolError: a value is outside its signal's range, or not a number.
        """
        try:
            data = self._pack(*values)
        except TypeError:
            data = None
        if data is None:
            raise self._refused(values)
        return data

    def _refused(self, values: Sequence[float]) -> ProtocolError:
        """What is wrong with values that do not fit."""
        for value, field in zip(values, self.fields, strict=True):
            name = f"{self._name}: {field.name}"
            try:
                if not field.low <= value <= field.high:
                    return ProtocolError(f"{name} is {value}, outside {field.low:g} to {field.high:g}")
                round(value)
            except TypeError:
                return ProtocolError(f"{name} is {value!r}, which is not a number")
        raise AssertionError(f"{self._name}: {values} fit")


def _field(definition: DbcMessage, name: str) -> Field:
    try:
        signal = definition.get_signal_by_name(name)
    except KeyError:
        raise ProtocolError(f"{definition.name}: the DBC gives it no signal {name}") from None
    scale, offset = signal.conversion.scale, signal.conversion.offset
    low, high = signal.minimum, signal.maximum
    if (
        signal.byte_order != "little_endian"
        or signal.conversion.is_float
        or low is None
        or high is None
        or not scale
        or not all(map(math.isfinite, (scale, offset, low, high)))
    ):
        raise ProtocolError(f"{definition.name}: {name} is no little-endian integer with a scale and a range")
    slack = 0 if scale == 1 and offset == 0 else abs(scale) * _TOLERANCE
    return Field(
        name, signal.start, signal.length, signal.is_signed, low - slack, high + slack, scale, offset
    )


def _to_bytes(bits: Sequence[str], length: int) -> str:
    return f"({' | '.join(bits) or 0}).to_bytes({length}, 'little')"


def _from_bytes(values: Sequence[str]) -> Callable[[bytes], list[Any]]:
    return function(["data"], f"[{', '.join(values)}]", "bits = int.from_bytes(data, 'little')")


def function(arguments: Sequence[str], result: str, before: str = "pass", **known: Any) -> Callable[..., Any]:
    """A function made of expressions over numbers and of what is ``known``; none may be text out of a DBC.

    It is compiled under this file's name, so that who watches for text that is executed can tell it apart.
    """
    made: dict[str, Any] = {}
    text = f"def made({', '.join(arguments)}):\n {before}\n return {result}"
    exec(compile(text, __file__, "exec"), known, made)
    written: Callable[..., Any] = made["made"]
    return written
