#!/usr/bin/env python3
"""Frames a second through the typed messages and the framing, beside bare cantools and bare cobs in the same run.

  encode, decode    a tick's frames for 16 joints (set-points, latch, a sample, a pose) as typed messages, beside
                    `cantools` on the same DBC with dictionaries of the same values, strict as our side is (it checks
                    every range) and not
  pack, unpack      the same frames in COBS with CRC-16 and zero delimiters, read back as one stream, beside `cobs`
                    alone: no CRC, no identifier, packets handed over already cut

The contenders take turns in short rounds; the figure is the median round. Ratio: ours to the peer, above 1 is faster.
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

JOINTS = 16


@dataclass
class Contest:
    """Two or more ways to do the same; each callable works through ``count`` frames."""

    name: str
    count: int
    ways: dict[str, Callable[[], object]]


def tick_messages() -> list[Any]:
    """What one tick and its answer carry."""
    from firmware_protocol.assembly import sample_messages, setpoint_messages
    from firmware_protocol.catalogue import Mode, PoseMotion, PosePosition, State

    angles = [0.1 * joint - 0.7 for joint in range(JOINTS)]
    return [
        *setpoint_messages(1234, angles, 0.01),
        *sample_messages(
            State(1234, 77, Mode.ARMED, 123_456_789), [31 * joint for joint in range(JOINTS)], angles
        ),
        PosePosition(77, 1.234, -0.567),
        PoseMotion(77, 0.321, 0.137),
    ]


def contests() -> list[Contest]:
    from cobs import cobs

    from firmware_protocol.catalogue import database, decode, encode
    from firmware_protocol.framing import StreamDecoder, crc16, pack, pack_all

    messages = tick_messages()
    frames = [encode(message) for message in messages]
    definitions = [database().get_message_by_name(type(message).__name__) for message in messages]
    values = [{field.name: getattr(message, field.name) for field in fields(message)} for message in messages]
    pairs = list(zip(definitions, values, strict=True))
    coded = list(zip(definitions, (frame.data for frame in frames), strict=True))
    for (definition, value), frame in zip(pairs, frames, strict=True):
        assert definition.encode(value) == frame.data, "the peers must do the same work"

    bodies = [frame.id.to_bytes(2, "little") + frame.data for frame in frames]
    bodies = [body + crc16(body).to_bytes(2, "little") for body in bodies]
    packets = [cobs.encode(body) for body in bodies]
    stream = pack_all(frames)
    decoder = StreamDecoder()
    assert decoder.feed(stream) == frames
    assert [cobs.decode(packet) for packet in packets] == bodies
    count = len(frames)
    return [
        Contest(
            "encode",
            count,
            {
                "snakebot": lambda: [encode(message) for message in messages],
                "cantools": lambda: [d.encode(v) for d, v in pairs],
                "cantools, not strict": lambda: [d.encode(v, strict=False) for d, v in pairs],
            },
        ),
        Contest(
            "decode",
            count,
            {
                "snakebot": lambda: [decode(frame) for frame in frames],
                "cantools": lambda: [d.decode(data, decode_choices=False) for d, data in coded],
            },
        ),
        Contest(
            "pack",
            count,
            {
                "snakebot": lambda: [pack(frame) for frame in frames],
                "cobs": lambda: [cobs.encode(body) for body in bodies],
            },
        ),
        Contest(
            "unpack",
            count,
            {
                "snakebot": lambda: decoder.feed(stream),
                "cobs": lambda: [cobs.decode(packet) for packet in packets],
            },
        ),
    ]


def measure(contest: Contest, rounds: int, round_s: float) -> dict[str, float]:
    """Frames a second of each way: median over rounds in which they take turns."""
    rates: dict[str, list[float]] = {name: [] for name in contest.ways}
    for _ in range(rounds):
        for name, way in contest.ways.items():
            calls, start = 0, time.perf_counter()
            while (elapsed := time.perf_counter() - start) < round_s:
                for _ in range(20):
                    way()
                calls += 20
            rates[name].append(calls * contest.count / elapsed)
    return {name: statistics.median(values) for name, values in rates.items()}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--round-s", type=float, default=0.1, help="length of a round, s")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    results = {contest.name: measure(contest, options.rounds, options.round_s) for contest in contests()}
    if options.json:
        print(json.dumps(results))
        return
    print(f"{'':8} {'':22} {'frames/s':>12} {'ratio':>7}")
    for name, rates in results.items():
        for way, rate in rates.items():
            ratio = "" if way == "snakebot" else f"{rates['snakebot'] / rate:7.2f}"
            print(f"{name:8} {way:22} {rate:12,.0f} {ratio:>7}")
            name = ""


if __name__ == "__main__":
    main()
