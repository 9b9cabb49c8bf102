"""The limiter in mid-motion: what the limits allow is executed as it is, and pauses change nothing of the rule."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

from firmware_protocol.assembly import to_wire
from firmware_protocol.catalogue import Mode
from snakebot.conformance.bench import Bench, growth
from snakebot.conformance.case import case
from snakebot.conformance.limits_tape import play
from snakebot.conformance.rule import (
    TICK_S,
    Limits,
    Rule,
    arm_finely,
    as_built_at_most,
    beside_the_rule,
    by_the_rule,
    hold_between,
    pace_limits,
    set_all,
    slow_limits,
)
from snakebot.conformance.violations import expect
from snakebot.gait.limits import WIRE_STEP_RAD

_SHARE = 0.95  # of speed and acceleration: PROTOCOL.md promises to execute that as it is
_INTERVALS_S = (0.002, 0.005, 0.02)  # from the finest, where rounding counts most
_COASTS_S = 0.02
_RESTS_S = 0.03
_MOST_RISE = 9  # ticks of a rise to a speed; chosen: no joint goes further than a nudge
_SETTLES_TICKS = 12  # without a change, after which both paths are where they are for any joint that stands
_CLOSE_RAD = 0.6 * WIRE_STEP_RAD  # half a step, by which an answer is rounded, and single precision
# Ways in steps of the wire, tick by tick, for 0.25 rad/s and 2.5 rad/s^2. On them, and on few others, one of the two
# paths can follow where the other cannot: once in 8000 ticks of random ways, among which these were found.
_PARTING_PACE = 0.25, 2.5
_PARTING_WAYS = (
    (0, -2, -7, -15, -24, -37, -52, -70, -88, -110, -135, -160, -184, -210, -235, -257, -277, -295, -308, -323, -334,
     -340, -345, -347, -352, -356),
    (2, 8, 15, 25, 38, 52, 70, 90, 112, 138, 162, 188, 212, 238, 262, 288, 312, 338, 364, 388, 413, 436),
    (0, 0, -1, 2, 8, 15, 22, 22, 28, 35, 45, 58, 72, 87, 102, 121, 137, 155, 176, 200, 221, 247, 270, 295, 319, 345),
)  # fmt: skip
_STOPS_TICKS = 24  # of such a motion, to the rest


def _ramp(t_s: float, speed: float, acceleration: float) -> float:
    """Way made from rest to rest: all acceleration, all speed for a while, all braking."""
    rise_s = speed / acceleration
    up_s = min(max(t_s, 0.0), rise_s)
    even_s = min(max(t_s - rise_s, 0.0), _COASTS_S)
    down_s = min(max(t_s - rise_s - _COASTS_S, 0.0), rise_s)
    return acceleration * up_s**2 / 2 + speed * even_s + speed * down_s - acceleration * down_s**2 / 2


def _hard(t_s: float, limits: Limits) -> float:
    """Out, a rest, back, a rest, and one swing: rad from the start. Each joint keeps 95 % of its own limits."""
    speed, acceleration = _SHARE * limits[1], _SHARE * limits[2]
    there_s = 2 * speed / acceleration + _COASTS_S + _RESTS_S
    way = _ramp(t_s, speed, acceleration) - _ramp(t_s - there_s, speed, acceleration)
    swing_s = t_s - 2 * there_s
    if swing_s > 0:
        turns = min(swing_s * acceleration / speed, 2 * math.pi)
        way += speed**2 / acceleration * (1 - math.cos(turns))
    return way


@case("A motion that asks for 95 % of speed and acceleration is executed as it is, whatever its rate.")
def executes_what_the_limits_allow(bench: Bench) -> None:
    limits = [
        as_built_at_most(bench, joint, (math.inf, 0.3 + 0.03 * (joint % 5), 5.0 + 0.7 * (joint % 4)))
        for joint in range(1, bench.joints + 1)
    ]
    lasts_s = max(4 * v / a + 2 * (_COASTS_S + _RESTS_S) + 2 * math.pi * v / a for _, v, a in limits) + 0.02
    for interval_s in _INTERVALS_S:
        bench.fresh()
        set_all(bench, limits)
        before = bench.counters().clamped
        here = [to_wire(angle) for angle in bench.arm()]
        bench.executed(here, "the first one")
        side = [-1.0 if angle > 0 else 1.0 for angle in here]

        def motion(t_s: float, here: Sequence[float] = here, side: Sequence[float] = side) -> list[float]:
            ways = [_hard(t_s, of_joint) for of_joint in limits]
            return [to_wire(angle + s * way) for angle, s, way in zip(here, side, ways, strict=True)]

        bench.samples.clear()
        sent = bench.stream(lasts_s, motion, interval_s)
        bench.ping()
        answers = {sample.state.sequence: sample.applied_rad for sample in bench.samples}
        for number, (sequence, angles) in enumerate(sent, start=1):
            expect(
                sequence in answers, f"set-point {number}, {1e3 * interval_s:g} ms apart, was not executed"
            )
            off = [abs(a - b) for a, b in zip(answers[sequence], angles, strict=True)]
            joint = off.index(max(off))
            expect(
                off[joint] < 0.6 * WIRE_STEP_RAD,
                f"set-points {1e3 * interval_s:g} ms apart at 95 % of the limits: number {number}, joint {joint + 1}, "
                f"{angles[joint]:.4f} rad, was changed to {answers[sequence][joint]:.4f}",
            )
        bench.must_go(Mode.DISARMED)
        grown = growth(bench.counters().clamped, before)
        expect(
            grown == 0, f"{grown} set-points {1e3 * interval_s:g} ms apart at 95 % of the limits were clamped"
        )


@case("Holding in mid-motion and armed again: each joint goes on from where it is, at rest, by the rule.")
def goes_on_after_holding(bench: Bench) -> None:
    here = bench.sample().applied_rad
    limits = [slow_limits(bench, joint, angle, 6) for joint, angle in enumerate(here, start=1)]
    set_all(bench, limits)
    play(bench, arm_finely(bench), limits, 4 * bench.nudge_rad, 90, 12, holds_every=8)


@case(
    "A joint that is to stop dead in full motion goes on from the path that the rule says: each, both ways."
)
def stops_dead_by_the_rule(bench: Bench) -> None:
    for side in (1.0, -1.0):
        bench.fresh()
        limits = [pace_limits(bench, joint, 2) for joint in range(1, bench.joints + 1)]
        here, rule = beside_the_rule(bench, limits)
        ways = [_dead_stop(speed, acceleration) for _, speed, acceleration in limits]
        for number in range(_STOPS_TICKS):
            targets = [to_wire(angle + side * way[number]) for angle, way in zip(here, ways, strict=True)]
            by_the_rule(bench, rule, targets, f"set-point {number + 1} of a motion that stops dead")
            bench.listen(TICK_S)


def _dead_stop(speed: float, acceleration: float) -> list[float]:
    """Way (rad) tick by tick: a share of the acceleration, up to one of the speed, some ticks of that, and no more."""
    most = min(_MOST_RISE, int(0.85 * speed / (0.6 * acceleration * TICK_S)))
    way, v, ways = 0.0, 0.0, []
    for number in range(_STOPS_TICKS):
        v = 0.0 if number >= most + 3 else v + 0.6 * acceleration * TICK_S if number < most else v
        way += v * TICK_S
        ways.append(way)
    return ways


def _small_step(of_joint: Limits, start_rad: float, side: float) -> float:
    """A set-point (rad) from rest after which the joint's two paths are apart, and one of them is the nearer one."""
    for steps in range(1, 40):
        target = to_wire(start_rad + side * steps * WIRE_STEP_RAD)
        model = Rule(*([limit] for limit in of_joint))
        model.reset([start_rad])
        model.execute([target], TICK_S, 1, 1.0)
        if model.keeps(0):
            return target
    return to_wire(start_rad)


