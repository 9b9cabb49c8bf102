"""What is set of a joint is set of that joint and of no other: limits and modes."""

from __future__ import annotations

from collections.abc import Sequence

from firmware_protocol.catalogue import (
    HostHeartbeat,
    JointMode,
    LimitKind,
    Mode,
    Result,
)
from snakebot.conformance.bench import LIMIT_STEP, MOST_LIMIT, Bench, growth
from snakebot.conformance.case import case
from snakebot.conformance.lag import angles_of
from snakebot.conformance.violations import expect

_STEP_RAD = 1e-4  # resolution of an angle on the wire (PROTOCOL.md)


@case("Each joint, each kind: up to the built-in limit is ok, zero and one step more are bad_value.")
def knows_the_limits_of_each_joint(bench: Bench) -> None:
    for joint in range(1, bench.joints + 1):
        for kind in LimitKind:
            built_in = bench.built_in(joint, kind)
            for value, wanted in (
                (built_in, Result.OK),
                (built_in + LIMIT_STEP, Result.BAD_VALUE),
                (built_in + 1.0, Result.BAD_VALUE),
                (0.0, Result.BAD_VALUE),
                (LIMIT_STEP, Result.OK),
                (built_in, Result.OK),
            ):
                if value > MOST_LIMIT:
                    continue  # the wire cannot even ask for it
                answer = bench.set_limit(joint, kind, value)
                expect(
                    answer.result is wanted,
                    f"joint {joint}, {kind.name.lower()} limit {value:.3f} (built in: {built_in:.3f}): {answer}",
                )


@case("Holding, each joint, each kind: a limit is tightened step by step, and never loosened by one.")
def tightens_the_limits_of_each_joint(bench: Bench) -> None:
    for joint in range(1, bench.joints + 1):
        for kind in LimitKind:
            bench.built_in(joint, kind)
    bench.enter(Mode.HOLDING)
    for joint in range(1, bench.joints + 1):
        bench.send(HostHeartbeat(bench.host, joint))
        for kind in LimitKind:
            share = 0.7 + 0.01 * joint  # more than the joint before has: set there, it would be too loose
            value = round(bench.built_in(joint, kind) * share / LIMIT_STEP) * LIMIT_STEP
            for number, wanted in (
                (0, Result.OK),
                (0, Result.OK),
                (1, Result.FORBIDDEN),
                (-1, Result.OK),
                (0, Result.FORBIDDEN),
            ):
                answer = bench.set_limit(joint, kind, value + number * LIMIT_STEP)
                expect(
                    answer.result is wanted,
                    f"holding, joint {joint}, {kind.name.lower()} limit {value:.3f} {number:+d} step: {answer}",
                )


@case("rigid is ok up to the joint's own angle limit in force, on both sides, and bad_value one step beyond.")
def rigid_within_the_limit_of_each_joint(bench: Bench) -> None:
    for joint in range(1, bench.joints + 1):
        limit = (
            round(min(bench.built_in(joint, LimitKind.ANGLE), 0.5 + 0.05 * joint) / LIMIT_STEP) * LIMIT_STEP
        )
        expect(
            bench.set_limit(joint, LimitKind.ANGLE, limit).result is Result.OK, "an angle limit was refused"
        )
    for joint in range(1, bench.joints + 1):
        limit = (
            round(min(bench.built_in(joint, LimitKind.ANGLE), 0.5 + 0.05 * joint) / LIMIT_STEP) * LIMIT_STEP
        )
        for side in (1.0, -1.0):
            for beyond, wanted in ((0.0, Result.OK), (_STEP_RAD, Result.BAD_VALUE), (0.04, Result.BAD_VALUE)):
                answer = bench.set_joint_mode(joint, JointMode.RIGID, side * (limit + beyond))
                expect(
                    answer.result is wanted,
                    f"joint {joint} rigid at {side * (limit + beyond):.4f} rad, its limit is {limit:.3f}: {answer}",
                )
        for mode in (JointMode.FREE, JointMode.RIGID_HERE, JointMode.ACTIVE):
            answer = bench.set_joint_mode(joint, mode, 3.2)
            expect(
                answer.result is Result.OK, f"{mode.name.lower()} needs no angle, and was answered {answer}"
            )


def _goals(bench: Bench, here: Sequence[float], side: float) -> list[float]:
    """An angle of its own for each joint, to alternating sides."""
    share = [(1 + j % 4) / 4 * side * (1 if j % 2 else -1) for j in range(bench.joints)]
    return [round(angle + bench.nudge_rad * part, 4) for angle, part in zip(here, share, strict=True)]


def _near(bench: Bench, applied: Sequence[float], wanted: Sequence[float], when: str) -> None:
    for joint, (angle, goal) in enumerate(zip(applied, wanted, strict=True), start=1):
        expect(abs(angle - goal) < 3e-4, f"{when}: joint {joint} is at {angle:.4f} rad, not {goal:.4f}")


