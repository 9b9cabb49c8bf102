"""Power, felt by hand: a joint that is turned away comes back if its servo has power, and stays if not."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from firmware_protocol.assembly import to_wire
from firmware_protocol.catalogue import (
    Fault,
    FaultEvent,
    HostHeartbeat,
    JointMode,
    LimitKind,
    Mode,
    Result,
)
from snakebot.conformance.bench import Bench
from snakebot.conformance.case import case
from snakebot.conformance.lag import angles_of
from snakebot.conformance.violations import expect

_TURN_RAD = 0.1
_PATIENCE_S = 0.25


def _listen(bench: Bench, here: Sequence[float] | None) -> None:
    """Let the joints settle; with angles, keep set-points coming, else the holder's heartbeat."""
    if here is not None:
        bench.stream(_PATIENCE_S, lambda t: here)
    else:
        bench.send(HostHeartbeat(bench.host, 1))
        bench.listen(_PATIENCE_S)


def feel(bench: Bench, powered: Sequence[bool], when: str, here: Sequence[float] | None = None) -> None:
    """Turn every joint to either side, and see which come back."""
    assert bench.lab.turn_joint is not None
    # half a count of the encoder, and the board's own rounding
    read_within_rad = 0.5 * bench.lab.encoder_rad + 0.6 * bench.rad_per_count
    for side in (1.0, -1.0):
        _listen(bench, here)
        before = angles_of(bench, bench.samples[-1])
        for joint, angle in enumerate(before, start=1):
            bench.lab.turn_joint(joint, angle + side * _TURN_RAD)
        _listen(bench, here)
        sample = bench.samples[-1]
        for joint, (was, now, wanted) in enumerate(
            zip(before, angles_of(bench, sample), powered, strict=True), start=1
        ):
            came_back = abs(now - was) < _TURN_RAD / 2
            expect(
                came_back == wanted,
                f"{when}: joint {joint} was turned by hand and "
                + ("came back: its servo has power" if came_back else "stayed: its servo has no power"),
            )
            if not wanted:
                turned = was + side * _TURN_RAD
                error = abs(now - turned)
                expect(
                    error <= read_within_rad,
                    f"{when}: joint {joint} was turned to {turned:.4f} rad and is read at {now:.4f}",
                )
                off = abs(sample.applied_rad[joint - 1] - now)
                expect(
                    off < 1.5e-4, f"{when}: the register of joint {joint} is {off:.4f} rad off its encoder"
                )


def _none(bench: Bench) -> list[bool]:
    return [False] * bench.joints


def _all(bench: Bench) -> list[bool]:
    return [True] * bench.joints


@case(
    "Disarmed, stopped, disarmed again: no joint has power, and the register follows all of them.",
    needs=("turn_joint",),
)
def off_joints_can_be_turned(bench: Bench) -> None:
    feel(bench, _none(bench), "disarmed")
    bench.arm()
    bench.stop()
    feel(bench, _none(bench), "stopped while armed")
    bench.make_safe()
    feel(bench, _none(bench), "after a stop was cleared")
    bench.arm()
    bench.must_go(Mode.HOLDING)
    bench.must_go(Mode.DISARMED)
    feel(bench, _none(bench), "disarmed while holding")


@case("Armed and holding: every joint has power.", needs=("turn_joint",))
def held_joints_come_back(bench: Bench) -> None:
    here = bench.arm()
    feel(bench, _all(bench), "armed", here)
    bench.must_go(Mode.HOLDING)
    feel(bench, _all(bench), "holding")
    bench.must_go(Mode.ARMED)
    feel(bench, _all(bench), "armed after holding", here)


@case(
    "A joint that hands moved a moment before gets power where it is, to either side.", needs=("turn_joint",)
)
def power_finds_joints_where_they_are(bench: Bench) -> None:
    assert bench.lab.turn_joint is not None
    for side, mode in itertools.product(
        (1.0, -1.0), (JointMode.ACTIVE, JointMode.RIGID, JointMode.RIGID_HERE)
    ):
        bench.fresh()
        for joint in range(1, bench.joints + 1):
            bench.set_joint_mode(joint, mode)
        before = angles_of(bench, bench.sample())
        bench.listen(0.01)  # no unasked sample is near, for which the board would read its encoders
        for joint, angle in enumerate(before, start=1):
            bench.lab.turn_joint(joint, angle + side * _TURN_RAD)
        bench.must_go(Mode.ARMED)
        bench.must_go(Mode.HOLDING)
        _listen(bench, None)
        sample = bench.samples[-1]
        for joint, (was, now, register) in enumerate(
            zip(before, angles_of(bench, sample), sample.applied_rad, strict=True), start=1
        ):
            stands, commanded = now - was - side * _TURN_RAD, register - was - side * _TURN_RAD
            expect(
                max(abs(stands), abs(commanded)) < _TURN_RAD / 4,
                f"{mode.name.lower()} joint {joint} was turned {side * _TURN_RAD:.2f} rad and armed; its register is "
                f"{commanded:.3f} rad off there, and it stands {stands:.3f} rad off",
            )


