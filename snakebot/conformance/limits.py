"""Limits: what may be set when, and what the board makes of set-points that break them."""

from __future__ import annotations

import math

from firmware_protocol.assembly import ANGLE_STEP_RAD
from firmware_protocol.catalogue import (
    ClearRequest,
    HostHeartbeat,
    InfoRequest,
    JointLimits,
    JointMode,
    JointModeRequest,
    LimitKind,
    LimitRequest,
    Message,
    Mode,
    ModeRequest,
    Ping,
    Result,
)
from snakebot.conformance.bench import LIMIT_STEP, MOST_LIMIT, Bench, growth
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
                answer.result is Result.BAD_VALUE,
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
        f"{growth(after.clamped, before.clamped)} of its set-points were clamped",
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
    grown = growth(after.clamped, before.clamped)
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


def reports_of(bench: Bench, request: Message) -> dict[int, JointLimits]:
    """What a request is followed by: the limits of every joint."""
    bench.heard.clear()
    bench.send(request)
    bench.ping()
    reports = [m for m in bench.heard if isinstance(m, JointLimits)]
    expect(
        sorted(report.joint for report in reports) == list(range(1, bench.joints + 1)),
        f"JointLimits must come once for every joint after {type(request).__name__}; they came for "
        f"{[report.joint for report in reports]}",
    )
    return {report.joint: report for report in reports}


@case("The limits in force are reported when armed is granted, and granted again, and after an InfoRequest.")
def reports_its_limits(bench: Bench) -> None:
    wanted = {}
    for joint in range(1, bench.joints + 1):
        for kind, share in zip(LimitKind, (0.9, 0.5, 0.25), strict=True):
            wanted[joint, kind] = bench.built_in(joint, kind) * (share - 0.01 * joint)
            answer = bench.set_limit(joint, kind, wanted[joint, kind])
            expect(answer.result is Result.OK, "a limit was refused")
    requests: list[Message] = [
        InfoRequest(bench.other),
        ModeRequest(bench.token(), Mode.ARMED, bench.host),
        ModeRequest(bench.token(), Mode.ARMED, bench.host),
    ]
    for request in requests:
        for joint, report in reports_of(bench, request).items():
            said = (report.angle_rad, report.speed_rad_s, report.acceleration_rad_s2)
            for kind, reported in zip(LimitKind, said, strict=True):
                value = wanted[joint, kind]
                expect(
                    abs(reported - value) <= 1.01 * LIMIT_STEP,
                    f"the {kind.name.lower()} limit {value:.3f} of joint {joint} is reported as {reported:.3f}",
                )
    bench.heard.clear()
    expect(bench.go(Mode.ARMED, bench.other).result is Result.HELD, "another host armed a held board")
    bench.ping()
    expect(
        not any(isinstance(m, JointLimits) for m in bench.heard), "a refused request is no reason to report"
    )


@case("Changing the mode to and fro gains no time: a joint is no faster than its limits by it.")
def toggling_gains_nothing(bench: Bench) -> None:
    speed, rounds, at_once = 0.3, 6, 10
    for between, pause_s in ((Mode.HOLDING, 0.0), (Mode.HOLDING, 0.001), (Mode.DISARMED, 0.0)):
        bench.fresh()
        expect(bench.set_limit(1, LimitKind.SPEED, speed).result is Result.OK, "a speed limit was refused")
        here = bench.arm()
        target = [here[0] + (-_BEYOND_RAD if here[0] >= 0 else _BEYOND_RAD), *here[1:]]
        bench.samples.clear()
        sent_s = bench.clock.now_s()
        for _ in range(rounds):
            for _ in range(at_once):
                bench.send(ModeRequest(bench.token(), between, bench.host))
                bench.send(ModeRequest(bench.token(), Mode.ARMED, bench.host))
                bench.tick(target, 0.02)
                if pause_s:
                    bench.listen(pause_s)
            bench.ping()  # never more under way than a small buffer holds
        took_s = bench.clock.now_s() - sent_s
        expect(bench.samples, "none of the set-points was executed: the credit lets the first ones through")
        moved = max(abs(sample.applied_rad[0] - here[0]) for sample in bench.samples)
        allowed = speed * (took_s + 0.02 + 0.02) + 1e-3
        expect(
            moved <= allowed,
            f"{rounds * at_once} changes to {between.name.lower()} and back within {took_s:.3f} s moved the joint "
            f"by {moved:.4f} rad; {allowed:.4f} at most",
        )


