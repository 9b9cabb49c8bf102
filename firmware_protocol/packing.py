"""One message's signals to and from bytes, as the DBC lays them out.

A control loop packs and unpacks ten frames a tick. What cantools looks up anew each time (ranges, scales, positions) is
looked up once here; a test holds the result against cantools, value by value.
"""

from __future__ import annotations

from collections.abc import Sequence

from cantools.database.can import Message as DbcMessage

from firmware_protocol.frame import ProtocolError

_TOLERANCE = 1e-6  # of a signal's scale: a limit that floating point misses by a hair is met


class Layout:
    """Where a message's signals are, and what they may hold.

    Args:
        definition: the message in the DBC; little-endian integers with a scale, and none of them multiplexed.
        names: the signals in the order in which values are given and returned.

    Raises:
        ProtocolError: a signal is missing, or of another kind.
    """

    def __init__(self, definition: DbcMessage, names: Sequence[str]) -> None:
        self.length = definition.length
        self._name = definition.name
        self._out: list[tuple[str, float, float, float, float, bool, int, int]] = []
        self._in: list[tuple[int, int, int, float, float, bool]] = []
        for name in names:
            try:
                signal = definition.get_signal_by_name(name)
            except KeyError:
                raise ProtocolError(f"{self._name}: the DBC gives it no signal {name}") from None
            if (
                signal.byte_order != "little_endian"
                or signal.conversion.is_float
                or signal.minimum is None
                or signal.maximum is None
                or not signal.conversion.scale
            ):
                raise ProtocolError(
                    f"{self._name}: {name} is no little-endian integer with a scale and a range"
                )
            scale, offset = signal.conversion.scale, signal.conversion.offset
            plain = scale == 1 and offset == 0
            slack = 0 if plain else abs(scale) * _TOLERANCE
            low, high = signal.minimum - slack, signal.maximum + slack
            mask = (1 << signal.length) - 1
            sign = 1 << (signal.length - 1) if signal.is_signed else 0
            self._out.append((name, low, high, scale, offset, plain, mask, signal.start))
            self._in.append((signal.start, mask, sign, scale, offset, plain))

    def pack(self, values: Sequence[float]) -> bytes:
        """Values, in the order of ``names``, as bytes.

        Raises:
            ProtocolError: a value is outside its signal's range, or not a number.
        """
        bits = 0
        for value, (name, low, high, scale, offset, plain, mask, start) in zip(
            values, self._out, strict=True
        ):
            try:
                if not low <= value <= high:
                    raise ProtocolError(f"{self._name}: {name} is {value}, outside {low:g} to {high:g}")
                raw = round(value if plain else (value - offset) / scale)
                bits |= (raw & mask) << start
            except TypeError:
                raise ProtocolError(f"{self._name}: {name} is {value!r}, which is not a number") from None
        return bits.to_bytes(self.length, "little")

    def unpack(self, data: bytes) -> list[float]:
        """The values, in the order of ``names``; those without a scale are whole numbers."""
        bits = int.from_bytes(data, "little")
        values: list[float] = []
        for start, mask, sign, scale, offset, plain in self._in:
            raw = bits >> start & mask
            if raw & sign:
                raw -= mask + 1
            values.append(raw if plain else raw * scale + offset)
        return values
