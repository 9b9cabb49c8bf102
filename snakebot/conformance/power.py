"""Which joint has power when, seen through what the joint does. Every joint, both sides."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from firmware_protocol.catalogue import BoardHeartbeat, Fault, FaultEvent, JointMode, Mode, Result
from snakebot.conformance.bench import Bench
from snakebot.conformance.case import case
from snakebot.conformance.lag import (
    Thrown,
    angles_of,
    at_rest,
    expect_no_power,
    expect_power,
    throw,
    throw_from,
    went_on,
)
from snakebot.conformance.violations import NotApplicableError, expect

_SIDES = (1.0, -1.0)  # sign of the turn: either way
_LATER_S = 0.035  # after the last set-point; chosen: with the throw, less than from one heartbeat to the next
_LEAST_WAY = 0.2  # of its way, that a simulated joint goes in that time


def _all(bench: Bench, powered: bool) -> list[bool]:
    return [powered] * bench.joints


def _hold(bench: Bench, mode: Mode) -> None:
    if mode is Mode.HOLDING:
        bench.must_go(Mode.HOLDING)


@case("Emergency stop takes the power of every joint at once, from armed and from holding.")
def stop_takes_all_power(bench: Bench) -> None:
    for mode in (Mode.ARMED, Mode.HOLDING):

        def stop(mode: Mode = mode) -> None:
            _hold(bench, mode)
            bench.stop()

        when = f"after an emergency stop while {mode.name.lower()}"
        expect_no_power(bench, stop, when)
        expect(bench.beat().powered == 0, f"{when} the heartbeat says that there is power")


@case("Disarming takes the power of every joint at once, from armed and from holding.")
def disarming_takes_all_power(bench: Bench) -> None:
    for mode in (Mode.ARMED, Mode.HOLDING):

        def disarm(mode: Mode = mode) -> None:
            _hold(bench, mode)
            bench.must_go(Mode.DISARMED)

        expect_no_power(bench, disarm, f"disarmed while {mode.name.lower()}")


@case("Rigid joints lose their power as the others do: stopped or disarmed, from armed and from holding.")
def rigid_joints_lose_their_power(bench: Bench) -> None:
    for mode in (Mode.ARMED, Mode.HOLDING):
        for stops in (True, False):
            for kind in (JointMode.RIGID, JointMode.RIGID_HERE):

                def take(mode: Mode = mode, stops: bool = stops, kind: JointMode = kind) -> None:
                    for joint, angle in enumerate(bench.samples[-1].applied_rad, start=1):
                        answer = bench.set_joint_mode(joint, kind, angle)
                        expect(answer.result is Result.OK, f"{kind.name.lower()} was answered {answer}")
                    _hold(bench, mode)
                    if stops:
                        bench.stop()
                    else:
                        bench.must_go(Mode.DISARMED)

                how = "stopped" if stops else "disarmed"
                expect_no_power(bench, take, f"{kind.name.lower()} and {how} while {mode.name.lower()}")


@case("Holding keeps the power of every joint: it goes on to the set-point that it has.")
def holding_keeps_power(bench: Bench) -> None:
    for side in _SIDES:
        bench.fresh()
        thrown = throw(bench, side)
        for _ in range(2):  # asked for once more it changes nothing
            bench.must_go(Mode.HOLDING)
        expect_power(went_on(bench, thrown), _all(bench, True), "holding")
        expect(bench.beat().powered == 1, "the heartbeat of a holding board says that there is no power")


@case("A joint that is made free loses its power, and no other joint does: each joint, armed and holding.")
def freeing_takes_one_joints_power(bench: Bench) -> None:
    for joint in range(1, bench.joints + 1):
        for mode, side in ((Mode.ARMED, 1.0), (Mode.HOLDING, -1.0)):
            bench.fresh()
            thrown = throw(bench, side)
            _hold(bench, mode)
            expect(
                bench.set_joint_mode(joint, JointMode.FREE).result is Result.OK,
                f"free joint {joint}: refused",
            )
            powered = [other != joint for other in range(1, bench.joints + 1)]
            expect_power(
                went_on(bench, thrown), powered, f"joint {joint} made free while {mode.name.lower()}"
            )


@case("A joint that was made free before arming gets no power; active again, it does at once.")
def free_joints_get_no_power(bench: Bench) -> None:
    for joint in range(1, bench.joints + 1):
        bench.fresh()
        expect(
            bench.set_joint_mode(joint, JointMode.FREE).result is Result.OK, f"free joint {joint}: refused"
        )
        for powered in (False, True):
            before = angles_of(bench, bench.sample())
            here = bench.arm()
            bench.must_go(Mode.HOLDING)
            bench.must_go(Mode.ARMED)
            if powered:
                answer = bench.set_joint_mode(joint, JointMode.ACTIVE)
                expect(answer.result is Result.OK, f"active again, joint {joint}: {answer}")
            side = -1.0 if before[joint - 1] > 0 else 1.0
            goal = [angle + side * bench.nudge_rad for angle in here]
            now = angles_of(bench, bench.stand_at(goal, 0.3, "a stream with a free joint"))
            shares = [side * (b - a) / bench.nudge_rad for a, b in zip(before, now, strict=True)]
            wanted = [powered or other != joint for other in range(1, bench.joints + 1)]
            expect_power(
                shares, wanted, f"joint {joint} " + ("active again" if powered else "free before arming")
            )
            bench.must_go(Mode.DISARMED)
            bench.samples.clear()
            bench.listen(0.2)


@case("Each joint moves where its own set-point sends it, to either side, and no other joint does.")
def moves_each_joint(bench: Bench) -> None:
    for joint in range(bench.joints):
        bench.fresh()
        here = bench.arm()
        for side in _SIDES:
            goal = list(here)
            goal[joint] += side * bench.nudge_rad
            goal[joint] = round(goal[joint], 4)
            sample = bench.stand_at(goal, 0.3, "a stream that moves one joint")
            for other, (angle, wanted) in enumerate(zip(sample.applied_rad, goal, strict=True)):
                expect(
                    abs(angle - wanted) < 3e-4,
                    f"joint {other + 1} was applied {angle:.4f} rad, not {wanted:.4f}",
                )
            for other, (angle, wanted) in enumerate(zip(angles_of(bench, sample), goal, strict=True)):
                off = abs(angle - wanted)
                expect(
                    off < bench.nudge_rad / 2,
                    f"joint {joint + 1} was sent to {goal[joint]:.3f} rad: joint {other + 1} is {off:.3f} rad off",
                )


@case("Arming starts every joint from where it is: after a stop in mid-motion nothing jumps.")
def arms_in_mid_motion(bench: Bench) -> None:
    for side in _SIDES:
        bench.fresh()
        throw(bench, side)
        bench.stop()
        bench.make_safe()
        before = angles_of(bench, at_rest(bench))
        bench.samples.clear()
        here = bench.arm()
        sample = bench.executed(here, "the first one after arming")
        after = angles_of(bench, bench.stand_at(here, 0.1, "the stream"))
        for joint in range(bench.joints):
            off = abs(sample.applied_rad[joint] - before[joint])
            expect(
                off < bench.rad_per_count + 2e-4,
                f"joint {joint + 1} was armed {off:.4f} rad from where it is",
            )
            jump = abs(after[joint] - before[joint])
            expect(jump < 0.01, f"joint {joint + 1} jumped by {jump:.3f} rad when the board was armed")


@case(
    "Without power the register follows the encoders, with power it does not: frozen for 2 s, then relaxed."
)
def relaxed_joints_follow_their_encoders(bench: Bench) -> None:
    count = bench.rad_per_count
    if count < 6e-4:
        raise NotApplicableError("the encoders are too fine to tell a reading from a set-point")
    here = bench.arm()
    between = [
        round((round(angle / count) + 0.5) * count, 4) for angle in here
    ]  # an angle that no encoder reads
    bench.stand_at(between, 0.2, "the stream")
    bench.wait(FaultEvent, code=Fault.WATCHDOG)
    bench.samples.clear()
    frozen = bench.sample().applied_rad
    off = max(abs(a - b) for a, b in zip(frozen, between, strict=True))
    expect(off < 2e-4, f"the register moved by {off:.4f} rad when the joints froze")
    bench.listen(2.15)
    bench.samples.clear()
    relaxed = bench.sample()
    for joint, (applied, angle) in enumerate(
        zip(relaxed.applied_rad, angles_of(bench, relaxed), strict=True), 1
    ):
        expect(
            abs(applied - angle) < 1.5e-4,
            f"2.2 s after the fault the register of joint {joint} does not follow its encoder: it still has power",
        )


def _throw_after_a_heartbeat(bench: Bench) -> Thrown:
    """Arm, and ``throw`` where the next heartbeat comes later: nothing makes the board look at its joints before."""
    if not bench.simulated:
        raise NotApplicableError("how soon a real servo follows is not known")
    here = bench.arm()
    while not any(isinstance(m, BoardHeartbeat) for m in bench.heard):
        bench.stream(0.01, lambda t: here)
    return throw_from(bench, here, 1.0)


@case(
    "Encoders are read when the set-point comes, not before: the reading shows how far each joint has got by then."
)
def reads_at_the_moment_of_the_setpoint(bench: Bench) -> None:
    thrown = _throw_after_a_heartbeat(bench)
    then = angles_of(bench, thrown.sample)
    bench.listen(_LATER_S)
    now = angles_of(bench, bench.executed(thrown.sample.applied_rad, "a set-point after a pause"))
    for joint, (a, b, lag) in enumerate(zip(now, then, thrown.behind_rad, strict=True), start=1):
        expect(
            (a - b) / lag > _LEAST_WAY,
            f"{1e3 * _LATER_S:g} ms after one set-point the next one was answered with a reading of joint {joint} that "
            f"has gone {100 * (a - b) / lag:.0f} % of its way",
        )


@case(
    "Power is there until it is taken: by a stop, by disarming, by freeing, by clearing a fault, up to that moment."
)
def power_lasts_until_it_is_taken(bench: Bench) -> None:
    takes: dict[str, Callable[[], object]] = {
        "stopped": bench.stop,
        "disarmed": partial(bench.must_go, Mode.DISARMED),
        "freed": lambda: [bench.set_joint_mode(joint + 1, JointMode.FREE) for joint in range(bench.joints)],
    }
    if bench.lab.fail is not None:
        takes["cleared"] = lambda: bench.clear(latch)
    latch = 0
    for how, take in takes.items():
        bench.fresh()
        thrown = _throw_after_a_heartbeat(bench)
        if bench.lab.fail is not None and how == "cleared":
            bench.lab.fail(Fault.OVERCURRENT, 1, 5)
            latch = bench.wait(FaultEvent, 0.02).number
            bench.lab.fail(Fault.NONE, 0, 0)
        bench.listen(_LATER_S)
        take()
        shares = went_on(bench, thrown)
        if max(map(abs, shares)) > 1.0 + _LEAST_WAY:
            raise NotApplicableError("a joint coasts when it loses its power")
        for joint, share in enumerate(shares, start=1):
            expect(
                share > _LEAST_WAY,
                f"{how} {1e3 * _LATER_S:g} ms after its set-point joint {joint} had gone {100 * share:.0f} % of its "
                "way: it lost its power before",
            )