@case("Nothing but a granted request for armed and an InfoRequest is followed by JointLimits.")
def reports_limits_for_nothing_else(bench: Bench) -> None:
    speed = bench.built_in(1, LimitKind.SPEED)
    host = bench.host

    def harmless() -> list[Message]:
        return [
            Ping(7),
            HostHeartbeat(host, 1),
            JointModeRequest(bench.token(), 1, JointMode.ACTIVE, 0.0, host),
            LimitRequest(bench.token(), 1, LimitKind.SPEED, speed, host),
            ClearRequest(bench.token(), 0, host),
            ModeRequest(bench.token(), Mode.ARMED, 0),
        ]

    for mode in Mode:
        bench.fresh()
        bench.enter(mode)
        requests = harmless()
        if mode in (Mode.STOPPED, Mode.FAULT):
            requests.append(ModeRequest(bench.token(), Mode.ARMED, host))
        if mode in (Mode.ARMED, Mode.HOLDING):
            requests += [ModeRequest(bench.token(), wanted, host) for wanted in (Mode.HOLDING, Mode.DISARMED)]
        else:
            requests.append(ModeRequest(bench.token(), Mode.DISARMED, host))
        bench.ping()
        bench.heard.clear()
        for request in requests:
            bench.send(request)
            bench.ping()
            said = any(isinstance(m, JointLimits) for m in bench.heard)
            expect(not said, f"{request} while {mode.name.lower()} was followed by JointLimits")


@case(
    "The limits of every joint are those it was built with, to half a step of the wire; so are rigid angles.",
    needs=("plate",),
)
def has_the_limits_on_its_plate(bench: Bench) -> None:
    plate = bench.lab.plate
    assert plate is not None
    if bench.reset is not None:  # a limit beyond the wire does not come back by a request
        bench.start_anew()
    reports = reports_of(bench, InfoRequest(bench.host))
    for joint, limits in enumerate(plate.limits, start=1):
        report = reports[joint]
        said = (report.angle_rad, report.speed_rad_s, report.acceleration_rad_s2)
        for kind, written, told in zip(LimitKind, limits, said, strict=True):
            steps = math.floor(min(written, MOST_LIMIT) / LIMIT_STEP + 0.5)
            for value in (told, bench.built_in(joint, kind)):
                expect(
                    round(value / LIMIT_STEP) == steps,
                    f"the {kind.name.lower()} limit of joint {joint} is {written:.5f}: it tells {told:.3f} and accepts "
                    f"up to {bench.built_in(joint, kind):.3f}",
                )
    for mode in (Mode.DISARMED, Mode.HOLDING):
        bench.enter(mode)
        for joint, limits in enumerate(plate.limits, start=1):
            bench.send(HostHeartbeat(bench.host, joint))
            _rigid_up_to(bench, joint, limits[0])


def _rigid_up_to(bench: Bench, joint: int, limit_rad: float) -> None:
    """The built-in angle limit, asked for as the wire has it, does not become one that is looser by its rounding."""
    bench.set_limit(joint, LimitKind.ANGLE, bench.built_in(joint, LimitKind.ANGLE))
    in_force = min(limit_rad, bench.built_in(joint, LimitKind.ANGLE))
    steps = math.floor(in_force / ANGLE_STEP_RAD + 0.5)
    for further, result in ((0, Result.OK), (1, Result.BAD_VALUE)):
        for side in (1.0, -1.0):
            answer = bench.set_joint_mode(joint, JointMode.RIGID, side * (steps + further) * ANGLE_STEP_RAD)
            expect(
                answer.result is result,
                f"angle limit {in_force:.6f} rad: rigid at {steps + further} steps was answered "
                f"{answer.result.name.lower()}",
            )
