"""The quick packing of messages against cantools, which reads the same DBC: the same bytes, values and refusals."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Any

import cantools
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.catalogue import (
    MESSAGES,
    InfoSerial,
    Message,
    Ping,
    Setpoint,
    database,
    decode,
    encode,
)
from firmware_protocol.frame import Frame, ProtocolError


def within(signal: Any) -> st.SearchStrategy[Any]:
    """Values that the DBC allows, on and off the wire's grid."""
    if signal.choices:
        return st.sampled_from(sorted(signal.choices))
    if signal.conversion.scale == 1:
        return st.integers(int(signal.minimum), int(signal.maximum))
    return st.floats(signal.minimum, signal.maximum)


@st.composite
def messages(draw: st.DrawFn) -> Message:
    cls = MESSAGES[draw(st.sampled_from(sorted(MESSAGES)))]
    definition = database().get_message_by_name(cls.__name__)
    values = {f.name: draw(within(definition.get_signal_by_name(f.name))) for f in fields(cls)}  # type: ignore[arg-type]
    return cls(
        **{name: cls.enums[name](value) if name in cls.enums else value for name, value in values.items()}
    )


def by_cantools(message: Message) -> bytes:
    values = {f.name: getattr(message, f.name) for f in fields(message)}  # type: ignore[arg-type]
    return database().get_message_by_name(type(message).__name__).encode(values, strict=True)


@settings(max_examples=400, deadline=None)
@given(messages())
def test_the_same_bytes(message: Message) -> None:
    assert encode(message).data == by_cantools(message)


@settings(max_examples=400, deadline=None)
@given(st.sampled_from(sorted(MESSAGES)), st.binary(min_size=8, max_size=8))
def test_the_same_values(name: str, noise: bytes) -> None:
    definition = database().get_message_by_name(name)
    data = noise[: definition.length]
    expected = definition.decode(data, decode_choices=False)
    assert isinstance(expected, dict)
    try:
        message = decode(Frame(definition.frame_id, data))
    except ProtocolError:
        enums = MESSAGES[name].enums
        assert any(expected[field] not in {int(value) for value in enum} for field, enum in enums.items())
        return
    assert {f.name: getattr(message, f.name) for f in fields(message)} == expected  # type: ignore[arg-type]


@pytest.mark.parametrize("name", sorted(MESSAGES))
def test_what_is_out_of_range_is_refused_where_cantools_refuses_it(name: str) -> None:
    cls = MESSAGES[name]
    definition = database().get_message_by_name(name)
    good: dict[str, Any] = {}
    for signal in definition.signals:
        lowest = min(signal.choices) if signal.choices else signal.minimum
        good[signal.name] = lowest if signal.conversion.scale != 1 else int(lowest)  # type: ignore[arg-type]
    for signal in definition.signals:
        step = signal.conversion.scale
        assert signal.minimum is not None
        assert signal.maximum is not None
        for value in (signal.minimum - step, signal.maximum + step, math.nan, math.inf, -math.inf, "1", None):
            message = cls(**{**good, signal.name: value})
            with pytest.raises(
                (cantools.Error, ArithmeticError, LookupError, TypeError, ValueError, AttributeError)
            ):
                by_cantools(message)
            with pytest.raises(ProtocolError, match=f"{name}.*{signal.name}"):
                encode(message)
        for value in (signal.minimum, signal.maximum):
            edge = cls(**{**good, signal.name: value})
            assert encode(edge).data == by_cantools(edge)


def test_all_64_bits_of_a_serial_number() -> None:
    for number in (0, 1, (1 << 53) + 1, (1 << 64) - 1):
        assert decode(encode(InfoSerial(number))) == InfoSerial(number)


def test_numbers_of_numpy_do_too() -> None:
    assert encode(Ping(np.uint32(0xFFFFFFFF))) == encode(Ping(0xFFFFFFFF))  # type: ignore[arg-type]
    angles = [float(np.float64(0.1)), 0.2, -0.3]
    assert encode(Setpoint(1, 1, *map(np.float64, angles))) == encode(Setpoint(1, 1, *angles))
