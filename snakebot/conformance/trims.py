"""Trims: what the servo is told is the set-point and the trim, and the limits hold for that sum."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from contextlib import contextmanager

from firmware_protocol.assembly import Sample
from firmware_protocol.catalogue import JointMode, LimitKind, Result, TrimRequest
from snakebot.conformance.bench import LIMIT_STEP, Bench
from snakebot.conformance.case import case
from snakebot.conformance.violations import NotApplicableError, expect

_STEP_RAD = 1e-4  # of an angle on the wire
_LAG_S = 0.15  # a servo, and whatever the simulated board makes of it, is there by then


@contextmanager
def _trimmed(bench: Bench, trim_rad: float) -> Iterator[None]:
    """Joint 1 has this trim; afterwards it has none, and stands."""
    if not bench.simulated:
        raise NotApplicableError("a trim cannot be read back: on a real robot it is left alone")
    _set(bench, trim_rad)
    try:
        yield
    finally:
        bench.fresh()
        _set(bench, 0.0)
        bench.stand_at(bench.arm(), 0.4, "the stream after the trim was taken away")
        bench.make_safe()


def _set(bench: Bench, trim_rad: float) -> None:
    answer = bench.ask(TrimRequest(bench.token(), 1, trim_rad, bench.host))
    expect(answer.result is Result.OK, f"a trim of {trim_rad} rad was answered {answer}")


def _moved(bench: Bench, sample: Sample, here: float) -> float:
    """By how much the encoder of joint 1 says that it has moved, rad."""
    counts = sample.measured_counts[0]
    if counts is None:
        raise NotApplicableError("joint 1 has no encoder reading")
    return counts * bench.rad_per_count - here


@case(
    "TrimRequest: the servo is told the set-point and the trim; what is reported are joint angles, without it."
)
def trims_the_servo(bench: Bench) -> None:
    trim = 0.04
    with _trimmed(bench, trim):
        here = bench.arm()
        sample = bench.stand_at(here, 0.5, "the stream")
        expect(abs(sample.applied_rad[0] - here[0]) < 2e-4, "a trim moved the register")
        moved = _moved(bench, sample, here[0])
        expect(abs(moved - trim) < 0.01, f"a trim of {trim} rad moved the joint by {moved:.3f} rad")


@case("A trim that was changed does not jump at arming: the way to it is made under the joint's limits.")
def slews_to_a_new_trim(bench: Bench) -> None:
    trim, speed = 0.2, 0.25
    with _trimmed(bench, trim):
        expect(bench.set_limit(1, LimitKind.SPEED, speed).result is Result.OK, "a speed limit was refused")
        here = bench.arm()
        bench.stream(0.4, lambda t: here)
        bench.ping()
        running = [sample for sample in bench.samples if sample.measured_counts[0] is not None]
        expect(len(running) > 20, "a stream at 100 Hz was not executed")
        start_us = running[0].state.board_time_us
        for sample in running:
            passed_s = ((sample.state.board_time_us - start_us) & 0xFFFFFFFF) * 1e-6
            moved = abs(_moved(bench, sample, here[0]))
            allowed = speed * (passed_s + 0.02) + 2 * bench.rad_per_count + 0.005
            expect(
                moved <= allowed,
                f"{passed_s:.3f} s after arming a new trim has moved the joint by {moved:.3f} rad, "
                f"{allowed:.3f} at {speed} rad/s",
            )
        last = bench.stand_at(here, trim / speed + _LAG_S, "the stream")
        moved = _moved(bench, last, here[0])
        expect(
            abs(moved - trim) < 0.01, f"a trim of {trim} rad moved the joint by {moved:.3f} rad in the end"
        )


@case("The angle limit holds for the set-point and the trim together.")
def limits_the_sum(bench: Bench) -> None:
    trim = 0.04
    limit = abs(bench.sample().applied_rad[0]) + bench.nudge_rad + trim
    limit = round(min(bench.built_in(1, LimitKind.ANGLE), limit) / LIMIT_STEP) * LIMIT_STEP
    for side, inwards in itertools.product((1.0, -1.0), (1.0, -1.0)):
        its_trim = side * inwards * trim
        with _trimmed(bench, its_trim):
            expect(bench.set_limit(1, LimitKind.ANGLE, limit).result is Result.OK, "a limit was refused")
            here = bench.arm()
            last = bench.stand_at(
                [side * (limit + 2 * trim), *here[1:]], 1.0, "the stream to the end of the joint"
            )
            end = side * limit - its_trim
            off = abs(last.applied_rad[0] - end)
            expect(
                off < 3 * _STEP_RAD,
                f"limit {limit:.3f} rad, trim {its_trim}: the joint went to {last.applied_rad[0]:.4f} rad, "
                f"not to {end:.4f}",
            )
            bench.stream(0.6, lambda t, here=here: here)  # type: ignore[misc]


@case("A rigid joint that has a trim goes to its angle, too: the servo is told the angle and the trim.")
def trims_rigid_joints(bench: Bench) -> None:
    for trim in (0.04, -0.03):
        with _trimmed(bench, trim):
            here = bench.arm()
            goal = round(here[0] + (bench.nudge_rad if here[0] < 0 else -bench.nudge_rad), 4)
            answer = bench.set_joint_mode(1, JointMode.RIGID, goal)
            expect(answer.result is Result.OK, f"rigid was answered {answer}")
            sample = bench.stand_at(here, 0.6, "the stream with a rigid joint")
            off = abs(sample.applied_rad[0] - goal)
            expect(
                off < 2e-4, f"a rigid joint with a trim of {trim} rad is applied {off:.4f} rad off its angle"
            )
            moved = _moved(bench, sample, here[0])
            expect(
                abs(moved - (goal - here[0]) - trim) < 0.01,
                f"a rigid joint {goal - here[0]:.3f} rad away, with a trim of {trim} rad, moved by {moved:.3f} rad",
            )
