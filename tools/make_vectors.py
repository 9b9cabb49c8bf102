#!/usr/bin/env python3
"""Write firmware_protocol/vectors.json: what every implementation of the protocol must meet, byte for byte.

frames       fields -> identifier, payload, serial packet; and back
bad_packets  bytes on a serial line that must be dropped and counted, each ended by its zero
bad_frames   frames that pass the line's check and must be dropped and counted all the same
ticks        set-points of all joints with their CRC-32 and frames
limiter      set-points, as sent and as timed, and what is executed; null: too early

``--check`` compares and writes nothing.
"""

from __future__ import annotations

import argparse
import binascii
import json
import math
import random
import sys
import zlib
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from cobs import cobs  # noqa: E402

from firmware_protocol.assembly import ANGLE_STEP_RAD, setpoint_crc, setpoint_messages  # noqa: E402
from firmware_protocol.catalogue import MESSAGES, catalogue_hash, database, encode, frame_id  # noqa: E402
from firmware_protocol.frame import Frame  # noqa: E402
from firmware_protocol.framing import crc16, pack  # noqa: E402
from snakebot.gait.limits import SlewLimiter  # noqa: E402

VECTORS = ROOT / "firmware_protocol/vectors.json"


def _shown(frame: Frame) -> dict[str, Any]:
    return {"id": frame.id, "payload": frame.data.hex(), "packet": pack(frame).hex()}


def frames() -> list[dict[str, Any]]:
    """Three of each message: every signal at its lowest, at its highest, and somewhere."""
    chosen = []
    for name, cls in MESSAGES.items():
        definition = database().get_message_by_name(name)
        for which in ("lowest", "highest", "some"):
            draw = random.Random(f"{name} {which}")
            fields: dict[str, int | float] = {}
            for signal in definition.signals:
                scale = signal.scale
                assert signal.minimum is not None, signal.name
                assert signal.maximum is not None, signal.name
                least, most = round(signal.minimum / scale), round(signal.maximum / scale)
                most = min(most, (1 << signal.length) - 1)  # 2^64 - 1 is no float
                if signal.choices:
                    least, most = min(signal.choices), max(signal.choices)
                raw = {"lowest": least, "highest": most, "some": draw.randint(least, most)}[which]
                fields[signal.name] = raw if scale == 1 else round(raw * scale, 9)
            message = cls(**{k: cls.enums[k](int(v)) if k in cls.enums else v for k, v in fields.items()})
            chosen.append({"message": name, "fields": fields, **_shown(encode(message))})
    return chosen


def _packet(body: bytes) -> str:
    return bytes(cobs.encode(body) + b"\0").hex()


def bad_packets() -> list[dict[str, str]]:
    good = pack(Frame(80, bytes([1, 2, 3, 4])))
    body = (80).to_bytes(2, "little") + bytes([1, 2, 3, 4])
    crc = crc16(body).to_bytes(2, "little")

    def long(identifier: int, payload: int) -> str:
        whole = identifier.to_bytes(2, "little") + bytes(range(1, payload + 1))
        return _packet(whole + crc16(whole).to_bytes(2, "little"))

    flipped = [bytes(b ^ (1 << bit) if i == place else b for i, b in enumerate(good[:-1])) for place, bit in
               ((0, 1), (1, 0), (2, 7), (4, 3), (7, 6), (8, 0))]  # fmt: skip
    return [
        {"why": "CRC of the wrong byte order", "bytes": _packet(body + crc[::-1])},
        {"why": "CRC with start 0", "bytes": _packet(body + binascii.crc_hqx(body, 0).to_bytes(2, "little"))},
        *({"why": "one bit flipped", "bytes": (packet + b"\0").hex()} for packet in flipped),
        {"why": "first byte lost", "bytes": good[1:].hex()},
        {"why": "last byte lost", "bytes": (good[:-2] + b"\0").hex()},
        {"why": "two packets without a zero between", "bytes": (good[:-1] + good).hex()},
        {"why": "identifier of 12 bits", "bytes": long(0x800, 4)},
        {"why": "identifier of 16 bits", "bytes": long(0xFFFF, 0)},
        {"why": "nine bytes of payload", "bytes": long(80, 9)},
        {"why": "no CRC", "bytes": _packet(b"\x50\x01")},
        {"why": "run beyond the end", "bytes": "0550010200"},
        {"why": "a single byte", "bytes": "0100"},
        {"why": "fourteen bytes", "bytes": "0e" + "11" * 13 + "00"},
        {"why": "a kilobyte", "bytes": "a5" * 1024 + "00"},
    ]


def bad_frames() -> list[dict[str, Any]]:
    cases = [
        ("no message has this identifier", 0x7FF, ""),
        ("no message has this identifier", 0, "0102030405060708"),
        ("Latch a byte short", 17, "00" * 7),
        ("Setpoint without payload", 16, ""),
        ("Ping too long", 80, "0102030405"),
        ("ModeRequest: mode 5 has no name", 64, "010500000001"),
        ("ModeRequest: mode 255 has no name", 64, "01ff00000001"),
        ("JointModeRequest: joint mode 4 has no name", 65, "0181000000000001"),
        ("LimitRequest: kind 3 has no name", 66, "0161010001000000"),
        ("State from a host: mode 15 has no name", 32, "010000f000000000"),
    ]
    return [{"why": why, **_shown(Frame(identifier, bytes.fromhex(data)))} for why, identifier, data in cases]


