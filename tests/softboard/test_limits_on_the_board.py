"""Whatever a host sends, whenever it sends it: no executed set-point breaks a joint's limits."""

from __future__ import annotations

import itertools
import math
import random

import pytest
from board_rig import HOST, Rig
from hypothesis import given, settings
from hypothesis import strategies as st
from limit_windows import nearest_to_limits

from firmware_protocol.assembly import setpoint_messages
from firmware_protocol.catalogue import (
    Counters,
    LimitKind,
    LimitRequest,
    Mode,
    ModeRequest,
    encode,
)
from snakebot.softboard.register import SetpointRegister

STEP_RAD = 1e-4  # the wire's resolution
EARLY_S = 0.020  # by how much a set-point may come early, in all

ticks = st.lists(
    st.tuples(
        st.floats(-3.2, 3.2),  # target
        st.sampled_from(
            [0.0005, 0.001, 0.002, 0.005, 0.01, 0.01, 0.02, 0.05, 0.1275]
        ),  # interval, as declared
        st.sampled_from([1, 1, 1, 2, 3, 7, 300]),  # step of the sequence number
        st.sampled_from([0.0, 0.0, 0.0003, 0.002, 0.01, 0.01, 0.02, 0.05, 0.0999]),  # time that passes
    ),
    min_size=2,
    max_size=60,
)
# target_rad, declared interval_s, step of the sequence number, time that passes (s)
Target = tuple[float, float, int, float]
limits = st.tuples(st.floats(0.2, 1.6), st.floats(0.5, 8.0), st.floats(1.0, 100.0))


def run(
    stream: list[Target], limit: tuple[float, float, float], start_rad: float
) -> list[tuple[float, float, float]]:
    """(time, time that the set-point could use, executed angle) of each executed set-point."""
    register = SetpointRegister([limit[0]], [limit[1]], [limit[2]], [0.0])
    register.follow(0, start_rad)
    register.start(0.0)
    t_s = executed_s = 0.0
    sequence, credit_s = 65500, EARLY_S
    executed = [(0.0, 0.0, start_rad)]
    for target_rad, interval_s, step, passes_s in stream:
        t_s += passes_s
        first = len(executed) == 1
        sequence = (sequence + step) % 65536
        tick = None
        for message in setpoint_messages(sequence, [target_rad], interval_s):
            tick = register.assemble(encode(message)) or tick
        assert tick is not None
        declared_s = interval_s * (1 if first else min(tick.step, 4))
        available_s = min(credit_s + (t_s - executed_s), declared_s + EARLY_S)
        dt_s = min(declared_s, available_s)
        if dt_s < 0.0005:
            assert not register.execute(tick, t_s), "too early"
            continue
        assert register.execute(tick, t_s)
        credit_s, executed_s = available_s - dt_s, t_s
        executed.append((t_s, dt_s, register.applied_rad[0]))
    return executed


def nearest(
    executed: list[tuple[float, float, float]], limit: tuple[float, float, float]
) -> tuple[float, float]:
    """The stream against its limits, in the time that its set-points could use."""
    times = list(itertools.accumulate(dt_s for _, dt_s, _ in executed))
    return nearest_to_limits(times, [now for *_, now in executed], limit[1], limit[2], 1.01 * STEP_RAD)


@settings(max_examples=80, deadline=None)
@given(ticks, limits, st.floats(-1.0, 1.0))
def test_no_executed_setpoint_breaks_a_limit(
    stream: list[Target], limit: tuple[float, float, float], start_share: float
) -> None:
    executed = run(stream, limit, start_share * limit[0])
    assert all(abs(now) <= limit[0] + 1e-12 for *_, now in executed)
    nearest(executed, limit)
    if len(executed) > 1:
        (_, _, before), (_, dt_s, now) = executed[:2]  # the first one from rest
        assert abs(now - before) <= limit[2] * dt_s**2 + 1.01 * STEP_RAD


