"""Set-points that come in pieces, twice, too late, or beside each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from firmware_protocol.assembly import groups, setpoint_messages
from firmware_protocol.catalogue import EmergencyStop, Latch, Message, Mode, State, encode
from firmware_protocol.frame import Frame
from snakebot.conformance.bench import Bench, growth
from snakebot.conformance.case import case
from snakebot.conformance.violations import expect

_SHORT_S = 0.0005
_KEPT = 4


def _next(bench: Bench, angles: Sequence[float], ahead: int = 1) -> list[Message]:
    bench.sequence = (bench.sequence + ahead) & 0xFFFF
    return setpoint_messages(bench.sequence, angles, _SHORT_S)


def _split(
    bench: Bench, angles: Sequence[float], latch_first: bool
) -> tuple[int, list[Message], list[Message]]:
    """A set-point's number, what begins it, and what completes it."""
    messages = _next(bench, angles)
    if latch_first:
        messages = messages[::-1]
    return bench.sequence, messages[:1], messages[1:]


def _executed(bench: Bench, sequence: int, why: str) -> None:
    expect(bench.answered(sequence), f"set-point {sequence} was not executed: {why}")


@case("Four unfinished set-points are kept, each can be completed; with a fifth the oldest is given up.")
def keeps_four_unfinished(bench: Bench) -> None:
    for latch_first in (False, True):
        bench.fresh()
        here = bench.arm()
        bench.executed(here, "the first one", _SHORT_S)
        begun = [_split(bench, here, latch_first) for _ in range(_KEPT)]
        for _, beginning, _ in begun:
            bench.send(*beginning)
        for sequence, _, rest in begun:
            bench.listen(0.001)
            bench.send(*rest)
            _executed(bench, sequence, "four unfinished ones are kept")
        begun = [_split(bench, here, latch_first) for _ in range(_KEPT + 1)]
        for _, beginning, _ in begun:
            bench.send(*beginning)
        oldest, _, rest = begun[0]
        bench.listen(0.001)
        bench.send(*rest)
        bench.refused(oldest, "it was the oldest of five unfinished ones")
        bench.executed(here, "the one after six unfinished ones", _SHORT_S)


@case("However many set-points were begun, the last four of them are kept: each can be completed.")
def keeps_the_last_four(bench: Bench) -> None:
    for given_up in range(1, 2 * _KEPT + 1):  # each place becomes free in its turn
        bench.fresh()
        here = bench.arm()
        bench.executed(here, "the first one", _SHORT_S)
        begun = [_split(bench, here, False) for _ in range(given_up + _KEPT)]
        for _, beginning, _ in begun:
            bench.send(*beginning)
        for sequence, _, rest in begun[given_up:]:
            bench.listen(0.001)
            bench.send(*rest)
            _executed(bench, sequence, f"it was one of the last four, {given_up} were begun before them")


@case("The oldest is the one that began first, whatever its number.")
def gives_up_the_first_begun(bench: Bench) -> None:
    here = bench.arm()
    bench.executed(here, "the first one", _SHORT_S)
    begun = [_split(bench, here, False) for _ in range(_KEPT + 1)]
    order = [begun[3], begun[1], begun[0], begun[2], begun[4]]
    for _, beginning, _ in order:
        bench.send(*beginning)
    first, _, rest = order[0]
    second, _, second_rest = order[1]
    bench.send(*rest)  # begins it anew, in place of the second
    bench.refused(first, "it was begun first of five unfinished ones")
    bench.send(*second_rest)
    bench.refused(second, "it was given up for a sixth")
    third, _, third_rest = order[2]
    bench.listen(0.001)
    bench.send(*third_rest)
    bench.refused(third, "it was given up for a seventh")
    bench.executed(here, "the one after many unfinished ones", _SHORT_S)


@case("What is older than a complete set-point is given up; what is newer is kept.")
def gives_up_what_is_older(bench: Bench) -> None:
    here = bench.arm()
    bench.executed(here, "the first one", _SHORT_S)
    older, middle, newer = (_split(bench, here, True) for _ in range(3))
    for _, beginning, _ in (older, middle, newer):
        bench.send(*beginning)
    bench.listen(0.001)
    bench.send(*middle[2])
    _executed(bench, middle[0], "it was complete")
    bench.listen(0.001)
    bench.send(*newer[2])
    _executed(bench, newer[0], "it was newer than a complete one, and is complete now")
    bench.send(*older[2])
    bench.refused(older[0], "it was older than one that had been executed")


