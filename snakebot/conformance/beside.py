"""What a host sends beside its set-points changes nothing of them; what was set stays, whatever stops the board."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from firmware_protocol.assembly import setpoint_messages
from firmware_protocol.catalogue import (
    LATCHES,
    Acknowledge,
    ClearRequest,
    HostHeartbeat,
    InfoRequest,
    JointMode,
    JointModeRequest,
    Latch,
    LimitKind,
    LimitRequest,
    Message,
    Mode,
    ModeRequest,
    Ping,
    Result,
    TrimRequest,
    ZeroRequest,
)
from snakebot.conformance.bench import LIMIT_STEP, Bench
from snakebot.conformance.case import case
from snakebot.conformance.lag import angles_of
from snakebot.conformance.limits import reports_of
from snakebot.conformance.limits_tape import play
from snakebot.conformance.requests import moves_freely
from snakebot.conformance.rule import Limits, arm_finely, set_all, slow_limits
from snakebot.conformance.violations import expect

_RELAXED_S = 2.1  # a fault has relaxed: 2 s (PROTOCOL.md), and what a main loop may be late


def _asides(bench: Bench, limits: list[Limits], number: int) -> list[list[Message]]:
    """Everything that may come between two set-points of an armed board and changes nothing of the second one."""
    joint, token, host, other = number % bench.joints + 1, bench.token(), bench.host, bench.other
    wrong = setpoint_messages((bench.sequence + 1) & 0xFFFF, [0.0] * bench.joints, 0.01)
    latch = wrong[-1]
    assert isinstance(latch, Latch)
    stale = [(bench.sequence - back) & 0xFFFF for back in (0, 1, 4000)]
    return [
        [JointModeRequest(token, joint, JointMode.ACTIVE, 0.0, host)],
        [LimitRequest(token, joint, kind, limits[joint - 1][kind], host) for kind in LimitKind],
        [ModeRequest(token, Mode.ARMED, host)],
        [InfoRequest(host), Ping(number)],
        [HostHeartbeat(host, number & 0xFFFF), HostHeartbeat(other, number & 0xFFFF)],
        [ClearRequest(token, latch_number, host) for latch_number in range(LATCHES)],
        [TrimRequest(token, joint, 0.1, host), ZeroRequest(token, joint, 99, host)],
        [ModeRequest(token, mode, other) for mode in (Mode.DISARMED, Mode.HOLDING, Mode.ARMED)],
        [JointModeRequest(token, joint, mode, 0.0, other) for mode in JointMode],
        [LimitRequest(token, joint, kind, LIMIT_STEP, other) for kind in LimitKind],
        [LimitRequest(token, joint, kind, 0.0, host) for kind in LimitKind],
        [ModeRequest(token, Mode.STOPPED, host), ModeRequest(token, Mode.FAULT, host)],
        [*wrong[:-1], replace(latch, crc32=latch.crc32 ^ 1)],
        *([*setpoint_messages(number, [0.0] * bench.joints, 0.1)] for number in stale),
    ]


@case(
    "Whatever else comes between two set-points, requests, questions, stale and wrong ones, the rule gives it no time."
)
def nothing_beside_changes_the_rule(bench: Bench) -> None:
    here = bench.sample().applied_rad
    limits = [slow_limits(bench, joint, angle, 1) for joint, angle in enumerate(here, start=1)]
    set_all(bench, limits)

    def aside(number: int) -> None:
        if number > 1:  # the first one after arming is always newer
            asides = _asides(bench, limits, number)
            bench.send(*asides[number % len(asides)])

    play(bench, arm_finely(bench), limits, 4 * bench.nudge_rad, 160, 12, before_each=aside)


@case(
    "A joint that is made free, rigid and active again in mid-motion changes nothing of the rule for the others."
)
def one_joints_mode_is_no_others(bench: Bench) -> None:
    for apart in sorted({1, bench.joints} if bench.joints > 1 else ()):
        bench.fresh()
        here = bench.sample().applied_rad
        limits = [slow_limits(bench, joint, angle, 4) for joint, angle in enumerate(here, start=1)]
        set_all(bench, limits)
        modes = (JointMode.FREE, JointMode.ACTIVE, JointMode.RIGID_HERE, JointMode.ACTIVE)

        def turn(number: int, apart: int = apart, modes: Sequence[JointMode] = modes) -> None:
            if number % 5 == 4:
                bench.set_joint_mode(apart, modes[number // 5 % len(modes)])

        play(bench, arm_finely(bench), limits, 4 * bench.nudge_rad, 90, 12, before_each=turn, but_joint=apart)


@case("Every request is done, whatever its token: the one before may have had the same.")
def tokens_mean_nothing(bench: Bench) -> None:
    token = bench.token()
    for mode in (Mode.ARMED, Mode.HOLDING, Mode.ARMED, Mode.DISARMED):
        bench.send(ModeRequest(token, mode, bench.host))
        answer = bench.wait(Acknowledge, token=token)
        expect(answer.mode is mode, f"{mode.name.lower()} was asked for with the token before: {answer}")
    built_in = bench.built_in(1, LimitKind.SPEED)
    for share in (1.0, 0.5, 1.0):
        wanted = share * built_in
        on_the_wire = round(wanted / LIMIT_STEP) * LIMIT_STEP
        bench.send(LimitRequest(token, 1, LimitKind.SPEED, on_the_wire, bench.host))
        told = reports_of(bench, InfoRequest(bench.host))[1].speed_rad_s
        expect(
            abs(told - wanted) < 1.01 * LIMIT_STEP,
            f"a limit of {wanted:.3f} was asked for with the token before, {told:.3f} is in force",
        )


@case("What is answered held, or bad_value, is not done: no joint mode, limit, trim or zero, of any joint.")
def does_nothing_that_is_refused(bench: Bench) -> None:
    for joint in range(1, bench.joints + 1):
        for kind in LimitKind:
            bench.built_in(joint, kind)
    before = reports_of(bench, InfoRequest(bench.host))
    for mode in (Mode.ARMED, Mode.HOLDING, Mode.DISARMED):
        result = Result.BAD_VALUE if mode is Mode.DISARMED else Result.HELD
        bench.fresh()
        bench.enter(mode)
        for joint in range(1, bench.joints + 1):
            if mode is Mode.ARMED:  # the watchdog runs meanwhile
                bench.fresh()
                bench.enter(mode)
            bench.send(HostHeartbeat(bench.host, joint))
            for request in _held(bench, joint) if result is Result.HELD else _bad(bench, joint):
                answer = bench.ask(request)
                expect(
                    (answer.result, answer.mode) == (result, mode),
                    f"{request} while {mode.name.lower()} was answered {answer}",
                )
        bench.make_safe()
        when = f"after requests that were {result.name.lower()} while {mode.name.lower()}"
        expect(reports_of(bench, InfoRequest(bench.host)) == before, f"{when} the limits are others")
        moves_freely(bench, when)


def _held(bench: Bench, joint: int) -> list[Message]:
    """All that another host could set of a joint."""
    other = bench.other
    return [
        *(JointModeRequest(bench.token(), joint, mode, 0.0, other) for mode in JointMode if mode),
        *(LimitRequest(bench.token(), joint, kind, LIMIT_STEP, other) for kind in LimitKind),
        TrimRequest(bench.token(), joint, 0.2, other),
        ZeroRequest(bench.token(), joint, 500, other),
    ]


def _bad(bench: Bench, joint: int) -> list[Message]:
    """All that nobody can set of a joint."""
    host = bench.host
    requests: list[Message] = [LimitRequest(bench.token(), joint, kind, 0.0, host) for kind in LimitKind]
    if bench.built_in(joint, LimitKind.ANGLE) < 3.2:
        requests += [JointModeRequest(bench.token(), joint, JointMode.RIGID, a, host) for a in (3.2, -3.2)]
    return [*requests, *(TrimRequest(bench.token(), joint, trim, host) for trim in (0.3001, -0.3001, 3.2767))]


def _ways_out(bench: Bench) -> dict[str, Callable[[], None]]:
    """From disarmed through power, a stop or a fault, and back to disarmed."""

    def stopped_while(mode: Mode) -> Callable[[], None]:
        def way() -> None:
            bench.enter(mode)
            bench.stop()
            bench.make_safe()

        return way

    def fault(relaxes: bool) -> Callable[[], None]:
        def way() -> None:
            bench.enter(Mode.FAULT)
            if relaxes:
                bench.listen(_RELAXED_S)
            bench.make_safe()

        return way

    def disarmed() -> None:
        bench.enter(Mode.HOLDING)
        bench.must_go(Mode.DISARMED)

    ways = {
        f"stopped while {mode.name.lower()}": stopped_while(mode) for mode in Mode if mode is not Mode.STOPPED
    }
    return {"disarmed": disarmed, **ways, "a fault": fault(False), "a fault that relaxed": fault(True)}


@case(
    "Limits and joint modes stay as they were set through disarming, stops, faults and clears: each joint's."
)
def what_is_set_stays_set(bench: Bench) -> None:
    for odd in (0, 1):
        bench.fresh()
        here = bench.sample().applied_rad
        limits = [slow_limits(bench, joint, angle, 2) for joint, angle in enumerate(here, start=1)]
        set_all(bench, limits)
        before = reports_of(bench, InfoRequest(bench.host))
        free = [joint % 2 == odd for joint in range(1, bench.joints + 1)]
        for joint, is_free in enumerate(free, start=1):
            answer = bench.set_joint_mode(joint, JointMode.FREE if is_free else JointMode.RIGID_HERE)
            expect(answer.result is Result.OK, f"a joint mode was answered {answer}")
        for name, way in _ways_out(bench).items():
            way()
            expect(
                reports_of(bench, InfoRequest(bench.host)) == before,
                f"after {name} other limits are in force",
            )
            _stays(bench, free, f"after {name}")


def _stays(bench: Bench, free: list[bool], when: str) -> None:
    """No joint follows a set-point: one is free, or rigid where it is."""
    bench.listen(0.11)  # an unasked sample: joints without power are where their encoders say
    bench.samples.clear()
    here = bench.arm()
    was = angles_of(bench, bench.samples[-1])
    goal = [angle + (bench.nudge_rad if angle < 0 else -bench.nudge_rad) for angle in here]
    sample = bench.stand_at(goal, 0.2, "a stream with free and rigid joints")
    for joint, is_free in enumerate(free, start=1):
        at, told = angles_of(bench, sample)[joint - 1], sample.applied_rad[joint - 1]
        moved = abs(at - was[joint - 1]) if is_free else abs(told - here[joint - 1])
        expect(
            moved < bench.nudge_rad / 4,
            f"{when} joint {joint}, {'free' if is_free else 'rigid'} before, followed a set-point by {moved:.3f} rad",
        )
    bench.must_go(Mode.DISARMED)