@settings(max_examples=80, deadline=None)
@given(
    st.lists(st.sampled_from([-3.0, 3.0]) | st.floats(-3.2, 3.2), min_size=2, max_size=100),
    st.sampled_from([0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05]),
    limits,
    st.floats(-1.0, 1.0),
    st.integers(1, 60),
)
def test_at_a_steady_rate_a_joint_brakes_in_time_for_its_end(
    targets: list[float],
    interval_s: float,
    limit: tuple[float, float, float],
    start_share: float,
    ticks_each: int,
) -> None:
    stream = [(target, interval_s, 1, interval_s) for target in targets for _ in range(ticks_each)]
    executed = run(stream, limit, start_share * limit[0])
    assert all(abs(now) <= limit[0] + 1e-12 for *_, now in executed)
    nearest(executed, limit)


@pytest.mark.parametrize("rate_hz", [20, 100, 250, 500, 1000, 2000])
@pytest.mark.parametrize("limit", [(1.6, 8.0, 60.0), (0.4, 2.0, 8.0), (1.6, 8.0, 250.0)])
def test_a_jump_is_made_up_for_as_fast_as_the_limits_allow_and_ends_at_rest(
    rate_hz: int, limit: tuple[float, float, float]
) -> None:
    """The target jumps and stays: the joint goes there at its limits, neither faster nor past it."""
    _, speed, acceleration = limit
    way = 0.7 * limit[0]
    stream = [(way, 1 / rate_hz, 1, 1 / rate_hz)] * (2 * rate_hz)
    executed = run(stream, limit, 0.0)
    nearest(executed, limit)
    peak = min(speed, math.sqrt(acceleration * way))
    shortest_s = way / peak + peak / acceleration
    arrived_s = next(t_s for t_s, _, now in executed if abs(now - way) < STEP_RAD / 2)
    assert arrived_s <= shortest_s + 0.02 + 2 / rate_hz
    assert all(abs(now - way) < 1e-9 for t_s, _, now in executed if t_s > arrived_s + 2 / rate_hz)
    assert max(now for *_, now in executed) <= way + STEP_RAD


@pytest.mark.parametrize("rate_hz", [20, 100, 250, 500, 1000, 2000])
@pytest.mark.parametrize("limit", [(1.6, 8.0, 60.0), (1.6, 2.5, 8.0)])
def test_rounding_does_not_look_like_a_broken_limit_at_any_rate(
    rate_hz: int, limit: tuple[float, float, float]
) -> None:
    """Moves to and fro at 90 % of the limits, rounded to the wire, some ticks lost: nothing is changed."""
    speed, acceleration, way = 0.9 * limit[1], 0.9 * limit[2], 0.6

    def angle(t_s: float) -> float:
        peak = min(speed, math.sqrt(acceleration * way))
        rising_s = peak / acceleration
        there_s = rising_s + way / peak
        turns, t_s = divmod(t_s, there_s)
        if t_s < rising_s:
            gone = acceleration * t_s**2 / 2
        elif t_s < there_s - rising_s:
            gone = peak * (t_s - rising_s / 2)
        else:
            gone = way - acceleration * (there_s - t_s) ** 2 / 2
        return gone if turns % 2 == 0 else way - gone

    draw = random.Random(rate_hz)
    stream, tick = [], 0
    while tick < 3 * rate_hz:
        lost = 1 if draw.random() < 0.9 else draw.randint(1, 2)
        tick += lost
        stream.append((round(angle(tick / rate_hz), 4), 1 / rate_hz, lost, lost / rate_hz))
    executed = run(stream, limit, 0.0)
    assert len(executed) == len(stream) + 1
    for (target, *_), (_, _, now) in zip(stream, executed[1:], strict=True):
        assert abs(now - target) < STEP_RAD / 2
    assert nearest(executed, limit)[1] > 0.5, "the limit was never near"


@settings(max_examples=80, deadline=None)
@given(ticks, limits, st.floats(-1.0, 1.0))
def test_on_the_clock_no_more_is_moved_than_time_has_passed(
    stream: list[Target], limit: tuple[float, float, float], start_share: float
) -> None:
    """Bursts and lies about the interval included: over any stretch of time the mean speed is within the limit."""
    executed = run(stream, limit, start_share * limit[0])
    for i, (from_s, _, before) in enumerate(executed):
        for to_s, _, now in executed[i:]:
            allowed = limit[1] * (to_s - from_s + EARLY_S) + 2 * STEP_RAD
            assert abs(now - before) <= allowed + 1e-9


