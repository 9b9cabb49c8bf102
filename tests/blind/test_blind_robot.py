"""The stand-in for reality moves as the paper's robot does, and its faults leave the marks they should."""

import numpy as np
import pytest
from blind.faults import FAULTS, draw_joints
from blind.robot import Parameters, Recording, Robot, gait_command, real_robot

TICK_S = 0.01
T = np.arange(0.0, 14.0, TICK_S)
GAIT = (np.radians(66), np.radians(80), 2.0)


def run(parameters: Parameters, gait: tuple[float, float, float] = GAIT, seed: int = 0) -> Recording:
    return Robot(parameters).run(T, gait_command(T, *gait), np.random.default_rng(seed))


def faulty(name: str, magnitude: float, at: list[int] | None = None) -> Recording:
    p = Parameters().noiseless()
    joints = np.arange(5) if at is None else np.array(at)
    FAULTS[name].apply(p, joints, magnitude, np.random.default_rng(0))
    return run(p)


@pytest.fixture(scope="module")
def clean() -> Recording:
    return run(Parameters().noiseless())


def speed(r: Recording) -> float:
    """Over the last two cycles."""
    first = np.searchsorted(r.t_s, r.t_s[-1] - 2 * np.pi)
    return float(np.linalg.norm(r.pose[-1, :2] - r.pose[first, :2]) / (r.t_s[-1] - r.t_s[first]))


def test_speed_is_the_published_models(clean: Recording) -> None:
    # 0.137 m/s: (14)-(25) with prescribed joints at (66, 80, 2); the lag of the servos takes a little of it
    assert speed(clean) == pytest.approx(0.137, rel=0.04)


def test_nominal_servo_is_a_lag_of_30_ms(clean: Recording) -> None:
    late = np.zeros_like(clean.command_rad)
    for i in range(1, T.size):
        late[i] = clean.command_rad[i - 1] + (late[i - 1] - clean.command_rad[i - 1]) * np.exp(-TICK_S / 0.03)
    rate = np.gradient(late, TICK_S, axis=0)[200:]
    ahead_s = ((clean.encoder_rad - late)[200:] * rate).sum(axis=0) / (rate**2).sum(axis=0)
    assert np.abs(ahead_s).max() < 0.001  # the background's scatter is 3 % of 30 ms


def test_encoders_are_quantised_and_noisy_runs_repeat_only_with_the_seed() -> None:
    p = real_robot(np.random.default_rng(3))
    first, same, other = run(p, seed=1), run(p, seed=1), run(p, seed=2)
    counts = first.encoder_rad / (2 * np.pi / 8192)
    assert np.allclose(counts, np.round(counts), atol=1e-6)
    assert np.array_equal(first.encoder_rad, same.encoder_rad)
    assert not np.array_equal(first.encoder_rad, other.encoder_rad)


def test_rate_limit_is_kept() -> None:
    rate = np.abs(np.diff(faulty("rate_limit", 4.0, [2]).encoder_rad, axis=0)) / TICK_S
    # of the motor; the load sways the output a little about it
    assert np.median(rate[:, 2]) == pytest.approx(1.0, rel=0.05)
    assert rate[:, 2].max() < 1.45
    assert rate[:, 1].max() > 1.8


def test_torque_limit_weakens_only_the_joints_named(clean: Recording) -> None:
    change = np.sqrt(np.mean((faulty("torque_limit", 8.0, [2]).encoder_rad - clean.encoder_rad) ** 2, axis=0))
    assert np.argmax(change) == 2
    assert change[2] > 5 * np.delete(change, 2).max()


def test_play_lets_the_output_go_to_both_sides_and_no_farther_than_half_of_it(clean: Recording) -> None:
    off = np.degrees(faulty("backlash", 6.0, [0]).encoder_rad - clean.encoder_rad)[400:, 0]
    assert 0.8 < off.max() < 3.2
    assert -3.2 < off.min() < -0.8


def test_joint_rigid_and_free(clean: Recording) -> None:
    assert np.degrees(np.ptp(faulty("joint_rigid", 1.0, [2]).encoder_rad[100:, 2])) < 3
    assert speed(faulty("joint_free", 1.0, [2])) < 0.6 * speed(clean)  # 0.30 in the published reference


def test_encoder_faults_leave_the_path_alone(clean: Recording) -> None:
    for name in ("encoder_offset", "encoder_gain", "encoder_eccentricity"):
        r = faulty(name, 0.3)
        assert np.array_equal(r.pose, clean.pose)
        assert not np.allclose(r.encoder_rad, clean.encoder_rad, atol=1e-4)


@pytest.mark.slow
def test_each_fault_does_something(clean: Recording) -> None:
    for name, fault in FAULTS.items():
        r = faulty(name, float(fault.low**0.3 * fault.high**0.7), [1, 2] if name == "wiring" else [1])
        moved = np.abs(r.pose - clean.pose).max() if fault.stage == "body" else 0
        assert max(moved, np.abs(r.encoder_rad - clean.encoder_rad).max()) > 1e-3, name


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_a_hundred_faulty_robots_at_the_ends_of_the_ranges_stay_in_one_piece() -> None:
    rng = np.random.default_rng(0)
    t = np.arange(0.0, 5.0, TICK_S)
    for number in range(100):
        p = real_robot(rng)
        name = list(FAULTS)[number % len(FAULTS)]
        fault, joints = FAULTS[name], draw_joints(name, rng)
        magnitude = (fault.low, fault.high, (fault.low * fault.high) ** 0.5)[number % 3]
        fault.apply(p, np.arange(5) if joints is None else joints, magnitude, rng)
        gait = (np.radians(rng.uniform(5, 70)), np.radians(80), rng.uniform(0.5, 5))
        r = Robot(p).run(t, gait_command(t, *gait), rng)  # raises where it blows up
        assert np.abs(r.pose[:, :2]).max() < 20, name
        if name not in ("joint_free", "encoder_offset", "encoder_gain", "encoder_noise", "mount_resonance"):
            assert np.abs(r.encoder_rad).max() < 3.5, name
