"""Requests: what each is answered in each mode, and in which order wrong things are looked for."""

from __future__ import annotations

import pytest
from board_rig import HOST, OTHER, Rig, bench, samples

from firmware_protocol.catalogue import (
    Acknowledge,
    Counters,
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
    frame_id,
)
from firmware_protocol.frame import Frame


def joint_mode(joint: int, mode: JointMode, angle_rad: float = 0.0, host: int = HOST) -> JointModeRequest:
    return JointModeRequest(9, joint, mode, angle_rad, host)


def limit(value: float, kind: LimitKind = LimitKind.SPEED, joint: int = 1, host: int = HOST) -> LimitRequest:
    return LimitRequest(10, joint, kind, value, host)


REQUESTS = [
    joint_mode(1, JointMode.FREE),
    limit(1.0),
    TrimRequest(11, 1, 0.01, HOST),
    ZeroRequest(12, 1, 5, HOST),
]


@pytest.mark.parametrize("mode", Mode)
@pytest.mark.parametrize("request_", REQUESTS, ids=lambda request: type(request).__name__)
def test_which_request_is_possible_in_which_mode(mode: Mode, request_: Message) -> None:
    rig = Rig()
    rig.enter(mode)
    possible = {Mode.DISARMED}
    if isinstance(request_, JointModeRequest | LimitRequest):
        possible |= {Mode.ARMED, Mode.HOLDING}
    answer = rig.ask(request_)
    assert answer.request == frame_id(type(request_))
    assert answer.detail == mode
    assert answer.result is (Result.OK if mode in possible else Result.FORBIDDEN)


@pytest.mark.parametrize("mode", Mode)
@pytest.mark.parametrize("kind", [JointModeRequest, LimitRequest, TrimRequest, ZeroRequest])
def test_held_comes_before_everything_and_joint_and_value_before_mode(
    mode: Mode, kind: type[Message]
) -> None:
    def request(joint: int, host: int, good: bool = True) -> Message:
        if kind is JointModeRequest:
            return joint_mode(joint, JointMode.RIGID, 0.1 if good else 3.0, host)
        if kind is LimitRequest:
            return limit(1.0 if good else 200.0, joint=joint, host=host)
        if kind is TrimRequest:
            return TrimRequest(11, joint, 0.01 if good else 3.0, host)
        return ZeroRequest(12, joint, 5, host)

    rig = Rig()
    rig.enter(mode)
    held = mode in (Mode.ARMED, Mode.HOLDING)
    answer = rig.ask(request(6, OTHER))
    if held:
        assert (answer.result, answer.detail) == (Result.HELD, HOST)
    else:
        assert (answer.result, answer.detail) == (Result.BAD_JOINT, 5)
    for joint in (0, 6, 16, 31):
        frame = encode(request(1, HOST))
        raw = bytearray(frame.data)
        raw[1] = raw[1] & 0xE0 | joint
        rig.board.receive(Frame(frame.id, bytes(raw)), rig.now_s)
        answer = rig.one(rig.advance(0.0), Acknowledge)
        assert (answer.result, answer.detail) == (Result.BAD_JOINT, 5)
    if kind is not ZeroRequest:
        answer = rig.ask(request(1, HOST, good=False))
        assert (answer.result, answer.detail) == (Result.BAD_VALUE, 0)
    answer = rig.ask(request(1, 0))
    assert (answer.result, answer.detail) == ((Result.HELD, HOST) if held else (Result.BAD_VALUE, 0))


def test_unnamed_values_are_counted_as_corrupt_and_not_answered() -> None:
    rig = Rig()
    for request in (joint_mode(1, JointMode.FREE), limit(1.0)):
        frame = encode(request)
        raw = bytearray(frame.data)
        raw[1] |= 0xE0 if isinstance(request, JointModeRequest) else 0x60
        rig.board.receive(Frame(frame.id, bytes(raw)), rig.now_s)
    rig.board.receive(Frame(0x40, b"\x01\x09\x00\x00\x00\x01"), rig.now_s)  # a mode without a name
    rig.board.receive(Frame(0x7FF, b""), rig.now_s)
    rig.board.receive(Frame(17, b"\x00" * 7), rig.now_s)
    said = rig.advance(1.0)
    assert not [m for m in said if isinstance(m, Acknowledge)]
    counters = rig.one(said, Counters)
    assert (counters.received, counters.corrupt) == (5, 5)


def test_limits_only_tighten_while_armed() -> None:
    rig = Rig()
    assert rig.ask(limit(2.0)).result is Result.OK
    assert rig.ask(limit(8.0)).result is Result.OK, "disarmed, anything up to the built-in limit"
    assert rig.ask(limit(8.002)).result is Result.BAD_VALUE
    assert rig.ask(limit(0.0)).result is Result.BAD_VALUE
    rig.go(Mode.ARMED)
    assert rig.ask(limit(3.0)).result is Result.OK
    assert rig.ask(limit(3.0)).result is Result.OK, "once more is the same"
    assert rig.ask(limit(4.0)).result is Result.FORBIDDEN
    assert rig.ask(limit(8.1)).result is Result.BAD_VALUE


