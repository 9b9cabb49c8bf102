"""The run's metadata in an MCAP metadata record: a map of strings, guarded by a checksum.

A value that is not a string is stored as JSON, and so is a string that would read as JSON; viewers show plain
text as plain text. MCAP puts no checksum on metadata, so one is stored beside it: a flipped bit is noticed,
not believed.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from typing import Any

import orjson

RECORD_NAME = "run"
_CHECKSUM = "crc32"


def to_strings(metadata: Mapping[str, Any]) -> dict[str, str]:
    """Encode and add the checksum. Tuples come back as lists, numpy arrays too, other objects as text."""
    texts = {as_utf8(str(key)): _encode(value) for key, value in metadata.items() if str(key) != _CHECKSUM}
    return {**texts, _CHECKSUM: _checksum(texts)}


def from_strings(texts: Mapping[str, str]) -> dict[str, Any] | None:
    """Decode; None where the checksum is absent or does not fit."""
    body = {key: text for key, text in texts.items() if key != _CHECKSUM}
    if texts.get(_CHECKSUM) != _checksum(body):
        return None
    return {key: _decode(text) for key, text in body.items()}


def as_utf8(text: str) -> str:
    """Text that can be written: what a terminal passes on undecoded (``\\udcff``) is spelt out."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def _encode(value: Any) -> str:
    value = as_utf8(value) if isinstance(value, str) else value
    if isinstance(value, str) and isinstance(_decode(value), str) and not value.startswith('"'):
        return value
    try:
        options = orjson.OPT_SERIALIZE_NUMPY | orjson.OPT_NON_STR_KEYS
        return orjson.dumps(value, default=_plain, option=options).decode()
    except TypeError:  # integers beyond 64 bits, odd keys: a run must not fail over a remark
        return orjson.dumps(as_utf8(str(value))).decode()


def _decode(text: str) -> Any:
    try:
        return orjson.loads(text)
    except orjson.JSONDecodeError:
        return text


def _plain(value: Any) -> Any:
    if hasattr(value, "tolist"):
        return value.tolist()
    if hasattr(value, "items"):
        return dict(value.items())
    return str(value)


def _checksum(texts: Mapping[str, str]) -> str:
    return f"{zlib.crc32(orjson.dumps(sorted(texts.items()))):08x}"