def ticks() -> list[dict[str, Any]]:
    chosen = []
    draw = random.Random(7)
    for joints in (1, 2, 3, 4, 5, 6, 7, 15, 16):
        for sequence, interval in ((0, 0.0005), (4095, 0.01), (4096, 0.002), (65535, 0.1275)):
            raw = [draw.choice((-32767, -1, 0, 1, 32767, draw.randint(-32767, 32767))) for _ in range(joints)]
            angles = [round(r * ANGLE_STEP_RAD, 4) for r in raw]
            chosen.append(
                {
                    "sequence": sequence,
                    "interval_s": interval,
                    "angles_rad": angles,
                    "crc32": f"{setpoint_crc(sequence, angles):08x}",
                    "frames": [
                        _shown(encode(message)) for message in setpoint_messages(sequence, angles, interval)
                    ],
                }
            )
    return chosen


def _trace(
    draw: random.Random, limits: tuple[float, float, float], start: float, style: str
) -> dict[str, Any]:
    """One joint's stream; no decision of it hangs on the last digit of a float."""
    limiter = SlewLimiter([limits[0]], [limits[1]], [limits[2]])
    limiter.reset([start])
    steps = []
    t_s = executed_s = 0.0
    for index in range(60):
        interval, gap, elapsed, target = 0.01, 1, 0.01, start
        if style == "sine":
            target = limits[0] * 0.9 * math.sin(3.0 * 0.01 * index)
        elif style == "steps":
            target = limits[0] * (1.5 if index // 15 % 2 == 0 else -1.5)
        elif style == "bursts":
            target, elapsed = limits[0] * 1.5, (0.0601 if index % 12 == 11 else 0.0003)
        elif style == "quick":  # at 1000 Hz a slack at each tick would show
            target, interval, elapsed = limits[0] * (0.9 if index < 40 else 0.0), 0.001, 0.001
        else:
            target = draw.uniform(-3.2, 3.2)
            interval = draw.choice((0.0005, 0.002, 0.005, 0.01, 0.02, 0.1275))
            gap = draw.choice((1, 1, 1, 2, 4, 5, 300))
            elapsed = draw.choice((0.0, 0.0003, 0.0021, 0.0101, 0.0203, 0.0999))
        target = round(round(target / ANGLE_STEP_RAD) * ANGLE_STEP_RAD, 4)
        t_s = round(t_s + elapsed, 6)
        credit = min(limiter._credit_s + t_s - executed_s, interval * min(gap, 4) + 0.02)
        if abs(credit - 0.0005) < 2e-6 or abs(credit) < 1e-9:
            t_s = round(t_s + 0.00001, 6)
            elapsed = round(elapsed + 0.00001, 6)
        executed = limiter.execute([target], interval, gap, t_s - executed_s)
        if executed is not None:
            executed_s = t_s
        steps.append(
            {
                "target_rad": target,
                "interval_s": interval,
                "gap": gap,
                "elapsed_s": elapsed,
                "applied_rad": None if executed is None else round(executed[0][0], 9),
            }
        )
    return {
        "style": style,
        "angle_rad": limits[0],
        "speed_rad_s": limits[1],
        "acceleration_rad_s2": limits[2],
        "start_rad": start,
        "ticks": steps,
    }


def limiter() -> list[dict[str, Any]]:
    draw = random.Random(11)
    traces = []
    for style in ("sine", "steps", "bursts", "anything"):
        for limits, start in (
            ((1.658, 8.0, 60.0), 0.0),
            ((0.5, 1.0, 4.0), -0.3),
            ((0.3, 2.0, 20.0), 0.7),  # starts outside: only inwards
        ):
            traces.append(_trace(draw, limits, start, style))
    traces += [
        _trace(draw, *joint, "quick") for joint in (((1.658, 8.0, 60.0), 0.0), ((0.3, 2.0, 20.0), 0.7))
    ]
    return traces


def make() -> dict[str, Any]:
    return {
        "catalogue_hash": f"{catalogue_hash():08x}",
        "check": {
            "text": "123456789",
            "crc16": f"{crc16(b'123456789'):04x}",
            "crc32": f"{zlib.crc32(b'123456789'):08x}",
        },
        "emergency_stop_id": frame_id(MESSAGES["EmergencyStop"]),
        "frames": frames(),
        "bad_packets": bad_packets(),
        "bad_frames": bad_frames(),
        "ticks": ticks(),
        "limiter": limiter(),
    }


def text() -> str:
    """One vector a line: a change shows in a diff as what it is."""
    parts = []
    for key, value in make().items():
        if isinstance(value, list):
            rows = ",\n".join("  " + json.dumps(row) for row in value)
            parts.append(f' "{key}": [\n{rows}\n ]')
        else:
            parts.append(f' "{key}": {json.dumps(value)}')
    return "{\n" + ",\n".join(parts) + "\n}\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--check", action="store_true", help="write nothing; exit 1 if the file is out of date"
    )
    check = parser.parse_args().check
    fresh = text()
    if VECTORS.exists() and VECTORS.read_text(encoding="utf-8") == fresh:
        print("up to date")
        return 0
    if check:
        print(f"out of date: {VECTORS.relative_to(ROOT)}")
        return 1
    VECTORS.write_text(fresh, encoding="utf-8")
    print(f"written: {VECTORS.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
