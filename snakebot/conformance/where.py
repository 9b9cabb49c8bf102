"""Where a robot is, as far as its board knows; and joints that stand where no set-point could have sent them."""

from __future__ import annotations

import itertools
import math

from firmware_protocol.assembly import ANGLE_STEP_RAD, LARGEST
from firmware_protocol.catalogue import Applied, PoseMotion, PosePosition, State
from snakebot.conformance.bench import LIMIT_STEP, Bench, passed_us
from snakebot.conformance.case import case
from snakebot.conformance.lag import angles_of, read_now
from snakebot.conformance.limits_tape import play
from snakebot.conformance.rule import Limits, arm_finely, set_all, slow_limits
from snakebot.conformance.violations import NotApplicableError, expect

_FAR_RAD = 3.4  # beyond what the wire carries of an angle, 3.2767 rad
_FAR_COUNTS = 33_000  # beyond what the wire carries of a count, 32767: whole turns
_STRETCH = 10  # samples over which positions are compared with speeds
_PLACE_M = 2e-4  # by which two positions on the wire may be off: a step of 1e-4 m in x and in y
_ARRIVES_S = 0.02  # an answer that is not closed waits for the next heartbeat, 100 ms
_OUTSIDE_RAD = 0.08  # beyond a joint's limit


@case(
    "A board with a pose sends it after each sample, with the sample's number; others send none.",
    needs=("plate",),
)
def tells_its_pose(bench: Bench) -> None:
    assert bench.lab.plate is not None
    here = bench.arm()

    def wave(t_s: float) -> list[float]:
        return [
            round(angle + bench.nudge_rad * math.sin(6.0 * t_s) * math.cos(joint), 4)
            for joint, angle in enumerate(here)
        ]

    bench.heard.clear()
    bench.stream(1.0, wave)
    bench.listen(_ARRIVES_S)
    told = {type(m): m.sample for m in bench.heard if isinstance(m, State | PoseMotion)}
    bench.ping()
    parts = [m for m in bench.heard if isinstance(m, State | Applied | PosePosition | PoseMotion)]
    if not bench.lab.plate.pose:
        expect(
            not any(isinstance(m, PosePosition | PoseMotion) for m in parts),
            "a board without a pose sent one",
        )
        return
    states = [m for m in parts if isinstance(m, State)]
    places = [m for m in parts if isinstance(m, PosePosition)]
    motions = [m for m in parts if isinstance(m, PoseMotion)]
    numbers = [m.sample for m in states]
    expect(
        [m.sample for m in places] == numbers and [m.sample for m in motions] == numbers,
        f"{len(states)} samples, {len(places)} positions and {len(motions)} motions, or other numbers",
    )
    expect(
        told.get(PoseMotion) == told.get(State),
        f"{1e3 * _ARRIVES_S:.0f} ms after sample {told.get(State)} its pose had not come: is the last frame closed?",
    )
    for before, after in itertools.pairwise(parts):
        right = isinstance(after, PosePosition | PoseMotion) == isinstance(
            before, Applied | PosePosition
        ) or (isinstance(before, Applied) and isinstance(after, Applied))
        expect(right, f"a pose comes right after its sample's last frame: {before} came before {after}")
    for first in range(0, len(states) - _STRETCH, _STRETCH):
        went_m = along_m = 0.0
        stretch = range(first, first + _STRETCH)
        for a, b, p, q, m, n in (
            (states[k], states[k + 1], places[k], places[k + 1], motions[k], motions[k + 1]) for k in stretch
        ):
            heading_rad = (m.heading_rad + n.heading_rad) / 2
            went_m += math.cos(heading_rad) * (q.x_m - p.x_m) + math.sin(heading_rad) * (q.y_m - p.y_m)
            along_m += 1e-6 * passed_us(b.board_time_us, a.board_time_us) * (m.speed_m_s + n.speed_m_s) / 2
        expect(
            abs(went_m - along_m) < _PLACE_M + 0.05 * abs(along_m),
            f"by its positions it went {went_m:.5f} m ahead, by its speed {along_m:.5f} m",
        )


@case(
    "A joint without power that stands beyond what the wire carries: Applied is the largest angle.",
    needs=("turn_joint",),
)
def tells_angles_beyond_the_wire(bench: Bench) -> None:
    turn = bench.lab.turn_joint
    assert turn is not None
    if not bench.simulated:
        raise NotApplicableError("a real joint is not turned that far")
    largest = LARGEST * ANGLE_STEP_RAD
    for joint in range(1, bench.joints + 1):
        was = angles_of(bench, read_now(bench))
        for side in (1.0, -1.0):
            turn(joint, side * _FAR_COUNTS * bench.rad_per_count)
            sample = read_now(bench)
            counts, applied = sample.measured_counts[joint - 1], sample.applied_rad[joint - 1]
            expect(
                counts is None, f"joint {joint} stands {_FAR_COUNTS} counts off, and is measured at {counts}"
            )
            expect(
                abs(applied - side * largest) < ANGLE_STEP_RAD / 2,
                f"joint {joint} stands {side * _FAR_COUNTS:.0f} counts off: it was told as {applied:.4f} rad",
            )
            turn(joint, side * _FAR_RAD)
            sample = read_now(bench)
            turn(joint, was[joint - 1])
            now = angles_of(bench, sample)[joint - 1]
            expect(
                abs(now - side * _FAR_RAD) <= bench.rad_per_count,
                f"joint {joint} was turned to {side * _FAR_RAD} rad and is measured at {now:.4f}",
            )
            applied = sample.applied_rad[joint - 1]
            expect(
                abs(applied - side * largest) < ANGLE_STEP_RAD / 2,
                f"joint {joint} stands at {now:.3f} rad, beyond the wire's {largest}: it was told as {applied:.4f}",
            )
    read_now(bench)


@case(
    "Armed beyond its limit a joint stays where it is, goes no further out, and comes back in by the rule: both sides.",
    needs=("turn_joint",),
)
def comes_back_from_beyond_its_limit(bench: Bench) -> None:
    turn = bench.lab.turn_joint
    assert turn is not None
    for first in (1.0, -1.0):
        bench.fresh()
        here = angles_of(bench, read_now(bench))
        sides = [first * (-1.0 if joint % 2 else 1.0) for joint in range(bench.joints)]
        limits: list[Limits] = []
        for joint, (angle, side) in enumerate(zip(here, sides, strict=True), start=1):
            _, speed, acceleration = slow_limits(bench, joint, angle, 2)
            inner = round((abs(angle) + bench.nudge_rad) / LIMIT_STEP) * LIMIT_STEP
            limits.append((inner, speed, acceleration))
            turn(joint, side * (inner + _OUTSIDE_RAD))
        set_all(bench, limits)
        read_now(bench)
        try:
            play(bench, arm_finely(bench), limits, 4 * bench.nudge_rad, 60, 12)
        finally:
            bench.make_safe()
            for joint, angle in enumerate(here, start=1):
                turn(joint, angle)
            read_now(bench)
