"""What ``snakebot doctor`` asks of a board: who it is, how fast it answers, how its clock runs, how the wire is."""

from __future__ import annotations

from dataclasses import dataclass, replace

from firmware_protocol.catalogue import (
    PROTOCOL_MAJOR,
    PROTOCOL_MINOR,
    Counters,
    Fault,
    Mode,
    Ping,
    Pong,
    catalogue_hash,
    decode,
    encode,
)
from firmware_protocol.frame import ProtocolError
from snakebot import __version__
from snakebot.board.boardclock import BoardClock
from snakebot.board.client import Board
from snakebot.clock import Clock
from snakebot.doctor.finding import Finding, Status, percentile
from snakebot.links.base import Link

PINGS = 300  # chosen: the 99th percentile is then the third worst
_PING_INTERVAL_S = 0.005  # chosen: 300 pings take 1.5 s
_PING_TIMEOUT_S = 0.2  # chosen: twice the board's watchdog of 0.1 s
_LISTEN_S = 1.3  # counters come once a second
_GOOD_TRIP_S = 0.003  # chosen: leaves most of a tick at 100 Hz
_TICK_S = 0.01  # of the default rate, 100 Hz
_USUAL_DRIFT_PPM = 200.0  # chosen: several times what a quartz is off by


@dataclass(frozen=True, slots=True)
class RoundTrips:
    """Pings that were answered, in order: how long each took, its middle on the host's clock, the board's clock, s."""

    trips_s: list[float]
    middle_s: list[float]
    board_s: list[float]
    lost: int


def check_board(link: Link, clock: Clock) -> list[Finding]:
    """Everything that a board can be asked without moving it.

    Raises:
        NoBoardError: nobody answers, or the two ends do not speak the same catalogue.
        LostBoardError: the link went away.
    """
    board = Board(link, clock)
    info = board.connect()
    kind = "simulated board" if info.simulated else "board"
    what = f"{kind} {info.serial_number}, {info.joints} joints, {info.counts_per_rev} counts a turn"
    ours = f"protocol {PROTOCOL_MAJOR}.{PROTOCOL_MINOR}, catalogue {catalogue_hash():08x}, snakebot {__version__}"
    theirs = f"protocol {info.protocol}, catalogue {info.catalogue_hash:08x}, firmware {info.firmware}"
    findings = [
        Finding("board", Status.OK, what),
        Finding("agreement", Status.OK, f"host: {ours}; board: {theirs}"),
    ]
    measured = measure_round_trips(link, clock)
    findings.append(_trips(measured))
    counters: list[Counters] = []
    end_s = clock.now_s() + _LISTEN_S
    while clock.now_s() < end_s:
        counters += [item for item in board.poll(0.05) if isinstance(item, Counters)]
    findings += [_mode(board), *_others(board), _board_clock(measured), _wire(link, counters)]
    return findings


def measure_round_trips(link: Link, clock: Clock, count: int = PINGS) -> RoundTrips:
    """Ping the board every 5 ms. Frames that are no answer are dropped."""
    measured = RoundTrips([], [], [], 0)
    board_clock = BoardClock()
    lost = 0
    for nonce in range(count):
        start_s = clock.now_s()
        link.send([encode(Ping(nonce))])
        pong = _answer(link, nonce, start_s + _PING_TIMEOUT_S, clock)
        if pong is None:
            lost += 1
        else:
            end_s = clock.now_s()
            measured.trips_s.append(end_s - start_s)
            measured.middle_s.append((start_s + end_s) / 2)
            measured.board_s.append(1e-6 * board_clock.unwrap(pong.board_time_us))
        clock.sleep_until(start_s + _PING_INTERVAL_S)
    return replace(measured, lost=lost)


def _answer(link: Link, nonce: int, deadline_s: float, clock: Clock) -> Pong | None:
    while True:
        left_s = deadline_s - clock.now_s()
        for frame in link.receive(max(left_s, 0.0)):
            try:
                message = decode(frame)
            except ProtocolError:
                continue
            if isinstance(message, Pong) and message.nonce == nonce:
                return message
        if left_s <= 0:
            return None


