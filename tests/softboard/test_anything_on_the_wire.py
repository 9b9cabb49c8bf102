"""Frames of any kind in any order at any time: the board stands, and what must always hold does."""

from __future__ import annotations

from typing import Any

from board_rig import HOST, OTHER, Rig
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.assembly import setpoint_messages
from firmware_protocol.catalogue import (
    MESSAGES,
    NOBODY,
    BoardHeartbeat,
    ClearRequest,
    EmergencyStop,
    Fault,
    HostHeartbeat,
    JointMode,
    JointModeRequest,
    Message,
    Mode,
    ModeRequest,
    decode,
    encode,
    frame_id,
)
from firmware_protocol.frame import Frame, ProtocolError

hosts = st.sampled_from([HOST, OTHER, 0])
known = st.sampled_from([frame_id(kind) for kind in MESSAGES.values()])
noise = st.builds(Frame, known | st.integers(0, 0x7FF), st.binary(max_size=8))
whole = st.builds(Frame, known, st.binary(min_size=8, max_size=8))
requests: st.SearchStrategy[Message] = st.one_of(
    st.builds(ModeRequest, st.integers(0, 255), st.sampled_from(Mode), hosts),
    st.builds(
        JointModeRequest,
        st.integers(0, 255),
        st.integers(1, 5),
        st.sampled_from(JointMode),
        st.floats(-2, 2),
        hosts,
    ),
    st.builds(ClearRequest, st.integers(0, 255), st.integers(0, 4), hosts),
    st.builds(HostHeartbeat, hosts, st.integers(0, 65535)),
    st.just(EmergencyStop()),
)
tick = st.tuples(st.integers(0, 65535), st.lists(st.floats(-3.2, 3.2), min_size=5, max_size=5))
passing = st.sampled_from([0.0, 0.001, 0.01, 0.0999, 0.1, 0.5, 1.0, 2.0, 5.0])


def clears(event: object, latch: int) -> bool:
    """It is a request to clear this latch."""
    if isinstance(event, Frame):
        try:
            event = decode(event)
        except ProtocolError:
            return False
    return isinstance(event, ClearRequest) and event.number == latch and event.host != NOBODY


@settings(max_examples=150, deadline=None)
@given(st.lists(noise | whole | requests | tick | passing, max_size=60))
def test_the_board_stands_and_its_rules_hold(events: list[Any]) -> None:
    rig = Rig()
    board, plant = rig.board, rig.plant
    limits = rig.robot.angle_limit_rad
    for event in events:
        before, commands, applied = board.mode, len(plant.commands), board._register.servo_rad
        latch = board._machine.latch
        if isinstance(event, float):
            rig.advance(event)
        elif isinstance(event, Frame):
            board.receive(event, rig.now_s)
        elif isinstance(event, Message):
            board.receive(encode(event), rig.now_s)
        else:
            for message in setpoint_messages(event[0], event[1], 0.01):
                board.receive(encode(message), rig.now_s)
        said = [decode(frame) for frame in board.advance(rig.now_s)]

        if board.mode in (Mode.DISARMED, Mode.STOPPED):
            assert set(plant.modes) == {"free"}
        if before in (Mode.STOPPED, Mode.FAULT):
            cleared = clears(event, latch)
            assert board.mode in ((Mode.DISARMED,) if cleared else (before, Mode.STOPPED)), (
                "only a clear leads out"
            )
        if board.mode is Mode.FAULT:
            assert before in (Mode.ARMED, Mode.HOLDING, Mode.FAULT)
        if len(plant.commands) > commands:
            assert before in (Mode.ARMED, Mode.HOLDING, Mode.DISARMED)
        if before is Mode.ARMED and board.mode is Mode.ARMED:
            for index, (was, now) in enumerate(zip(applied, board._register.servo_rad, strict=True)):
                if plant.modes[index] == "active":
                    assert abs(now) <= max(limits[index], abs(was)) + 1e-9
        for beat in said:
            if isinstance(beat, BoardHeartbeat):
                assert (beat.holder == NOBODY) or beat.mode is not Mode.DISARMED
                assert (beat.fault is Fault.NONE) == (beat.mode not in (Mode.STOPPED, Mode.FAULT))
        assert board.next_event_s > rig.now_s


@settings(max_examples=50, deadline=None)
@given(st.lists(noise | whole | tick, max_size=30))
def test_a_stop_is_obeyed_whatever_came_before(events: list[Any]) -> None:
    rig = Rig()
    rig.go(Mode.ARMED)
    for event in events:
        frames = (
            [event] if isinstance(event, Frame) else map(encode, setpoint_messages(event[0], event[1], 0.01))
        )
        for frame in frames:
            rig.board.receive(frame, rig.now_s)
    rig.board.receive(Frame(1, b""), rig.now_s)
    assert rig.board.mode is Mode.STOPPED
    assert set(rig.plant.modes) == {"free"}
