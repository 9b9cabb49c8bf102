"""What feeds the watchdog, and that nothing else does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from firmware_protocol.assembly import setpoint_messages
from firmware_protocol.catalogue import (
    Applied,
    BoardHeartbeat,
    ClearRequest,
    Fault,
    FaultEvent,
    HostHeartbeat,
    InfoRequest,
    JointMode,
    JointModeRequest,
    Latch,
    LimitKind,
    LimitRequest,
    Message,
    Mode,
    ModeRequest,
    Ping,
    Pong,
    Result,
    State,
    TrimRequest,
    ZeroRequest,
    encode,
)
from firmware_protocol.frame import Frame
from snakebot.conformance.bench import Bench, growth, passed_us
from snakebot.conformance.case import case
from snakebot.conformance.violations import expect
from snakebot.conformance.watchdog import in_time

_STEP_S = 0.009  # no divisor of the watchdog
_INTERVAL_BYTE = 3  # of a Latch: behind its sequence number and its joints, as in the DBC


def _strange(bench: Bench) -> list[Frame]:
    """Frames that are counted as corrupt: unknown, too short, without a name."""
    latch = encode(setpoint_messages(bench.sequence & 0xFFFF, [0.0] * bench.joints, 0.01)[-1])
    heartbeat = encode(HostHeartbeat(bench.host, 0))
    unnamed = encode(ModeRequest(bench.token(), Mode.ARMED, bench.host))
    return [
        Frame(0x7FF, latch.data),
        Frame(latch.id, latch.data[:-1]),
        Frame(heartbeat.id, heartbeat.data[:-1]),
        Frame(unnamed.id, unnamed.data[:1] + b"\x07" + unnamed.data[2:]),
    ]


def _chatter(bench: Bench, here: Sequence[float], mode: Mode) -> dict[str, list[Frame]]:
    """Everything that a host may send and that must not feed a watchdog."""
    bench.sequence += 1
    *groups, latch = setpoint_messages(bench.sequence & 0xFFFF, here, 0.01)
    assert isinstance(latch, Latch)
    limit = bench.built_in(1, LimitKind.SPEED)
    kinds: dict[str, list[Message]] = {
        "bare latches": [latch],
        "groups without their latch": list(groups),
        "set-points with a wrong CRC-32": [*groups, replace(latch, crc32=latch.crc32 ^ 1)],
        "trims and zeros": [
            TrimRequest(bench.token(), 1, 0.0, bench.host),
            ZeroRequest(bench.token(), 1, 0, bench.host),
        ],
        "what boards say": [
            State(bench.sequence & 0xFFFF, 0, Mode.ARMED, 0),
            Applied(0, 0, 0.0, 0.0, 0.0),
            BoardHeartbeat(1, mode, 1, 0, Fault.NONE, bench.host),
            Pong(0, 0),
        ],
        "requests for the mode that it is in": [ModeRequest(bench.token(), mode, bench.host)],
        "requests of another host": [ModeRequest(bench.token(), Mode.DISARMED, bench.other)],
        "joint modes": [JointModeRequest(bench.token(), 1, JointMode.ACTIVE, 0.0, bench.host)],
        "limits": [LimitRequest(bench.token(), 1, LimitKind.SPEED, limit, bench.host)],
        "pings and questions": [Ping(bench.sequence), InfoRequest(bench.host)],
        "heartbeats of another host": [HostHeartbeat(bench.other, bench.sequence & 0xFFFF)],
        "requests to clear": [ClearRequest(bench.token(), 0, bench.host)],
        "heartbeats of nobody": [HostHeartbeat(0, bench.sequence & 0xFFFF)],
    }
    if mode is Mode.ARMED:
        kinds["heartbeats of the holder"] = [HostHeartbeat(bench.host, bench.sequence & 0xFFFF)]
    else:
        kinds["set-points"] = [*groups, latch]
    frames = {name: [encode(message) for message in messages] for name, messages in kinds.items()}
    return {**frames, "frames that are no messages": _strange(bench)}


@case(
    "Armed: bare latches, groups, wrong set-points, requests, heartbeats do not feed the watchdog, each by itself."
)
def only_setpoints_feed_armed(bench: Bench) -> None:
    bench.built_in(1, LimitKind.SPEED)
    here = list(bench.sample().applied_rad)
    for name in _chatter(bench, here, Mode.ARMED):
        bench.fresh()
        here = bench.arm()
        last = bench.executed(here, "the first one").state.board_time_us
        while not any(isinstance(m, FaultEvent) for m in bench.heard):
            bench.send_frames(_chatter(bench, here, Mode.ARMED)[name])
            bench.listen(_STEP_S)
            expect(
                passed_us(bench.ping().board_time_us, last) < 200_000,
                f"{name} kept an armed board from its fault",
            )
        event = next(m for m in bench.heard if isinstance(m, FaultEvent))
        in_time(passed_us(event.board_time_us, last), 100_000, f"in spite of {name} the fault")


@case("Holding: set-points, latches, requests and the heartbeats of others do not feed the watchdog.")
def only_the_holder_feeds_holding(bench: Bench) -> None:
    bench.built_in(1, LimitKind.SPEED)
    here = list(bench.sample().applied_rad)
    names = list(_chatter(bench, here, Mode.HOLDING))
    for half in (names[::2], names[1::2]):
        bench.fresh()
        here = bench.arm()
        before = bench.ping().board_time_us
        bench.must_go(Mode.HOLDING)
        after = bench.ping().board_time_us
        while not any(isinstance(m, FaultEvent) for m in bench.heard):
            for name in half:
                bench.send_frames(_chatter(bench, here, Mode.HOLDING)[name])
            bench.listen(0.07)
            expect(
                passed_us(bench.ping().board_time_us, after) < 1_200_000,
                f"one of these kept a holding board from its fault: {', '.join(half)}",
            )
        event = next(m for m in bench.heard if isinstance(m, FaultEvent))
        expect(
            passed_us(event.board_time_us, before) >= 999_800
            and passed_us(event.board_time_us, after) <= 1_005_000,
            f"holding began between {before} and {after} us, the fault is dated {event.board_time_us}, not 1 s later",
        )


@case("The holder is known by all 32 bits of its number: heartbeats of hosts that differ in one do not feed.")
def knows_whose_heartbeat_it_is(bench: Bench) -> None:
    before = bench.ping().board_time_us
    bench.must_go(Mode.ARMED)
    bench.must_go(Mode.HOLDING)
    after = bench.ping().board_time_us
    while not any(isinstance(m, FaultEvent) for m in bench.heard):
        bench.send(*(HostHeartbeat(bench.host ^ 1 << bit, bit) for bit in range(32)))
        bench.listen(0.07)
        now = bench.ping().board_time_us
        expect(
            passed_us(now, after) < 1_200_000, "the heartbeat of a host with almost the holder's number fed"
        )
    event = next(m for m in bench.heard if isinstance(m, FaultEvent))
    expect(
        passed_us(event.board_time_us, before) >= 999_800
        and passed_us(event.board_time_us, after) <= 1_005_000,
        f"holding began between {before} and {after} us, the fault is dated {event.board_time_us}, not 1 s later",
    )


@case("Each change between armed and holding starts a new watchdog, of the new mode's time.")
def every_mode_has_its_own_watchdog(bench: Bench) -> None:
    here = bench.arm()
    bench.stream(0.08, lambda t: here)
    bench.listen(0.07)
    bench.must_go(Mode.HOLDING)
    bench.listen(0.5)
    expect(bench.beat().mode is Mode.HOLDING, "a holding board fell into fault before 1 s was over")
    before = bench.ping().board_time_us
    bench.must_go(Mode.ARMED)
    after = bench.ping().board_time_us
    event = bench.wait(FaultEvent, 0.3, code=Fault.WATCHDOG)
    expect(
        passed_us(event.board_time_us, before) >= 99_800 and passed_us(event.board_time_us, after) <= 105_000,
        f"armed again between {before} and {after} us, the fault is dated {event.board_time_us} us, not 100 ms later",
    )


@case("A fault stays: set-points, heartbeats and requests to arm do not end it, before and after it relaxes.")
def faults_stay(bench: Bench) -> None:
    here = bench.arm()
    event = bench.wait(FaultEvent, code=Fault.WATCHDOG)
    bench.heard.clear()
    for number in range(27):
        bench.send(HostHeartbeat(bench.host, number))
        sequence = bench.tick([angle + 0.01 for angle in here])
        answer = bench.go(Mode.ARMED if number % 2 else Mode.HOLDING)
        expect(
            (answer.result, answer.mode) == (Result.FORBIDDEN, Mode.FAULT),
            f"in fault a request was answered {answer}",
        )
        bench.refused(sequence, "the board was in fault")
        bench.listen(0.1)
    beats = [m for m in bench.heard if isinstance(m, BoardHeartbeat)]
    expect(len(beats) >= 20, f"{len(beats)} heartbeats in 2.7 s")
    for beat in beats:
        expect(
            (beat.mode, beat.fault, beat.holder) == (Mode.FAULT, Fault.WATCHDOG, bench.host),
            f"the heartbeat of a board in fault is {beat}",
        )
    expect(
        beats[0].powered == 1 and beats[-1].powered == 0, "frozen joints have power, relaxed ones have none"
    )
    powered = [beat.powered for beat in beats]
    expect(powered == sorted(powered, reverse=True), "a relaxed board got power again")
    events = [m for m in bench.heard if isinstance(m, FaultEvent)]
    expect(len(events) == len(beats), f"{len(events)} FaultEvents with {len(beats)} heartbeats")
    expect(all(m == event for m in events), f"the fault was told as {event}, then as {events[-1]}")
    expect((event.joint, event.detail) == (0, 0), f"a watchdog's fault is no joint's: {event}")


@case("The holder's heartbeats keep a holding board for as long as they come; set-points keep an armed one.")
def feeds_for_long(bench: Bench) -> None:
    here = bench.arm()
    bench.stream(0.6, lambda t: here, 0.08)
    answer = bench.go(Mode.ARMED)  # no heartbeat, which may come as late as the watchdog
    expect(answer.result is Result.OK, f"set-points every 80 ms did not keep the board armed: {answer}")
    bench.must_go(Mode.HOLDING)
    for number in range(3):
        bench.listen(0.85)
        bench.send(HostHeartbeat(bench.host, number))
        bench.ping()
        expect(bench.beat().mode is Mode.HOLDING, "heartbeats every 0.95 s did not keep the board holding")


@case(
    "A message is what its identifier says: one whose bytes read like the holder's heartbeat does not feed."
)
def takes_no_message_for_a_heartbeat(bench: Bench) -> None:
    here = list(bench.sample().applied_rad)
    *_, latch = setpoint_messages(0x1234, here, 0.01)
    likeness = int.from_bytes(encode(latch).data[:4], "little")
    bench.must_go(Mode.ARMED, likeness)
    bench.must_go(Mode.HOLDING, likeness)
    after = bench.ping().board_time_us
    while not any(isinstance(m, FaultEvent) for m in bench.heard):
        bench.send(latch, Ping(likeness), ClearRequest(0, 0, likeness), InfoRequest(likeness))
        bench.listen(0.05)
        expect(
            passed_us(bench.ping().board_time_us, after) < 1_200_000,
            "a message that is no heartbeat kept a holding board from its fault",
        )


@case("A set-point of no length is too early: it is dropped, and feeds no watchdog.")
def drops_setpoints_without_length(bench: Bench) -> None:
    before = bench.counters().dropped
    here = bench.arm()
    last = bench.executed(here, "the first one").state.board_time_us
    sent = 0
    while not any(isinstance(m, FaultEvent) for m in bench.heard):
        bench.sequence = (bench.sequence + 1) & 0xFFFF
        *groups, latch = (encode(message) for message in setpoint_messages(bench.sequence, here, 0.0005))
        data = bytearray(latch.data)
        data[_INTERVAL_BYTE] = 0
        bench.send_frames([*groups, Frame(latch.id, bytes(data))])
        sent += 1
        bench.refused(bench.sequence, "its interval is 0")
        bench.listen(_STEP_S)
        now = bench.ping().board_time_us
        expect(passed_us(now, last) < 200_000, "set-points of no length kept an armed board from its fault")
    event = next(m for m in bench.heard if isinstance(m, FaultEvent))
    in_time(passed_us(event.board_time_us, last), 100_000, "in spite of set-points of no length the fault")
    bench.make_safe()
    grown = growth(bench.counters().dropped, before)
    expect(grown == sent, f"{sent} set-points of no length were sent, Counters.dropped grew by {grown}")