@case(
    "Of a joint's two paths the nearer one stays while the board holds, whichever that is: each joint, both ways."
)
def keeps_the_nearer_path(bench: Bench) -> None:
    for side, on in itertools.product((1.0, -1.0), repeat=2):
        bench.fresh()
        limits = [pace_limits(bench, joint, 2) for joint in range(1, bench.joints + 1)]
        here, rule = beside_the_rule(bench, limits)
        small = [_small_step(*each, side) for each in zip(limits, here, strict=True)]
        by_the_rule(bench, rule, small, "a small step")
        hold_between(bench)
        rule.rest(1.0)
        far = [to_wire(angle + on * bench.nudge_rad) for angle in here]
        by_the_rule(bench, rule, far, "a jump after a small step and holding")


@case(
    "Where one of a joint's two paths comes near the target and the other does not, the other is given up: both ways."
)
def gives_up_the_path_that_cannot_follow(bench: Bench) -> None:
    limits = [
        as_built_at_most(bench, joint, (math.inf, *_PARTING_PACE)) for joint in range(1, bench.joints + 1)
    ]
    for side, way in itertools.product((1, -1), _PARTING_WAYS):
        bench.fresh()
        here, rule = beside_the_rule(bench, limits)
        start = [to_wire(angle) for angle in here]
        for number, steps in enumerate([0] * _SETTLES_TICKS + list(way), start=1):
            targets = [to_wire(angle + side * steps * WIRE_STEP_RAD) for angle in start]
            by_the_rule(bench, rule, targets, f"set-point {number}, {side * steps} steps on", _CLOSE_RAD)
            bench.listen(TICK_S)
