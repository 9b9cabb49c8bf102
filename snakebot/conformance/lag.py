"""Power seen from outside: a joint that lags behind its set-point goes on to it if it has power, and not without.

Where the joints of a robot coast without power, that cannot be told, and the case says so.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from firmware_protocol.assembly import Sample
from snakebot.conformance.bench import Bench
from snakebot.conformance.violations import NotApplicableError, expect

_TICKS = 4  # of 10 ms; chosen: long enough for a set-point to come into force
_LEAST_COUNTS = 12  # of lag, to tell one from the other
_ARRIVED = 0.2  # of the lag: a joint that ends so near to its set-point was sent there
_STAYED = 0.35  # of the lag: a joint that ends so near to where it was has stopped
_RESTS = 4  # samples, a tenth of a second apart, in which a joint at rest stays where it is; chosen
_COASTS = 50  # samples that a robot without power may take to come to rest; chosen, 5 s
_SETTLES_S = 0.3  # what a servo takes to its set-point, several times over


@dataclass(frozen=True, slots=True)
class Thrown:
    """All joints on their way: what was read last, and how far each was behind its set-point (rad)."""

    sample: Sample
    behind_rad: tuple[float, ...]


def angles_of(bench: Bench, sample: Sample) -> list[float]:
    """Measured angles (rad).

    Raises:
        NotApplicableError: a joint has no reading.
    """
    angles = []
    for joint, counts in enumerate(sample.measured_counts, start=1):
        if counts is None:
            raise NotApplicableError(f"joint {joint} has no encoder reading")
        angles.append(counts * bench.rad_per_count)
    return angles


def read_now(bench: Bench) -> Sample:
    """A sample that begins from now on: the next one may be on its way already."""
    bench.sample()
    return bench.sample()


def at_rest(bench: Bench, within_counts: int = 1) -> Sample:
    """A sample of joints without power that have stopped: some may go on by themselves for a while.

    Raises:
        NotApplicableError: they do not stop.
    """
    seen = [read_now(bench)]
    for _ in range(_COASTS):
        columns = zip(*(sample.measured_counts for sample in seen[-_RESTS:]), strict=True)
        spread = max(max(c or 0 for c in column) - min(c or 0 for c in column) for column in columns)
        if len(seen) >= _RESTS and spread <= within_counts:
            return seen[-1]
        seen.append(bench.sample())
    raise NotApplicableError("the joints do not come to rest without power")


def throw(bench: Bench, side: float) -> Thrown:
    """Arm, and send all joints away to one side; return while they are still behind."""
    return throw_from(bench, bench.arm(), side)


def throw_from(bench: Bench, here: Sequence[float], side: float) -> Thrown:
    """The same of a board that is armed, from these angles (rad)."""
    goal = [angle + side * bench.nudge_rad for angle in here]
    sent = bench.stream(0.01 * _TICKS, lambda t: goal)
    sample = bench.answered(sent[-1][0])
    expect(sample, "a set-point of a stream at 100 Hz was not executed")
    assert sample is not None
    measured = angles_of(bench, sample)
    behind = tuple(applied - now for applied, now in zip(sample.applied_rad, measured, strict=True))
    for joint, lag in enumerate(behind, start=1):
        if abs(lag) < _LEAST_COUNTS * bench.rad_per_count or lag * side < 0:
            raise NotApplicableError(f"joint {joint} follows too closely to tell whether it has power")
    return Thrown(sample, behind)


def went_on(bench: Bench, thrown: Thrown) -> list[float]:
    """What share of its way each joint has gone since, once all have come to rest; 1 with power, 0 without."""
    bench.listen(_SETTLES_S)
    bench.samples.clear()
    now = angles_of(bench, bench.sample())
    then = angles_of(bench, thrown.sample)
    return [(a - b) / lag for a, b, lag in zip(now, then, thrown.behind_rad, strict=True)]


def expect_no_power(bench: Bench, taking: Callable[[], None], when: str) -> None:
    """``taking`` the power in mid-motion leaves no joint with it, whichever way it was sent.

    The board may be in any mode, and is disarmed first.
    """
    for side in (1.0, -1.0):
        bench.fresh()
        thrown = throw(bench, side)
        taking()
        expect_power(went_on(bench, thrown), [False] * bench.joints, when)


def expect_power(shares: Sequence[float], powered: Sequence[bool], when: str, *, moving: bool = True) -> None:
    """Joints that should have power went on to their set-points, the others did not.

    Args:
        moving: they were in motion when it was taken from them, so that one that coasts says nothing; joints that
            stood and have none stay.

    Raises:
        NotApplicableError: a joint without power went on by itself: one that stops at its set-point proves nothing.
    """
    for joint, (share, wanted) in enumerate(zip(shares, powered, strict=True), start=1):
        if not wanted and abs(share) > _STAYED and abs(share - 1.0) >= _ARRIVED:
            expect(moving, f"{when}: joint {joint} moved, so its servo has power")
            raise NotApplicableError(f"joint {joint} coasts when it loses its power")
    for joint, (share, wanted) in enumerate(zip(shares, powered, strict=True), start=1):
        expect(
            (abs(share - 1.0) < _ARRIVED) == wanted,
            f"{when}: joint {joint} went {100 * share:.0f} % of the way to its set-point: "
            + ("it has lost its power" if wanted else "its servo still has power"),
        )
