"""Every frame that is no message of the catalogue: counted, dropped, not answered."""

from __future__ import annotations

from collections.abc import Iterator

from firmware_protocol.catalogue import (
    MESSAGES,
    Acknowledge,
    Counters,
    EmergencyStop,
    InfoProtocol,
    JointMode,
    JointModeRequest,
    LimitKind,
    LimitRequest,
    Message,
    Mode,
    ModeRequest,
    Ping,
    Pong,
    encode,
    frame_id,
)
from firmware_protocol.frame import Frame
from snakebot.conformance.bench import Bench, growth
from snakebot.conformance.case import case
from snakebot.conformance.frames import vectors
from snakebot.conformance.violations import expect

_MAX_ID = 0x7FF  # of CAN, 11 bits
_AT_ONCE = 32  # frames; chosen: no receive buffer of a board overflows


def _golden() -> dict[str, Frame]:
    """One good frame of each message."""
    frames = vectors()["frames"]
    return {vector["message"]: Frame(vector["id"], bytes.fromhex(vector["payload"])) for vector in frames}


def _wrong_lengths() -> Iterator[Frame]:
    for name, frame in _golden().items():
        if name != EmergencyStop.__name__:
            for length in set(range(9)) - {len(frame.data)}:
                yield Frame(frame.id, (frame.data + bytes(8))[:length])


def _unknown_ids() -> Iterator[Frame]:
    known = {frame_id(message) for message in MESSAGES.values()}
    for identifier in sorted(set(range(_MAX_ID + 1)) - known):
        yield Frame(identifier, bytes(8))


def _unnamed_values(bench: Bench) -> Iterator[Frame]:
    """Values that have no name in each enumeration that a host sends."""
    host = bench.host
    mode = bytearray(encode(ModeRequest(1, Mode.ARMED, host)).data)
    for value in (5, 6, 7, 8, 16, 64, 128, 255):
        mode[1] = value
        yield Frame(frame_id(ModeRequest), bytes(mode))
    joint = bytearray(encode(JointModeRequest(1, 1, JointMode.ACTIVE, 0.0, host)).data)
    for value in range(4, 8):
        joint[1] = joint[1] & 0x1F | value << 5
        yield Frame(frame_id(JointModeRequest), bytes(joint))
    limit = bytearray(encode(LimitRequest(1, 1, LimitKind.ANGLE, 0.5, host)).data)
    limit[1] = limit[1] & 0x9F | 3 << 5
    yield Frame(frame_id(LimitRequest), bytes(limit))


def _all_counted(bench: Bench, frames: list[Frame], what: str) -> None:
    before, sent_before = bench.counters(), bench.sent
    bench.heard.clear()
    for first in range(0, len(frames), _AT_ONCE):
        bench.send_frames(frames[first : first + _AT_ONCE])
        bench.ping()
    pings = sum(isinstance(m, Pong) for m in bench.heard)
    after = bench.counters()
    corrupt = growth(after.corrupt, before.corrupt)
    expect(corrupt == len(frames), f"{len(frames)} frames with {what}: {corrupt} were counted as corrupt")
    received, sent = growth(after.received, before.received), bench.sent - sent_before
    expect(received == sent, f"{sent} frames were sent, Counters.received grew by {received}")
    answers = [m for m in bench.heard if isinstance(m, Acknowledge | InfoProtocol)]
    expect(not answers, f"frames with {what} were answered: {answers}")
    expect(pings == -(-len(frames) // _AT_ONCE), f"a frame with {what} was answered by a Pong")
    beat = bench.beat()
    expect((beat.mode, beat.powered) == (Mode.DISARMED, 0), f"frames with {what} made the board {beat}")


@case(
    "Every message of every other length is counted as corrupt and dropped; the emergency stop has no wrong length."
)
def drops_every_wrong_length(bench: Bench) -> None:
    _all_counted(bench, list(_wrong_lengths()), "a wrong length")


@case("Every identifier that is in no catalogue is counted as corrupt and dropped.")
def drops_every_unknown_identifier(bench: Bench) -> None:
    _all_counted(bench, list(_unknown_ids()), "an unknown identifier")


@case("Every enumeration's values without a name are counted as corrupt and dropped.")
def drops_every_unnamed_value(bench: Bench) -> None:
    _all_counted(bench, list(_unnamed_values(bench)), "an unnamed value")


@case(
    "What boards say is no request: a good frame of every other message is dropped and not counted as corrupt."
)
def ignores_what_boards_say(bench: Bench) -> None:
    asked = ("Setpoint", "Latch", "HostHeartbeat", "Ping", "InfoRequest", "EmergencyStop")
    frames = [f for name, f in _golden().items() if name not in asked and not name.endswith("Request")]
    before: Counters = bench.counters()
    bench.heard.clear()
    bench.send_frames(frames)
    after = bench.counters()
    expect(after.corrupt == before.corrupt, "a message that boards send was counted as corrupt")
    expect(
        not any(isinstance(m, Acknowledge) for m in bench.heard),
        "a message that boards send was acknowledged",
    )
    expect(bench.beat().mode is Mode.DISARMED, "a message that boards send changed the mode")


@case("A nonce comes back bit by bit.")
def returns_every_bit_of_a_nonce(bench: Bench) -> None:
    for bit in range(32):
        messages: list[Message] = [Ping(1 << bit)]
        bench.send(*messages)
        bench.wait(Pong, nonce=1 << bit)
