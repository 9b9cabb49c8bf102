"""The golden vectors: the Python side meets them, they are up to date, and some are worked out by hand."""

from __future__ import annotations

import itertools
import json
import math
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from firmware_protocol.assembly import SetpointAssembler, setpoint_messages
from firmware_protocol.catalogue import MESSAGES, Latch, Setpoint, catalogue_hash, decode, encode
from firmware_protocol.frame import Frame, ProtocolError
from firmware_protocol.framing import StreamDecoder, pack, unpack
from snakebot.gait.limits import SlewLimiter

VECTORS: dict[str, Any] = json.loads(
    (Path(__file__).resolve().parents[2] / "firmware_protocol/vectors.json").read_text(encoding="utf-8")
)


def frame_of(vector: dict[str, Any]) -> Frame:
    return Frame(vector["id"], bytes.fromhex(vector["payload"]))


def test_the_file_is_what_the_generator_writes(make_vectors: ModuleType) -> None:
    assert make_vectors.VECTORS.read_text(encoding="utf-8") == make_vectors.text(), (
        "run tools/make_vectors.py"
    )
    assert VECTORS["catalogue_hash"] == f"{catalogue_hash():08x}"


def test_every_message_has_vectors() -> None:
    assert {vector["message"] for vector in VECTORS["frames"]} == set(MESSAGES)


@pytest.mark.parametrize("vector", VECTORS["frames"], ids=lambda v: f"{v['message']}-{v['payload']}")
def test_frames_both_ways(vector: dict[str, Any]) -> None:
    cls = MESSAGES[vector["message"]]
    fields = {k: cls.enums[k](v) if k in cls.enums else v for k, v in vector["fields"].items()}
    frame = frame_of(vector)
    assert encode(cls(**fields)) == frame
    said = decode(frame)
    assert type(said) is cls
    for name, value in fields.items():
        assert getattr(said, name) == pytest.approx(value, abs=1e-9), name
    assert pack(frame).hex() == vector["packet"]
    assert unpack(bytes.fromhex(vector["packet"])[:-1]) == frame


@pytest.mark.parametrize("vector", VECTORS["bad_packets"], ids=lambda v: v["why"])
def test_bad_packets_are_dropped_and_the_next_one_is_heard(vector: dict[str, Any]) -> None:
    decoder = StreamDecoder()
    good = Frame(80, b"\x01\x02\x03\x04")
    assert decoder.feed(bytes.fromhex(vector["bytes"]) + pack(good)) == [good]
    assert decoder.corrupt == 1


@pytest.mark.parametrize("vector", VECTORS["bad_frames"], ids=lambda v: v["why"])
def test_bad_frames_are_no_messages(vector: dict[str, Any]) -> None:
    frame = frame_of(vector)
    assert unpack(bytes.fromhex(vector["packet"])[:-1]) == frame
    with pytest.raises(ProtocolError):
        decode(frame)


@pytest.mark.parametrize("vector", VECTORS["ticks"], ids=lambda v: f"{len(v['angles_rad'])}-{v['sequence']}")
def test_ticks(vector: dict[str, Any]) -> None:
    messages = setpoint_messages(vector["sequence"], vector["angles_rad"], vector["interval_s"])
    assert [encode(message) for message in messages] == [frame_of(frame) for frame in vector["frames"]]
    assembler = SetpointAssembler(len(vector["angles_rad"]))
    complete = None
    for frame in reversed(vector["frames"]):
        message = decode(frame_of(frame))
        assert isinstance(message, Setpoint | Latch)
        complete = assembler.add(message)
    assert complete is not None
    assert f"{complete[0].crc32:08x}" == vector["crc32"]
    assert complete[1] == pytest.approx(vector["angles_rad"], abs=1e-9)


