"""The golden vectors over the wire, and everything that is no message."""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from typing import Any

from firmware_protocol.assembly import setpoint_messages
from firmware_protocol.catalogue import (
    Acknowledge,
    Counters,
    Mode,
    Ping,
    Pong,
    encode,
)
from firmware_protocol.frame import Frame
from firmware_protocol.framing import pack
from snakebot.conformance.bench import Bench, growth
from snakebot.conformance.case import case
from snakebot.conformance.violations import expect

_REQUESTS = (
    "ModeRequest", "JointModeRequest", "LimitRequest", "TrimRequest", "ZeroRequest", "ClearRequest",
)  # fmt: skip


@cache
def vectors() -> dict[str, Any]:
    """``firmware_protocol/vectors.json``."""
    text = (files("firmware_protocol") / "vectors.json").read_text(encoding="utf-8")
    loaded = json.loads(text)
    assert isinstance(loaded, dict)
    return loaded


def _frame(vector: dict[str, Any]) -> Frame:
    return Frame(vector["id"], bytes.fromhex(vector["payload"]))


_AT_ONCE = 40  # pings; their answers are more than a board may gather for one write


@case("Frames that come in one go are all answered, in their order.", needs=("send_bytes",))
def answers_all_at_once(bench: Bench) -> None:
    assert bench.send_bytes is not None
    wanted = [0x5EA_0000 + number for number in range(_AT_ONCE)]
    bench.heard.clear()
    bench.send_bytes(b"".join(pack(encode(Ping(nonce))) for nonce in wanted))
    bench.sent += _AT_ONCE
    bench.listen(0.25)
    answered = [m.nonce for m in bench.heard if isinstance(m, Pong) and m.nonce in wanted]
    expect(
        answered == wanted, f"of {_AT_ONCE} pings in one go {len(answered)} were answered, or out of order"
    )


def _grown(before: Counters, after: Counters, name: str) -> int:
    return growth(getattr(after, name), getattr(before, name))


@case(
    "Every golden frame is understood: requests are acknowledged, pings answered, none is counted as corrupt."
)
def takes_golden_frames(bench: Bench) -> None:
    bench.enter(Mode.STOPPED)  # here no request changes anything, but to clear
    before, sent_before = bench.counters(), bench.sent
    for vector in sorted(vectors()["frames"], key=lambda v: v["message"] == "ModeRequest"):
        bench.send_frames([_frame(vector)])
        fields = vector["fields"]
        if vector["message"] in _REQUESTS:
            answer = bench.wait(Acknowledge, token=fields["token"])
            expect(answer.request == vector["id"], f"{vector['message']} was acknowledged as {answer}")
        elif vector["message"] == "Ping":
            bench.wait(Pong, nonce=fields["nonce"])
    after = bench.counters()
    expect(
        _grown(before, after, "corrupt") == 0,
        f"{_grown(before, after, 'corrupt')} golden frames counted as corrupt",
    )
    heard, sent = _grown(before, after, "received"), bench.sent - sent_before
    expect(heard == sent, f"{sent} frames were sent, Counters.received grew by {heard}")


@case(
    "An unknown identifier, a wrong length, an unnamed enumeration value: counted as corrupt, not answered."
)
def counts_bad_frames(bench: Bench) -> None:
    before = bench.counters()
    bench.heard.clear()
    bad = vectors()["bad_frames"]
    for vector in bad:
        bench.send_frames([_frame(vector)])
    after = bench.counters()
    expect(
        _grown(before, after, "corrupt") == len(bad),
        f"of {len(bad)} bad frames {_grown(before, after, 'corrupt')} were counted as corrupt: "
        + "; ".join(vector["why"] for vector in bad),
    )
    answers = [m for m in bench.heard if isinstance(m, Acknowledge)]
    expect(not answers, f"bad frames were answered: {answers}")
    expect(bench.beat().mode is Mode.DISARMED, "bad frames changed the mode")


@case(
    "A packet with a wrong CRC, length or coding is dropped and counted; the next one is heard.",
    needs=("send_bytes",),
)
def counts_bad_packets(bench: Bench) -> None:
    assert bench.send_bytes is not None
    before = bench.counters()
    bad = vectors()["bad_packets"]
    for number, vector in enumerate(bad):
        bench.send_bytes(b"\0" + bytes.fromhex(vector["bytes"]) + pack(encode(Ping(number))))
        bench.wait(Pong, nonce=number)
    bench.sent += len(bad)
    after = bench.counters()
    grown = _grown(before, after, "corrupt")
    expect(grown == len(bad), f"of {len(bad)} bad packets {grown} were counted as corrupt")
    received = _grown(before, after, "received")
    expect(
        received == len(bad) + 1,
        f"bad packets were received as frames: {received}, of {len(bad) + 1} good ones",
    )


