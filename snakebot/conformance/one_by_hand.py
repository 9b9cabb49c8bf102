"""One joint turned by hand beside others that are driven: where it gets power, and how it goes on from there."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from firmware_protocol.assembly import to_wire
from firmware_protocol.catalogue import HostHeartbeat, JointMode, LimitKind, Mode, Result
from snakebot.conformance.bench import Bench
from snakebot.conformance.case import case
from snakebot.conformance.lag import angles_of
from snakebot.conformance.violations import expect

_TURN_RAD = 0.1
_SETTLES_S = 0.25
_ACCELERATION = 6.0  # rad/s^2: in a tick of 10 ms a joint at rest makes 0.6 mrad
_MOST_RAD = 1.5e-3  # of a first tick at that: what is beyond is no work of a limiter


def _stand(bench: Bench, wanted_rad: Sequence[float], when: str) -> None:
    """Every joint and its register are there, once they have settled."""
    bench.send(HostHeartbeat(bench.host, 1))
    bench.listen(_SETTLES_S)
    sample = bench.samples[-1]
    for joint, (angle, now, register) in enumerate(
        zip(wanted_rad, angles_of(bench, sample), sample.applied_rad, strict=True), start=1
    ):
        expect(
            max(abs(now - angle), abs(register - angle)) < _TURN_RAD / 4,
            f"{when}: joint {joint} should be at {angle:.3f} rad; it is at {now:.3f}, its register {register:.3f}",
        )


@case(
    "Beside a free joint the others get power where they are; so does that one once it is active or rigid: each joint.",
    needs=("turn_joint",),
)
def power_finds_single_joints_where_they_are(bench: Bench) -> None:
    turn = bench.lab.turn_joint
    assert turn is not None
    again = (JointMode.ACTIVE, JointMode.RIGID_HERE, JointMode.RIGID)
    for free, mode in itertools.product(range(1, bench.joints + 1), again):
        bench.fresh()
        side = 1.0 if free % 2 else -1.0
        expect(bench.set_joint_mode(free, JointMode.FREE).result is Result.OK, "free was refused")
        wanted = angles_of(bench, bench.sample())
        bench.listen(0.01)  # no unasked sample is near, for which the board would read its encoders
        for joint, angle in enumerate(wanted, start=1):
            wanted[joint - 1] = angle + side * _TURN_RAD
            turn(joint, wanted[joint - 1])
        bench.must_go(Mode.ARMED)
        bench.must_go(Mode.HOLDING)
        _stand(bench, wanted, f"joint {free} is free, all were turned and the board armed")
        bench.listen(0.01)
        wanted[free - 1] -= side * _TURN_RAD
        turn(free, wanted[free - 1])
        expect(bench.set_joint_mode(free, mode).result is Result.OK, f"{mode.name.lower()} was refused")
        _stand(bench, wanted, f"joint {free} was turned and made {mode.name.lower()}")


@case(
    "A joint that hands moved while it was free begins there at rest: sent back or onwards at once, its limits hold.",
    needs=("turn_joint",),
)
def goes_back_under_its_limits(bench: Bench) -> None:
    turn = bench.lab.turn_joint
    assert turn is not None
    for joint in range(1, bench.joints + 1):
        for side in (1.0, -1.0):
            for onwards in (False, True):
                bench.fresh()
                answer = bench.set_limit(joint, LimitKind.ACCELERATION, _ACCELERATION)
                expect(answer.result is Result.OK, f"an acceleration limit was answered {answer}")
                start = [to_wire(angle) for angle in bench.arm()]
                bench.stand_at(start, 0.03, "the stream")
                expect(bench.set_joint_mode(joint, JointMode.FREE).result is Result.OK, "free was refused")
                bench.executed(start, "one with a free joint")
                was = start[joint - 1] + side * _TURN_RAD
                turn(joint, was)
                bench.listen(0.01)
                expect(
                    bench.set_joint_mode(joint, JointMode.ACTIVE).result is Result.OK, "active was refused"
                )
                goal = list(start)
                goal[joint - 1] = to_wire(was + side * _TURN_RAD) if onwards else start[joint - 1]
                now = bench.executed(goal, "the first one of a joint that is active again").applied_rad[
                    joint - 1
                ]
                expect(
                    abs(now - was) < _MOST_RAD + bench.rad_per_count / 2 + bench.lab.encoder_rad / 2,
                    f"joint {joint}, turned by hand to {was:.4f} rad and active again, was sent to "
                    f"{goal[joint - 1]:.4f} and went to {now:.4f} in a tick",
                )
        turn(joint, start[joint - 1])
