"""The limiter's rule beside a board: limits that a small motion breaks, and what the rule executes under them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from firmware_protocol.catalogue import LimitKind, Mode, Result
from snakebot.conformance.bench import LIMIT_STEP, Bench
from snakebot.conformance.lag import at_rest
from snakebot.conformance.violations import expect
from snakebot.gait.limits import WIRE_STEP_RAD, SlewLimiter

FULL_CREDIT_S = 0.035  # more than the credit can hold
SLACK_RAD = 1.1e-4  # between what a board applied and the rule: half a step of the wire, and single precision
TICK_S = 0.01
_TIE_RAD = 1e-5  # two paths are as near where their distances differ by less: single precision

Limits = tuple[float, float, float]  # angle (rad), speed (rad/s), acceleration (rad/s^2)


def arm_finely(bench: Bench) -> list[float]:
    """Arm joints at rest; the register (rad), finer than the wire tells it: without power it is the reading."""
    sample = at_rest(bench)
    bench.must_go(Mode.ARMED)
    start = []
    for counts, applied in zip(sample.measured_counts, sample.applied_rad, strict=True):
        angle = applied if counts is None else counts * bench.rad_per_count
        start.append(angle if abs(angle - applied) < 1e-4 else applied)
    return start


class Rule(SlewLimiter):
    """The rule, which of the two paths it keeps at rest, and where arithmetic leaves that open."""

    def keeps(self, joint: int) -> int:
        """Of a joint (from 0): 1 where the fastest path stays, -1 the slowest; 0 where one can hardly tell."""
        slow, fast = self._paths[joint, 0], self._paths[joint, 2]
        nearer = abs(slow - self.applied[joint]) - abs(fast - self.applied[joint])
        if abs(slow - fast) < 1.5 * WIRE_STEP_RAD or abs(nearer) < 0.2 * WIRE_STEP_RAD:
            return 0
        return 1 if nearer > 0 else -1

    def is_torn(self) -> bool:
        """Of some joint's two paths either may be the one that stays at rest: another arithmetic takes the other."""
        slow, fast = self._paths[:, 0], self._paths[:, 2]
        off = np.abs(np.abs(slow - self.applied) - np.abs(fast - self.applied))
        return bool(((off < _TIE_RAD) & (np.abs(slow - fast) > _TIE_RAD)).any())


def beside_the_rule(bench: Bench, limits: Sequence[Limits]) -> tuple[list[float], Rule]:
    """Limits in force, joints armed at rest, credit full: where the joints are (rad), and the rule from there."""
    set_all(bench, limits)
    here = arm_finely(bench)
    bench.listen(FULL_CREDIT_S)
    rule = Rule(*zip(*limits, strict=True))
    rule.reset(here)
    return here, rule


def by_the_rule(
    bench: Bench, rule: Rule, targets_rad: Sequence[float], what: str, slack_rad: float = SLACK_RAD
) -> None:
    """Send a set-point, for which there is credit, and compare what the board and the rule make of it."""
    applied = bench.executed(targets_rad, what, TICK_S).applied_rad
    rule.execute(targets_rad, TICK_S, 1, 1.0)
    for joint, (was, wanted) in enumerate(zip(applied, rule.applied_rad, strict=True), start=1):
        expect(
            abs(was - wanted) < slack_rad,
            f"{what}, joint {joint}: the rule gives {wanted:.5f} rad, the board applied {was:.4f}",
        )


def hold_between(bench: Bench) -> None:
    """Holding and armed again, with more time before and after it than the credit can hold."""
    for mode in (Mode.HOLDING, Mode.ARMED):
        bench.listen(FULL_CREDIT_S)
        bench.must_go(mode)
    bench.listen(FULL_CREDIT_S)


def slow_limits(bench: Bench, joint: int, here_rad: float, variant: int) -> Limits:
    """Limits of one joint, unlike those of its neighbours, that a small motion breaks."""
    wanted = (
        abs(here_rad) + bench.nudge_rad * (1 + joint % 5) / 5,
        0.3 + 0.11 * ((joint + variant) % 7),
        3.0 + 1.3 * ((joint + 2 * variant) % 5),
    )
    return as_built_at_most(bench, joint, wanted)


def as_built_at_most(bench: Bench, joint: int, wanted: Limits) -> Limits:
    """These limits of one joint as the wire can say them, none above what is built in."""
    kinds = zip(LimitKind, wanted, strict=True)
    angle, speed, acceleration = (
        round(min(bench.built_in(joint, kind), value) / LIMIT_STEP) * LIMIT_STEP for kind, value in kinds
    )
    return angle, speed, acceleration


def pace_limits(bench: Bench, joint: int, variant: int) -> Limits:
    """The same of speed and acceleration alone: its angle is limited as built in."""
    return bench.built_in(joint, LimitKind.ANGLE), *slow_limits(bench, joint, 0.0, variant)[1:]


def set_all(bench: Bench, limits: Sequence[Limits]) -> None:
    for joint, of_joint in enumerate(limits, start=1):
        set_all_of(bench, joint, of_joint)


def set_all_of(bench: Bench, joint: int, limits: Limits) -> None:
    for kind, value in zip(LimitKind, limits, strict=True):
        answer = bench.set_limit(joint, kind, value)
        expect(
            answer.result is Result.OK,
            f"{kind.name.lower()} limit {value:.3f} of joint {joint}: {answer}",
        )
