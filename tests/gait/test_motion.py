"""Gaits and motions: eq. (27), smooth ramps and changes, limits before and during a run."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from limit_windows import nearest_to_limits

from snakebot.errors import BadInputError
from snakebot.gait import (
    Gait,
    GaitMotion,
    Motion,
    ProbeMotion,
    SampledMotion,
    SlewLimiter,
    check_motion,
    load_gait,
    parse_probe,
)
from snakebot.gait.limits import CREDIT_SLACK_S, WIRE_STEP_RAD
from snakebot.robot import Limits, Robot, load_robot

JOINTS = 5


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("penn_state")


def derivatives(motion: Motion, step: float = 1e-3) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    t = np.arange(-5 * step, motion.duration_s + 5 * step, step)
    angles = motion.sampled(t)
    return angles, np.diff(angles, axis=0) / step, np.diff(angles, n=2, axis=0) / step**2


def test_wave_is_equation_27() -> None:
    gait = Gait.from_degrees(66, 80, 2, offset=5)
    t = 0.37
    for i in range(1, JOINTS + 1):
        phase = 2 * t + (i - 1) * math.radians(80)
        expected = math.radians(5) + math.radians(66) * math.sin(phase)
        assert gait.angles([t], JOINTS)[0, i - 1] == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize(
    ("values", "word"),
    [
        ((-1, 80, 2), "alpha"),
        ((66, 80, -2), "omega"),
        ((math.nan, 80, 2), "alpha_rad"),
        ((66, math.inf, 2), "beta"),
    ],
)
def test_impossible_gaits_are_refused(values: tuple[float, float, float], word: str) -> None:
    with pytest.raises(BadInputError, match=word):
        Gait.from_degrees(*values)


def test_named_gaits_load_and_unknown_ones_are_named(tmp_path) -> None:  # type: ignore[no-untyped-def]
    assert load_gait("penn_state_optimum") == Gait.from_degrees(66, 80, 2)
    with pytest.raises(BadInputError, match="penn_state_optimum"):
        load_gait("no_such_gait")
    broken = tmp_path / "gait.yaml"
    broken.write_text("alpha_deg: 66\nbeta: 80\nomega_rad_s: 2\n")
    with pytest.raises(BadInputError, match="beta is not known"):
        load_gait(broken)


def test_between_the_ramps_the_motion_is_the_wave() -> None:
    gait = Gait.from_degrees(66, 80, 2)
    motion = GaitMotion(gait, JOINTS, 20, 2, start_rad=[0.1] * JOINTS)
    t = np.linspace(2, 18, 400)
    np.testing.assert_allclose(motion.sampled(t), gait.angles(t, JOINTS), atol=1e-12)


def test_a_motion_begins_in_the_posture_found_and_ends_straight() -> None:
    start = [0.3, -0.2, 0.1, 0.0, -0.4]
    motion = GaitMotion(Gait.from_degrees(66, 80, 2), JOINTS, 12, 2, start_rad=start)
    assert motion.angles(0) == pytest.approx(start)
    assert motion.angles(-1) == pytest.approx(start)
    assert motion.angles(12) == pytest.approx([0] * JOINTS)


@settings(max_examples=25, deadline=None)
@given(
    alpha=st.floats(0, 90),
    beta=st.floats(-180, 180),
    omega=st.floats(0.2, 5),
    new_alpha=st.floats(0, 90),
    new_omega=st.floats(0.2, 5),
    at=st.floats(3, 6),
    stop=st.floats(0.2, 12),
)
def test_position_speed_and_acceleration_never_jump(
    alpha: float, beta: float, omega: float, new_alpha: float, new_omega: float, at: float, stop: float
) -> None:
    motion = GaitMotion(Gait.from_degrees(alpha, beta, omega), JOINTS, 14, 2)
    motion = motion.changed(at, Gait.from_degrees(new_alpha, beta / 2, new_omega, 5), 1.5)
    step = 1e-3
    for candidate in (motion, motion.ended(stop)):
        angles, speed, acceleration = derivatives(candidate, step)
        # A jump of a derivative shows as a difference that does not shrink with the step: bound each difference by
        # the step times a generous bound of the next derivative for these parameters.
        assert np.abs(np.diff(angles, axis=0)).max() < 40 * step
        assert np.abs(np.diff(speed, axis=0)).max() < 300 * step
        assert np.abs(np.diff(acceleration, axis=0)).max() < 4000 * step


@settings(max_examples=60, deadline=None)
@given(
    changes=st.lists(
        st.tuples(st.floats(0.1, 3), st.floats(0, 2), st.floats(0, 90), st.floats(0, 5)), max_size=3
    ),
    ramp=st.sampled_from([0.0, 0.5, 2.0]),
    stop=st.none() | st.floats(0.2, 12),
)
def test_sampled_at_once_is_the_same_motion(
    changes: list[tuple[float, float, float, float]], ramp: float, stop: float | None
) -> None:
    motion = GaitMotion(
        Gait.from_degrees(66, 80, 2), JOINTS, 12, ramp, [0.3, -0.2, 0.1, 0, 0], [0.1] * JOINTS
    )
    at_s = 0.0
    for later_s, blend_s, alpha, omega in changes:
        at_s += later_s
        motion = motion.changed(at_s, Gait.from_degrees(alpha, alpha / 2, omega, 5), blend_s)
        at_s += blend_s
    if stop is not None:
        motion = motion.ended(stop)
    t = np.unique([-1.0, *np.linspace(0, 12.5, 97), at_s, motion.duration_s, ramp])
    np.testing.assert_allclose(motion.sampled(t), [motion.angles(float(x)) for x in t], rtol=0, atol=1e-12)


def test_a_change_keeps_the_phase_and_arrives() -> None:
    new = Gait.from_degrees(40, 60, 3)
    motion = GaitMotion(Gait.from_degrees(66, 80, 2), JOINTS, 30, 2).changed(5, new, 2)
    late = np.linspace(8, 27, 200)
    angles = motion.sampled(late)
    assert np.abs(angles).max() == pytest.approx(math.radians(40), rel=1e-3)
    # From 7 s on joint 1 runs at the new frequency, whatever its phase.
    phase0 = 2 * 5 + 2 * 2 + (3 - 2) * 2 * 0.5  # omega old to 5 s, then the blend's integral over 2 s
    np.testing.assert_allclose(angles[:, 0], math.radians(40) * np.sin(phase0 + 3 * (late - 7)), atol=1e-9)
    with pytest.raises(BadInputError, match="last change"):
        motion.changed(6, new, 1)


def test_ramps_that_do_not_fit_are_refused() -> None:
    with pytest.raises(BadInputError, match="no room for two ramps"):
        GaitMotion(Gait.from_degrees(66, 80, 2), JOINTS, 3, 2)


def test_recorded_motion_is_played_back_and_can_be_ended() -> None:
    t = np.linspace(10, 14, 401)
    recorded = Gait.from_degrees(30, 80, 2).angles(t, 3)
    motion = SampledMotion(t, recorded, 1.0)
    assert motion.duration_s == pytest.approx(6.0)
    np.testing.assert_allclose(motion.sampled(1.0 + t - 10), recorded, atol=1e-9)
    assert motion.angles(0) == pytest.approx([0] * 3)
    ended = motion.ended(3.0)
    _, speed, _ = derivatives(ended)
    assert np.abs(speed[-3:]).max() < 1e-9
    with pytest.raises(BadInputError, match="no numbers"):
        SampledMotion(t, np.full((401, 3), np.nan), 1.0)


@pytest.mark.parametrize(
    ("gait", "words"),
    [
        ((96, 80, 1), ("angle", "95", "96")),
        ((66, 80, 9), ("speed", "rad/s", "allows 8")),
        ((20, 80, 15), ("acceleration", "allows 60")),
    ],
)
def test_a_motion_beyond_a_limit_names_joint_demand_and_allowance(
    robot: Robot, gait: tuple[float, float, float], words: tuple[str, ...]
) -> None:
    with pytest.raises(BadInputError, match=r"joint [1-5]: ") as caught:
        check_motion(GaitMotion(Gait.from_degrees(*gait), JOINTS, 20, 3), robot)
    for word in words:
        assert word in str(caught.value)


def limiter_of(robot: Robot) -> SlewLimiter:
    return SlewLimiter(robot.angle_limit_rad, robot.speed_limit_rad_s, robot.acceleration_limit_rad_s2)


@pytest.mark.parametrize("rate", [20, 100, 500, 1000, 2000])
def test_a_motion_within_limits_passes_the_limiter_unchanged(robot: Robot, rate: float) -> None:
    motion = GaitMotion(Gait.from_degrees(66, 80, 2), JOINTS, 12, 2)
    limiter = limiter_of(robot)
    targets, angles = [], []
    for k in range(int(12 * rate)):
        target = [round(angle / WIRE_STEP_RAD) * WIRE_STEP_RAD for angle in motion.angles(k / rate)]
        executed = limiter.execute(target, 1 / rate, 1, 1 / rate)
        assert executed is not None
        assert executed[1] == 0
        targets.append(target)
        angles.append(executed[0])
    assert np.array(angles) == pytest.approx(np.array(targets), abs=1e-9)


@settings(max_examples=60, deadline=None)
@given(
    data=st.data(),
    angle=st.floats(0.2, 3),
    speed=st.floats(0.5, 20),
    acceleration=st.floats(2, 200),
)
def test_nothing_executed_breaks_a_limit(
    data: st.DataObject, angle: float, speed: float, acceleration: float
) -> None:
    """Whatever is asked for, however it is timed: angle, speed and acceleration hold beyond the wire's resolution."""
    limiter = SlewLimiter([angle], [speed], [acceleration])
    steps = data.draw(
        st.lists(
            st.tuples(
                st.floats(-4, 4),
                st.sampled_from([0.0005, 0.001, 0.002, 0.01, 0.02, 0.05]),
                st.integers(1, 6),
                st.floats(0, 0.1),
                st.integers(1, 20),
            ),
            min_size=5,
            max_size=60,
        )
    )
    now, times, positions = 0.0, [0.0], [0.0]
    for target, interval, gap, elapsed, times_over in steps:
        for _ in range(times_over):
            now += elapsed
            credit_before = limiter._credit_s
            result = limiter.execute([target], interval, gap, elapsed)
            if result is None:
                continue
            times.append(times[-1] + min(interval * min(gap, 4), credit_before + elapsed))
            positions.append(result[0][0])
    assert max(map(abs, positions)) <= angle + 1e-9
    nearest_to_limits(times, positions, speed, acceleration, 1.01 * WIRE_STEP_RAD)
    assert times[-1] <= now + CREDIT_SLACK_S + 1e-9  # a burst cannot make time


