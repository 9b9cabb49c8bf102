"""Limits: what may be set when, and what the board makes of set-points that break them."""

from __future__ import annotations

from firmware_protocol.catalogue import LimitKind, Mode, Result
from snakebot.conformance.bench import LIMIT_STEP, Bench
from snakebot.conformance.case import case
from snakebot.conformance.violations import expect
from snakebot.gait.limits import SlewLimiter

_SPEED, _ACCELERATION = 0.6, 4.0
_BEYOND_RAD = 0.2  # a board without limits moves no further than this


@case("LimitRequest: zero and more than the built-in limit are bad_value.")
def refuses_limits_beyond_its_own(bench: Bench) -> None:
    for kind in LimitKind:
        built_in = bench.built_in(1, kind)
        for value in (0.0, built_in + LIMIT_STEP):
            answer = bench.set_limit(1, kind, value)
            expect(
                (answer.result, answer.detail) == (Result.BAD_VALUE, 0),
                f"{kind.name.lower()} limit {value:.3f} (built in: {built_in:.3f}) was answered {answer}",
            )
        for value in (built_in / 2, built_in):
            answer = bench.set_limit(1, kind, value)
            expect(answer.result is Result.OK, f"{kind.name.lower()} limit {value:.3f} was answered {answer}")


@case("While armed or holding a limit only tightens; loosening is forbidden; once more is the same.")
def only_tightens_while_armed(bench: Bench) -> None:
    built_in = {kind: bench.built_in(1, kind) for kind in LimitKind}
    for mode in (Mode.ARMED, Mode.HOLDING):
        bench.fresh()
        bench.enter(mode)
        for kind in (LimitKind.SPEED, LimitKind.ACCELERATION, LimitKind.ANGLE):
            steps = [
                (built_in[kind] * 0.9, Result.OK),
                (built_in[kind] * 0.9, Result.OK),
                (built_in[kind] * 0.95, Result.FORBIDDEN),
                (built_in[kind] + 2 * LIMIT_STEP, Result.BAD_VALUE),
            ]
            for value, wanted in steps:
                answer = bench.set_limit(1, kind, value)
                expect(
                    answer.result is wanted,
                    f"{mode.name.lower()}: {kind.name.lower()} limit {value:.3f} of built-in {built_in[kind]:.3f} "
                    f"was answered {answer.result.name.lower()}, not {wanted.name.lower()}",
                )
            if mode is Mode.ARMED:  # the watchdog runs meanwhile
                bench.fresh()
                bench.enter(mode)


def _tighten(bench: Bench, here: float) -> tuple[float, float, float]:
    """Slow limits for joint 1, and an angle limit just outside where it is."""
    angle = min(bench.built_in(1, LimitKind.ANGLE), abs(here) + bench.nudge_rad)
    angle = round(angle / LIMIT_STEP) * LIMIT_STEP
    for kind, value in zip(LimitKind, (angle, _SPEED, _ACCELERATION), strict=True):
        expect(
            bench.set_limit(1, kind, value).result is Result.OK,
            f"{kind.name.lower()} limit {value} was refused",
        )
    return angle, _SPEED, _ACCELERATION


@case(
    "The rule of the limiter, tick by tick: angle, speed, acceleration, braking before the end and before a target."
)
def follows_the_limiter(bench: Bench) -> None:
    limits = _tighten(bench, bench.sample().applied_rad[0])
    here = bench.arm()
    model = SlewLimiter(*([limit] for limit in limits))
    model.reset(here[:1])
    outwards = 1.0 if here[0] >= 0 else -1.0

    def first(t_s: float) -> float:
        """A run within speed and acceleration through the end of the joint, a jump back, a jump out."""
        if t_s < 0.3:
            return here[0] + outwards * (1.5 * t_s**2 if t_s < 0.15 else 0.45 * t_s - 0.03375)
        return here[0] if t_s < 0.6 else here[0] + outwards * _BEYOND_RAD

    sent = bench.stream(0.9, lambda t: [first(t), *here[1:]])
    bench.ping()
    answers = {sample.state.sequence: sample.applied_rad[0] for sample in bench.samples}
    for number, (sequence, angles) in enumerate(sent, start=1):
        executed = model.execute([round(angles[0], 4)], 0.01, 1, 0.01)
        expect(sequence in answers, f"set-point {number} of a stream at 100 Hz was not executed")
        assert executed is not None
        off = abs(answers[sequence] - executed[0][0])
        expect(
            off < 6e-4,
            f"set-point {number}: target {angles[0]:.4f} rad, the rule gives {executed[0][0]:.4f}, "
            f"the board applied {answers[sequence]:.4f}",
        )
        expect(abs(answers[sequence]) <= max(limits[0], abs(here[0])) + 1.1e-4, "beyond the angle limit")


@case("A motion within the limits is executed as it is, and nothing is counted as clamped.")
def leaves_good_motions_alone(bench: Bench) -> None:
    here = bench.arm()
    sign = [1.0 if angle < 0 else -1.0 for angle in here]
    before = None

    def smooth(t_s: float) -> list[float]:
        u = min(t_s / 0.8, 1.0)
        way = 0.03 * u**3 * (10 - 15 * u + 6 * u * u)
        return [round(angle + way * s, 4) for angle, s in zip(here, sign, strict=True)]

    bench.must_go(Mode.DISARMED)
    before = bench.counters()
    here = bench.arm()
    sent = bench.stream(0.8, smooth)
    bench.ping()
    answers = {sample.state.sequence: sample.applied_rad for sample in bench.samples}
    for sequence, angles in sent:
        expect(sequence in answers, "a set-point of a smooth motion was not executed")
        off = max(abs(a - b) for a, b in zip(answers[sequence], angles, strict=True))
        expect(off < 1.1e-4, f"a motion within the limits was changed by {off:.5f} rad")
    after = bench.counters()
    expect(
        after.clamped == before.clamped,
        f"{(after.clamped - before.clamped) & 0xFFFF} of its set-points were clamped",
    )


@case("A set-point that a limit changed is counted as clamped, once.")
def counts_clamped(bench: Bench) -> None:
    before = bench.counters()
    here = bench.arm()
    bench.executed(
        [angle + (_BEYOND_RAD if angle < 0 else -_BEYOND_RAD) for angle in here],
        "a jump, to be limited",
        0.001,
    )
    after = bench.counters()
    grown = (after.clamped - before.clamped) & 0xFFFF
    expect(grown == 1, f"one set-point was clamped, Counters.clamped grew by {grown}")


@case(
    "A burst after a stall cannot make a joint faster than its limits: no more time is used than has passed, + 20 ms."
)
def bursts_gain_nothing(bench: Bench) -> None:
    speed = 0.3
    expect(bench.set_limit(1, LimitKind.SPEED, speed).result is Result.OK, "a speed limit was refused")
    here = bench.arm()
    inwards = -_BEYOND_RAD if here[0] >= 0 else _BEYOND_RAD
    target = [here[0] + inwards, *here[1:]]
    bench.stream(0.1, lambda t: here)
    bench.listen(0.05)
    bench.heard.clear()
    bench.samples.clear()
    sent_s = bench.clock.now_s()
    for _ in range(15):
        bench.tick(target)
    bench.ping()
    took_s = bench.clock.now_s() - sent_s
    expect(bench.samples, "none of a burst was executed: the credit lets the first ones through")
    moved = max(abs(sample.applied_rad[0] - here[0]) for sample in bench.samples)
    allowed = speed * (0.05 + 0.02 + took_s + 0.02) + 1e-3
    expect(moved <= allowed, f"a burst moved the joint by {moved:.4f} rad; {allowed:.4f} at most")
