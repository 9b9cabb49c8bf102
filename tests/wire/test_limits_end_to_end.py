"""Random gaits, robots, changes in mid-run and faults: nothing sent and nothing executed breaks a limit."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from wire_bench import Bench

from firmware_protocol.catalogue import JointMode, Latch, Setpoint, decode
from firmware_protocol.frame import Frame, ProtocolError
from snakebot.control import JointFault
from snakebot.errors import BadInputError, BoardFaultError, HostLateError, LostBoardError
from snakebot.gait import Gait
from snakebot.robot import robot_from_mapping
from snakebot.simboard.disturbance import Rates

STEP_RAD = 1e-4  # the wire's resolution

gaits = st.builds(
    Gait,
    st.floats(0.05, 1.3),
    st.floats(-math.pi, math.pi),
    st.floats(0.2, 8.0),
    st.floats(-0.3, 0.3),
)
robots = st.fixed_dictionaries(
    {
        "joints": st.integers(1, 7),
        "limits": st.fixed_dictionaries(
            {
                "angle_deg": st.floats(20, 100),
                "speed_rad_s": st.floats(1, 9),
                "acceleration_rad_s2": st.floats(8, 90),
            }
        ),
    }
)
modes = st.sampled_from([JointMode.FREE, JointMode.RIGID, JointMode.RIGID_HERE, JointMode.ACTIVE])
happenings = st.lists(
    st.one_of(
        st.tuples(st.floats(0.1, 3.5), st.just("gait"), gaits, st.floats(0.2, 1.5)),
        st.tuples(st.floats(0.1, 3.5), st.just("stop"), st.none(), st.none()),
        st.tuples(st.floats(0.1, 3.5), st.just("stall"), st.floats(0.0, 0.09), st.none()),
    ),
    max_size=4,
)
faults = st.lists(st.tuples(st.floats(0, 3), st.integers(1, 7), modes, st.floats(-0.3, 0.3)), max_size=3)


class Eavesdropper:
    """Takes the set-points off the wire as they leave the host."""

    def __init__(self, joints: int) -> None:
        self.joints = joints
        self.parts: dict[int, dict[int, Setpoint]] = {}
        self.sent: dict[int, tuple[float, ...]] = {}
        self.interval_s: dict[int, float] = {}
        self.order: list[int] = []

    def hear(self, frames: Sequence[Frame]) -> None:
        for frame in frames:
            try:
                message = decode(frame)
            except ProtocolError as error:
                raise AssertionError(f"the host sent no message: {error}") from None
            if isinstance(message, Setpoint):
                self.parts.setdefault(message.sequence, {})[message.group] = message
            elif isinstance(message, Latch) and message.sequence not in self.sent:
                groups = self.parts[message.sequence & 0xFFF]
                angles = [
                    a
                    for g in sorted(groups)
                    for a in (groups[g].first_rad, groups[g].second_rad, groups[g].third_rad)
                ]
                self.sent[message.sequence] = tuple(angles[: self.joints])
                self.interval_s[message.sequence] = message.interval_s
                self.order.append(message.sequence)


def check_limits(
    rows: np.ndarray, dt_s: np.ndarray, limits: tuple[np.ndarray, np.ndarray, np.ndarray], slack_s: float
) -> None:
    """Angle, speed and acceleration of a stream of set-points; the wire's resolution is allowed for."""
    angle, speed, acceleration = limits
    assert np.isfinite(rows).all()
    assert (np.abs(rows) <= angle + STEP_RAD).all(), "angle"
    moved = np.diff(rows, axis=0)
    allowed = speed * (dt_s[:, None] + slack_s) + 2 * STEP_RAD
    assert (np.abs(moved) <= allowed).all(), f"speed: {(np.abs(moved) - allowed).max()}"
    velocity = moved / dt_s[:, None]
    change = np.abs(np.diff(velocity, axis=0))
    fuzz = 4 * STEP_RAD * (1 / dt_s[1:] + 1 / dt_s[:-1])[:, None]
    at_end = (np.abs(rows[2:]) > angle - 1e-3) | (
        np.abs(rows[1:-1]) > angle - 1e-3
    )  # stops there, whatever else
    allowed = acceleration * np.maximum(dt_s[1:], dt_s[:-1])[:, None] + fuzz
    assert ((change <= allowed) | at_end).all(), f"acceleration: {(change - allowed)[~at_end].max()}"


@settings(max_examples=12, deadline=None)
@given(robots, gaits, happenings, faults, st.integers(0, 1000), st.booleans())
def test_nothing_sent_and_nothing_executed_breaks_a_limit(
    description: dict[str, Any], gait: Gait, events: list[Any], broken: list[Any], seed: int, bad_wire: bool
) -> None:
    robot = robot_from_mapping(description, "test")
    joint_faults = [
        JointFault(at, (joint,), mode, angle)
        for at, joint, mode, angle in broken
        if joint <= robot.joints and abs(angle) < min(robot.angle_limit_rad)
    ]
    rates = Rates(flip=0.003, drop=0.03, duplicate=0.03, reorder=0.03, delay=0.02) if bad_wire else None
    bench = Bench(rates, seed, robot=robot, gait=gait, duration_s=4, ramp_s=1, faults=joint_faults)
    ear = Eavesdropper(robot.joints)
    waiting = sorted(events, key=lambda event: event[0])

    def happen() -> None:
        while waiting and bench.loop.progress.t_s >= waiting[0][0]:
            _, what, first, second = waiting.pop(0)
            if what == "gait":
                with contextlib.suppress(BadInputError):
                    bench.loop.change_gait(first, second)
            elif what == "stop":
                bench.loop.request_stop()
            else:
                bench.clock.sleep_until(bench.clock.now_s() + first)

    bench.link.before = happen
    send = bench.link.send

    def heard(frames: Sequence[Frame]) -> None:
        ear.hear(frames)
        send(frames)

    bench.link.send = heard  # type: ignore[method-assign]
    try:
        bench.run()
    except BadInputError:
        assert not ear.order, "a motion that was refused has moved"
        return
    except (BoardFaultError, HostLateError, LostBoardError):
        pass
    bench.rest_of_life(3)
    limits = (
        np.array(robot.angle_limit_rad),
        np.array(robot.speed_limit_rad_s),
        np.array(robot.acceleration_limit_rad_s2),
    )
    sent = np.array([ear.sent[sequence] for sequence in ear.order])
    if len(sent) > 3:
        check_limits(sent, np.array([ear.interval_s[s] for s in ear.order[1:]]), limits, 0.0)
    executed = np.array([row for _, row in bench.joints.commands])
    assert (np.abs(executed) <= limits[0] + STEP_RAD).all()
    times = np.array([t for t, _ in bench.joints.commands])
    for width in (1, 3, 10):  # a set-point may come 20 ms early, in all
        if len(times) > width:
            passed = (times[width:] - times[:-width])[:, None] + 0.021
            assert (
                np.abs(executed[width:] - executed[:-width]) <= limits[1] * passed + 2 * width * STEP_RAD
            ).all()
