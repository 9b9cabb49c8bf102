"""Probes: what is written is what moves, within the limits asked for, from rest to rest."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from snakebot.errors import BadInputError
from snakebot.gait import Probe, ProbeMotion, SlewLimiter, check_motion, parse_probe, probe_span_s
from snakebot.gait.limits import WIRE_STEP_RAD
from snakebot.robot import load_robot

JOINTS = 5
RAMP_S = 2.0
ROBOT = load_robot("penn_state")


def not_too_long(probe: Probe) -> bool:
    return probe_span_s(probe, 2) < 25


some_joints = st.one_of(
    st.none(), st.lists(st.integers(1, JOINTS), min_size=1, max_size=3, unique=True).map(tuple)
)
moves = st.builds(
    Probe,
    kind=st.sampled_from(["triangle", "steps"]),
    amplitude_rad=st.floats(0.01, 1.2),
    joints=some_joints,
    offset_rad=st.floats(-0.5, 0.5),
    rate_rad_s=st.floats(0.05, 7.0),
    acceleration_rad_s2=st.floats(1.0, 55.0),
    hold_s=st.floats(0.0, 0.6),
    steps=st.integers(1, 4),
).filter(not_too_long)
sines = st.builds(
    Probe,
    kind=st.just("sine"),
    amplitude_rad=st.floats(0.01, 0.5),
    joints=some_joints,
    offset_rad=st.floats(-0.4, 0.4),
    omega_rad_s=st.lists(st.floats(0.5, 8.0), min_size=1, max_size=3).map(tuple),
).filter(not_too_long)


def motion_of(probe: Probe, cycles: int = 2, start: list[float] | None = None) -> ProbeMotion:
    return ProbeMotion(probe, JOINTS, probe_span_s(probe, cycles) + 2 * RAMP_S, RAMP_S, start)


def differences(
    motion: ProbeMotion, step: float = 1e-3
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    t = np.arange(-5 * step, motion.duration_s + 5 * step, step)
    angle = motion.sampled(t)
    return t, angle, np.diff(angle, axis=0) / step, np.diff(angle, n=2, axis=0) / step**2


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(probe=moves)
def test_between_the_ramps_a_probe_keeps_its_own_amplitude_rate_and_acceleration(probe: Probe) -> None:
    motion = motion_of(probe)
    t, angle, speed, acceleration = differences(motion)
    inner = (t > RAMP_S + 0.005) & (t < motion.duration_s - RAMP_S - 0.005)
    moved = list(probe.joint_indices(JOINTS))
    way = angle[inner][:, moved] - probe.offset_rad
    assert np.abs(way).max() <= probe.amplitude_rad + 1e-9
    assert np.abs(way).max() > 0.98 * probe.amplitude_rad - 1e-3 * probe.rate_rad_s
    assert np.abs(speed[inner[:-1]]).max() <= probe.rate_rad_s * (1 + 1e-6)
    assert np.abs(acceleration[inner[:-2]]).max() <= probe.acceleration_rad_s2 * (1 + 1e-6)
    still = [joint for joint in range(JOINTS) if joint not in moved]
    assert np.abs(angle[:, still]).max(initial=0) == 0


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    probe=st.one_of(moves, sines),
    start=st.lists(st.floats(-0.3, 0.3), min_size=JOINTS, max_size=JOINTS),
    stop=st.one_of(st.none(), st.floats(0.1, 20)),
)
def test_every_probe_starts_where_the_robot_is_and_ends_straight_at_rest_without_a_jump(
    probe: Probe, start: list[float], stop: float | None
) -> None:
    motion = motion_of(probe, start=start)
    if stop is not None:
        motion = motion.ended(stop)
    _, angle, speed, acceleration = differences(motion)
    assert angle[0] == pytest.approx(start)
    assert angle[-1] == pytest.approx([0] * JOINTS, abs=1e-12)
    assert np.abs(speed[[0, -1]]).max() < 1e-9
    assert np.abs(acceleration).max() < 250  # a jump of the speed v would be v / 1 ms
    assert np.abs(np.diff(angle, axis=0)).max() < 20e-3


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(probe=st.one_of(moves, sines), rate=st.sampled_from([50, 100, 500, 1000]))
def test_a_probe_that_passes_the_check_passes_the_limiter_unchanged(probe: Probe, rate: float) -> None:
    motion = motion_of(probe, 1)
    try:
        check_motion(motion, ROBOT)
    except BadInputError:
        assume(False)
    limiter = SlewLimiter(
        ROBOT.angle_limit_rad, ROBOT.speed_limit_rad_s, [a * 1.001 for a in ROBOT.acceleration_limit_rad_s2]
    )
    rows = motion.sampled(np.arange(0, motion.duration_s, 1 / rate))
    targets = np.round(rows / WIRE_STEP_RAD) * WIRE_STEP_RAD
    angles = []
    for target in targets.tolist():
        executed = limiter.execute(target, 1 / rate, 1, 1 / rate)
        assert executed is not None
        angles.append(executed[0])
    assert np.array(angles) == pytest.approx(targets, abs=1e-9)


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(probe=st.one_of(moves, sines))
def test_what_a_probe_prints_is_read_as_the_same_motion(probe: Probe) -> None:
    again = parse_probe(str(probe))
    assert str(again) == str(probe)
    assert (again.kind, again.joints) == (probe.kind, probe.joints)
    t = np.linspace(0, probe_span_s(probe, 1), 200)
    a, b = motion_of(probe, 1), motion_of(again, 1)
    np.testing.assert_allclose(a.sampled(t), b.sampled(t), atol=1e-5)


def test_a_triangle_has_constant_speed_between_its_turns() -> None:
    probe = parse_probe("triangle:amplitude_deg=5,rate_deg_s=10,joints=3")
    motion = motion_of(probe, 3)
    _, _, speed, _ = differences(motion)
    cruising = np.isclose(np.abs(speed[:, 2]), math.radians(10), rtol=1e-6)
    assert cruising.mean() > 0.5
    assert np.count_nonzero(np.diff(np.sign(speed[:, 2][cruising]))) == 6  # up, down, up, down, up, down, up


def test_steps_grow_and_rest() -> None:
    motion = motion_of(parse_probe("steps:amplitude_deg=20,steps=4,hold_s=0.5"), 1)
    _, angle, speed, _ = differences(motion)
    rests = np.degrees(angle[:-1, 0][np.abs(speed[:, 0]) < 1e-9])
    found = sorted({round(float(rest), 6) + 0.0 for rest in rests})
    assert found == pytest.approx([-20, -15, -10, -5, 0, 5, 10, 15, 20], abs=1e-6)


def test_a_sine_of_two_frequencies_has_both() -> None:
    motion = ProbeMotion(parse_probe("sine:amplitude_deg=10,omega_rad_s=1+8"), 2, 44, 2)
    for span, omega in (((3, 21), 1), ((24, 41), 8)):
        t = np.arange(*span, 0.01)
        angle = motion.sampled(t)[:, 1]
        design = np.column_stack([np.sin(omega * t), np.cos(omega * t)])
        rest = angle - design @ np.linalg.lstsq(design, angle, rcond=None)[0]
        assert np.abs(rest).max() < 1e-9


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("square:amplitude_deg=5", "triangle, steps, sine"),
        ("triangle:amplitude_deg=5", "needs rate_deg_s"),
        ("triangle:amplitude_deg=5,rate_deg_s=10,hold_s=1", "not understood"),
        ("triangle:amplitude_deg=5,rate_deg_s=0", "above 0"),
        ("triangle:amplitude_deg=-5,rate_deg_s=3", "above 0"),
        ("triangle:amplitude_deg=5,rate_deg_s=ten", "not a number"),
        ("triangle:amplitude_deg=5,rate_deg_s=nan", "not a number"),
        ("triangle:amplitude_deg=5,amplitude_deg=6,rate_deg_s=1", "twice"),
        ("triangle:amplitude_deg=5+6,rate_deg_s=1", "one number"),
        ("steps:amplitude_deg=5,steps=2.5", "whole"),
        ("steps:amplitude_deg=5,steps=1000", "at most"),
        ("steps:amplitude_deg=5,joints=0", "from 1"),
        ("steps:amplitude_deg=5,joints=2+2", "each once"),
        ("sine:amplitude_deg=5,omega_rad_s=0", "above 0"),
    ],
)
def test_what_is_no_probe_is_one_line(text: str, word: str) -> None:
    with pytest.raises(BadInputError, match=word) as caught:
        parse_probe(text)
    assert "\n" not in str(caught.value)


def test_joints_that_do_not_exist_times_that_do_not_fit_and_limits_are_named() -> None:
    with pytest.raises(BadInputError, match="joint 7 of a robot with 5"):
        motion_of(parse_probe("steps:amplitude_deg=5,joints=7"))
    with pytest.raises(BadInputError, match="no room for it"):
        ProbeMotion(parse_probe("triangle:amplitude_deg=50,rate_deg_s=1"), JOINTS, 10, 2)
    with pytest.raises(BadInputError, match=r"joint 3.*acceleration.*lower acceleration_rad_s2 of --probe"):
        check_motion(motion_of(parse_probe("steps:amplitude_deg=20,acceleration_rad_s2=100,joints=3")), ROBOT)
