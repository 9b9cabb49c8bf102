"""Requests: each acknowledged by its token, what is wrong found in the order of the page, what is refused not done."""

from __future__ import annotations

from collections.abc import Callable

from firmware_protocol.catalogue import (
    NOBODY,
    Acknowledge,
    ClearRequest,
    JointMode,
    JointModeRequest,
    LimitKind,
    LimitRequest,
    Message,
    Mode,
    ModeRequest,
    Result,
    TrimRequest,
    ZeroRequest,
    encode,
)
from firmware_protocol.frame import Frame
from snakebot.conformance.bench import LIMIT_STEP, Bench
from snakebot.conformance.case import case
from snakebot.conformance.lag import angles_of
from snakebot.conformance.violations import expect

Make = Callable[[int, int], Message]  # token, host


def _good(bench: Bench, joint: int) -> list[Make]:
    """One harmless request of each kind."""
    speed = bench.built_in(joint, LimitKind.SPEED)
    return [
        lambda token, host: ModeRequest(token, Mode.DISARMED, host),
        lambda token, host: JointModeRequest(token, joint, JointMode.ACTIVE, 0.0, host),
        lambda token, host: LimitRequest(token, joint, LimitKind.SPEED, speed, host),
        lambda token, host: TrimRequest(token, joint, 0.0, host),
        lambda token, host: ZeroRequest(token, joint, 0, host),
    ]


@case("Every token comes back, of every kind of request, for every joint.")
def returns_every_token(bench: Bench) -> None:
    for joint in range(1, bench.joints + 1):
        for number, make in enumerate(_good(bench, joint)):
            for token in (0, 255, 1 << (joint + number) % 8):
                answer = bench.ask(make(token, bench.host))
                wanted = (token, Result.OK, encode(make(token, 1)).id, Mode.DISARMED, 0, bench.host)
                seen = (answer.token, answer.result, answer.request, answer.mode, answer.detail, answer.host)
                expect(seen == wanted, f"{make(token, bench.host)} was answered {answer}")


@case("Each request is acknowledged once, and as often as it comes.")
def acknowledges_each_request(bench: Bench) -> None:
    makes: list[Make] = [*_good(bench, 1), lambda token, host: ClearRequest(token, 0, host)]
    for make in makes:
        for times in (1, 3):
            bench.heard.clear()
            token = bench.token()
            bench.send(*[make(token, bench.host)] * times)
            bench.ping()
            answers = [m for m in bench.heard if isinstance(m, Acknowledge)]
            expect(
                len(answers) == times and all(a == answers[0] for a in answers),
                f"{make(token, 1)} was sent {times} times and answered {answers}",
            )


@case("Host 0 is bad_value in every kind of request, in every mode that nobody holds.")
def refuses_nobodys_requests(bench: Bench) -> None:
    for mode in (Mode.DISARMED, Mode.STOPPED, Mode.FAULT):
        makes = _good(bench, bench.joints)
        bench.fresh()
        bench.enter(mode)
        for make in makes:
            answer = bench.ask(make(bench.token(), NOBODY))
            expect(
                (answer.result, answer.mode, answer.detail) == (Result.BAD_VALUE, mode, 0),
                f"{make(0, 0)} while {mode.name.lower()} was answered {answer}",
            )
        for wanted in (Mode.ARMED, Mode.HOLDING):
            answer = bench.go(wanted, NOBODY)
            expect(answer.result is Result.BAD_VALUE, f"host 0 asked for {wanted.name.lower()}: {answer}")
        bench.fresh() if mode is Mode.DISARMED else expect(
            bench.beat().mode is mode, "host 0 changed the mode"
        )


