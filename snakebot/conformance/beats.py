"""How often the board speaks unasked, and whether what it says in each mode is true."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from firmware_protocol.assembly import groups
from firmware_protocol.catalogue import (
    NO_READING,
    Applied,
    BoardHeartbeat,
    Counters,
    Fault,
    FaultEvent,
    HostHeartbeat,
    InfoProtocol,
    Measured,
    Message,
    Mode,
    State,
)
from snakebot.conformance.bench import Bench, passed_us
from snakebot.conformance.case import case
from snakebot.conformance.lag import angles_of, read_now
from snakebot.conformance.violations import expect

_LISTEN_S = 3.0  # enough for two messages that come once a second
_COUNTERS = {"received", "corrupt", "dropped", "clamped"}


def _arrivals(bench: Bench, seconds: float) -> list[tuple[float, Message]]:
    """Everything that comes, each with the host's time."""
    until_s = bench.clock.now_s() + seconds
    found: list[tuple[float, Message]] = []
    while bench.clock.now_s() < until_s:
        said = bench.listen(0.001)
        found += [(bench.clock.now_s(), message) for message in said]
    return found


@case("Exactly 10 heartbeats and 10 samples a second while nothing streams, and one Counters.")
def keeps_its_rates(bench: Bench) -> None:
    bench.wait(Counters, 1.6)
    arrivals = _arrivals(bench, _LISTEN_S)
    blur_s = 0.005 + 2 * bench.tolerance_s
    for kind, period_s in ((BoardHeartbeat, 0.1), (State, 0.1), (Counters, 1.0)):
        times = [t_s for t_s, message in arrivals if isinstance(message, kind)]
        expect(len(times) >= 2, f"{len(times)} {kind.__name__} in {_LISTEN_S:g} s")
        mean_s = (times[-1] - times[0]) / (len(times) - 1)
        allowed_s = max(0.02 * period_s, 2 * blur_s / (len(times) - 1))
        expect(
            abs(mean_s - period_s) <= allowed_s,
            f"{kind.__name__} comes every {1e3 * mean_s:.1f} ms in the mean, not every {1e3 * period_s:.0f}",
        )
        gaps = [b - a for a, b in itertools.pairwise(times)]
        expect(
            all(abs(gap - period_s) <= 2 * blur_s for gap in gaps),
            f"{kind.__name__} comes after {min(gaps):.4f} to {max(gaps):.4f} s",
        )
    clocks = [message.board_time_us for _, message in arrivals if isinstance(message, State)]
    mean_us = passed_us(clocks[-1], clocks[0]) / (len(clocks) - 1)
    expect(98_000 <= mean_us <= 102_000, f"unasked samples are {mean_us:.0f} us of the board's clock apart")


@case(
    "The frames of a sample come in order: State, each group of Measured, each group of Applied; all of one number."
)
def orders_its_samples(bench: Bench) -> None:
    bench.listen(0.25)
    parts = [m for m in bench.heard if isinstance(m, State | Measured | Applied)]
    first = next(index for index, message in enumerate(parts) if isinstance(message, State))
    number = groups(bench.joints)
    sample = parts[first : first + 1 + 2 * number]
    seen = [(type(m), 0 if isinstance(m, State) else m.group) for m in sample]
    wanted = [(State, 0), *((Measured, g) for g in range(number)), *((Applied, g) for g in range(number))]
    expect(seen == wanted, f"the frames of a sample are {seen}")
    expect(
        len({m.sample for m in sample}) == 1,
        f"the frames of one sample carry numbers {[m.sample for m in sample]}",
    )
    beyond = 3 * number - bench.joints
    if beyond:
        measured, applied = sample[number], sample[-1]
        assert isinstance(measured, Measured)
        assert isinstance(applied, Applied)
        counts = (measured.first_counts, measured.second_counts, measured.third_counts)[3 - beyond :]
        angles = (applied.first_rad, applied.second_rad, applied.third_rad)[3 - beyond :]
        expect(set(counts) == {NO_READING}, f"joints that the board does not have are read as {counts}")
        expect(set(angles) == {0.0}, f"joints that the board does not have are applied {angles} rad")


