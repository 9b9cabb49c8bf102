"""Who the board says it is, what it says unasked, and whether its clock can be trusted."""

from __future__ import annotations

import itertools

from firmware_protocol.catalogue import (
    MAX_JOINTS,
    NOBODY,
    PROTOCOL_MAJOR,
    PROTOCOL_MINOR,
    BoardHeartbeat,
    Counters,
    Fault,
    HostHeartbeat,
    Mode,
    State,
    catalogue_hash,
)
from snakebot.conformance.bench import Bench, passed_us
from snakebot.conformance.case import case
from snakebot.conformance.violations import expect


@case(
    "InfoRequest is answered by InfoProtocol, InfoFirmware, InfoSerial; version and catalogue are this host's."
)
def identifies_itself(bench: Bench) -> None:
    protocol, firmware, _ = bench.identify()
    expect(
        protocol.protocol_major == PROTOCOL_MAJOR,
        f"host speaks protocol {PROTOCOL_MAJOR}, the board {protocol.protocol_major}",
    )
    expect(
        protocol.catalogue_hash == catalogue_hash(),
        f"host has catalogue {catalogue_hash():08x}, the board {protocol.catalogue_hash:08x}: "
        "generate the board's codec from the same snakebot.dbc",
    )
    expect(
        protocol.protocol_minor == PROTOCOL_MINOR,
        f"this host asks for what protocol {PROTOCOL_MAJOR}.{PROTOCOL_MINOR} says, the board speaks "
        f"{protocol.protocol_major}.{protocol.protocol_minor}",
    )
    expect(1 <= protocol.joints <= MAX_JOINTS, f"{protocol.joints} joints")
    expect(firmware.watchdog_ms == 100, f"the watchdog is 100 ms, the board reports {firmware.watchdog_ms}")
    expect(firmware.counts_per_rev >= 16, f"{firmware.counts_per_rev} encoder counts a turn")
    beat = bench.beat()
    expect(
        beat.boot_id == firmware.boot_id,
        f"InfoFirmware has boot id {firmware.boot_id}, the heartbeat {beat.boot_id}",
    )
    expect(
        beat.simulated == protocol.simulated,
        "InfoProtocol and BoardHeartbeat disagree on whether this is a simulation",
    )


@case("A disarmed board: no power, no holder, no fault in its heartbeat, whichever host is there.")
def disarmed_is_what_it_says(bench: Bench) -> None:
    bench.send(HostHeartbeat(bench.host, 1))
    bench.ping()
    beat = bench.beat()
    seen = (beat.mode, beat.powered, beat.holder, beat.fault)
    expect(seen == (Mode.DISARMED, 0, NOBODY, Fault.NONE), f"the heartbeat of a disarmed board is {beat}")


@case("Heartbeats and unasked samples 10 times a second, Counters once.")
def speaks_unasked(bench: Bench) -> None:
    bench.beat()
    bench.heard.clear()
    bench.samples.clear()
    bench.listen(2.0)
    beats = [m for m in bench.heard if isinstance(m, BoardHeartbeat)]
    counters = [m for m in bench.heard if isinstance(m, Counters)]
    expect(18 <= len(beats) <= 22, f"{len(beats)} heartbeats in 2 s")
    expect(
        18 <= len(bench.samples) <= 22, f"{len(bench.samples)} complete samples in 2 s while nothing streams"
    )
    expect(1 <= len(counters) <= 3, f"{len(counters)} Counters in 2 s")
    times = [m.board_time_us for m in bench.heard if isinstance(m, State)]
    gaps = [passed_us(b, a) for a, b in itertools.pairwise(times)]
    expect(
        all(80_000 <= gap <= 120_000 for gap in gaps),
        f"unasked samples are apart by {gaps} us of the board's clock",
    )


@case("Samples are numbered one by one, with 12 bits.")
def numbers_its_samples(bench: Bench) -> None:
    while len(bench.samples) < 4:
        bench.sample()
    numbers = [sample.state.sample for sample in bench.samples]
    steps = {(b - a) % 4096 for a, b in itertools.pairwise(numbers)}
    expect(steps == {1}, f"sample numbers {numbers}")


@case("Ping is answered at once by Pong, with its nonce and the board's clock.")
def answers_pings(bench: Bench) -> None:
    for _ in range(10):
        before_s = bench.clock.now_s()
        first = bench.ping()
        took_s = bench.clock.now_s() - before_s
        expect(took_s <= 2 * bench.tolerance_s, f"a Pong took {1e3 * took_s:.0f} ms")
        second = bench.ping()
        expect(
            passed_us(second.board_time_us, first.board_time_us) < 1_000_000,
            f"the board's clock went from {first.board_time_us} to {second.board_time_us} us",
        )


@case("The board's clock counts microseconds, modulo 2^32, and goes right to 1 %.")
def clock_goes_right(bench: Bench) -> None:
    bench.ping()
    start_s, start = bench.clock.now_s(), bench.ping().board_time_us
    bench.listen(1.0)
    end_s, end = bench.clock.now_s(), bench.ping().board_time_us
    board_s, host_s = passed_us(end, start) * 1e-6, end_s - start_s
    expect(
        abs(board_s - host_s) <= 0.01 * host_s + 2 * bench.tolerance_s,
        f"the board counted {board_s:.4f} s where the host counted {host_s:.4f} s",
    )
