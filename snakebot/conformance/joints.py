"""Joint modes, trims and zeros."""

from __future__ import annotations

from collections.abc import Callable

from firmware_protocol.catalogue import (
    MAX_TRIM_RAD,
    Acknowledge,
    JointMode,
    JointModeRequest,
    LimitKind,
    LimitRequest,
    Message,
    Mode,
    Result,
    TrimRequest,
    ZeroRequest,
    encode,
)
from firmware_protocol.frame import Frame
from snakebot.conformance.bench import Bench
from snakebot.conformance.case import case
from snakebot.conformance.lag import at_rest
from snakebot.conformance.violations import NotApplicableError, expect

Make = Callable[[int, int, int], Message]  # token, joint, host


def _requests(bench: Bench) -> list[Make]:
    """One harmless request of each kind."""
    speed = bench.built_in(1, LimitKind.SPEED)
    return [
        lambda token, joint, host: JointModeRequest(token, joint, JointMode.ACTIVE, 0.0, host),
        lambda token, joint, host: LimitRequest(token, joint, LimitKind.SPEED, speed, host),
        lambda token, joint, host: TrimRequest(token, joint, 3.2, host),
        lambda token, joint, host: ZeroRequest(token, joint, 0, host),
    ]


@case(
    "A joint that the board does not have is bad_joint, with the number of joints; another host's is held first."
)
def knows_its_joints(bench: Bench) -> None:
    makes = _requests(bench)
    for mode in (Mode.DISARMED, Mode.STOPPED):
        bench.fresh()
        bench.enter(mode)
        for make in makes:
            for joint in {0, bench.joints + 1, 31}:
                frame = encode(make(bench.token(), 1, bench.host))
                data = bytearray(frame.data)
                data[1] = data[1] & 0xE0 | joint
                bench.send_frames([Frame(frame.id, bytes(data))])
                answer = bench.wait(Acknowledge, 0.5, token=data[0])
                expect(
                    (answer.result, answer.detail) == (Result.BAD_JOINT, bench.joints),
                    f"{type(make(0, 1, 1)).__name__} for joint {joint} was answered {answer}",
                )
    bench.fresh()
    bench.enter(Mode.HOLDING)
    for make in makes:
        answer = bench.ask(make(bench.token(), min(bench.joints + 1, 16), bench.other))
        expect(
            (answer.result, answer.mode) == (Result.HELD, Mode.HOLDING),
            f"another host's {type(make(0, 1, 1)).__name__} was answered {answer}",
        )


@case("Which request is possible in which mode: the others are forbidden, with the mode.")
def forbids_by_mode(bench: Bench) -> None:
    makes = _requests(bench)
    for mode in (Mode.ARMED, Mode.HOLDING, Mode.STOPPED, Mode.FAULT):
        for make in makes:
            if isinstance(make(0, 1, 1), TrimRequest):
                make = _small_trim
            kind = type(make(0, 1, 1))
            bench.fresh()
            bench.enter(mode)
            answer = bench.ask(make(bench.token(), 1, bench.host))
            possible = mode in (Mode.ARMED, Mode.HOLDING) and kind in (JointModeRequest, LimitRequest)
            wanted = Result.OK if possible else Result.FORBIDDEN
            expect(
                (answer.result, answer.mode) == (wanted, mode),
                f"{kind.__name__} while {mode.name.lower()} was answered {answer.result.name.lower()} "
                f"(detail {answer.detail}), not {wanted.name.lower()}",
            )


def _small_trim(token: int, joint: int, host: int) -> Message:
    return TrimRequest(token, joint, 0.0, host)


