"""Random gaits, robots, changes in mid-run and faults: nothing sent and nothing executed breaks a limit."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Sequence
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from limits_bench import HostEar, StepCheck, board_ear
from samples import sample
from wire_bench import Bench

from firmware_protocol.catalogue import EmergencyStop, Fault, JointMode, encode
from firmware_protocol.frame import Frame
from snakebot.cli.keys import press
from snakebot.control import JointFault
from snakebot.errors import BadInputError, BoardFaultError, HostLateError, LostBoardError, NoBoardError
from snakebot.gait import Gait
from snakebot.robot import Robot, robot_from_mapping
from snakebot.softboard.disturbance import Rates
from snakebot.softboard.hardware import HardwareFault

DURATION_S, RAMP_S = 2.5, 0.6

joint_limits = st.fixed_dictionaries(
    {
        "angle_deg": st.floats(20, 100),
        "speed_rad_s": st.floats(1, 9),
        "acceleration_rad_s2": st.floats(8, 90),
    }
)


@st.composite
def robots(draw: st.DrawFn) -> Robot:
    """One limit for all joints, or one a joint."""
    joints = draw(st.sampled_from([1, 2, 3, 4, 5, 6, 7, 16]))
    one = draw(joint_limits)
    limits: dict[str, Any] = dict(one)
    if draw(st.booleans()):
        limits = {
            key: [value * draw(st.floats(0.8, 1.0)) for _ in range(joints)] for key, value in one.items()
        }
    return robot_from_mapping({"joints": joints, "limits": limits}, "test")


@st.composite
def gaits(draw: st.DrawFn, robot: Robot) -> Gait:
    """Most of them within this robot's limits, some beyond."""
    omega = draw(st.floats(0.2, 8.0))
    speed, acceleration = min(robot.speed_limit_rad_s), min(robot.acceleration_limit_rad_s2)
    possible = min(*robot.angle_limit_rad, speed / omega, acceleration / omega**2, 1.3)
    return Gait(
        possible * draw(st.floats(0.1, 1.05)),
        draw(st.floats(-math.pi, math.pi)),
        omega,
        draw(st.sampled_from([0.0, 0.05, -0.1, 0.3])),
    )


@st.composite
def happenings(draw: st.DrawFn, robot: Robot) -> list[tuple[float, str, Any]]:
    """(time, what, with what): what a user, a computer, a wire and a board may do in mid-run."""
    kinds = st.one_of(
        st.tuples(st.just("gait"), st.tuples(gaits(robot), st.floats(0.2, 1.5))),
        st.tuples(st.just("keys"), st.text("aAbBwWoO", min_size=1, max_size=3)),
        st.tuples(st.just("stop"), st.none()),
        st.tuples(st.just("emergency stop"), st.booleans()),
        st.tuples(st.just("stall"), st.floats(0.0, 0.15)),
        st.tuples(st.just("silence"), st.floats(0.0, 0.2)),
        st.tuples(st.just("reboot"), st.none()),
        st.tuples(st.just("servo fault"), st.none()),
    )
    often = st.one_of(st.just(0.5), st.floats(0.05, DURATION_S))
    return sorted(((draw(often), *draw(kinds)) for _ in range(draw(st.integers(0, 5)))), key=lambda e: e[0])


modes = st.sampled_from([JointMode.FREE, JointMode.RIGID, JointMode.RIGID_HERE, JointMode.ACTIVE])


@st.composite
def joint_faults(draw: st.DrawFn, robot: Robot) -> list[JointFault]:
    """Joints that lose power, get it back, and are held, at 0 and in mid-run."""
    times = st.one_of(st.just(0.0), st.floats(0, 2.2))
    return [
        JointFault(
            draw(times),
            (draw(st.integers(1, robot.joints)),),
            draw(modes),
            draw(st.floats(-0.3, 0.3)),
        )
        for _ in range(draw(st.integers(0, 4)))
    ]


wires = st.one_of(
    st.none(),
    st.builds(
        Rates,
        flip=st.floats(0, 0.005),
        drop=st.floats(0, 0.1),
        duplicate=st.floats(0, 0.1),
        delay=st.floats(0, 0.1),
        reorder=st.floats(0, 0.1),
        truncate=st.floats(0, 0.02),
    ),
)


@st.composite
def cases(draw: st.DrawFn) -> dict[str, Any]:
    robot = draw(robots())
    return {
        "robot": robot,
        "gait": draw(gaits(robot)),
        "events": draw(happenings(robot)),
        "faults": draw(joint_faults(robot)),
        "rates": draw(wires),
        "rate_hz": draw(st.sampled_from([20.0, 50.0, 100.0, 100.0, 250.0, 500.0, 1000.0])),
        "seed": draw(st.integers(0, 1000)),
        "again_after_s": draw(st.sampled_from([0.05, 0.5, 3.0])),
    }


