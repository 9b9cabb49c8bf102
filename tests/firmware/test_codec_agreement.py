"""One change of the DBC, and the generated C, the Python messages and the vectors must all say that they disagree."""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import fields
from pathlib import Path
from types import ModuleType

import cantools
import pytest

from firmware_protocol.catalogue import MESSAGES, catalogue_hash, dbc_text

ROOT = Path(__file__).resolve().parents[2]
GENERATED = ROOT / "firmware_protocol/firmware/core/generated"


def disagreements(dbc: str, make_codec: ModuleType) -> dict[str, list[str]]:
    """Who does not agree with this DBC, and where: C, Python, vectors."""
    found: dict[str, list[str]] = {"c": [], "python": [], "vectors": []}
    for name, text in make_codec.generate_codec(dbc).items():
        if (GENERATED / name).read_text(encoding="utf-8") != text:
            found["c"].append(name)

    database = cantools.database.load_string(dbc, database_format="dbc")
    assert isinstance(database, cantools.database.can.Database)
    digest = int.from_bytes(hashlib.sha256(dbc.encode()).digest()[:4], "big")
    if digest != catalogue_hash():
        found["python"].append("catalogue hash")
    if {message.name for message in database.messages} != set(MESSAGES):
        found["python"].append("message names")
    for message in database.messages:
        cls = MESSAGES.get(message.name)
        if cls is None:
            continue
        if {signal.name for signal in message.signals} != {field.name for field in fields(cls)}:  # type: ignore[arg-type]
            found["python"].append(f"{message.name}: signals")
        for signal in message.signals:
            named = set(signal.choices or ())
            if named != {int(value) for value in cls.enums.get(signal.name, ())}:
                found["python"].append(f"{message.name}.{signal.name}: named values")

    vectors = json.loads((ROOT / "firmware_protocol/vectors.json").read_text(encoding="utf-8"))
    if vectors["catalogue_hash"] != f"{digest:08x}":
        found["vectors"].append("catalogue hash")
    for vector in vectors["frames"]:
        try:
            message = database.get_message_by_name(vector["message"])
            data = message.encode(vector["fields"], strict=False, padding=False)
            if message.frame_id != vector["id"] or data.hex() != vector["payload"]:
                raise ValueError("other bytes")
        except (KeyError, ValueError, OverflowError, cantools.database.EncodeError) as error:
            found["vectors"].append(f"{vector['message']}: {error}")
    return found


def test_dbc_c_python_and_vectors_agree(make_codec: ModuleType) -> None:
    assert disagreements(dbc_text(), make_codec) == {"c": [], "python": [], "vectors": []}, (
        "the DBC has changed: run tools/make_codec.py and tools/make_vectors.py, and look at catalogue.py"
    )


# ruff: noqa: E501
# What a hand slips into; the last column: who notices by more than the hash.
CHANGES = [
    ("a signal moved by a bit", r"(SG_ simulated : )24\|1@", r"\g<1>25|1@", "vectors"),
    ("a signal one bit narrower", r"(SG_ crc32 : )32\|32", r"\g<1>32|31", "vectors"),
    ("another scale", r"(SG_ interval_s : 24\|8@1\+ \()0\.0005", r"\g<1>0.001", "vectors"),
    ("signed made unsigned", r"(SG_ zero_counts : 16\|16@1)-", r"\1+", "c"),
    ("another byte order", r"(SG_ nonce : )0\|32@1(\+ \(1,0\) \[0\|4294967295\] \"\" Board)", r"\g<1>7|32@0\2", "vectors"),
    ("a signal renamed", r"SG_ trim_rad ", "SG_ trim ", "python"),
    ("a message renamed", r"BO_ 80 Ping:", "BO_ 80 Echo:", "python"),
    ("another identifier", r"BO_ 80 Ping:", "BO_ 82 Ping:", "vectors"),
    ("another length", r"BO_ 80 Ping: 4", "BO_ 80 Ping: 5", "vectors"),
    ("one named value more", r"(VAL_ 64 mode .*4 \"fault\")", r'\1 5 "parked"', "python"),
    ("another range", r"(SG_ joints : 16\|8@1\+ \(1,0\) \[1\|)16(\] \"\" Board)", r"\g<1>12\2", "c"),
    ("one signal more", r"(BO_ 80 Ping: )4( Host\n)", '\\g<1>5\\2 SG_ urgent : 32|8@1+ (1,0) [0|255] "" Board\n', "python"),
]  # fmt: skip


@pytest.mark.parametrize(("what", "pattern", "change", "who"), CHANGES, ids=[change[0] for change in CHANGES])
def test_any_change_of_one_signal_is_loud(
    what: str, pattern: str, change: str, who: str, make_codec: ModuleType
) -> None:
    changed, times = re.subn(pattern, change, dbc_text(), count=1)
    assert times == 1, "the pattern is out of date"
    found = disagreements(changed, make_codec)
    assert all(found.values()), f"{what}: {found}"
    beyond_hash = [entry for entry in found[who] if "hash" not in entry and entry != "catalogue.h"]
    assert beyond_hash, f"{what} should be named by {who}: {found}"