@settings(max_examples=80, deadline=None)
@given(ticks, limits, st.floats(0.01, 1.0), st.sampled_from([-1, 1]))
def test_a_joint_that_starts_outside_its_limit_only_goes_inwards(
    stream: list[Target], limit: tuple[float, float, float], outside_rad: float, side: int
) -> None:
    executed = run(stream, limit, side * (limit[0] + outside_rad))
    furthest = limit[0] + outside_rad
    for _, _, now in executed:
        assert abs(now) <= furthest + 1e-9
        furthest = max(abs(now), limit[0])


def test_a_motion_within_the_limits_is_executed_as_it_is() -> None:
    rig = Rig()
    rig.advance(0.01)
    rig.go(Mode.ARMED)
    for index in range(500):
        rig.advance(0.01)
        t_s = 0.01 * (index + 1)
        u = min(t_s / 2.0, 1.0)
        ramp = u**3 * (10 - 15 * u + 6 * u**2)
        rig.tick([1.15 * ramp * math.sin(2 * t_s + 1.4 * joint) for joint in range(5)])
    counters = [m for m in rig.advance(1.0) if isinstance(m, Counters)][-1]
    assert (counters.clamped, counters.dropped, counters.corrupt) == (0, 0, 0)


def test_a_changed_setpoint_is_counted_once_however_many_joints() -> None:
    rig = Rig()
    rig.advance(0.01)
    rig.go(Mode.ARMED)
    rig.advance(0.01)
    rig.tick([1.0] * 5)
    counters = [m for m in rig.advance(1.0) if isinstance(m, Counters)][-1]
    assert counters.clamped == 1


def test_a_tightened_limit_holds_at_once() -> None:
    rig = Rig()
    rig.advance(0.01)
    rig.go(Mode.ARMED)
    rig.say(LimitRequest(1, 2, LimitKind.ANGLE, 0.1, 0xA11CE))
    rig.stream(1.0, [0.5] * 5)
    assert rig.plant.commands[-1][1] == [0.5, 0.1, 0.5, 0.5, 0.5]


@pytest.mark.parametrize("between", [Mode.HOLDING, Mode.DISARMED])
@pytest.mark.parametrize(("rounds", "pause_s"), [(63, 0.0), (200, 0.001)])
def test_changing_the_mode_to_and_fro_gains_no_time(between: Mode, rounds: int, pause_s: float) -> None:
    """24 rad/s against 8 by a change each millisecond, 1.5 rad in no time by 63 in one batch, where it did."""
    rig = Rig()
    rig.advance(0.01)
    rig.go(Mode.ARMED)
    rig.stream(0.05)
    began_s, start_rad = rig.now_s, rig.board._register.servo_rad[0]
    for _ in range(rounds):
        rig.say(ModeRequest(1, between, HOST), ModeRequest(2, Mode.ARMED, HOST))
        rig.tick([1.6] * 5, 0.02)
        moved = rig.board._register.servo_rad[0] - start_rad
        assert moved <= 8.0 * (rig.now_s - began_s + EARLY_S) + 2 * STEP_RAD
        rig.advance(pause_s)


def test_each_change_of_mode_starts_from_rest_without_a_new_slack() -> None:
    """A tight limit shows it: a step of the wire each millisecond would be 0.1 rad/s."""
    rig = Rig()
    for kind, value in ((LimitKind.SPEED, 0.02), (LimitKind.ACCELERATION, 1.0)):
        rig.say(LimitRequest(1, 1, kind, value, HOST))
    rig.go(Mode.ARMED)
    began_s = rig.now_s
    for _ in range(500):
        rig.advance(0.001)
        rig.say(ModeRequest(1, Mode.HOLDING, HOST), ModeRequest(2, Mode.ARMED, HOST))
        rig.tick([1.0] * 5, 0.001)
    moved = rig.board._register.servo_rad[0]
    assert moved <= 0.02 * (rig.now_s - began_s + EARLY_S) + 2 * STEP_RAD