@case("While set-points stream the heartbeats come 10 times a second as ever, and Counters once.")
def speaks_while_it_streams(bench: Bench) -> None:
    here = bench.arm()
    bench.heard.clear()
    bench.stream(2.3, lambda t: here)
    beats = sum(isinstance(m, BoardHeartbeat) for m in bench.heard)
    counters = sum(isinstance(m, Counters) for m in bench.heard)
    expect(21 <= beats <= 25, f"{beats} heartbeats in 2.3 s of set-points")
    expect(2 <= counters <= 3, f"{counters} Counters in 2.3 s of set-points")


@case("Samples are numbered on, one by one, through every change of the mode.")
def numbers_on_through_all_modes(bench: Bench) -> None:
    here = bench.arm()
    bench.stream(0.03, lambda t: here)
    for mode in (Mode.ARMED, Mode.HOLDING, Mode.ARMED, Mode.DISARMED, Mode.ARMED):
        bench.must_go(mode)
    bench.stream(0.03, lambda t: here)
    bench.stop()
    bench.clear()
    bench.listen(0.12)
    bench.enter(Mode.FAULT)
    bench.clear()
    bench.listen(0.12)
    numbers = [m.sample for m in bench.heard if isinstance(m, State)]
    jumps = [(a, b) for a, b in itertools.pairwise(numbers) if (b - a) % 4096 != 1]
    expect(not jumps and len(numbers) > 6, f"sample numbers jump where the mode changes: {jumps}")


@case("In each mode the samples and the heartbeat name it, its holder, its power and its fault.")
def names_its_mode(bench: Bench) -> None:
    wanted = {
        Mode.DISARMED: (0, False, Fault.NONE),
        Mode.ARMED: (1, True, Fault.NONE),
        Mode.HOLDING: (1, True, Fault.NONE),
        Mode.STOPPED: (0, False, Fault.EMERGENCY_STOP),
        Mode.FAULT: (1, True, Fault.WATCHDOG),
    }
    for mode, (powered, held, fault) in wanted.items():
        bench.fresh()
        here = list(bench.sample().applied_rad)
        bench.enter(mode)
        bench.heard.clear()
        bench.samples.clear()
        if mode is Mode.ARMED:
            bench.stream(0.22, lambda t, here=here: here)  # type: ignore[misc]
            bench.must_go(mode)
        else:
            bench.listen(0.22)
        beats = [m for m in bench.heard if isinstance(m, BoardHeartbeat)]
        for beat in beats:
            seen = (beat.mode, beat.powered, beat.holder == bench.host, beat.fault)
            expect(
                seen == (mode, powered, held, fault),
                f"the heartbeat of a board that is {mode.name.lower()}: {beat}",
            )
        modes = {sample.state.mode for sample in bench.samples}
        expect(beats and modes == {mode}, f"samples of a board that is {mode.name.lower()} say {modes}")
        events = [m for m in bench.heard if isinstance(m, FaultEvent)]
        expect(
            len(events) == (len(beats) if fault else 0),
            f"{len(events)} FaultEvents while {mode.name.lower()}",
        )


@case(
    "Unasked samples begin 100 ms after the last set-point, with its number; a State has the time of its reading."
)
def goes_on_unasked(bench: Bench) -> None:
    # Wherever the heartbeat is between two set-points.
    for sequence, pause_s in ((1, 0.0), (4095, 0.037), (40_000, 0.071)):
        bench.fresh()
        here = bench.arm()
        bench.listen(pause_s)
        bench.sequence = sequence
        before = bench.ping().board_time_us
        bench.samples.clear()  # one unasked, from before, may have the number that comes now
        last = bench.executed(here, "the first one").state
        after = bench.ping().board_time_us
        expect(
            passed_us(last.board_time_us, before) <= passed_us(after, before),
            f"a set-point between {before} and {after} us was answered by a State of {last.board_time_us} us",
        )
        bench.must_go(Mode.HOLDING)
        bench.heard.clear()
        bench.listen(0.33)
        states = [m for m in bench.heard if isinstance(m, State)]
        expect(len(states) == 3, f"{len(states)} samples in the 0.33 s after the last set-point")
        for number, state in enumerate(states, start=1):
            passed = passed_us(state.board_time_us, last.board_time_us)
            expect(
                abs(passed - 100_000 * number) <= 5_000,
                f"unasked sample {number} came {passed} us after the last",
            )
            expect(state.sequence == last.sequence, f"an unasked sample says set-point {state.sequence}")