@case(
    "What is up to 2047 behind a complete set-point is older: it does not meet the one that comes 4096 later."
)
def forgets_what_is_far_behind(bench: Bench) -> None:
    for behind in (1, 100, 1500, 2000, 2047):
        bench.fresh()
        here = bench.arm()
        there = [angle + 0.0005 for angle in here]
        bench.executed(here, "the first one", _SHORT_S)
        bench.send(*_next(bench, there)[1:])  # its first group is lost
        remnant = bench.sequence
        bench.sequence += behind - 1
        bench.executed(here, f"{behind} after one that lost a frame", _SHORT_S)
        bench.sequence = remnant + 4095
        bench.executed(here, "it came 4096 after one that had lost a frame, and was complete", _SHORT_S)


@case("Four are kept wherever a place is free: completing one in between takes none of the newer ones away.")
def keeps_newer_ones_beside_a_free_place(bench: Bench) -> None:
    for before in range(1, _KEPT):
        bench.fresh()
        here = bench.arm()
        bench.executed(here, "the first one", _SHORT_S)
        oldest = _split(bench, here, True)
        newer = [_split(bench, here, True) for _ in range(_KEPT)]
        for _, beginning, _ in newer[:before]:
            bench.send(*beginning)
        bench.send(*oldest[1])
        bench.listen(0.001)
        bench.send(*oldest[2])
        _executed(bench, oldest[0], "it was complete")
        for _, beginning, _ in newer[before:]:
            bench.send(*beginning)
        for sequence, _, rest in newer:
            bench.listen(0.001)
            bench.send(*rest)
            _executed(
                bench,
                sequence,
                f"it was one of four unfinished ones, {before} of them begun before another was completed",
            )


@case(
    "Groups without their latch are counted as nothing in the modes that drop set-points, however many come."
)
def counts_no_groups(bench: Bench) -> None:
    for mode in (Mode.DISARMED, Mode.HOLDING, Mode.STOPPED, Mode.FAULT):
        bench.fresh()
        here = list(bench.sample().applied_rad)
        before = bench.counters()
        bench.enter(mode)
        for _ in range(3 * _KEPT):
            bench.send(*_next(bench, here)[:-1])
        bench.ping()
        bench.make_safe()
        grown = growth(bench.counters().dropped, before.dropped)
        expect(grown == 0, f"groups came while {mode.name.lower()}, Counters.dropped grew by {grown}")