class Play:
    """One host on a bench, the things that happen to it, and an ear at each end."""

    def __init__(self, bench: Bench, gait: Gait, events: Sequence[tuple[float, str, Any]]) -> None:
        self.bench = bench
        self.gait = gait
        self.waiting = list(events)
        self.silent_until_s = -math.inf
        self.ear = HostEar(bench)
        send = bench.link.send
        bench.link.before = self.happen
        to_board = bench.link._to_board
        bench.link._to_board = lambda data: (
            b"" if bench.clock.now_s() < self.silent_until_s else to_board(data)
        )

        def heard(frames: Sequence[Frame]) -> None:
            self.ear.hear(frames)
            send(frames)

        bench.link.send = heard  # type: ignore[method-assign]

    def happen(self) -> None:
        bench, loop = self.bench, self.bench.loop
        while self.waiting and loop.progress.ticks and loop.progress.t_s >= self.waiting[0][0]:
            _, what, how = self.waiting.pop(0)
            now_s = bench.clock.now_s()
            match what:
                case "gait":
                    with contextlib.suppress(BadInputError):
                        loop.change_gait(*how)
                case "keys":
                    for key in how:
                        self.gait = press(loop, self.gait, key)
                case "stop":
                    loop.request_stop()
                case "emergency stop" if how:
                    loop.request_emergency_stop()
                case "emergency stop":
                    bench.sim.receive(encode(EmergencyStop(host=77)), now_s)
                case "stall":
                    bench.clock.sleep_until(now_s + how)
                case "silence":
                    self.silent_until_s = now_s + how
                case "reboot":
                    bench.sim.reset(now_s)
                case _:
                    for fault in (Fault.SERVO, Fault.NONE):
                        bench.sim.fail(HardwareFault(fault), now_s)

    def run(self) -> bool:
        """True if the motion was begun; how it ended is its own affair, as long as it was in a documented way."""
        try:
            self.bench.run()
        except (BadInputError, NoBoardError):  # refused, or the wire let no handshake through
            assert not self.ear.ticks, "a motion that was not begun has moved"
            return False
        except (BoardFaultError, HostLateError, LostBoardError, KeyboardInterrupt):
            pass
        return True


def play(case: dict[str, Any]) -> list[StepCheck]:
    """A run, and another one by a new host on the same board whatever became of the first."""
    robot: Robot = case["robot"]
    faults = [
        fault
        for fault in case["faults"]
        if fault.mode is not JointMode.RIGID or abs(fault.angle_rad) < min(robot.angle_limit_rad)
    ]
    options = {"robot": robot, "gait": case["gait"], "rate_hz": case["rate_hz"], "ramp_s": RAMP_S}
    with board_ear(robot) as executed:
        bench = Bench(case["rates"], case["seed"], duration_s=DURATION_S, faults=faults, **options)
        first = Play(bench, case["gait"], case["events"])
        if not first.run():
            return []
        bench.rest_of_life(case["again_after_s"])
        again = Bench(case["rates"], case["seed"] + 1, duration_s=1.4, on=bench, **options)
        second = Play(again, case["gait"], [])
        second.run()
        again.rest_of_life(3)
    assert not any(bench.joints.powered)
    first.ear.check.look()
    second.ear.check.look()
    return [first.ear.check, second.ear.check, executed]


@settings(max_examples=50, deadline=None)
@given(cases())
def test_nothing_sent_and_nothing_executed_breaks_a_limit(case: dict[str, Any]) -> None:
    play(case)


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_nothing_breaks_a_limit_in_hundreds_of_runs() -> None:
    runs = sample(600, 200)
    begun: list[list[StepCheck]] = []

    @settings(max_examples=runs, deadline=None)
    @given(cases())
    def many(case: dict[str, Any]) -> None:
        if checks := play(case):
            begun.append(checks)

    many()
    assert len(begun) > runs / 3, "most gaits were refused: nothing was tried"
    for name, each in (
        ("sent", [c for a, b, _ in begun for c in (a, b)]),
        ("executed", [c for *_, c in begun]),
    ):
        worst = {
            what: max(c.margins.worst[what] for c in each) for what in ("angle", "speed", "acceleration")
        }
        steps = sum(c.margins.steps for c in each)
        nearest = ", ".join(f"{what} {value:.4f}" for what, value in worst.items())
        print(f"{name}: {len(begun)} runs twice, {steps} set-points; of the limit: {nearest}")
        assert steps > 20_000
        assert worst["acceleration"] > 0.5, "the limits were never near"