def test_built_in_limit_as_the_wire_rounds_it_is_accepted() -> None:
    for degrees in (10, 33.3, 57.7, 90, 95, 179):
        rig = Rig(bench(1, limits={"angle_deg": degrees}))
        built_in = rig.robot.angle_limit_rad[0]
        rounded = round(built_in / 0.002) * 0.002
        assert rig.ask(limit(rounded, LimitKind.ANGLE)).result is Result.OK
        assert rig.ask(limit(rounded + 0.002, LimitKind.ANGLE)).result is Result.BAD_VALUE
        rig.go(Mode.ARMED)
        assert rig.ask(limit(rounded, LimitKind.ANGLE)).result is Result.OK


def test_free_joint_has_no_power_and_its_register_follows_it() -> None:
    rig = Rig()
    rig.go(Mode.ARMED)
    rig.stream(0.3, [0.02] * 5)
    rig.ask(joint_mode(3, JointMode.FREE))
    assert rig.plant.modes == ["active", "active", "free", "active", "active"]
    rig.plant.angle_rad[2] = 0.5
    rig.advance(0.01)
    (sample,) = samples(rig.tick([0.02] * 5), 5)
    assert sample.applied_rad[2] == pytest.approx(0.5, abs=8e-4)
    assert sample.applied_rad[1] == pytest.approx(0.02, abs=1e-4)
    rig.ask(joint_mode(3, JointMode.ACTIVE))
    assert rig.plant.modes[2] == "active"
    before = rig.board._register.applied_rad[2]
    rig.advance(0.01)
    rig.tick([0.02] * 5)
    assert abs(rig.board._register.applied_rad[2] - before) < 0.01, (
        "it starts from where it is, under the limits"
    )


def test_a_joint_that_gets_power_back_while_holding_stays_where_it_is() -> None:
    rig = Rig()
    rig.enter(Mode.HOLDING)
    rig.ask(joint_mode(3, JointMode.FREE))
    rig.advance(0.05)
    rig.plant.angle_rad[2] = 0.4
    rig.ask(joint_mode(3, JointMode.ACTIVE))
    assert rig.plant.commands[-1] == (rig.now_s, pytest.approx([0.0, 0.0, 0.4, 0.0, 0.0], abs=4e-4))
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


def test_rigid_here_stays_at_the_applied_angle() -> None:
    rig = Rig()
    rig.go(Mode.ARMED)
    rig.stream(0.5, [0.1] * 5)
    rig.ask(joint_mode(5, JointMode.RIGID_HERE, 3.0))  # the angle is not looked at
    rig.stream(0.5, [-0.1] * 5)
    assert rig.plant.commands[-1][1] == pytest.approx([-0.1, -0.1, -0.1, -0.1, 0.1], abs=1e-4)


def test_joint_modes_survive_disarming_and_not_a_reset() -> None:
    rig = Rig()
    rig.ask(joint_mode(2, JointMode.FREE))
    rig.go(Mode.ARMED)
    assert rig.plant.modes == ["active", "free", "active", "active", "active"]
    rig.go(Mode.DISARMED)
    assert set(rig.plant.modes) == {"free"}
    rig.go(Mode.ARMED)
    assert rig.plant.modes[1] == "free"
    rig.board.reset(rig.now_s)
    assert set(rig.plant.modes) == {"free"}
    rig.go(Mode.ARMED)
    assert set(rig.plant.modes) == {"active"}
    assert set(rig.board.joint_modes) == {JointMode.ACTIVE}


def test_trim_reaches_the_servo_and_not_the_register() -> None:
    rig = Rig()
    rig.ask(TrimRequest(1, 2, 0.05, HOST))
    rig.go(Mode.ARMED)
    rig.stream(0.2, [0.01] * 5)
    assert rig.plant.commands[-1][1] == pytest.approx([0.01, 0.06, 0.01, 0.01, 0.01], abs=1e-4)
    assert rig.board._register.applied_rad == pytest.approx([0.01] * 5, abs=1e-4)


def test_zero_shifts_the_reading_and_both_survive_a_reset() -> None:
    rig = Rig()
    rig.plant.angle_rad = [0.1] * 5
    rig.ask(ZeroRequest(1, 1, 130, HOST))
    rig.ask(TrimRequest(2, 1, 0.02, HOST))
    for _ in range(2):
        sample = samples(rig.advance(0.2), 5)[-1]
        assert sample.measured_counts == (0, 130, 130, 130, 130)
        rig.board.reset(rig.now_s)
        rig.advance(0.0)
    rig.go(Mode.ARMED)
    rig.advance(0.01)
    rig.tick([0.0] * 5)
    assert rig.plant.commands[0][1][0] == pytest.approx(0.02, abs=1e-4)


def test_requests_can_be_repeated() -> None:
    rig = Rig()
    for request in REQUESTS:
        assert rig.ask(request) == rig.ask(request)