def drift(measured: RoundTrips) -> tuple[float, float] | None:
    """By how much the board's clock runs fast, ppm, and how uncertain that is; None with too few round trips.

    From the shortest round trip of the first and of the last third: a stamp belongs to the middle of its trip, give or
    take half of it.
    """
    third = len(measured.trips_s) // 3
    if third == 0:
        return None
    early = min(range(third), key=measured.trips_s.__getitem__)
    late = min(range(len(measured.trips_s) - third, len(measured.trips_s)), key=measured.trips_s.__getitem__)
    span_s = measured.middle_s[late] - measured.middle_s[early]
    board_s = measured.board_s[late] - measured.board_s[early]
    uncertainty_s = (measured.trips_s[early] + measured.trips_s[late]) / 2
    return 1e6 * (board_s / span_s - 1), 1e6 * uncertainty_s / span_s


def _trips(measured: RoundTrips) -> Finding:
    if not measured.trips_s:
        return Finding(
            "round trip", Status.FAIL, f"none of {measured.lost} pings was answered", "check the wiring"
        )
    trips_s = sorted(measured.trips_s)
    median_s, p99_s = percentile(trips_s, 0.5), percentile(trips_s, 0.99)
    found = (
        f"{1e3 * median_s:.2f} ms (median), {1e3 * p99_s:.2f} ms (p99), {1e3 * trips_s[-1]:.2f} ms (worst)"
    )
    if measured.lost:
        found += f"; {measured.lost} of {measured.lost + len(measured.trips_s)} lost"
        return Finding(
            "round trip", Status.WARN, found, "frames are lost: check wiring, baud rate and termination"
        )
    if p99_s <= _GOOD_TRIP_S:
        return Finding("round trip", Status.OK, found)
    advice = "look at the latency timer, USB hubs, and other programs on this computer"
    if p99_s > _TICK_S:
        advice += f"; at 100 Hz answers come late: run with --rate {max(1, int(0.8 / p99_s))} or less"
    return Finding("round trip", Status.WARN, found, advice)


def _mode(board: Board) -> Finding:
    mode = board.mode
    assert mode is not None
    name = mode.name.lower()
    if mode in (Mode.FAULT, Mode.STOPPED):
        reason = Fault(board.fault).name.lower().replace("_", " ")
        return Finding(
            "mode", Status.WARN, f"{name}: {reason}", "a run clears it at its start; see why it came first"
        )
    if board.holder not in (0, board.host):
        advice = "wait until it is done; `snakebot stop` stops it"
        return Finding("mode", Status.WARN, f"{name}, held by host {board.holder:08x}", advice)
    return Finding("mode", Status.OK, name)


def _others(board: Board) -> list[Finding]:
    hosts = ", ".join(f"{host:08x}" for host in sorted(board.neighbours.hosts))
    advice = "two hosts on one line disturb each other: end the other one before a run"
    return [Finding("other hosts", Status.WARN, hosts, advice)] if hosts else []


def _board_clock(measured: RoundTrips) -> Finding:
    estimate = drift(measured)
    if estimate is None:
        return Finding("board clock", Status.INFO, "too few round trips to compare it by")
    drift_ppm, uncertainty_ppm = estimate
    found = f"{drift_ppm:+.0f} +- {uncertainty_ppm:.0f} ppm against this computer's"
    if abs(drift_ppm) > _USUAL_DRIFT_PPM + uncertainty_ppm:
        advice = "more than a crystal does: does the firmware count the right clock?"
        return Finding("board clock", Status.WARN, found, advice)
    return Finding("board clock", Status.OK, found)


def _wire(link: Link, counters: list[Counters]) -> Finding:
    ours = link.statistics.corrupt
    found = f"{ours} of {ours + link.statistics.received} packets corrupt here"
    theirs = 0
    if counters:
        theirs = counters[-1].corrupt
        found += f", {theirs} at the board since its reset"
    if ours or theirs:
        advice = "noise: shorten or shield the cable, check the ground; many: is the baud rate right?"
        return Finding("wire", Status.WARN, found, advice)
    return Finding("wire", Status.OK, found)
