"""What counts as clamped: a set-point that a limit changed by what the wire can show, once, however many joints."""

from __future__ import annotations

from collections.abc import Sequence

from firmware_protocol.assembly import to_wire
from firmware_protocol.catalogue import JointMode, Mode, Result
from snakebot.conformance.bench import LIMIT_STEP, Bench, growth
from snakebot.conformance.case import case
from snakebot.conformance.lag import read_now
from snakebot.conformance.rule import (
    FULL_CREDIT_S,
    TICK_S,
    Limits,
    arm_finely,
    beside_the_rule,
    by_the_rule,
    pace_limits,
    set_all,
    slow_limits,
)
from snakebot.conformance.violations import expect
from snakebot.gait.limits import WIRE_STEP_RAD, SlewLimiter

_STAYS = 5  # ticks without a change, after which the rule knows the joint as resting
_TRIED_LIMITS = 800  # steps of an acceleration limit: they shorten a jump by all shares of a step
_FINE_ENOUGH = 7  # such steps at a time: 0.014 of a step of an angle


@case(
    "A joint at its limit alone makes the set-point count as clamped: each joint, each side, once a set-point."
)
def counts_each_joints_clamping(bench: Bench) -> None:
    _count_clamping(bench, (1.0, -1.0))


@case(
    "The same where all joints stand at one angle: one that is there says nothing of one that is not.",
    needs=("turn_joint",),
)
def counts_each_joints_clamping_in_line(bench: Bench) -> None:
    turn = bench.lab.turn_joint
    assert turn is not None
    for joint in range(1, bench.joints + 1):
        turn(joint, 0.0)
    read_now(bench)
    _count_clamping(bench, (1.0,))


def _count_clamping(bench: Bench, sides: Sequence[float]) -> None:
    """Let each joint jump to each of these sides and back, and count with the board."""
    before = bench.counters().clamped
    here = bench.arm()
    bench.stream(0.05, lambda t: here)
    wanted = 0
    for joint in range(bench.joints):
        for side in sides:
            goal = list(here)
            goal[joint] += side * 0.2
            bench.stream(0.02, lambda t, goal=goal: goal)  # type: ignore[misc]
            wanted += 2
            settled = False
            for _ in range(40):  # the way back is clamped until it is there
                bench.listen(0.01)
                sample = bench.executed(here, "the way back")
                settled = max(abs(a - b) for a, b in zip(sample.applied_rad, here, strict=True)) < 0.5e-4
                wanted += not settled
                if settled:
                    break
            expect(settled, f"joint {joint + 1} did not come back from a small jump")
    bench.must_go(Mode.DISARMED)
    grown = growth(bench.counters().clamped, before)
    expect(grown == wanted, f"{wanted} set-points were clamped, Counters.clamped grew by {grown}")


@case("A rigid joint on its way is not clamped; while a joint is rigid, another's clamping counts as ever.")
def counts_clamping_beside_rigid_joints(bench: Bench) -> None:
    for joint in range(1, bench.joints + 1):
        bench.fresh()
        before = bench.counters().clamped
        here = [to_wire(angle) for angle in bench.arm()]
        bench.executed(here, "the first one")
        goal = to_wire(here[joint - 1] + (-bench.nudge_rad if here[joint - 1] > 0 else bench.nudge_rad))
        answer = bench.set_joint_mode(joint, JointMode.RIGID, goal)
        expect(answer.result is Result.OK, f"rigid at {goal} rad was answered {answer}")
        bench.stand_at(here, 0.05, "a stream with a rigid joint")
        wanted = 0
        if bench.joints > 1:
            other = joint % bench.joints
            jump = list(here)
            jump[other] = to_wire(jump[other] + 0.2)
            bench.stand_at(jump, 0.03, "a stream with a rigid joint and a jump")
            wanted = 3
        bench.must_go(Mode.DISARMED)
        grown = growth(bench.counters().clamped, before)
        expect(
            grown == wanted,
            f"joint {joint} was rigid and on its way, another was clamped {wanted} times: Counters.clamped grew "
            f"by {grown}",
        )


def _first_changed(model: SlewLimiter, targets: Sequence[float], joint: int, side: float) -> int:
    """The shortest jump of one joint (steps of the wire) that a limit shortens by clearly more than half a step."""
    for steps in range(1, 200):
        wanted = list(targets)
        wanted[joint] = to_wire(wanted[joint] + side * steps * WIRE_STEP_RAD)
        trial = model.copy()
        trial.execute(wanted, TICK_S, 1, 1.0)
        if abs(trial.applied_rad[joint] - wanted[joint]) > 0.6 * WIRE_STEP_RAD:
            return steps
    raise AssertionError("slow limits shorten every long jump")


