"""Set-points: complete, in order, at once, or not at all."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

from firmware_protocol.assembly import groups, setpoint_messages
from firmware_protocol.catalogue import Latch, Message, Mode, Setpoint, State, encode
from firmware_protocol.frame import Frame
from firmware_protocol.framing import pack
from snakebot.conformance.bench import Bench, growth
from snakebot.conformance.case import case
from snakebot.conformance.violations import expect

_SHORT_S = 0.0005  # an interval that many set-points at once are still in time with


def _parts(
    bench: Bench, sequence: int, angles: Sequence[float], interval_s: float = _SHORT_S
) -> list[Message]:
    return setpoint_messages(sequence & 0xFFFF, angles, interval_s)


def _send(bench: Bench, messages: Sequence[Message]) -> None:
    bench.send(*messages)


@case(
    "Each executed set-point is answered by one sample with its sequence number, State, Measured and Applied."
)
def answers_each_setpoint(bench: Bench) -> None:
    here = bench.arm()
    sequences = [sequence for sequence, _ in bench.stream(0.3, lambda t: here)]
    bench.ping()
    bench.sample()
    heard = [m.sequence for m in bench.heard if isinstance(m, State)]
    for sequence in sequences:
        times = heard.count(sequence)
        allowed = (1, 2) if sequence == sequences[-1] else (1,)  # the last one is repeated unasked
        expect(times in allowed, f"set-point {sequence} was answered by {times} samples")


@case("Applied is the register after the set-point: a step of 1e-4 rad shows at once.")
def applies_what_it_is_told(bench: Bench) -> None:
    here = bench.arm()
    for count in (1, 2, 5):
        target = [angle + 1e-4 * count for angle in here]
        bench.listen(0.01)
        sample = bench.executed(target, "a step of some 1e-4 rad, 10 ms after the one before")
        off = max(abs(a - b) for a, b in zip(sample.applied_rad, target, strict=True))
        expect(off < 1.1e-4, f"applied differs from the set-point by {off:.5f} rad")
        expect(sample.state.mode is Mode.ARMED, f"the sample says {sample.state.mode.name.lower()}")


@case("Frames of one set-point may come in any order.")
def takes_any_order(bench: Bench) -> None:
    here = bench.arm()
    for _ in range(12):
        bench.sequence += 1
        messages = _parts(bench, bench.sequence, here)
        bench.draw.shuffle(messages)
        bench.listen(0.002)
        _send(bench, messages)
        expect(bench.answered(bench.sequence & 0xFFFF), f"not executed in the order {messages}")


@case("A group or a latch that is missing: not executed; what comes later is.")
def needs_every_frame(bench: Bench) -> None:
    here = bench.arm()
    for missing in range(groups(bench.joints) + 1):
        bench.sequence += 1
        messages = _parts(bench, bench.sequence, here)
        lost = messages.pop(missing)
        _send(bench, messages)
        bench.refused(bench.sequence & 0xFFFF, f"{type(lost).__name__} was missing")
        bench.executed(here, "a complete set-point after one that lost a frame", _SHORT_S)


@case("A torn mix of two set-points is not executed: the CRC-32 spans the groups.")
def refuses_torn_mixes(bench: Bench) -> None:
    here = bench.arm()
    there = [angle + 0.001 for angle in here]
    bench.sequence += 1
    ours, theirs = _parts(bench, bench.sequence, here), _parts(bench, bench.sequence, there)
    _send(bench, [theirs[0], *ours[1:]])
    bench.refused(bench.sequence & 0xFFFF, "its first group belongs to other angles than its CRC-32")
    bench.executed(here, "the one after a torn mix", _SHORT_S)


@case("A latch with a wrong CRC-32, joint count or sequence number is not executed.")
def refuses_wrong_latches(bench: Bench) -> None:
    here = bench.arm()
    for bit in (0, 7, 13, 31):
        bench.sequence += 1
        *parts, latch = _parts(bench, bench.sequence, here)
        assert isinstance(latch, Latch)
        _send(bench, [*parts, replace(latch, crc32=latch.crc32 ^ 1 << bit)])
        bench.refused(bench.sequence & 0xFFFF, f"bit {bit} of its CRC-32 was wrong")
        bench.executed(here, "the one after a wrong CRC-32", _SHORT_S)
    bench.sequence += 1
    *parts, latch = _parts(bench, bench.sequence, here)
    assert isinstance(latch, Latch)
    _send(bench, [*parts, replace(latch, joints=latch.joints % 16 + 1)])
    bench.refused(bench.sequence & 0xFFFF, "its latch names another number of joints")
    bench.sequence += 1
    *parts, latch = _parts(bench, bench.sequence, here)
    assert isinstance(latch, Latch)
    wrong = (latch.sequence + 4096) & 0xFFFF
    _send(bench, [*parts, replace(latch, sequence=wrong)])
    bench.refused(wrong, "the sequence number of its latch is not the one in its CRC-32")
    bench.executed(here, "the one after wrong latches", _SHORT_S)


@case("A corrupted angle that passed the frame's own check is not executed.")
def refuses_corrupted_angles(bench: Bench) -> None:
    here = bench.arm()
    for _ in range(8):
        bench.sequence += 1
        frames = [encode(message) for message in _parts(bench, bench.sequence, here)]
        joint = bench.draw.randrange(bench.joints)
        place, bit = 2 + 2 * (joint % 3) + bench.draw.randrange(2), bench.draw.randrange(8)
        data = bytearray(frames[joint // 3].data)
        data[place] ^= 1 << bit
        frames[joint // 3] = Frame(frames[joint // 3].id, bytes(data))
        bench.send_frames(frames)
        bench.refused(bench.sequence & 0xFFFF, f"an angle of joint {joint + 1} was corrupted")
        bench.executed(here, "the one after a corrupted one", _SHORT_S)


@case("A packet that was corrupted on the line is not executed; the stream goes on.", needs=("send_bytes",))
def survives_corrupted_packets(bench: Bench) -> None:
    assert bench.send_bytes is not None
    here = bench.arm()
    for _ in range(10):
        bench.sequence += 1
        packets = [bytearray(pack(encode(message))) for message in _parts(bench, bench.sequence, here)]
        packet = bench.draw.choice(packets)
        packet[bench.draw.randrange(len(packet) - 1)] ^= 1 << bench.draw.randrange(8)
        bench.send_bytes(b"\0" + b"".join(packets) + b"\0")
        bench.refused(bench.sequence & 0xFFFF, "one of its packets was corrupted on the line")
        bench.executed(here, "the one after a corrupted packet", _SHORT_S)


@case("A packet that goes on behind its end is another one: it is not executed.", needs=("send_bytes",))
def takes_no_packet_that_goes_on(bench: Bench) -> None:
    assert bench.send_bytes is not None
    here = bench.arm()
    for more in (1, 2, 40):
        bench.sequence += 1
        *groups, latch = (pack(encode(message)) for message in _parts(bench, bench.sequence, here))
        bench.send_bytes(b"\0" + b"".join(groups) + latch.rstrip(b"\0") + b"\1" * more + b"\0")
        bench.refused(bench.sequence & 0xFFFF, f"its last packet was {more} bytes too long")
        bench.executed(here, "the one after a packet that was too long", _SHORT_S)


@case("Duplicated and stale set-points are not executed; newer is 1 to 32767 ahead, modulo 65536.")
def knows_newer_from_older(bench: Bench) -> None:
    here = bench.arm()
    bench.executed(here, "the first one after arming is always newer", _SHORT_S)
    for back in (0, 1, 5, 32767, 32768):
        last = bench.sequence
        answers = sum(isinstance(m, State) and m.sequence == last & 0xFFFF for m in bench.heard)
        stale = (last - back) & 0xFFFF
        bench.heard = (
            [m for m in bench.heard if not (isinstance(m, State) and m.sequence == stale)]
            if back
            else bench.heard
        )
        _send(bench, _parts(bench, stale, here))
        if back:
            bench.refused(stale, f"it was {back} behind the last one")
        else:
            bench.ping()
            again = sum(isinstance(m, State) and m.sequence == last & 0xFFFF for m in bench.heard)
            expect(again == answers, "a set-point was executed twice")
    for ahead in (1, 2, 300, 32767):
        bench.executed(here, f"it was {ahead} ahead of the last one", _SHORT_S, step=ahead)


@case("Sequence numbers wrap at 16 bits, those of groups at 12.")
def wraps_sequence_numbers(bench: Bench) -> None:
    here = bench.arm()
    for start in (65536 - 5, 4096 - 5):
        bench.sequence = start
        if start < 65536 - 5:
            bench.fresh()
            here = bench.arm()
            bench.sequence = start
        for _ in range(10):
            bench.executed(
                here, f"sequence number {(bench.sequence + 1) & 0xFFFF}, across the wrap", _SHORT_S
            )
            bench.listen(0.002)


@case("The remnant of a lost set-point does not meet the one that comes 4096 later.")
def forgets_remnants(bench: Bench) -> None:
    here = bench.arm()
    there = [angle + 0.0005 for angle in here]
    bench.executed(here, "the first one", _SHORT_S)
    remnant = bench.sequence + 1
    _send(bench, _parts(bench, remnant, there)[1:])  # its first group is lost
    bench.sequence = remnant
    bench.executed(here, "the one after a lost frame", _SHORT_S)
    bench.sequence = remnant + 4095
    bench.executed(here, "it came 4096 after one that had lost a frame, and was complete", _SHORT_S)


@case("Many unfinished set-points: the oldest are given up, the next complete one is executed.")
def gives_up_the_oldest(bench: Bench) -> None:
    here = bench.arm()
    for _ in range(20):
        bench.sequence += 1
        _send(bench, _parts(bench, bench.sequence, here)[:1])
    bench.executed(here, "a complete one after twenty unfinished ones", _SHORT_S)


@case("Group frames with numbers that no joint has do no harm.")
def ignores_groups_without_joints(bench: Bench) -> None:
    here = bench.arm()
    bench.sequence += 1
    *parts, latch = _parts(bench, bench.sequence, here)
    frame = encode(Setpoint(bench.sequence & 0xFFF, 0, 1.0, 1.0, 1.0))
    strange = [
        Frame(frame.id, bytes([frame.data[0], frame.data[1] & 0x0F | group << 4]) + frame.data[2:])
        for group in range(groups(bench.joints), 16)
    ]
    begun = _parts(bench, bench.sequence + 1, here)
    _send(bench, [parts[0], begun[0]])  # beside it: what is written behind the last joint might get there
    bench.send_frames([*(encode(part) for part in parts[1:]), *strange, encode(latch)])
    sample = bench.answered(bench.sequence & 0xFFFF)
    expect(sample, "a complete set-point among groups without joints was not executed")
    assert sample is not None
    off = max(abs(a - b) for a, b in zip(sample.applied_rad, here, strict=True))
    expect(off < 2e-4, f"a group without joints moved the register by {off:.4f} rad")
    bench.sequence += 1
    bench.listen(0.001)
    _send(bench, begun[1:])
    expect(
        bench.answered(bench.sequence & 0xFFFF),
        "groups without joints took away what another set-point had begun",
    )


@case("Set-points are dropped and counted in every mode but armed.")
def drops_setpoints_unless_armed(bench: Bench) -> None:
    here = list(bench.sample().applied_rad)
    for mode in (Mode.DISARMED, Mode.HOLDING, Mode.STOPPED, Mode.FAULT):
        bench.fresh()
        bench.enter(mode)
        dropped = bench.counters().dropped if mode is Mode.DISARMED else None
        if mode is Mode.HOLDING:
            bench.must_go(Mode.HOLDING)
        sequence = bench.tick([angle + 0.01 for angle in here])
        bench.refused(sequence, f"the board was {mode.name.lower()}")
        if dropped is not None:
            grown = growth(bench.counters().dropped, dropped)
            expect(grown == 1, f"one set-point was dropped, Counters.dropped grew by {grown}")


@case("Frames of before arming do not count after it.")
def forgets_what_came_before_arming(bench: Bench) -> None:
    here = list(bench.sample().applied_rad)
    bench.sequence += 1
    messages = _parts(bench, bench.sequence, here)
    _send(bench, messages[:-1])
    bench.must_go(Mode.ARMED)
    _send(bench, messages[-1:])
    bench.refused(bench.sequence & 0xFFFF, "its groups had come before the board was armed")
    for between in (Mode.DISARMED, Mode.HOLDING):
        for begins_with_latch in (False, True):
            bench.sequence += 1
            messages = _parts(bench, bench.sequence, here)
            if begins_with_latch:
                messages.reverse()
            _send(bench, messages[:-1])
            bench.must_go(between)
            bench.must_go(Mode.ARMED)
            _send(bench, messages[-1:])
            bench.refused(
                bench.sequence & 0xFFFF,
                f"it began before the board was {between.name.lower()} and armed again",
            )


@case("Sample numbers wrap at 12 bits while set-points stream.", long=True)
def wraps_sample_numbers(bench: Bench) -> None:
    here = bench.arm()
    for _ in range(42):
        bench.samples.clear()
        bench.heard.clear()
        bench.stream(0.5, lambda t: here, 0.005)
        bench.ping()
        numbers = [sample.state.sample for sample in bench.samples]
        jumps = [(a, b) for a, b in itertools.pairwise(numbers) if (b - a) % 4096 != 1]
        expect(not jumps, f"sample numbers jump: {jumps[:3]}")