@pytest.mark.parametrize("rate", [20, 100, 250, 500, 1000, 2000])
def test_a_limit_is_the_same_at_any_rate(rate: float) -> None:
    """From rest to 0.5 rad and back: what rounding needs is granted once, not at each tick."""
    limiter = SlewLimiter([1.6], [8.0], [60.0])
    times, positions = [0.0], [0.0]
    for k in range(2 * int(rate)):
        result = limiter.execute([0.5 if k < rate else 0.0], 1 / rate, 1, 1 / rate)
        assert result is not None
        times.append((k + 1) / rate)
        positions.append(result[0][0])
    _, acceleration = nearest_to_limits(times, positions, 8.0, 60.0, WIRE_STEP_RAD)
    assert acceleration > 0.9, "slower than the limits"


@pytest.mark.parametrize("share", [0.5, 0.9])
@pytest.mark.parametrize("rate", [20, 100, 250, 500, 1000])
def test_a_joint_that_was_left_behind_catches_up_with_a_moving_target(rate: float, share: float) -> None:
    """As a joint does that gets its power back in mid-run: it comes to its set-points and stays with them."""
    limiter = SlewLimiter([1.6], [8.0], [60.0])
    limiter.follow(0, -0.6)
    late = 0
    for k in range(int(4 * rate)):
        target = round(share * 60 / 64 * math.sin(8 * k / rate), 4)
        result = limiter.execute([target], 1 / rate, 1, 1 / rate)
        assert result is not None
        if k > 2.5 * rate:
            late += result[1]
    assert late == 0