@case(
    "Every joint rigid at an angle of its own goes there and stays; active again, it follows the set-points."
)
def each_rigid_joint_has_its_angle(bench: Bench) -> None:
    for side, mode in ((1.0, Mode.DISARMED), (-1.0, Mode.ARMED)):
        bench.fresh()
        here = bench.sample().applied_rad
        goals = _goals(bench, here, side)
        if mode is Mode.ARMED:
            bench.arm()
            bench.must_go(Mode.HOLDING)
        for joint, goal in enumerate(goals, start=1):
            answer = bench.set_joint_mode(joint, JointMode.RIGID, goal)
            expect(answer.result is Result.OK, f"rigid at {goal:.4f} rad, joint {joint}: {answer}")
        bench.must_go(Mode.ARMED)
        first = bench.executed(here, "the first one with rigid joints")
        jump = max(abs(a - b) for a, b in zip(first.applied_rad, here, strict=True))
        expect(jump < bench.nudge_rad / 4, f"a rigid joint jumped by {jump:.3f} rad")
        _near(bench, bench.stand_at(here, 0.4, "the stream").applied_rad, goals, "all rigid")
        for joint in range(1, bench.joints + 1):
            bench.set_joint_mode(joint, JointMode.ACTIVE)
            wanted = [*here[:joint], *goals[joint:]]
            applied = bench.stand_at(here, 0.2, "the stream").applied_rad
            _near(bench, applied, wanted, f"joints up to {joint} active again")


@case("A rigid joint that is made rigid at another angle goes there; what was refused in between moves none.")
def rigid_joints_take_their_last_angle(bench: Bench) -> None:
    here = bench.arm()
    for side in (1.0, -1.0, 0.5):
        goals = _goals(bench, here, side)
        for joint, goal in enumerate(goals, start=1):
            answer = bench.set_joint_mode(joint, JointMode.RIGID, goal)
            expect(answer.result is Result.OK, f"rigid at {goal:.4f} rad, joint {joint}: {answer}")
            answer = bench.set_joint_mode(joint, JointMode.RIGID, here[joint - 1], bench.other)
            expect(answer.result is Result.HELD, f"another host's rigid was answered {answer}")
            bench.listen(0.01)
            bench.executed(here, "one with rigid joints")
        applied = bench.stand_at(here, 0.4, "the stream").applied_rad
        _near(bench, applied, goals, "all rigid, at other angles than before")


@case("rigid_here, joint by joint: that joint stays, the others follow the set-points, to both sides.")
def each_rigid_here_joint_stays(bench: Bench) -> None:
    before = bench.counters().clamped
    for joint in range(1, bench.joints + 1):
        bench.make_safe()
        bench.samples.clear()
        here = [round(angle, 4) for angle in bench.arm()]
        bench.executed(here, "the first one")
        expect(
            bench.set_joint_mode(joint, JointMode.RIGID_HERE, 1.0).result is Result.OK,
            "rigid_here was refused",
        )
        for side in (1.0, -1.0):
            goals = [round(angle + side * 0.008, 4) for angle in here]
            start = list(bench.samples[-1].applied_rad)

            def smooth(
                t_s: float, start: Sequence[float] = start, goals: Sequence[float] = goals
            ) -> list[float]:
                u = min(t_s / 0.3, 1.0)
                share = u**3 * (10 - 15 * u + 6 * u * u)
                return [round(a + (b - a) * share, 4) for a, b in zip(start, goals, strict=True)]

            sample = bench.answered(bench.stream(0.32, smooth)[-1][0])
            expect(sample, "the stream was not executed")
            assert sample is not None
            wanted = [*goals[: joint - 1], here[joint - 1], *goals[joint:]]
            _near(bench, sample.applied_rad, wanted, f"joint {joint} rigid_here")
        expect(bench.set_joint_mode(joint, JointMode.ACTIVE).result is Result.OK, "active was refused")
    bench.make_safe()
    grown = growth(bench.counters().clamped, before)
    expect(grown == 0, f"a rigid joint is no limit, and yet {grown} set-points were counted as clamped")


@case("A reset makes every joint active and every limit the built-in one.", needs=("reset",))
def forgets_modes_and_limits_at_a_reset(bench: Bench) -> None:
    assert bench.reset is not None
    for joint in range(1, bench.joints + 1):
        bench.set_joint_mode(joint, JointMode.FREE if joint % 2 else JointMode.RIGID_HERE)
        for kind in LimitKind:
            bench.set_limit(joint, kind, bench.built_in(joint, kind) / 2)
    bench.reset()
    bench.identify()
    bench.samples.clear()
    bench.enter(Mode.HOLDING)
    for joint in range(1, bench.joints + 1):
        bench.send(HostHeartbeat(bench.host, joint))
        for kind in LimitKind:
            answer = bench.set_limit(joint, kind, bench.built_in(joint, kind) * 0.9)
            expect(
                answer.result is Result.OK,
                f"joint {joint}: {kind.name.lower()} limit of before the reset: {answer}",
            )
    bench.must_go(Mode.DISARMED)
    bench.samples.clear()
    here = bench.arm()
    goals = _goals(bench, here, 0.2)
    sample = bench.stand_at(goals, 0.4, "the stream")
    _near(bench, sample.applied_rad, goals, "after a reset")
    for joint, (angle, was, goal) in enumerate(
        zip(angles_of(bench, sample), here, goals, strict=True), start=1
    ):
        expect(
            abs(angle - goal) < abs(goal - was) / 2 + bench.rad_per_count,
            f"joint {joint} has no power after a reset",
        )