@case("What is wrong is found in this order: held, bad_joint, bad_value, forbidden.")
def finds_errors_in_order(bench: Bench) -> None:
    built_in = {kind: bench.built_in(1, kind) for kind in LimitKind}
    host, other, none = bench.host, bench.other, bench.joints
    beyond = built_in[LimitKind.SPEED] + 2 * LIMIT_STEP

    def no_joint(message: Message) -> Frame:
        frame = encode(message)
        data = bytearray(frame.data)
        data[1] &= 0xE0
        return Frame(frame.id, bytes(data))

    wrong: list[Callable[[int], list[Message]]] = [
        lambda h: [JointModeRequest(bench.token(), 1, JointMode.RIGID, 3.2, h)],
        lambda h: [LimitRequest(bench.token(), 1, kind, 0.0, h) for kind in LimitKind],
        lambda h: [LimitRequest(bench.token(), 1, LimitKind.SPEED, beyond, h)],
        lambda h: [TrimRequest(bench.token(), 1, 3.2, h)],
    ]
    table: list[tuple[Mode, int, bool, Result, int]] = [
        (Mode.HOLDING, other, True, Result.HELD, 0),
        (Mode.HOLDING, other, False, Result.HELD, 0),
        (Mode.HOLDING, NOBODY, True, Result.HELD, 0),
        (Mode.HOLDING, host, True, Result.BAD_JOINT, none),
        (Mode.HOLDING, host, False, Result.BAD_VALUE, 0),
        (Mode.STOPPED, NOBODY, True, Result.BAD_JOINT, none),
        (Mode.STOPPED, other, True, Result.BAD_JOINT, none),
        (Mode.STOPPED, host, False, Result.BAD_VALUE, 0),
        (Mode.FAULT, host, False, Result.BAD_VALUE, 0),
        (Mode.FAULT, other, True, Result.BAD_JOINT, none),
        (Mode.DISARMED, host, False, Result.BAD_VALUE, 0),
        (Mode.DISARMED, NOBODY, True, Result.BAD_JOINT, none),
    ]
    for mode, who, without_joint, result, detail in table:
        bench.fresh()
        bench.enter(mode)
        for make in wrong:
            for message in make(who):
                frame = no_joint(message) if without_joint else encode(message)
                bench.send_frames([frame])
                answer = bench.wait(Acknowledge, 0.5, token=frame.data[0])
                expect(
                    (answer.result, answer.mode, answer.detail, answer.host) == (result, mode, detail, who),
                    f"{message}{' without a joint' if without_joint else ''} while {mode.name.lower()}: {answer}",
                )


@case(
    "Stopped or in fault, requests for joints, limits, trims and zeros of any host are forbidden, and do nothing."
)
def does_nothing_that_is_forbidden(bench: Bench) -> None:
    for joint in range(1, bench.joints + 1):
        for kind in LimitKind:
            bench.built_in(joint, kind)
    for mode in (Mode.STOPPED, Mode.FAULT):
        bench.fresh()
        bench.enter(mode)
        for joint in range(1, bench.joints + 1):
            for host in (bench.host, bench.other):
                requests: list[Message] = [
                    JointModeRequest(bench.token(), joint, JointMode.FREE, 0.0, host),
                    JointModeRequest(bench.token(), joint, JointMode.RIGID_HERE, 0.0, host),
                    JointModeRequest(bench.token(), joint, JointMode.RIGID, 0.0, host),
                    TrimRequest(bench.token(), joint, 0.2, host),
                    ZeroRequest(bench.token(), joint, 500, host),
                    *(LimitRequest(bench.token(), joint, kind, LIMIT_STEP, host) for kind in LimitKind),
                ]
                for request in requests:
                    answer = bench.ask(request)
                    expect(
                        (answer.result, answer.mode, answer.detail) == (Result.FORBIDDEN, mode, 0),
                        f"{request} while {mode.name.lower()} was answered {answer}",
                    )
        bench.make_safe()
        moves_freely(bench, f"after requests while {mode.name.lower()}")


@case("Armed or holding, trims and zeros are forbidden, and do nothing.")
def trims_only_while_disarmed(bench: Bench) -> None:
    for mode in (Mode.ARMED, Mode.HOLDING):
        bench.fresh()
        bench.enter(mode)
        for joint in range(1, bench.joints + 1):
            if mode is Mode.ARMED:
                bench.fresh()
                bench.enter(mode)
            requests = (
                TrimRequest(bench.token(), joint, 0.2, bench.host),
                ZeroRequest(bench.token(), joint, 500, bench.host),
            )
            for request in requests:
                answer = bench.ask(request)
                expect(
                    (answer.result, answer.mode, answer.detail) == (Result.FORBIDDEN, mode, 0),
                    f"{request} while {mode.name.lower()} was answered {answer}",
                )
        bench.fresh()
        moves_freely(bench, f"after requests while {mode.name.lower()}")


def moves_freely(bench: Bench, when: str) -> None:
    """Every joint follows the set-points, at full limits, without a trim, from the zero that it had."""
    bench.samples.clear()
    here = bench.arm()
    side = [-1.0 if angle > 0 else 1.0 for angle in here]
    goals = [round(angle + s * bench.nudge_rad, 4) for angle, s in zip(here, side, strict=True)]
    sample = bench.stand_at(goals, 0.4, "the stream")
    for joint, (applied, measured, goal) in enumerate(
        zip(sample.applied_rad, angles_of(bench, sample), goals, strict=True), start=1
    ):
        expect(
            abs(applied - goal) < 3e-4, f"{when}: joint {joint} was applied {applied:.4f} rad, not {goal:.4f}"
        )
        expect(
            abs(measured - goal) < bench.nudge_rad / 2,
            f"{when}: joint {joint} is {measured - goal:.3f} rad off",
        )
    bench.make_safe()