@case("Extra zeros are no packets; a packet may come in single bytes.", needs=("send_bytes",))
def takes_zeros_and_single_bytes(bench: Bench) -> None:
    assert bench.send_bytes is not None
    before = bench.counters()
    bench.send_bytes(b"\0" * 50 + pack(encode(Ping(7))) + b"\0" * 50)
    bench.wait(Pong, nonce=7)
    for byte in pack(encode(Ping(8))):
        bench.send_bytes(bytes([byte]))
    bench.wait(Pong, nonce=8)
    grown = _grown(before, bench.counters(), "corrupt")
    expect(grown == 0, f"extra zeros were counted as {grown} corrupt packets")


@case(
    "A packet that lost bytes on the line is corrupt, also right after the same one whole: nothing of that stands in.",
    needs=("send_bytes",),
)
def completes_no_packet_from_the_one_before(bench: Bench) -> None:
    assert bench.send_bytes is not None
    before = bench.counters()
    whole = pack(encode(Ping(0x5A5A5A5A)))[:-1]
    lost = [(first, last) for first in range(len(whole)) for last in range(first + 1, len(whole) + 1)]
    for first, last in lost:
        bench.send_bytes(whole + b"\0")
        bench.wait(Pong, nonce=0x5A5A5A5A)
        bench.heard.clear()
        bench.send_bytes(whole[:first] + whole[last:] + b"\0")
        bench.ping()
        pongs = [m for m in bench.heard if isinstance(m, Pong) and m.nonce == 0x5A5A5A5A]
        expect(not pongs, f"a Ping that had lost bytes {first + 1} to {last} was answered")
    grown = _grown(before, bench.counters(), "corrupt")
    wanted = len(lost) - 1  # one has lost all
    expect(grown == wanted, f"of {wanted} packets that had lost bytes {grown} were counted as corrupt")


@case("Noise costs the packets it touches, and nothing else.", needs=("send_bytes",))
def survives_noise(bench: Bench) -> None:
    assert bench.send_bytes is not None
    for number in range(30):
        noise = bench.draw.randbytes(bench.draw.randrange(1, 60)).replace(b"\x01\x00", b"")
        bench.send_bytes(noise + b"\0" + pack(encode(Ping(number))))
        bench.wait(Pong, nonce=number)


@case("Every frame that is received is counted, those of set-points, executed or not, as all others.")
def counts_the_frames_of_setpoints(bench: Bench) -> None:
    before, sent_before = bench.counters(), bench.sent
    here = bench.arm()
    bench.stand_at(here, 0.1, "a stream")
    bench.must_go(Mode.HOLDING)
    bench.stream(0.05, lambda t: here)
    bench.must_go(Mode.DISARMED)
    after = bench.counters()
    heard, sent = _grown(before, after, "received"), bench.sent - sent_before
    expect(heard == sent, f"{sent} frames were sent, most of set-points, Counters.received grew by {heard}")


@case("Counters wrap at 16 bits.", long=True)
def counters_wrap(bench: Bench) -> None:
    before, sent_before = bench.counters(), bench.sent
    here = list(bench.sample().applied_rad)
    latch = encode(setpoint_messages(1, here, 0.01)[-1])  # counted as dropped: the board is disarmed
    bad = Frame(latch.id, latch.data[:-1])
    for frame in (latch, bad):
        for _ in range(66_000 // _AT_ONCE + 1):
            bench.send_frames([frame] * _AT_ONCE)
            bench.ping()  # never more under way than a small buffer holds
    after = bench.counters()
    kinds = (66_000 // _AT_ONCE + 1) * _AT_ONCE
    for name, wanted in (("received", bench.sent - sent_before), ("dropped", kinds), ("corrupt", kinds)):
        heard = _grown(before, after, name)
        expect(
            heard == wanted & 0xFFFF,
            f"{wanted} frames to be counted as {name} were sent: the counter grew by {heard}, not {wanted & 0xFFFF}",
        )