@case(
    "An angle beyond the joint's limit, a trim beyond 0.3 rad, and host 0 are bad_value; that goes before forbidden."
)
def refuses_bad_values(bench: Bench) -> None:
    limit = bench.built_in(1, LimitKind.ANGLE)
    beyond = limit + 0.01
    for mode in (Mode.DISARMED, Mode.STOPPED):
        bench.fresh()
        bench.enter(mode)
        requests: list[Message] = [JointModeRequest(bench.token(), 1, JointMode.FREE, 0.0, 0)]
        requests += [TrimRequest(bench.token(), 1, 0.0, 0), ZeroRequest(bench.token(), 1, 0, 0)]
        if beyond < 3.27:
            requests.append(JointModeRequest(bench.token(), 1, JointMode.RIGID, beyond, bench.host))
            requests.append(JointModeRequest(bench.token(), 1, JointMode.RIGID, -beyond, bench.host))
        for trim in (MAX_TRIM_RAD + 1e-4, -MAX_TRIM_RAD - 1e-4, 3.2767):
            requests.append(TrimRequest(bench.token(), 1, trim, bench.host))
        for request in requests:
            answer = bench.ask(request)
            expect(
                (answer.result, answer.mode) == (Result.BAD_VALUE, mode), f"{request} was answered {answer}"
            )


@case("A trim of 0.3 rad is the most, for each joint, on either side; one step more is bad_value.")
def bounds_the_trim_of_each_joint(bench: Bench) -> None:
    for joint in range(1, bench.joints + 1):
        asked = [(MAX_TRIM_RAD + 1e-4, Result.BAD_VALUE), (-MAX_TRIM_RAD - 1e-4, Result.BAD_VALUE)]
        if bench.simulated:  # a trim cannot be read back: on a real robot it is left alone
            asked += [(MAX_TRIM_RAD, Result.OK), (-MAX_TRIM_RAD, Result.OK), (0.0, Result.OK)]
        for trim, wanted in asked:
            answer = bench.ask(TrimRequest(bench.token(), joint, trim, bench.host))
            expect(answer.result is wanted, f"a trim of {trim} rad, joint {joint}, was answered {answer}")


@case("A rigid joint goes to its angle under the limiter and stays, whatever the set-points say.")
def rigid_goes_and_stays(bench: Bench) -> None:
    here = bench.arm()
    goal = round(here[0] + (bench.nudge_rad if here[0] < 0 else -bench.nudge_rad), 4)
    answer = bench.set_joint_mode(1, JointMode.RIGID, goal)
    expect(answer.result is Result.OK, f"rigid was answered {answer}")
    first = bench.executed(here, "the first one with a rigid joint").applied_rad[0]
    expect(abs(first - here[0]) < bench.nudge_rad, "a rigid joint jumped to its angle")
    last = bench.stand_at(here, 0.6, "the stream with a rigid joint")
    expect(
        abs(last.applied_rad[0] - goal) < 2e-4,
        f"the rigid joint is at {last.applied_rad[0]:.4f} rad, not {goal}",
    )
    others = max((abs(a - b) for a, b in zip(last.applied_rad[1:], here[1:], strict=True)), default=0.0)
    expect(others < 2e-4, f"the other joints moved by {others:.4f} rad")


@case("rigid_here stays at the applied angle; its angle is not looked at.")
def rigid_here_stays(bench: Bench) -> None:
    here = bench.arm()
    bench.executed(here, "the first one")
    answer = bench.set_joint_mode(bench.joints, JointMode.RIGID_HERE, 3.2)
    expect(answer.result is Result.OK, f"rigid_here was answered {answer}")
    there = [angle + (0.02 if angle < 0 else -0.02) for angle in here]
    last = bench.stand_at(there, 0.4, "the stream with a rigid joint")
    off = abs(last.applied_rad[-1] - here[-1])
    expect(off < 3e-4, f"the joint that was to stay went by {off:.4f} rad")