@case(
    "A set-point counts as clamped as soon as a limit changes what the wire can show of it, to either side."
)
def counts_the_smallest_change(bench: Bench) -> None:
    here = bench.sample().applied_rad
    limits = [slow_limits(bench, joint, angle, 1) for joint, angle in enumerate(here, start=1)]
    for joint in sorted({0, bench.joints // 2, bench.joints - 1}):
        for side in (1.0, -1.0):
            for further in (-1, 0):
                bench.fresh()
                before = bench.counters().clamped
                start, rule = beside_the_rule(bench, limits)
                targets = [to_wire(angle) for angle in start]
                for _ in range(_STAYS):
                    by_the_rule(bench, rule, targets, "a set-point that stays")
                    bench.listen(TICK_S)
                steps = _first_changed(rule, targets, joint, side) + further
                jump = list(targets)
                jump[joint] = to_wire(jump[joint] + side * steps * WIRE_STEP_RAD)
                bench.executed(jump, f"a jump of {steps} steps")
                bench.must_go(Mode.DISARMED)
                grown = growth(bench.counters().clamped, before)
                expect(
                    grown == further + 1,
                    f"a jump of {steps} steps of joint {joint + 1} is changed by a step at {steps - further}"
                    f": Counters.clamped grew by {grown}",
                )


def _jump_changed_by(limits: Limits, start_rad: float, share: float) -> tuple[Limits, float]:
    """A joint's limits, one a little tighter, and a jump that they shorten by this share of a step, to a hundredth."""
    target = to_wire(start_rad)
    angle, speed, acceleration = limits
    steps = 1
    for further in range(0, _TRIED_LIMITS, _FINE_ENOUGH):
        tried = angle, speed, acceleration - further * LIMIT_STEP
        settled = SlewLimiter(*([limit] for limit in tried))
        settled.reset([start_rad])
        for _ in range(_STAYS):
            settled.execute([target], TICK_S, 1, 1.0)
        while True:
            model, wanted = settled.copy(), to_wire(target + steps * WIRE_STEP_RAD)
            model.execute([wanted], TICK_S, 1, 1.0)
            changed = abs(model.applied_rad[0] - wanted) / WIRE_STEP_RAD
            if changed > 0.3:
                break
            steps += 1
        if abs(changed - share) < 0.01:
            return tried, wanted
        steps -= changed > 1.0
    raise AssertionError("one of many limits shortens a jump by any share of a step")


@case("A change counts as clamped from half a step of the wire on: just less is none, just more is one.")
def counts_from_half_a_step(bench: Bench) -> None:
    for joint in sorted({0, bench.joints - 1}):
        _count_from_half_a_step(bench, joint, None)


@case("The same while another joint is rigid.")
def counts_from_half_a_step_beside_a_rigid_joint(bench: Bench) -> None:
    if bench.joints > 1:
        _count_from_half_a_step(bench, 0, bench.joints - 1)


def _count_from_half_a_step(bench: Bench, joint: int, rigid: int | None) -> None:
    """Let a joint make a jump that its limits shorten by a little less than half a step, and by a little more."""
    limits = [pace_limits(bench, joint, 1) for joint in range(1, bench.joints + 1)]
    for share, counted in ((0.475, 0), (0.525, 1)):
        bench.fresh()
        before = bench.counters().clamped
        start = arm_finely(bench)
        of_joint, goal = _jump_changed_by(limits[joint], start[joint], share)
        set_all(bench, [*limits[:joint], of_joint, *limits[joint + 1 :]])
        if rigid is not None:
            answer = bench.set_joint_mode(rigid + 1, JointMode.RIGID, to_wire(start[rigid]))
            expect(answer.result is Result.OK, f"rigid where the joint is was answered {answer}")
        bench.listen(FULL_CREDIT_S)
        targets = [to_wire(angle) for angle in start]
        for _ in range(_STAYS):
            bench.executed(targets, "a set-point that stays")
            bench.listen(TICK_S)
        targets[joint] = goal
        bench.executed(targets, "a jump of some steps")
        bench.must_go(Mode.DISARMED)
        grown = growth(bench.counters().clamped, before)
        expect(
            grown == counted,
            f"a jump of joint {joint + 1} was shortened by {share} steps of the wire: Counters.clamped grew by {grown}",
        )
