"""The limiter's rule on every joint at once: motions that break every limit, ticks that are late, early, or lost."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from firmware_protocol.assembly import to_wire
from firmware_protocol.catalogue import FaultEvent, LimitKind, Mode, Result, State
from snakebot.conformance.bench import LIMIT_STEP, Bench, passed_us
from snakebot.conformance.case import case
from snakebot.conformance.rule import (
    FULL_CREDIT_S,
    SLACK_RAD,
    Limits,
    Rule,
    arm_finely,
    hold_between,
    set_all,
    set_all_of,
    slow_limits,
)
from snakebot.conformance.violations import NotApplicableError, expect
from snakebot.gait.limits import SlewLimiter

# Uncertainty of the times, s: a microsecond of the clock counts for more where a joint brakes at the last moment.
_BLUR_S = 1e-4
_CLOCK_S = 2e-6  # by which the time between two readings of the board's clock may be off
_INTERVAL_STEP_S = 0.0005
_PAUSE_S = 0.000037  # between two multiples of a step: no tick comes just in time or just too early
_PATIENCE_S = 0.06  # without an executed tick: then one comes that must be
_LONG_STEPS = (
    128,
    170,
)  # of the interval: all that need the eighth bit of its byte, and leave the watchdog alone


@dataclass(slots=True)
class _Motion:
    """Where a joint is sent: it stays a while, it sweeps a while, it jumps."""

    bench: Bench
    middle_rad: float
    reach_rad: float
    longest: int  # ticks
    target_rad: float = 0.0
    sweep_rad: float = 0.0
    left: int = 0
    shown: list[float] = field(default_factory=list)

    def next_rad(self) -> float:
        draw = self.bench.draw
        if self.left == 0:
            self.left = draw.randrange(1, self.longest)
            self.sweep_rad = draw.choice((0.0, 0.0, draw.uniform(-0.3, 0.3) * self.reach_rad / 4))
            if draw.random() < 0.7:
                self.target_rad = self.middle_rad + draw.uniform(-self.reach_rad, self.reach_rad)
        self.left -= 1
        self.target_rad = min(max(self.target_rad + self.sweep_rad, -3.2), 3.2)
        return to_wire(self.target_rad)


def _sent(
    bench: Bench, angles: Sequence[float], interval_s: float, step: int
) -> tuple[State | None, int, float]:
    """Send one set-point.

    The State that answers it, or None: it was dropped. When it came by the board's clock (us), and by how much it may
    have come earlier (s): of one that was dropped only the answer to a ping behind it is known.
    """
    bench.heard.clear()
    sent_s = bench.clock.now_s()
    sequence = bench.tick(angles, interval_s, step)
    pong = bench.ping()
    earlier_s = bench.clock.now_s() - sent_s
    if any(isinstance(m, FaultEvent) for m in bench.heard):
        bench.blame_the_watchdog()
        expect(False, "a FaultEvent came in mid-stream")
    state = next((m for m in bench.heard if isinstance(m, State) and m.sequence == sequence), None)
    return (None, pong.board_time_us, earlier_s) if state is None else (state, state.board_time_us, 0.0)


def play(
    bench: Bench,
    here: Sequence[float],
    limits: Sequence[Limits],
    reach_rad: float,
    ticks: int,
    longest: int,
    tighter: Sequence[Limits] = (),
    holds_every: int = 0,
    before_each: Callable[[int], None] | None = None,
    long_ticks: bool = False,
    but_joint: int = 0,
) -> None:
    """Move all joints at random, and compare each tick with the rule. The board must be armed, at rest.

    ``tighter`` limits come into force halfway, in mid-motion; every so many set-points the board holds in between, or
    some later, where the rule says clearly which path stays.
    ``before_each`` set-point something else may be sent; ``long_ticks`` are as long as the watchdog lets them be;
    ``but_joint`` (from 1) is not compared.
    """
    bench.listen(FULL_CREDIT_S)
    model = Rule(*zip(*limits, strict=True))
    model.reset(here)
    motions = [_Motion(bench, angle, reach_rad, longest, angle) for angle in here]
    last_us, due, dropped, holds = None, False, 0, False
    for number in range(ticks):
        if tighter and number == ticks // 2:
            set_all(bench, tighter)
            angle_rad, speed_rad_s, acceleration_rad_s2 = zip(*tighter, strict=True)
            model.angle_rad[:] = angle_rad
            model.speed_rad_s[:] = speed_rad_s
            model.acceleration_rad_s2[:] = acceleration_rad_s2
        holds = holds or (holds_every > 0 and number % holds_every == holds_every - 1)
        if holds and not model.is_torn():
            hold_between(bench)
            model.rest(1.0)
            last_us, holds = None, False
        targets = [motion.next_rad() for motion in motions]
        plain = last_us is None or due or long_ticks or bench.draw.random() < 0.5
        interval_s = 0.01 if plain else bench.draw.randrange(1, 50) * _INTERVAL_STEP_S
        if long_ticks and last_us is not None:
            interval_s = bench.draw.randrange(*_LONG_STEPS) * _INTERVAL_STEP_S
        step = 1 if plain else bench.draw.choice((1, 1, 2, 3, 4, 5, 9, 300))
        pause_s = interval_s if plain else bench.draw.choice((0.0, 0.001, 0.004, 0.012, 0.025))
        bench.listen(_PAUSE_S + pause_s)
        if before_each is not None:
            before_each(number)
        state, now_us, earlier_s = _sent(bench, targets, interval_s, step)
        elapsed_s = 1.0 if last_us is None else 1e-6 * passed_us(now_us, last_us)
        for near_s in (
            elapsed_s,
            max(elapsed_s - earlier_s, 0.0) - _CLOCK_S,
            elapsed_s + _CLOCK_S,
        ):  # of the clock the last digit is round
            would = model.copy().execute(targets, interval_s, step, near_s)
            if (would is None) == (state is None):
                elapsed_s = near_s
                break
        place = (
            f"set-point {number + 1} (interval {interval_s:g} s, step {step}, {1e3 * elapsed_s:.3f} ms later)"
        )
        if state is None:
            expect(would is None, f"{place} was dropped, the rule executes it")
            dropped += 1
            bench.sequence = (bench.sequence - step) & 0xFFFF
            due = elapsed_s > _PATIENCE_S
            continue
        expect(would is not None, f"{place} was executed, by the rule it came too early")
        model.execute(targets, interval_s, step, elapsed_s)
        last_us, due = now_us, False
        sample = next(s for s in reversed(bench.samples) if s.state.sample == state.sample)
        for joint, (applied, wanted, target) in enumerate(
            zip(sample.applied_rad, model.applied_rad, targets, strict=True), start=1
        ):
            if joint == but_joint:
                continue
            expect(
                abs(applied - wanted) < SLACK_RAD + _BLUR_S * limits[joint - 1][1],
                f"{place}: joint {joint}, target {target:.4f} rad, the rule gives {wanted:.4f}, "
                f"the board applied {applied:.4f}",
            )


@case(
    "The rule on every joint with limits of its own, set while disarmed: late, early, lost ticks, jumps both ways."
)
def keeps_every_joints_limits(bench: Bench) -> None:
    here = bench.sample().applied_rad
    for variant in (0, 1):  # the second time some are looser than the first time
        limits = [slow_limits(bench, joint, angle, variant) for joint, angle in enumerate(here, start=1)]
        set_all(bench, limits)
        play(bench, arm_finely(bench), limits, 4 * bench.nudge_rad, 90, 12)
        bench.must_go(Mode.DISARMED)
        bench.samples.clear()


@case("The rule for long ticks: all 8 bits of an interval count.")
def keeps_its_limits_in_long_ticks(bench: Bench) -> None:
    here = bench.sample().applied_rad
    limits = [slow_limits(bench, joint, angle, 3) for joint, angle in enumerate(here, start=1)]
    set_all(bench, limits)
    play(bench, arm_finely(bench), limits, 4 * bench.nudge_rad, 24, 6, long_ticks=True)


@case(
    "Limits that are tightened in mid-motion hold from the next set-point on: what is beyond them goes no further out."
)
def keeps_limits_set_in_mid_motion(bench: Bench) -> None:
    for share in (0.9, 0.3):  # of each limit: joints are too far out and too fast
        bench.fresh()
        here = bench.sample().applied_rad
        limits = [slow_limits(bench, joint, angle, 5) for joint, angle in enumerate(here, start=1)]
        set_all(bench, limits)
        rounded = [
            [max(round(share * value / LIMIT_STEP), 1) * LIMIT_STEP for value in one] for one in limits
        ]
        tighter = [(angle, speed, acceleration) for angle, speed, acceleration in rounded]
        play(bench, arm_finely(bench), limits, 4 * bench.nudge_rad, 90, 12, tighter)


@case("Limits that are tightened while holding are kept; what was refused changes none.")
def keeps_limits_set_while_holding(bench: Bench) -> None:
    here = bench.sample().applied_rad
    limits = [slow_limits(bench, joint, angle, 3) for joint, angle in enumerate(here, start=1)]
    start = arm_finely(bench)
    bench.must_go(Mode.HOLDING)
    set_all(bench, limits)
    for joint in range(1, bench.joints + 1):
        for kind, value in zip(LimitKind, limits[joint - 1], strict=True):
            for refused, host, result in (
                (value + LIMIT_STEP, bench.host, Result.FORBIDDEN),
                (value / 2, bench.other, Result.HELD),
                (0.0, bench.host, Result.BAD_VALUE),
            ):
                answer = bench.set_limit(joint, kind, refused, host)
                expect(
                    answer.result is result,
                    f"{kind.name.lower()} limit {refused:.3f} of joint {joint}: {answer}",
                )
    bench.must_go(Mode.ARMED)
    play(bench, start, limits, 4 * bench.nudge_rad, 90, 12)


@case(
    "The first set-point after arming has 20 ms of time, and what has passed since: no more, however long it was off."
)
def starts_with_little_credit(bench: Bench) -> None:
    interval_s = 0.06
    here = bench.sample().applied_rad
    limits = [slow_limits(bench, joint, angle, 4) for joint, angle in enumerate(here, start=1)]
    for between in (Mode.DISARMED, Mode.HOLDING):
        bench.fresh()
        set_all(bench, limits)
        start = arm_finely(bench)
        if between is Mode.HOLDING:
            bench.must_go(Mode.HOLDING)
            bench.listen(0.3)
            bench.must_go(Mode.ARMED)
            bench.listen(0.05)  # more than the credit can hold
            bench.must_go(Mode.HOLDING)
            bench.listen(0.3)
            start = list(bench.samples[-1].applied_rad)
        before_us = bench.ping().board_time_us
        if between is Mode.HOLDING:
            bench.must_go(Mode.ARMED)
        goal = [to_wire(angle - bench.nudge_rad if angle > 0 else angle + bench.nudge_rad) for angle in start]
        sample = bench.executed(goal, "the first one after arming", interval_s)
        longest_s = 1e-6 * passed_us(sample.state.board_time_us, before_us) + (
            0.0 if between is Mode.HOLDING else 0.01
        )
        moves = []
        for elapsed_s in (0.0, longest_s):
            model = SlewLimiter(*zip(*limits, strict=True))
            model.reset(start)
            expect(model.execute(goal, interval_s, 1, elapsed_s), "the rule drops the first one after arming")
            moves.append([abs(a - b) for a, b in zip(model.applied_rad, start, strict=True)])
        for joint, (applied, was, least, most) in enumerate(
            zip(sample.applied_rad, start, *moves, strict=True), 1
        ):
            moved = abs(applied - was)
            expect(
                least - 2 * SLACK_RAD <= moved <= most + 2 * SLACK_RAD,
                f"the first set-point after {between.name.lower()} moved joint {joint} by {moved:.4f} rad, "
                f"not {least:.4f} to {most:.4f}",
            )


def _exactly(bench: Bench, joint: int) -> Limits:
    """Built-in limits put in force, known to more than half a step of the wire: a long tape tells them apart."""
    below = 0.0 if bench.lab.plate is not None else LIMIT_STEP
    angle, speed, acceleration = (bench.built_in(joint, kind) - below for kind in LimitKind)
    set_all_of(bench, joint, (angle, speed, acceleration))
    if (
        bench.lab.plate is not None
    ):  # the board has the smaller one of what was asked for and what it is built for
        written = bench.lab.plate.limits[joint - 1]
        angle, speed, acceleration = map(min, (angle, speed, acceleration), written)
    return angle, speed, acceleration


@case(
    "The built-in limits of every joint, reached at both ends and at full speed: simulated boards only.",
    long=True,
)
def keeps_its_built_in_limits(bench: Bench) -> None:
    if not bench.simulated:
        raise NotApplicableError("a real robot is not driven to its limits by a test")
    limits = [_exactly(bench, joint) for joint in range(1, bench.joints + 1)]
    for _ in range(2):
        here = arm_finely(bench)
        play(bench, here, limits, 2.0, 300, 60)
        bench.stand_at(here, 1.5, "the way back")
        bench.must_go(Mode.DISARMED)
        bench.samples.clear()
