"""Trims and zeros: each joint has its own, also after a reset."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from firmware_protocol.assembly import ANGLE_STEP_RAD
from firmware_protocol.catalogue import (
    MAX_TRIM_RAD,
    JointMode,
    LimitKind,
    Mode,
    Result,
    TrimRequest,
    ZeroRequest,
)
from snakebot.conformance.bench import Bench
from snakebot.conformance.case import case
from snakebot.conformance.lag import angles_of, at_rest, read_now
from snakebot.conformance.violations import NotApplicableError, expect

_TRIM_RAD = 0.1


def _trim_all(bench: Bench, trims: Sequence[float]) -> None:
    for joint, trim in enumerate(trims, start=1):
        answer = bench.ask(TrimRequest(bench.token(), joint, round(trim, 4), bench.host))
        expect(answer.result is Result.OK, f"a trim of {trim:.3f} rad, joint {joint}: {answer}")


def _trims_seen(bench: Bench) -> list[float]:
    here = bench.arm()
    sample = bench.stand_at(here, 0.4, "the stream")
    off = max(abs(a - b) for a, b in zip(sample.applied_rad, here, strict=True))
    expect(off < 3e-4, f"a trim moved the register by {off:.4f} rad")
    seen = [a - b for a, b in zip(angles_of(bench, sample), sample.applied_rad, strict=True)]
    bench.make_safe()
    return seen


@contextmanager
def _trimmed(bench: Bench, trims: Sequence[float]) -> Iterator[None]:
    """Every joint has its trim; afterwards none has."""
    if not bench.simulated:
        raise NotApplicableError("a trim cannot be read back: on a real robot it is left alone")
    _trim_all(bench, trims)
    try:
        yield
    finally:
        bench.fresh()
        _trim_all(bench, [0.0] * bench.joints)
        bench.stand_at(bench.arm(), 0.4, "the stream after the trims were taken away")
        bench.make_safe()


def _alternating(bench: Bench, side: float, least: float, more: float) -> list[float]:
    return [side * (least + more * (j % 5)) * (-1 if j % 2 else 1) for j in range(bench.joints)]


@case("Each joint has a trim of its own, to either side; a reset leaves it as it is.")
def each_joint_has_its_trim(bench: Bench) -> None:
    plain = _trims_seen(bench)
    for side in (1.0, -1.0):
        trims = _alternating(bench, side, 0.03, 0.01)
        with _trimmed(bench, trims):
            if side < 0 and bench.reset is not None:
                bench.reset()
                bench.identify()
            for joint, (seen, was, trim) in enumerate(
                zip(_trims_seen(bench), plain, trims, strict=True), start=1
            ):
                expect(
                    abs(seen - was - trim) < 0.005,
                    f"a trim of {trim:.3f} rad moved joint {joint} by {seen - was:.3f} rad",
                )
            off = read_now(bench)
            for joint, (a, b) in enumerate(zip(off.applied_rad, angles_of(bench, off), strict=True), start=1):
                expect(
                    abs(a - b) < 1.5e-4,
                    f"joint {joint} without power: applied {a:.4f} rad, measured {b:.4f} rad",
                )


@case(
    "Each rigid joint goes to its angle with the trim of its own, and each active one beside it to its set-point."
)
def rigid_joints_take_their_own_trims(bench: Bench) -> None:
    for side in (1.0, -1.0):
        with _trimmed(bench, _alternating(bench, side, 0.03, 0.01)):
            here = bench.arm()
            for first in (1, 2):  # every other joint, then all
                for joint in range(first, bench.joints + 1, 2):
                    answer = bench.set_joint_mode(joint, JointMode.RIGID, here[joint - 1])
                    expect(answer.result is Result.OK, f"rigid was answered {answer}")
                sample = bench.stand_at(here, 0.6, "the stream with rigid joints")
                for joint, (applied, angle) in enumerate(zip(sample.applied_rad, here, strict=True), start=1):
                    off = abs(applied - angle)
                    expect(
                        off < 2e-4,
                        f"joint {joint}, rigid or beside one, is applied {off:.4f} rad off its angle",
                    )


@case("The largest trims are kept over a reset, and are in force at once after it.", needs=("reset",))
def a_reset_brings_trims_into_force(bench: Bench) -> None:
    if not bench.simulated:
        raise NotApplicableError("a trim cannot be read back: on a real robot it is left alone")
    for side in (1.0, -1.0):
        with _trimmed(bench, _alternating(bench, side, MAX_TRIM_RAD, 0.0)):
            bench.stand_at(bench.arm(), 0.4, "the stream")
            bench.make_safe()
            bench.start_anew()
            before = angles_of(bench, read_now(bench))
            for joint in range(1, bench.joints + 1):
                answer = bench.set_limit(joint, LimitKind.SPEED, 0.1)
                expect(answer.result is Result.OK, f"a speed limit of joint {joint} was refused")
            sample = bench.stand_at(bench.arm(), 0.3, "the stream after a reset")
            for joint, (was, now) in enumerate(zip(before, angles_of(bench, sample), strict=True), start=1):
                expect(
                    abs(now - was) > 0.8 * MAX_TRIM_RAD,
                    f"joint {joint} has a trim of {MAX_TRIM_RAD} rad since before the reset: its servo was told "
                    f"{abs(now - was):.3f} rad more",
                )


@case("A free joint's new trim comes into force when it gets power, not when the board does; nothing jumps.")
def trims_wait_for_their_joints_power(bench: Bench) -> None:
    for joint in range(1, bench.joints + 1):
        side = 1.0 if joint % 2 else -1.0
        with _trimmed(
            bench, [side * _TRIM_RAD if other == joint else 0.0 for other in range(1, bench.joints + 1)]
        ):
            expect(bench.set_joint_mode(joint, JointMode.FREE).result is Result.OK, "free was refused")
            here = bench.arm()
            bench.stand_at(here, 0.1, "a stream with a free joint")
            bench.must_go(Mode.HOLDING)
            before = angles_of(bench, bench.samples[-1])[joint - 1]
            expect(bench.set_joint_mode(joint, JointMode.ACTIVE).result is Result.OK, "active was refused")
            sample = read_now(bench)
            moved = abs(angles_of(bench, sample)[joint - 1] - before)
            told = sample.applied_rad[joint - 1] - before
            expect(
                moved < _TRIM_RAD / 4 and abs(told + side * _TRIM_RAD) < _TRIM_RAD / 4,
                f"joint {joint} was free when the board was armed, and got power with a new trim of "
                f"{side * _TRIM_RAD} rad: it moved by {moved:.3f} rad, its register is {told:.3f} rad off",
            )


def _zero_all(bench: Bench, zeros: Sequence[int]) -> None:
    for joint, zero in enumerate(zeros, start=1):
        answer = bench.ask(ZeroRequest(bench.token(), joint, zero, bench.host))
        expect(answer.result is Result.OK, f"zero {zero}, joint {joint}: {answer}")


def _counts(bench: Bench) -> list[int]:
    sample = at_rest(bench, 0)
    angles_of(bench, sample)
    return [c for c in sample.measured_counts if c is not None]


@case(
    "Each joint has a zero of its own, on either side; the register follows it, and a reset leaves it as it is."
)
def each_joint_has_its_zero(bench: Bench) -> None:
    if not bench.simulated:
        raise NotApplicableError("a zero cannot be read back: on a real robot it is left alone")
    raw = _counts(bench)
    try:
        for side in (1, -1):
            zeros = [side * (40 + 7 * j) * (-1 if j % 2 else 1) for j in range(bench.joints)]
            _zero_all(bench, zeros)
            if side < 0 and bench.reset is not None:
                bench.reset()
                bench.identify()
            for joint, (now, was, zero) in enumerate(zip(_counts(bench), raw, zeros, strict=True), start=1):
                expect(
                    abs(now - (was - zero)) <= 2,
                    f"zero {zero} took the reading of joint {joint} from {was} to {now}",
                )
            sample = bench.samples[-1]
            for joint, (a, b) in enumerate(
                zip(sample.applied_rad, angles_of(bench, sample), strict=True), start=1
            ):
                expect(
                    abs(a - b) < 1.5e-4, f"joint {joint} without power: applied {a:.4f} rad, measured {b:.4f}"
                )
    finally:
        _zero_all(bench, [0] * bench.joints)


@case("A joint keeps its trim when its zero is set, and its zero when its trim is.")
def trims_and_zeros_are_two_things(bench: Bench) -> None:
    trims = _alternating(bench, 1.0, 0.03, 0.01)
    with _trimmed(bench, trims):
        plain = _trims_seen(bench)
        raw = _counts(bench)
        zeros = [20 + 3 * joint for joint in range(bench.joints)]
        try:
            _zero_all(bench, zeros)
            shifted = _counts(bench)
            kept = _trims_seen(bench)  # before any trim is set again: a new zero may have taken them
            stood = _counts(bench)
            _trim_all(bench, [-trim for trim in trims])
            again = _counts(bench)
            turned = _trims_seen(bench)
        finally:
            _zero_all(bench, [0] * bench.joints)
        for joint, zero in enumerate(zeros):
            moved = max(abs(shifted[joint] - raw[joint] + zero), abs(again[joint] - stood[joint]))
            expect(
                moved <= 2,
                f"joint {joint + 1} has zero {zero}, and its reading is {moved} counts off after a trim",
            )
            unmoved = plain[joint] - zero * bench.rad_per_count  # a servo knows no zero
            off = max(abs(kept[joint] - unmoved), abs(turned[joint] - unmoved + 2 * trims[joint]))
            expect(
                off < 0.005, f"the trim of joint {joint + 1} is {off:.3f} rad another after its zero was set"
            )


@case("Counts beyond 16 bits are no reading: a wrong angle would be worse.")
def reports_no_count_beyond_16_bits(bench: Bench) -> None:
    if not bench.simulated:
        raise NotApplicableError("a zero cannot be read back: on a real robot it is left alone")
    raw = _counts(bench)
    try:
        for joint in range(1, bench.joints + 1):
            here = raw[joint - 1]
            for wanted in (32767, -32767, 32768, -32768, 32766):
                zero = here - wanted
                if not -32768 <= zero <= 32767:
                    continue
                _zero_all(bench, [0] * (joint - 1) + [zero])
                counts = read_now(bench).measured_counts[joint - 1]
                fits = abs(wanted) <= 32767
                expect(
                    counts == (wanted if fits else None),
                    f"a joint that stands at {wanted} counts is reported as {counts}",
                )
            _zero_all(bench, [0] * joint)
    finally:
        _zero_all(bench, [0] * bench.joints)


@case(
    "What no request could have stored is no trim: beyond 0.3 rad it is none, each joint's.",
    needs=("reset", "store_trim"),
)
def forgets_impossible_trims(bench: Bench) -> None:
    assert bench.reset is not None
    store = bench.lab.store_trim
    assert store is not None
    most = round(MAX_TRIM_RAD / ANGLE_STEP_RAD)
    for joint in range(1, bench.joints + 1):
        for steps in (most + 1, -most - 1, 32767, -32768):
            store(joint, steps)
            bench.start_anew()
            moved = max(abs(trim) for trim in _trims_seen(bench))
            expect(
                moved < 0.005,
                f"{steps} steps were stored as the trim of joint {joint}: a joint moved by {moved:.3f} rad",
            )
        store(joint, 0)
    bench.reset()
