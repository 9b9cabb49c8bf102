"""Whose board it is: other hosts before and after arming, stops that somebody else has made, joints nobody has read."""

from __future__ import annotations

import itertools

import pytest
from wire_bench import Bench, LagJoints

from firmware_protocol.catalogue import JointMode, Mode
from firmware_protocol.frame import Frame
from snakebot.control import JointFault
from snakebot.errors import BoardFaultError
from snakebot.softboard import SoftBoard


def test_what_another_host_set_just_before_arming_is_set_right() -> None:
    ours = Bench(duration_s=3, faults=[JointFault(0.0, (3,), JointMode.FREE)])
    other = Bench(on=ours, seed=5)
    arm = ours.board.arm

    def arm_late() -> None:
        other.board.connect()
        for joint in range(1, 6):
            other.board.set_joint_mode(joint, JointMode.ACTIVE)
        arm()

    ours.board.arm = arm_late  # type: ignore[method-assign]
    assert ours.run().ended == "finished"
    assert ours.sim.joint_modes[2] is JointMode.FREE


@pytest.mark.parametrize("holder", [0, 99])
def test_a_board_that_is_no_longer_ours_ends_the_run(holder: int) -> None:
    bench = Bench(duration_s=20)

    def take_over() -> None:
        if bench.clock.now_s() > 4:
            bench.sim._machine.holder = holder
            if not holder:
                bench.sim._machine.mode = Mode.DISARMED

    bench.link.before = take_over
    with pytest.raises(BoardFaultError, match=r"no longer ours: (host 00000063 holds it|it is disarmed)"):
        bench.run()
    assert bench.clock.now_s() < 4.5


@pytest.mark.parametrize("keep_stop", [False, True])
def test_a_stop_found_at_the_start_is_cleared_unless_it_is_to_be_kept(keep_stop: bool) -> None:
    bench = Bench(duration_s=3, keep_stop=keep_stop)
    bench.sim.receive(Frame(1, b""), 0.0)
    assert bench.sim.mode is Mode.STOPPED
    if not keep_stop:
        assert bench.run().ended == "finished"
        return
    with pytest.raises(BoardFaultError, match="stopped already: nothing was moved"):
        bench.run()
    assert bench.sim.mode is Mode.STOPPED
    assert not any(on for _, _, on in bench.joints.power_changes)


class HalfBlind(LagJoints):
    """Joint 3 stands at 1 rad, and its encoder answers once in so many times (0: never)."""

    def __init__(self, once_in: int) -> None:
        super().__init__(5)
        self.angle_rad[2] = 1.0
        self._once_in, self._asked = once_in, itertools.count(1)

    def encoder_counts(self) -> list[int]:
        counts: list[int | None] = [*super().encoder_counts()]
        if not self._once_in or next(self._asked) % self._once_in:
            counts[2] = None
        return counts  # type: ignore[return-value]


def blind_bench(once_in: int, *faults: JointFault) -> Bench:
    bench = Bench(duration_s=3, faults=faults)
    bench.joints = HalfBlind(once_in)
    bench.sim = bench.link.board = SoftBoard(bench.robot, plant=bench.joints, boot_seed=0)
    return bench


def test_a_joint_that_cannot_be_read_gets_no_power() -> None:
    bench = blind_bench(0)
    with pytest.raises(BoardFaultError, match=r"no angle of joint 3 for 10 s.*--fault free:3"):
        bench.run()
    assert not any(on for _, _, on in bench.joints.power_changes)


def test_a_joint_that_cannot_be_read_may_stay_free() -> None:
    bench = blind_bench(0, JointFault(0.0, (3,), JointMode.FREE))
    assert bench.run().ended == "finished"
    assert bench.joints.angle_rad[2] == 1.0


def test_a_joint_that_is_read_now_and_then_starts_where_it_is() -> None:
    bench = blind_bench(3)
    assert bench.run().ended == "finished"
    assert bench.joints.commands[0][1][2] == pytest.approx(1.0, abs=0.001)