@pytest.mark.parametrize("trace", VECTORS["limiter"], ids=lambda v: f"{v['style']}-{v['angle_rad']}")
def test_limiter(trace: dict[str, Any]) -> None:
    limiter = SlewLimiter([trace["angle_rad"]], [trace["speed_rad_s"]], [trace["acceleration_rad_s2"]])
    limiter.reset([trace["start_rad"]])
    waited_s = 0.0
    for tick in trace["ticks"]:
        waited_s += tick["elapsed_s"]
        executed = limiter.execute([tick["target_rad"]], tick["interval_s"], tick["gap"], waited_s)
        if tick["applied_rad"] is None:
            assert executed is None
        else:
            assert executed is not None
            assert executed[0][0] == pytest.approx(tick["applied_rad"], abs=1e-6)
            waited_s = 0.0


def test_limiter_traces_show_every_rule() -> None:
    """A trace that never meets a limit proves nothing."""
    early = sum(tick["applied_rad"] is None for trace in VECTORS["limiter"] for tick in trace["ticks"])
    assert early > 20
    for trace in VECTORS["limiter"]:
        applied = [tick["applied_rad"] for tick in trace["ticks"] if tick["applied_rad"] is not None]
        assert max(abs(b - a) for a, b in itertools.pairwise(applied)) > 1e-3
    steps = [trace for trace in VECTORS["limiter"] if trace["style"] == "steps"]
    assert all(any(abs(t["applied_rad"] - t["target_rad"]) > 0.1 for t in trace["ticks"]) for trace in steps)


# Worked out by hand from the bit positions in snakebot.dbc, not by any code of this project.
BY_HAND = [
    # sequence 0xABC | group 5 << 12 = 0x5ABC; 1 rad = 10000 = 0x2710; -1 rad = 0xD8F0; -1e-4 rad = 0xFFFF
    ("Setpoint", {"sequence": 0xABC, "group": 5, "first_rad": 1.0, "second_rad": -1.0, "third_rad": -1e-4},
     "bc5a1027f0d8ffff"),
    # 10 ms = 20 steps of 0.5 ms
    ("Latch", {"sequence": 0x1234, "joints": 5, "interval_s": 0.01, "crc32": 0xDEADBEEF}, "34120514efbeadde"),
    # joint 3 | kind speed 1 << 5 = 0x23; 7.5 rad/s = 3750 steps = 0xEA6: bit 15 on, 17 bits: 0xEA6 << 7 = 0x75300
    ("LimitRequest", {"token": 9, "joint": 3, "kind": 1, "value": 7.5, "host": 1}, "0923530701000000"),
    # joint 31 would be 0x1F; joint 4 | rigid 2 << 5 = 0x44; 0.5 rad = 5000 = 0x1388
    ("JointModeRequest", {"token": 1, "joint": 4, "mode": 2, "angle_rad": 0.5, "host": 0x01020304},
     "0144881304030201"),
    # holding 2 | powered 1 << 4 | simulated 1 << 5 = 0x32
    ("BoardHeartbeat", {"boot_id": 0xBEEF, "mode": 2, "powered": 1, "simulated": 1, "fault": 3, "holder": 7},
     "efbe320307000000"),
    # -1 m = -10000 steps in 24 bits = 0xFFD8F0
    ("PosePosition", {"sample": 0xFFF, "x_m": -1.0, "y_m": 1.0}, "ff0ff0d8ff102700"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "fields", "payload"), BY_HAND, ids=lambda v: v if isinstance(v, str) else ""
)
def test_worked_out_by_hand(name: str, fields: dict[str, Any], payload: str) -> None:
    cls = MESSAGES[name]
    values = {k: cls.enums[k](v) if k in cls.enums else v for k, v in fields.items()}
    assert encode(cls(**values)).data.hex() == payload
    for field, value in values.items():
        decoded = getattr(decode(Frame(encode(cls(**values)).id, bytes.fromhex(payload))), field)
        assert math.isclose(decoded, value, abs_tol=1e-9)