@case(
    "Fault: every joint has power for 2 s, then none has; an emergency stop does not wait.",
    needs=("turn_joint",),
)
def faults_freeze_with_power(bench: Bench) -> None:
    for start in (Mode.ARMED, Mode.HOLDING):
        bench.fresh()
        bench.arm()
        if start is Mode.HOLDING:
            bench.must_go(Mode.HOLDING)
        bench.wait(FaultEvent, 1.5, code=Fault.WATCHDOG)
        feel(bench, _all(bench), f"in the first second after a fault while {start.name.lower()}")
        bench.listen(1.2)
        feel(bench, _none(bench), f"2 s after a fault while {start.name.lower()}")
        bench.make_safe()
        feel(bench, _none(bench), "after a fault was cleared")
    bench.arm()
    bench.wait(FaultEvent, code=Fault.WATCHDOG)
    bench.stop()
    feel(bench, _none(bench), "stopped while frozen")
    bench.fresh()
    bench.arm()
    bench.wait(FaultEvent, code=Fault.WATCHDOG)
    bench.make_safe()
    feel(bench, _none(bench), "a fault was cleared while frozen")


@case("Free joints have no power while the others have; rigid ones have.", needs=("turn_joint",))
def feels_joint_modes(bench: Bench) -> None:
    for joint in range(1, bench.joints + 1):
        for mode in (JointMode.FREE, JointMode.RIGID_HERE):
            bench.fresh()
            expect(bench.set_joint_mode(joint, mode).result is Result.OK, f"{mode.name.lower()} was refused")
            feel(bench, _none(bench), f"disarmed, joint {joint} {mode.name.lower()}")
            bench.arm()
            bench.must_go(Mode.HOLDING)
            powered = [mode is not JointMode.FREE or other != joint for other in range(1, bench.joints + 1)]
            feel(bench, powered, f"holding, joint {joint} {mode.name.lower()}")


@case(
    "Rigid joints relax with the others 2 s after a fault; a clear before that takes their power, and so does a reset.",
    needs=("turn_joint", "reset"),
)
def rigid_joints_relax(bench: Bench) -> None:
    for kind, after in itertools.product(
        (JointMode.RIGID, JointMode.RIGID_HERE), ("2 s", "a clear", "a reset")
    ):
        bench.fresh()
        for joint, angle in enumerate(bench.arm(), start=1):
            bench.set_joint_mode(joint, kind, angle)
        bench.wait(FaultEvent, code=Fault.WATCHDOG)
        feel(bench, _all(bench), f"{kind.name.lower()}, in the first second after a fault")
        if after == "2 s":
            bench.listen(1.2)
        elif after == "a clear":
            bench.make_safe()
        else:
            bench.start_anew()
        feel(bench, _none(bench), f"{kind.name.lower()}, frozen by a fault, after {after}")


@case("Encoders are read when the set-point takes effect.", needs=("turn_joint",))
def reads_when_it_executes(bench: Bench) -> None:
    assert bench.lab.turn_joint is not None
    here = bench.arm()
    bench.executed(here, "the first one")
    for side in (1.0, -1.0):
        bench.stream(_PATIENCE_S, lambda t: here)
        before = angles_of(bench, bench.samples[-1])
        bench.listen(0.01)
        for joint, angle in enumerate(before, start=1):
            bench.lab.turn_joint(joint, angle + side * _TURN_RAD)
        now = angles_of(bench, bench.executed(here, "the one after the joints were turned"))
        for joint, (was, turned) in enumerate(zip(before, now, strict=True), start=1):
            expect(
                abs(turned - was - side * _TURN_RAD) < _TURN_RAD / 2,
                f"joint {joint} was turned by {side * _TURN_RAD:.2f} rad; the sample right after it says "
                f"{turned - was:.3f}",
            )


@case("A reset takes the power of every joint, whatever mode it comes in.", needs=("turn_joint", "reset"))
def a_reset_takes_all_power(bench: Bench) -> None:
    for mode in (Mode.ARMED, Mode.HOLDING, Mode.FAULT):
        bench.fresh()
        bench.enter(mode)
        bench.start_anew()
        feel(bench, _none(bench), f"after a reset while {mode.name.lower()}")


@case(
    "A free joint's register is where hands put it while others are driven; active again, it begins there, at rest.",
    needs=("turn_joint",),
)
def free_joints_follow_hands(bench: Bench) -> None:
    assert bench.lab.turn_joint is not None
    for joint in range(1, bench.joints + 1):
        bench.fresh()
        answer = bench.set_limit(joint, LimitKind.ACCELERATION, 6.0)
        expect(answer.result is Result.OK, f"an acceleration limit was answered {answer}")
        goal = [to_wire(angle) for angle in bench.arm()]
        bench.stand_at(goal, 0.03, "the stream")
        expect(bench.set_joint_mode(joint, JointMode.FREE).result is Result.OK, "free was refused")
        for part in (0.3, 1.0, 0.6, -1.0, 0.2):
            bench.lab.turn_joint(joint, goal[joint - 1] + part * _TURN_RAD)
            bench.listen(0.01)
            sample = bench.executed(goal, "the first one after a free joint was turned")
            angle = angles_of(bench, sample)[joint - 1]
            off = abs(sample.applied_rad[joint - 1] - angle)
            expect(off < 1.5e-4, f"the register of free joint {joint} is {off:.4f} rad off its encoder")
            others = [abs(a - b) for a, b in zip(sample.applied_rad, goal, strict=True)]
            others[joint - 1] = 0.0
            expect(
                max(others) < 3e-4,
                f"joint {joint} was turned by hand, the others went by {max(others):.4f} rad",
            )
        expect(bench.set_joint_mode(joint, JointMode.ACTIVE).result is Result.OK, "active was refused")
        goal[joint - 1] = to_wire(sample.applied_rad[joint - 1])
        for _ in range(3):
            bench.listen(0.01)
            now = bench.executed(goal, "one of a joint that is active again").applied_rad[joint - 1]
            expect(
                abs(now - goal[joint - 1]) < 1.1e-4,
                f"joint {joint}, active again, was to stay at {goal[joint - 1]:.4f} rad and was applied {now:.4f}",
            )