@case("The board's resolution is the one that it reports: without power, register and counts are one angle.")
def register_is_the_reading(bench: Bench) -> None:
    sample = read_now(bench)
    _agree(bench, sample.applied_rad, angles_of(bench, sample))
    here = bench.arm()
    side = [-1.0 if angle > 0 else 1.0 for angle in here]
    goal = [
        angle + s * bench.nudge_rad * (1 + j % 3) / 3
        for j, (angle, s) in enumerate(zip(here, side, strict=True))
    ]
    bench.stand_at(goal, 0.3, "the stream")
    bench.must_go(Mode.DISARMED)
    sample = read_now(bench)
    _agree(bench, sample.applied_rad, angles_of(bench, sample))


def _agree(bench: Bench, applied_rad: Sequence[float], measured_rad: Sequence[float]) -> None:
    for joint, (applied, measured) in enumerate(zip(applied_rad, measured_rad, strict=True), start=1):
        expect(
            abs(applied - measured) < 1.5e-4,
            f"joint {joint} without power: applied {applied:.4f} rad, measured {measured:.4f} rad",
        )


@case("What the board says of itself is what is written on it.", needs=("plate",))
def says_what_it_is(bench: Bench) -> None:
    plate = bench.lab.plate
    assert plate is not None
    protocol, firmware, serial = bench.identify()
    said = (protocol.joints, firmware.counts_per_rev, serial.serial_number, bool(protocol.simulated))
    written = (plate.joints, plate.counts_per_rev, plate.serial_number, plate.simulated)
    expect(said == written, f"joints, counts a turn, serial number and simulated are {said}, not {written}")
    version = (firmware.firmware_major, firmware.firmware_minor, firmware.firmware_patch)
    expect(version == plate.firmware, f"its firmware is {version}, not {plate.firmware}")
    expect(bool(bench.beat().simulated) == plate.simulated, "the heartbeat is wrong about the simulation")


@case(
    "Who asks need not be known: hosts 0, 1 and 2^32 - 1 are told who the board is, also while another holds it."
)
def answers_anyone(bench: Bench) -> None:
    bench.must_go(Mode.ARMED)
    bench.must_go(Mode.HOLDING)
    own = bench.host
    bench.send(HostHeartbeat(own, 0))
    protocol = bench.identify()[0]
    try:
        for host in (0, 1, 0xFFFFFFFF, bench.other):
            bench.host = host
            expect(bench.identify()[0] == protocol, f"host {host} was told something else")
            bench.heard.clear()
            bench.ping()
            expect(
                not any(isinstance(m, InfoProtocol) for m in bench.heard),
                "a Ping was answered by InfoProtocol",
            )
    finally:
        bench.host = own


@case("In every mode, whoever holds the board, everyone is told who it is and gets a Pong.")
def answers_in_every_mode(bench: Bench) -> None:
    own, protocol = bench.host, bench.identify()[0]
    for mode in Mode:
        bench.fresh()
        bench.enter(mode)
        try:
            for host in (own, bench.other):
                bench.host = host
                expect(bench.identify()[0] == protocol, f"while {mode.name.lower()} something else was told")
                bench.ping()
        finally:
            bench.host = own


@case("Everything that the board sends is whole: no packet of its own is corrupt.")
def sends_whole_packets(bench: Bench) -> None:
    corrupt = bench.link.statistics.corrupt
    bench.identify()
    here = bench.arm()
    for sequence in (0, 255, 256, 0x7EFF, 0xFDFE, 0xFFFF):
        bench.sequence = sequence
        bench.executed(here, f"number {(sequence + 1) & 0xFFFF}", 0.001, step=1)
    bench.must_go(Mode.HOLDING)
    for nonce in (0, 1, 0x01000000, 0x00FF0000, 0xFFFFFFFF):
        bench.draw.seed(nonce)
        bench.ping()
    bench.listen(0.5)
    now = bench.link.statistics.corrupt
    expect(now == corrupt, f"{now - corrupt} packets of the board were corrupt")
