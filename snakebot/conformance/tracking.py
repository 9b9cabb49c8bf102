"""The limiter in mid-motion: what the limits allow is executed as it is, and pauses change nothing of the rule."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence

from firmware_protocol.assembly import to_wire
from firmware_protocol.catalogue import LimitKind, Mode
from snakebot.conformance.bench import LIMIT_STEP, Bench
from snakebot.conformance.case import case
from snakebot.conformance.limits_tape import Limits, arm_finely, play, set_all, slow_limits
from snakebot.conformance.violations import expect
from snakebot.gait.limits import SlewLimiter

_SHARE = 0.95  # of speed and acceleration: PROTOCOL.md promises to execute that as it is
_INTERVALS_S = (0.002, 0.005, 0.02)  # from the finest, where rounding counts most
_STEP_RAD = 1e-4  # of an angle on the wire
_COASTS_S = 0.02
_RESTS_S = 0.03
_TICK_S = 0.01


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
    limits: list[Limits] = []
    for joint in range(1, bench.joints + 1):
        wanted = math.inf, 0.3 + 0.03 * (joint % 5), 5.0 + 0.7 * (joint % 4)
        of_joint = [
            min(value, bench.built_in(joint, kind)) for kind, value in zip(LimitKind, wanted, strict=True)
        ]
        angle, speed, acceleration = (math.floor(value / LIMIT_STEP + 0.5) * LIMIT_STEP for value in of_joint)
        limits.append((angle, speed, acceleration))
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
                off[joint] < 0.6 * _STEP_RAD,
                f"set-points {1e3 * interval_s:g} ms apart at 95 % of the limits: number {number}, joint {joint + 1}, "
                f"{angles[joint]:.4f} rad, was changed to {answers[sequence][joint]:.4f}",
            )
        bench.must_go(Mode.DISARMED)
        grown = (bench.counters().clamped - before) & 0xFFFF
        expect(
            grown == 0, f"{grown} set-points {1e3 * interval_s:g} ms apart at 95 % of the limits were clamped"
        )


@case("Holding in mid-motion and armed again: each joint goes on from where it is, at rest, by the rule.")
def goes_on_after_holding(bench: Bench) -> None:
    here = bench.sample().applied_rad
    limits = [slow_limits(bench, joint, angle, 6) for joint, angle in enumerate(here, start=1)]
    set_all(bench, limits)
    play(bench, arm_finely(bench), limits, 4 * bench.nudge_rad, 90, 12, holds_every=8)


def _first_changed(model: SlewLimiter, targets: Sequence[float], joint: int, side: float) -> int:
    """The shortest jump of one joint (steps of the wire) that a limit shortens by clearly more than half a step."""
    for steps in range(1, 200):
        wanted = list(targets)
        wanted[joint] = to_wire(wanted[joint] + side * steps * _STEP_RAD)
        trial = copy.deepcopy(model)
        trial.execute(wanted, _TICK_S, 1, 1.0)
        if abs(trial.applied_rad[joint] - wanted[joint]) > 0.6 * _STEP_RAD:
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
                set_all(bench, limits)
                before = bench.counters().clamped
                start = arm_finely(bench)
                bench.listen(0.035)  # more than the credit can hold
                model = SlewLimiter(*zip(*limits, strict=True))
                model.reset(start)
                targets = [to_wire(angle) for angle in start]
                for _ in range(5):
                    bench.executed(targets, "a set-point that stays")
                    model.execute(targets, _TICK_S, 1, 1.0)
                    bench.listen(_TICK_S)
                steps = _first_changed(model, targets, joint, side) + further
                jump = list(targets)
                jump[joint] = to_wire(jump[joint] + side * steps * _STEP_RAD)
                bench.executed(jump, f"a jump of {steps} steps")
                bench.must_go(Mode.DISARMED)
                grown = (bench.counters().clamped - before) & 0xFFFF
                expect(
                    grown == further + 1,
                    f"a jump of {steps} steps of joint {joint + 1} is changed by a step at {steps - further}"
                    f": Counters.clamped grew by {grown}",
                )