@case("A free joint's register follows its encoder; active again, it starts from where the joint is.")
def free_follows_the_encoder(bench: Bench) -> None:
    here = bench.arm()
    way = bench.nudge_rad if here[0] < 0 else -bench.nudge_rad
    bench.stream(0.1, lambda t: [here[0] + way * t / 0.1, *here[1:]])  # a servo lags behind its set-point
    expect(bench.set_joint_mode(1, JointMode.FREE).result is Result.OK, "free was refused while armed")
    sample = bench.executed([here[0] + way, *here[1:]], "the first one with a free joint", 0.005)
    measured = sample.measured_counts[0]
    if measured is None:
        raise NotApplicableError("joint 1 has no encoder reading")
    off = abs(sample.applied_rad[0] - measured * bench.rad_per_count)
    expect(off <= bench.rad_per_count + 1e-4, f"a free joint's register is {off:.4f} rad off its encoder")
    expect(bench.set_joint_mode(1, JointMode.ACTIVE).result is Result.OK, "active was refused while armed")
    after = bench.executed(
        [sample.applied_rad[0], *here[1:]], "the first one of a joint that is active again"
    )
    jump = abs(after.applied_rad[0] - sample.applied_rad[0])
    expect(jump < 0.02, f"a joint that became active jumped by {jump:.3f} rad")


@case("Joint modes survive disarming.")
def joint_modes_survive_disarming(bench: Bench) -> None:
    expect(
        bench.set_joint_mode(1, JointMode.RIGID_HERE).result is Result.OK,
        "rigid_here was refused while disarmed",
    )
    here = bench.arm()
    bench.must_go(Mode.DISARMED)
    bench.samples.clear()
    here = bench.arm()
    there = [here[0] + (0.02 if here[0] < 0 else -0.02), *here[1:]]
    last = bench.stand_at(there, 0.2, "the stream")
    expect(
        abs(last.applied_rad[0] - here[0]) < 1e-3,
        "a rigid joint moved after the board was disarmed and armed again",
    )


_RAMP_RAD = 1e-3  # a tick of 10 ms: slow enough for any robot, and a joint that lags by 10 ms is told from its register
_RAMP_TICKS = 40


@case(
    "While a joint is free the register of the others goes where set-points send it, not where the joints are."
)
def others_keep_their_register(bench: Bench) -> None:
    for free in range(1, bench.joints + 1):
        bench.fresh()
        goal = bench.arm()
        expect(bench.set_joint_mode(free, JointMode.FREE).result is Result.OK, "free was refused")
        way = [-_RAMP_RAD if angle > 0 else _RAMP_RAD for angle in goal]
        for _ in range(_RAMP_TICKS):
            goal = [angle + step for angle, step in zip(goal, way, strict=True)]
            sample = bench.executed(goal, "one of a slow ramp")
            bench.listen(0.01)
        for joint, (applied, angle) in enumerate(zip(sample.applied_rad, goal, strict=True), start=1):
            off = abs(applied - angle) if joint != free else 0.0
            expect(
                off < 2e-4,
                f"joint {free} is free, and the register of joint {joint} {off:.4f} rad off its set-point",
            )


@case("Arming starts the register at the measured angles: nothing jumps.")
def arms_where_the_joints_are(bench: Bench) -> None:
    here = bench.arm()
    sample = bench.executed(here, "the first one after arming")
    for joint, (counts, applied) in enumerate(
        zip(sample.measured_counts, sample.applied_rad, strict=True), start=1
    ):
        if counts is not None:
            off = abs(applied - counts * bench.rad_per_count)
            expect(off < 0.02, f"joint {joint} was armed {off:.3f} rad from where it is")


@case("ZeroRequest: counts are relative to the zero from then on.")
def shifts_the_zero(bench: Bench) -> None:
    before = at_rest(bench).measured_counts[0]  # one that moved would leave a wrong zero behind
    if before is None or abs(before) > 30_000:
        raise NotApplicableError("joint 1 has no encoder reading")

    def reading_with_zero(zero: int) -> int:
        answer = bench.ask(ZeroRequest(bench.token(), 1, zero, bench.host))
        expect(answer.result is Result.OK, f"ZeroRequest was answered {answer}")
        counts = at_rest(bench).measured_counts[0]
        expect(counts is not None, "no reading after a ZeroRequest")
        assert counts is not None
        return counts

    raw = reading_with_zero(0)
    try:
        shifted = reading_with_zero(100)
        expect(abs(shifted - (raw - 100)) <= 2, f"zero 100 took the reading from {raw} to {shifted}")
    finally:
        reading_with_zero(raw - before)  # as it was
