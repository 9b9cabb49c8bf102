"""Reads a DBC that may be anybody's: of bounded size, and with nothing in it that a classic CAN frame cannot carry.

cantools takes every length, range and exponent in the file at its word, and builds a list, or an integer, that long.
What it is given is therefore looked through before.
"""

from __future__ import annotations

import re
from decimal import DecimalException

import cantools
import textparser
from cantools.database.can import Database

from firmware_protocol.frame import ProtocolError

MAX_CHARACTERS = 256 << 10
_MAX_BYTES = 8
_MAX_BITS = 8 * _MAX_BYTES
_MAX_ID = 0x7FF

_ASIDE = re.compile(r'"(?:\\"|[^"])*"|//[^\n]*')
_LENGTH = re.compile(r"BO_\s*\d+\s*\w*\s*:\s*(\d+)")  # a number ends where a name begins: no space is needed
_BITS = re.compile(r":\s*(\d+)\s*\|\s*(\d+)\s*@")
_TOO_MUCH = re.compile(r"\d{25}|\d\.?[eE][-+]?\d{3}|\bSG_MUL_VAL_\b|\bSG_\s+\w+\s+[mM]")


def read_dbc(text: str) -> Database:
    """The messages that a DBC defines.

    Raises:
        ProtocolError: one line: not a DBC, too long, or with messages or signals that this protocol has no use for
            (more than 8 bytes, identifiers of more than 11 bits, multiplexed signals).
    """
    if len(text) > MAX_CHARACTERS:
        raise ProtocolError(f"a DBC of {len(text)} characters is not read")
    plain = _ASIDE.sub(lambda found: '""' if found[0][0] == '"' else " ", text)
    if found := _TOO_MUCH.search(plain):
        raise ProtocolError(f"{found[0]!r} has no place in this protocol's DBC")
    for length in _LENGTH.findall(plain):
        if int(length) > _MAX_BYTES:
            raise ProtocolError(f"a message of {length} bytes; a frame carries {_MAX_BYTES}")
    for bits in _BITS.findall(plain):
        if max(map(int, bits)) > _MAX_BITS:
            raise ProtocolError(f"a signal at bits {'|'.join(bits)}; a frame carries {_MAX_BITS}")
    try:
        loaded = cantools.database.load_string(text, database_format="dbc")
    except (cantools.Error, textparser.Error, DecimalException, ArithmeticError, LookupError) as error:
        raise _refused(error) from None
    except (AttributeError, RecursionError, TypeError, ValueError) as error:
        raise _refused(error) from None
    assert isinstance(loaded, Database)
    numbers = [message.frame_id for message in loaded.messages]
    names = [message.name for message in loaded.messages]
    for message in loaded.messages:
        if message.is_extended_frame or not 0 <= message.frame_id <= _MAX_ID:
            raise ProtocolError(f"{message.name}: identifier {message.frame_id:#x} has more than 11 bits")
        if numbers.count(message.frame_id) > 1 or names.count(message.name) > 1:
            raise ProtocolError(f"{message.name}: its name or identifier {message.frame_id:#x} stands twice")
    return loaded


def _refused(error: Exception) -> ProtocolError:
    return ProtocolError(f"not a DBC: {' '.join(str(error).split())[:200] or type(error).__name__}")
