"""Requests: what they do to the joints. What each is answered is asked by the conformance suite."""

from __future__ import annotations

import itertools

import pytest
from board_rig import HOST, Rig, bench

from firmware_protocol.catalogue import (
    Counters,
    JointMode,
    JointModeRequest,
    LimitKind,
    LimitRequest,
    Mode,
    Result,
    TrimRequest,
)


def joint_mode(joint: int, mode: JointMode, angle_rad: float = 0.0, host: int = HOST) -> JointModeRequest:
    return JointModeRequest(9, joint, mode, angle_rad, host)


def limit(value: float, kind: LimitKind = LimitKind.SPEED, joint: int = 1, host: int = HOST) -> LimitRequest:
    return LimitRequest(10, joint, kind, value, host)


def test_built_in_limit_as_the_wire_rounds_it_is_accepted() -> None:
    for degrees in (10, 33.3, 57.7, 90, 95, 179):
        rig = Rig(bench(1, limits={"angle_deg": degrees}))
        built_in = rig.robot.angle_limit_rad[0]
        rounded = round(built_in / 0.002) * 0.002
        assert rig.ask(limit(rounded, LimitKind.ANGLE)).result is Result.OK
        assert rig.ask(limit(rounded + 0.002, LimitKind.ANGLE)).result is Result.BAD_VALUE
        rig.go(Mode.ARMED)
        assert rig.ask(limit(rounded, LimitKind.ANGLE)).result is Result.OK


def test_a_joint_that_gets_power_back_while_holding_stays_where_it_is() -> None:
    rig = Rig()
    rig.enter(Mode.HOLDING)
    rig.ask(joint_mode(3, JointMode.FREE))
    rig.advance(0.05)
    rig.plant.angle_rad[2] = 0.4
    rig.ask(joint_mode(3, JointMode.ACTIVE))
    commanded_s, commanded_rad = rig.plant.commands[-1]
    assert commanded_s == rig.now_s
    assert commanded_rad == pytest.approx([0.0, 0.0, 0.4, 0.0, 0.0], abs=4e-4)
    rig.advance(0.1)
    assert rig.plant.angle_rad[2] == pytest.approx(0.4, abs=4e-4)


def test_rigid_goes_to_its_angle_under_the_limiter_and_stays() -> None:
    rig = Rig()
    rig.go(Mode.ARMED)
    rig.ask(joint_mode(4, JointMode.RIGID, 0.3))
    assert rig.board._register.applied_rad[3] == 0.0
    rig.advance(0.01)
    rig.tick([0.0] * 5)
    assert 0 < rig.board._register.applied_rad[3] < 0.02
    rig.stream(1.0, [0.02, 0.02, 0.02, -0.2, 0.02])
    assert rig.plant.commands[-1][1] == pytest.approx([0.02, 0.02, 0.02, 0.3, 0.02], abs=1e-4)
    counters = [m for m in rig.advance(1.0) if isinstance(m, Counters)][-1]
    assert counters.clamped <= 5, "a rigid joint's own way is not a changed set-point"


@pytest.mark.parametrize("trim_rad", [0.3, -0.3])
def test_a_new_trim_is_slewed_in_after_arming(trim_rad: float) -> None:
    rig = Rig()
    rig.advance(0.05)
    rig.go(Mode.ARMED)
    rig.go(Mode.DISARMED)
    assert rig.ask(TrimRequest(1, 2, trim_rad, HOST)).result is Result.OK
    rig.go(Mode.ARMED)
    told = [rig.plant.commands[-1][1][1]]
    for _ in range(60):
        rig.advance(0.01)
        rig.tick([0.0] * 5)
        told.append(rig.plant.commands[-1][1][1])
        assert rig.board._register.applied_rad[1] == pytest.approx(told[-1] - trim_rad)
    speeds = [(now - before) / 0.01 for before, now in itertools.pairwise(told)]
    changes = [(now - before) / 0.01 for before, now in itertools.pairwise([0.0, *speeds])]
    assert told[0] == 0.0, "it jumped at arming"
    assert told[-1] == pytest.approx(trim_rad, abs=1e-4)
    assert max(map(abs, speeds)) <= 8.0
    assert max(map(abs, changes)) <= 60.0 + 2e-4 / 0.01**2


def test_a_trim_that_is_in_force_does_not_jump_at_the_next_arming() -> None:
    """Servo and joint are apart by the trim: it is told the angle at which the joint stays where it is."""
    rig = Rig()
    rig.ask(TrimRequest(1, 2, 0.2, HOST))
    rig.go(Mode.ARMED)
    rig.stream(1.0)
    rig.go(Mode.DISARMED)
    rig.plant.angle_rad[1] = 0.1
    rig.advance(0.2)
    assert rig.board._register.applied_rad[1] == pytest.approx(0.1, abs=4e-4)
    rig.go(Mode.ARMED)
    assert rig.plant.commands[-1][1][1] == pytest.approx(0.3, abs=4e-4)
    assert rig.board._register.applied_rad[1] == pytest.approx(0.1, abs=4e-4)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_angle_limit_holds_for_set_point_and_trim_together(side: float) -> None:
    rig = Rig()
    limit_rad = rig.robot.angle_limit_rad[0]
    rig.ask(TrimRequest(1, 1, side * 0.3, HOST))
    rig.go(Mode.ARMED)
    rig.stream(2.0, [side * limit_rad, 0.0, 0.0, 0.0, 0.0])
    assert max(abs(command[0]) for _, command in rig.plant.commands) <= limit_rad + 1e-9
    assert rig.board._register.applied_rad[0] == pytest.approx(side * (limit_rad - 0.3), abs=1e-4)


def test_a_trim_beyond_what_a_horn_can_be_off_is_refused() -> None:
    rig = Rig()
    assert rig.ask(TrimRequest(1, 1, 0.3, HOST)).result is Result.OK
    for trim_rad in (0.3001, -0.3001, 1.65):
        assert rig.ask(TrimRequest(1, 1, trim_rad, HOST)).result is Result.BAD_VALUE
