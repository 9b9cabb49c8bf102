"""The typed messages and the DBC say the same, and what the document promises of the DBC holds."""

from __future__ import annotations

import hashlib
import re
from dataclasses import FrozenInstanceError, fields
from enum import IntEnum
from importlib.resources import files
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import catalogue
from firmware_protocol.catalogue import (
    MESSAGES,
    Ping,
    catalogue_hash,
    database,
    decode,
    encode,
    frame_id,
)
from firmware_protocol.frame import Frame, ProtocolError

PROTOCOL = (files("firmware_protocol") / "PROTOCOL.md").read_text(encoding="utf-8")


def test_a_class_for_every_message_and_no_other() -> None:
    assert set(MESSAGES) == {message.name for message in database().messages}


@pytest.mark.parametrize("name", sorted(MESSAGES))
def test_fields_are_the_signals_in_their_order_on_the_wire(name: str) -> None:
    signals = sorted(database().get_message_by_name(name).signals, key=lambda signal: signal.start)
    assert [field.name for field in fields(MESSAGES[name])] == [signal.name for signal in signals]  # type: ignore[arg-type]


@pytest.mark.parametrize("name", sorted(MESSAGES))
def test_enumerations_are_the_named_values(name: str) -> None:
    enums = MESSAGES[name].enums
    for signal in database().get_message_by_name(name).signals:
        named = {int(value): str(text) for value, text in (signal.choices or {}).items()}
        enum = enums.get(signal.name)
        assert {int(item): item.name.lower() for item in enum or []} == named
        assert enum is None or issubclass(enum, IntEnum)


@pytest.mark.parametrize("name", sorted(MESSAGES))
def test_units_in_names_are_the_units_of_the_dbc(name: str) -> None:
    suffixes = {
        "rad": "rad",
        "rad_s": "rad/s",
        "rad_s2": "rad/s2",
        "s": "s",
        "us": "us",
        "ms": "ms",
        "m": "m",
        "m_s": "m/s",
        "v": "V",
        "a": "A",
        "c": "degC",
    }
    for signal in database().get_message_by_name(name).signals:
        found = re.search(r"_(rad_s2|rad_s|rad|m_s|us|ms|s|m|v|a|c)$", signal.name)
        if found:
            assert signal.unit == suffixes[found[1]]
        elif signal.name.endswith("_counts"):
            assert signal.unit == "counts"


def test_everything_fits_classic_can_with_11_bits_and_no_two_share_an_identifier() -> None:
    messages = database().messages
    assert all(message.length <= 8 and message.frame_id <= 0x7FF for message in messages)
    assert all(not message.is_extended_frame for message in messages)
    assert len({message.frame_id for message in messages}) == len(messages)


def test_signals_lie_within_their_message_and_apart() -> None:
    for message in database().messages:
        bits: set[int] = set()
        for signal in message.signals:
            own = set(range(signal.start, signal.start + signal.length))
            assert not own & bits, f"{message.name}.{signal.name}"
            assert max(own) < 8 * message.length
            bits |= own


def test_priorities_are_as_documented() -> None:
    """On a bus the smaller identifier wins: stop, fault, set-points, samples, beats, configuration, identity, rest."""
    order = [
        {"EmergencyStop"},
        {"FaultEvent"},
        {"Setpoint", "Latch"},
        {"State", "Measured", "Applied"},
        {"HostHeartbeat", "BoardHeartbeat"},
        {
            "ModeRequest",
            "JointModeRequest",
            "LimitRequest",
            "TrimRequest",
            "ZeroRequest",
            "ClearRequest",
            "JointLimits",
            "Acknowledge",
        },
        {"Ping", "Pong", "InfoRequest", "InfoProtocol", "InfoFirmware", "InfoSerial"},
        {"Supply", "JointSupply", "Counters", "PosePosition", "PoseMotion"},
    ]
    assert set().union(*order) == set(MESSAGES)
    ids = [sorted(frame_id(MESSAGES[name]) for name in group) for group in order]
    assert all(earlier[-1] < later[0] for earlier, later in pairwise(ids))
    assert frame_id(catalogue.Setpoint) < frame_id(catalogue.Latch)


def test_each_message_has_one_sender() -> None:
    assert {tuple(message.senders) for message in database().messages} == {("Host",), ("Board",)}


def test_sixteen_joints_fit() -> None:
    groups = -(-catalogue.MAX_JOINTS // 3)
    for name in ("Setpoint", "Measured", "Applied"):
        assert database().get_message_by_name(name).get_signal_by_name("group").maximum == groups - 1


def test_encoders_of_8192_counts_reach_half_a_turn_and_more() -> None:
    signal = database().get_message_by_name("Measured").get_signal_by_name("first_counts")
    assert signal.maximum is not None
    assert signal.maximum >= 8192 / 2
    assert signal.conversion.scale == 1


def test_the_hash_is_of_the_file_with_unix_line_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    text = (files("firmware_protocol") / "snakebot.dbc").read_bytes().replace(b"\r\n", b"\n")
    expected = int(hashlib.sha256(text).hexdigest()[:8], 16)
    assert catalogue_hash() == expected
    monkeypatch.setattr(catalogue, "dbc_text", lambda: text.decode().replace("\n", "\r\n"))
    assert catalogue_hash.__wrapped__() == expected


@given(st.sampled_from(sorted(MESSAGES)), st.binary(min_size=8, max_size=8))
def test_any_bytes_are_a_message_that_comes_back_or_are_refused(name: str, noise: bytes) -> None:
    frame = Frame(frame_id(MESSAGES[name]), noise[: database().get_message_by_name(name).length])
    try:
        message = decode(frame)
    except ProtocolError:
        assert MESSAGES[name].enums  # a value without a name is all that can be wrong with so many bytes
        return
    assert type(message) is MESSAGES[name]
    try:
        again = encode(message)
    except ProtocolError:
        return  # a receiver meets what no sender may send
    assert again.id == frame.id
    assert decode(again) == message


@pytest.mark.parametrize("name", sorted(MESSAGES))
def test_a_wrong_length_is_refused(name: str) -> None:
    identifier, length = frame_id(MESSAGES[name]), database().get_message_by_name(name).length
    for wrong in set(range(9)) - {length}:
        with pytest.raises(ProtocolError, match=rf"{name} has {length} bytes, not {wrong}"):
            decode(Frame(identifier, bytes(wrong)))


def test_an_unknown_identifier_is_refused() -> None:
    known = {frame_id(cls) for cls in MESSAGES.values()}
    for identifier in set(range(0x800)) - known:
        with pytest.raises(ProtocolError, match="no message has this identifier"):
            decode(Frame(identifier, bytes(8)))


def test_messages_cannot_be_changed() -> None:
    with pytest.raises(FrozenInstanceError):
        Ping(1).nonce = 2  # type: ignore[misc]


def test_the_document_names_the_version_in_force() -> None:
    assert "`protocol_major`" in PROTOCOL
    assert catalogue.PROTOCOL_MAJOR >= 1