class Drawn(Motion):
    """A motion drawn point by point: whatever a fault of ours, or of a file's numbers, could make of one."""

    def __init__(self, angles_rad: list[float]) -> None:
        self.joints, self.duration_s = JOINTS, 1.0
        self._angles_rad = angles_rad

    def angles(self, t_s: float) -> list[float]:
        row = [0.0] * JOINTS
        row[2] = self._angles_rad[int(max(t_s, 0.0) * 100) % len(self._angles_rad)]
        return row

    def ended(self, t_s: float) -> Motion:
        return self


@pytest.mark.parametrize(
    ("angles_rad", "word"),
    [
        ([0.0, math.nan], "angle"),
        ([math.nan], "angle"),
        ([0.0] * 50 + [math.inf], "angle"),
        ([-math.inf], "angle"),
    ],
)
def test_a_motion_with_a_sample_that_is_no_number_is_refused(
    robot: Robot, angles_rad: list[float], word: str
) -> None:
    with pytest.raises(BadInputError, match=f"joint 3: the motion's {word} is no finite number at"):
        check_motion(Drawn(angles_rad), robot)


def test_speeds_beyond_a_float_are_refused() -> None:
    wide = load_robot("penn_state").model_copy(
        update={"limits": Limits(angle_deg=1.7e308, speed_rad_s=1e308, acceleration_rad_s2=1e308)}
    )
    with pytest.raises(BadInputError, match=r"joint 3: the motion's speed is no finite number"):
        check_motion(Drawn([0.0, 2e306]), wide)
    with pytest.raises(BadInputError, match=r"joint 3: the motion's acceleration is no finite number"):
        check_motion(Drawn([0.0, 1e305]), wide)


@pytest.mark.parametrize("omega_rad_s", [2 * math.pi / 0.002, 1e5, 1e300, 1e308])
@pytest.mark.parametrize("alpha_deg", [0.0, 20.0])
def test_a_wave_that_the_check_cannot_resolve_is_refused(
    robot: Robot, omega_rad_s: float, alpha_deg: float
) -> None:
    """At 500 Hz every sample of the check sees the same angle: it would stand still."""
    with pytest.raises(BadInputError, match=r"the motion swings at .* lower --omega"):
        check_motion(GaitMotion(Gait.from_degrees(alpha_deg, 80, omega_rad_s), JOINTS, 5, 1), robot)
    slow = GaitMotion(Gait.from_degrees(20, 80, 2), JOINTS, 20, 1)
    with pytest.raises(BadInputError, match="swings at"):
        check_motion(slow.changed(5.0, Gait.from_degrees(20, 80, omega_rad_s), 1.0), robot)
    with pytest.raises(BadInputError, match="lower omega_rad_s of --probe"):
        probe = parse_probe(f"sine:amplitude_deg=10,omega_rad_s=1+{omega_rad_s!r}")
        check_motion(ProbeMotion(probe, JOINTS, 20, 1), robot)