@case("A group that is missing is missing: neither another one, nor angles of 0, stand in for it.")
def needs_every_group(bench: Bench) -> None:
    number = groups(bench.joints)
    for missing in range(number):
        for strange in {(missing + 1) % number, *range(number, 16)} - {missing}:
            bench.fresh()
            here = bench.arm()
            bench.executed(here, "the first one", _SHORT_S)
            angles = [0.0 if joint // 3 == missing else angle for joint, angle in enumerate(here)]
            frames = [encode(message) for message in _next(bench, angles)]
            lost = frames.pop(missing)
            data = bytearray(lost.data)
            data[1] = data[1] & 0x0F | strange << 4
            bench.listen(0.001)
            bench.send_frames([Frame(lost.id, bytes(data)), *frames])
            bench.refused(bench.sequence, f"group {missing} was missing, group {strange} came in its place")


@case("Every set-point that is not executed is counted as dropped, once: why ever.")
def counts_every_dropped_one(bench: Bench) -> None:
    before = bench.counters()
    here = bench.arm()
    wanted = 0
    bench.executed(here, "the first one", _SHORT_S)
    for _ in range(2):  # unfinished, older than a complete one
        bench.send(*_next(bench, here)[:-1])
        bench.listen(0.001)
        bench.executed(here, "the one after an unfinished one", _SHORT_S)
        wanted += 1
    for _ in range(3):  # stale: the last one again
        bench.send(*setpoint_messages(bench.sequence, here, _SHORT_S))
        wanted += 1
    *parts, latch = _next(bench, here)
    assert isinstance(latch, Latch)
    bench.send(*parts, replace(latch, crc32=latch.crc32 ^ 0x100))
    wanted += 1
    *parts, latch = _next(bench, here)
    assert isinstance(latch, Latch)
    bench.send(*parts, replace(latch, joints=latch.joints % 16 + 1))
    wanted += 1
    for _ in range(_KEPT + 3):  # only four of them are kept
        bench.send(*_next(bench, here)[:1])
    wanted += _KEPT + 3
    bench.listen(0.001)
    bench.executed(here, "the one after many unfinished ones", _SHORT_S)
    bench.stream(0.02, lambda t: here)
    bench.must_go(Mode.DISARMED)
    grown = growth(bench.counters().dropped, before.dropped)
    expect(grown == wanted, f"{wanted} set-points were not executed, Counters.dropped grew by {grown}")


@case("In every mode that drops set-points each latch is counted as dropped, once; groups are not.")
def counts_latches_in_every_mode(bench: Bench) -> None:
    for mode in (Mode.DISARMED, Mode.HOLDING, Mode.STOPPED, Mode.FAULT):
        bench.fresh()
        here = list(bench.sample().applied_rad)
        before = bench.counters()
        bench.enter(mode)
        messages = _next(bench, here)
        bench.send(*messages)
        bench.send(*messages[:-1])
        bench.send(messages[-1])
        bench.ping()
        bench.make_safe()
        grown = growth(bench.counters().dropped, before.dropped)
        expect(
            grown == 2, f"two latches were sent while {mode.name.lower()}, Counters.dropped grew by {grown}"
        )


@case("Frames that are sent several times at once: the set-point is executed once, and so is the next one.")
def takes_repeated_frames(bench: Bench) -> None:
    here = bench.arm()
    for times, each in ((2, False), (3, False), (2, True), (3, True)):
        for _ in range(4):
            messages = _next(bench, here)
            again = [m for m in messages for _ in range(times)] if each else messages * times
            bench.heard.clear()
            bench.listen(0.002)
            bench.send(*again)
            _executed(bench, bench.sequence, f"its frames came {times} times")
            bench.ping()
            answers = sum(isinstance(m, State) and m.sequence == bench.sequence for m in bench.heard)
            expect(answers == 1, f"a set-point whose frames came {times} times was executed {answers} times")


@case("Every bit that the CRC-32 covers, and every bit of it: one that is wrong, and nothing is executed.")
def checks_every_bit(bench: Bench) -> None:
    here = bench.arm()
    frames = len(_next(bench, here))
    bench.executed(here, "the first one", _SHORT_S)
    for frame in range(frames):
        group = frame < frames - 1
        joints = min(3, bench.joints - 3 * frame)
        bits = range(16, 16 + 16 * joints) if group else [*range(24), *range(32, 64)]
        for bit in bits:
            encoded = [encode(message) for message in _next(bench, here)]
            sequence = bench.sequence
            data = bytearray(encoded[frame].data)
            data[bit // 8] ^= 1 << bit % 8
            encoded[frame] = Frame(encoded[frame].id, bytes(data))
            bench.heard.clear()
            bench.send_frames(encoded)
            where = f"bit {bit} of " + (f"group {frame}" if group else "the latch")
            bench.refused(sequence, f"{where} was wrong")
            changed = int.from_bytes(data[:2], "little")
            if not group and changed != sequence:
                bench.refused(changed, f"{where} was wrong")
            if (
                not group and bit < 16
            ):  # the wrong latch may be that of a set-point to come: arming forgets it
                bench.make_safe()
                bench.samples.clear()
                here = bench.arm()
            if bit % 8 == 7:
                bench.listen(0.001)
                bench.executed(here, "the one after wrong ones", _SHORT_S)


@case("A latch that names another number of joints is not executed, whatever the number.")
def checks_the_joint_count(bench: Bench) -> None:
    here = bench.arm()
    for count in sorted({*range(18), 32, 64, 128, 255} - {bench.joints}):
        *parts, latch = _next(bench, here)
        data = bytearray(encode(latch).data)
        data[2] = count
        bench.send(*parts)
        bench.send_frames([Frame(encode(latch).id, bytes(data))])
        bench.refused(bench.sequence, f"its latch names {count} joints")
        if count % 4 == 0:
            bench.listen(0.001)
            bench.executed(here, "the one after a wrong latch", _SHORT_S)


@case("A request for armed while armed changes nothing: not the sequence, not what is unfinished.")
def arming_twice_changes_nothing(bench: Bench) -> None:
    here = bench.arm()
    bench.sequence = 1000
    bench.executed(here, "the first one", _SHORT_S)
    bench.must_go(Mode.ARMED)
    stale = setpoint_messages(500, here, _SHORT_S)
    bench.send(*stale)
    bench.refused(500, "it was 501 behind the last one; the board was armed already when it was armed again")
    sequence, beginning, rest = _split(bench, here, False)
    bench.send(*beginning)
    bench.must_go(Mode.ARMED)
    bench.send(*rest)
    _executed(bench, sequence, "its first frame came before a second request for armed")


@case("Emergency stop and set-points in one packet: nothing is executed after the stop.")
def stops_in_mid_stream(bench: Bench) -> None:
    here = bench.arm()
    bench.executed(here, "the first one", _SHORT_S)
    messages = _next(bench, here)
    bench.send(*messages[:1])
    bench.send(EmergencyStop(), *messages[1:], *_next(bench, here))
    bench.refused(bench.sequence, "it came after an emergency stop")
    expect(groups(bench.joints) >= 1 and bench.beat().mode is Mode.STOPPED, "the board did not stop")
