"""Each effect leaves the mark that its closed form says."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from snakebot.arrays import Floats
from snakebot.effects import assemble, predict
from snakebot.robot import Robot, load_robot, robot_from_mapping
from snakebot.smoothing import smoothed

OMEGA = 4.0
AMPLITUDE = 0.8


def bench(time_constant_s: float = 0.03, joints: int = 1, arm: dict[str, float] | None = None) -> Robot:
    servo: dict[str, Any] = {"time_constant_s": time_constant_s}
    if arm:
        servo["arm"] = arm
    return robot_from_mapping({"joints": joints, "servo": servo}, "bench")


def sine(
    duration_s: float = 12.0, step_s: float = 0.002, omega: float = OMEGA, amplitude: float = AMPLITUDE
) -> tuple[Floats, Floats]:
    t = np.arange(0.0, duration_s, step_s)
    return t, amplitude * np.sin(omega * t)[:, None]


def response(robot: Robot, specs: Sequence[str], t: Floats, command: Floats, **options: Any) -> Floats:
    return predict(robot, specs, t, command, quantise=False, **options).encoder_rad[:, 0]


def phasor(t: Floats, signal: Floats, omega: float = OMEGA, from_s: float = 6.0) -> complex:
    """Complex amplitude of the sine part, over whole cycles."""
    cycles = math.floor((t[-1] - from_s) * omega / (2 * math.pi))
    rows = (t >= from_s) & (t < from_s + cycles * 2 * math.pi / omega)
    basis = np.stack([np.sin(omega * t[rows]), np.cos(omega * t[rows]), np.ones(rows.sum())], axis=1)
    a, b, _ = np.linalg.lstsq(basis, signal[rows], rcond=None)[0]
    return complex(a, b)


# Set-points are held for 2 ms, which is a mean delay of 1 ms.
HOLD_S = 0.001


def test_nominal_lag_is_a_first_order_lag() -> None:
    t, command = sine()
    z = phasor(t, response(bench(), (), t, command)) / AMPLITUDE
    expected = np.exp(-1j * OMEGA * HOLD_S) / (1 + 1j * OMEGA * 0.03)
    assert abs(z - expected) < 2e-4


def test_servo_lag_replaces_the_nominal_one() -> None:
    t, command = sine()
    z = phasor(t, response(bench(), ["servo_lag:time_constant_s=0.1"], t, command)) / AMPLITUDE
    assert abs(z - np.exp(-1j * OMEGA * HOLD_S) / (1 + 1j * OMEGA * 0.1)) < 2e-4


@pytest.mark.parametrize("zeta", [0.1, 0.7, 1.0, 3.0])
def test_second_order_transfer_function(zeta: float) -> None:
    wn = 12.0
    t, command = sine(duration_s=25.0)
    spec = f"second_order:natural_freq_rad_s={wn},damping_ratio={zeta}"
    z = phasor(t, response(bench(), [spec], t, command), from_s=15.0) / AMPLITUDE
    expected = np.exp(-1j * OMEGA * HOLD_S) * wn**2 / (wn**2 - OMEGA**2 + 2j * zeta * wn * OMEGA)
    assert abs(z - expected) < 5e-4


def test_second_order_with_a_lag_is_both_in_a_row() -> None:
    t, command = sine()
    specs = ["servo_lag:time_constant_s=0.1", "second_order:natural_freq_rad_s=12,damping_ratio=0.7"]
    z = phasor(t, response(bench(), specs, t, command)) / AMPLITUDE
    lag = 1 / (1 + 1j * OMEGA * 0.1)
    assert abs(z - np.exp(-1j * OMEGA * HOLD_S) * lag * 144 / (144 - 16 + 2j * 0.7 * 12 * OMEGA)) < 5e-4


def test_second_order_step_overshoots_as_the_damping_says() -> None:
    t = np.arange(0, 3, 0.01)
    spec = ["second_order:natural_freq_rad_s=12,damping_ratio=0.3"]
    peak = response(bench(), spec, t, np.ones((t.size, 1)), initial_rad=[0.0]).max()
    assert peak == pytest.approx(1 + math.exp(-math.pi * 0.3 / math.sqrt(1 - 0.09)), abs=0.005)


@pytest.mark.parametrize("delay_s", [0.0, 0.0007, 0.033, 0.1])
def test_delay_turns_the_phase_and_leaves_the_amplitude(delay_s: float) -> None:
    t, command = sine()
    nominal = phasor(t, response(bench(), (), t, command))
    late = phasor(t, response(bench(), [f"command_delay:delay_s={delay_s}"], t, command))
    ripple = (
        OMEGA * 0.002**2 / (4 * 0.03)
    )  # of held set-points behind the lag, seen at another phase of the tick
    assert late / nominal == pytest.approx(np.exp(-1j * OMEGA * delay_s), abs=ripple)


def test_clock_drift_is_a_growing_delay() -> None:
    t, command = sine(duration_s=40.0)
    nominal = response(bench(), (), t, command)
    late = response(bench(), ["clock_drift:ppm=3000"], t, command)
    rows = t > 35
    shift = np.interp(t[rows] - 0.003 * t[rows], t, nominal) - late[rows]
    assert np.abs(shift).max() < 2e-3
    assert np.abs(nominal[rows] - late[rows]).max() > 0.2


def test_rate_limit_on_a_step_is_a_ramp_that_ends_in_the_lag() -> None:
    t = np.arange(0, 3, 0.01)
    angle = response(bench(), ["rate_limit:limit_rad_s=0.5"], t, np.ones((t.size, 1)), initial_rad=[0.0])
    edge_s = (1 - 0.5 * 0.03) / 0.5
    expected = np.where(t < edge_s, 0.5 * t, 1 - 0.5 * 0.03 * np.exp(-(t - edge_s) / 0.03))
    assert np.allclose(angle, expected, atol=1e-12)


def test_rate_limit_on_a_fast_sine_is_a_triangle() -> None:
    t, command = sine(amplitude=2.0)
    limit = 1.0
    angle = response(bench(time_constant_s=0.0), [f"rate_limit:limit_rad_s={limit}"], t, command)
    angle = angle[t > t[-1] - 2 * math.pi / OMEGA]
    quarter_s = math.pi / OMEGA / 2
    assert np.ptp(angle) / 2 == pytest.approx(limit * quarter_s, rel=0.01)
    rate = np.diff(angle) / 0.002
    assert np.mean(np.abs(np.abs(rate) - limit) < 1e-6) > 0.98


def test_voltage_sag_lets_the_rate_fall_through_the_run() -> None:
    t = np.arange(0, 20, 0.01)
    command = np.full((t.size, 1), 100.0)
    spec = ["voltage_sag:initial_rad_s=2,drop_per_s=0.05"]
    angle = response(bench(), spec, t, command, initial_rad=[0.0])
    assert np.allclose(angle, 2 / 0.05 * (1 - np.exp(-0.05 * t)), atol=1e-4)


def test_voltage_sag_is_faster_with_the_load_than_against_it() -> None:
    robot = bench(arm={"mass_kg": 1.0, "length_m": 0.1, "down_deg": 0})
    t = np.arange(0, 2, 0.01)
    spec = ["voltage_sag:initial_rad_s=2,drop_per_s=0,drop_per_nm=0.5"]
    up = response(robot, spec, t, np.full((t.size, 1), 1.5), initial_rad=[0.5])
    down = response(robot, spec, t, np.full((t.size, 1), 0.5), initial_rad=[1.5])
    load = 9.80665 * 0.1 * math.sin(1.0)
    at_one = np.interp(1.0, up, t)
    assert (np.interp(at_one + 0.01, t, up) - 1.0) / 0.01 == pytest.approx(2 * (1 - 0.5 * load), rel=0.02)
    assert np.abs(np.diff(down)).max() > 1.3 * np.abs(np.diff(up)).max()


@pytest.mark.parametrize(
    ("spec", "full_width_rad"),
    [
        ("deadband:width_deg=4", math.radians(8)),
        ("backlash:width_deg=8", math.radians(8)),
        ("joint_friction:coulomb_nm=0.5,stiffness_nm_rad=8", 2 * 0.5 / 8),
    ],
)
def test_loop_width_on_a_slow_triangle(spec: str, full_width_rad: float) -> None:
    """Commanded angle going up minus going down, at the same joint angle: the full width of the loop."""
    t = np.arange(0, 40, 0.01)
    command = 0.6 * (2 / math.pi) * np.arcsin(np.sin(2 * math.pi * t / 20))[:, None]
    angle = response(bench(time_constant_s=0.0), [spec], t, command)
    up, down = (t > 16) & (t < 24), (t > 6) & (t < 14)
    up_at = np.interp(0.0, angle[up], command[up, 0])
    down_at = np.interp(0.0, angle[down][::-1], command[down, 0][::-1])
    assert up_at - down_at == pytest.approx(full_width_rad, abs=0.003)
    still = np.abs(np.diff(angle[t >= 20])) < 1e-9
    assert still.mean() == pytest.approx(full_width_rad / 1.2, rel=0.03)  # of 1.2 rad between two reversals


def test_deadband_stops_short() -> None:
    t = np.arange(0, 3, 0.01)
    angle = response(bench(), ["deadband:width_deg=3"], t, np.ones((t.size, 1)), initial_rad=[0.0])
    assert angle[-1] == pytest.approx(1 - math.radians(3))
    small = response(bench(), ["deadband:width_deg=3"], t, np.full((t.size, 1), 0.05), initial_rad=[0.0])
    assert np.all(small == 0.0)


def test_both_kinds_of_deadband_stop_at_its_edge_and_only_the_soft_one_lags_behind() -> None:
    t = np.arange(0, 3, 0.01)
    band = math.radians(3)
    moving = {}
    for hard in (0, 1):
        effect = [f"deadband:width_deg=3,hard={hard}"]
        step = response(bench(), effect, t, np.ones((t.size, 1)), initial_rad=[0.0])
        assert step[-1] == pytest.approx(1 - band)
        moving[hard] = response(bench(), effect, t, 3 * t[:, None], initial_rad=[0.0])[t > 1]
    assert moving[1] - moving[0] == pytest.approx(band, abs=1e-3)


def test_play_that_the_load_takes_up_on_an_arm() -> None:
    """The arm hangs on the lower side of the play, whichever way the motor last turned."""
    arm = {"mass_kg": 0.5, "length_m": 0.15}
    t = np.arange(0, 6, 0.01)
    command = (1.2 * np.sin(2 * np.pi * t / 3))[:, None]
    made = {
        loaded: response(bench(arm=arm), [f"backlash:width_deg=4,loaded={loaded}"], t, command)
        - response(bench(arm=arm), (), t, command)
        for loaded in (0, 1)
    }
    later = t > 3
    low = -np.sign(command[:, 0])  # down is at zero
    far = later & (np.abs(command[:, 0]) > 0.3)
    assert made[1][far] == pytest.approx(math.radians(2) * low[far], abs=1e-3)
    assert np.abs(made[0][far] - math.radians(2) * low[far]).max() > math.radians(2)


@pytest.mark.parametrize(
    ("links", "width_deg", "alpha_deg", "beta_deg", "omega_rad_s"),
    [(6, 3.0, 50, 80, 2.0), (9, 3.0, 50, 80, 2.0), (9, 2.0, 15, 58, 4.7)],
)
def test_play_that_the_load_takes_up_in_a_body(
    links: int, width_deg: float, alpha_deg: float, beta_deg: float, omega_rad_s: float
) -> None:
    """A joint swings in the play of its gears: never farther than half of it, and on the side that bears the load."""
    body = {"links": links, "half_length_m": 0.48 / links, "link_mass_kg": 8.5 / links}
    friction = {"ct": 0.55, "cn": 35, "ct0": 0.33, "cn0": 1.5}
    robot = robot_from_mapping({**body, "friction": friction, "servo": {"time_constant_s": 0.04}}, "test")
    t = np.arange(0, 8, 0.01)
    phase = np.arange(robot.joints) * np.radians(beta_deg)
    ramp = np.clip(t / 1.5, 0, 1)[:, None] ** 2
    command = ramp * np.radians(alpha_deg) * np.sin(omega_rad_s * t[:, None] + phase)
    half = math.radians(width_deg / 2)
    nominal = predict(robot, (), t, command, quantise=False).joint_angle_rad
    found = predict(robot, [f"backlash:width_deg={width_deg},loaded=1"], t, command, quantise=False)
    swing = (found.joint_angle_rad - nominal)[t > 2]
    load = found.load_nm[t > 2]
    assert np.quantile(np.abs(swing), 0.98) < 1.15 * half
    heavy = np.abs(load) > 0.5 * np.quantile(np.abs(load), 0.95)
    assert np.mean(np.sign(swing[heavy]) == -np.sign(load[heavy])) > 0.95
    assert np.mean(np.abs(swing[heavy])) > 0.75 * half


@pytest.mark.parametrize("width_deg", [0.3, 1.0])
def test_play_under_known_torques_goes_as_in_a_body(width_deg: float) -> None:
    """Torques of the motion itself say what play changes, but for half of it, without simulating the body."""
    robot = load_robot("penn_state")
    t = np.arange(0, 8, 0.01)
    ramp = np.clip(t / 1.5, 0, 1)[:, None] ** 2
    command = ramp * np.radians(45) * np.sin(2 * t[:, None] + np.arange(robot.joints) * np.radians(80))
    play = [f"backlash:width_deg={width_deg},loaded=1"]
    nominal = predict(robot, (), t, command, quantise=False).joint_angle_rad
    swinging = predict(robot, play, t, command, quantise=False).joint_angle_rad
    load = assemble(robot).torque_of(t, smoothed(t, swinging))
    given = predict(robot, play, t, command, quantise=False, load_nm=load).joint_angle_rad
    assert np.std(given - swinging) < np.std(nominal - swinging) * 0.5


def test_gain_and_offset() -> None:
    t, command = sine()
    specs = ["command_gain:gain=0.8", "servo_offset:offset_deg=5"]
    nominal = response(bench(), (), t, command)
    assert np.allclose(response(bench(), specs, t, command), 0.8 * nominal + math.radians(5), atol=1e-12)


def test_encoder_gain_and_offset_leave_the_joint_alone() -> None:
    t, command = sine()
    nominal = predict(bench(), (), t, command, quantise=False)
    found = predict(
        bench(), ["encoder_offset:offset_deg=3", "encoder_gain:gain=1.1"], t, command, quantise=False
    )
    assert np.array_equal(found.joint_angle_rad, nominal.joint_angle_rad)
    assert np.allclose(found.encoder_rad, 1.1 * nominal.joint_angle_rad + math.radians(3), atol=1e-12)


def test_sensor_stage_can_be_undone() -> None:
    stages = assemble(bench(), ["encoder_offset:offset_deg=3", "encoder_gain:gain=1.1"])
    t, angle = sine()
    reading = stages.reading(t, angle)
    assert np.allclose(stages.true_angle(t, reading), angle, atol=1e-12)


def test_noise_and_counts_are_told_as_variance() -> None:
    robot = bench()
    t, command = sine()
    count = robot.rad_per_count
    found = predict(robot, ["encoder_noise:std_deg=0.5,lost_per_s=10"], t, command)
    expected = math.radians(0.5) ** 2 + count**2 / 12 + 10 * t * count**2
    assert np.allclose(found.variance_rad2[:, 0], expected)
    assert np.array_equal(found.encoder_rad, predict(robot, (), t, command).encoder_rad)


def test_prediction_is_in_whole_counts() -> None:
    robot = bench()
    t, command = sine()
    counts = predict(robot, (), t, command).encoder_rad / robot.rad_per_count
    assert np.allclose(counts, np.round(counts), atol=1e-9)


def test_loss_is_a_mean_delay() -> None:
    t, command = sine(step_s=0.02, duration_s=30)
    p = 0.3
    nominal = phasor(t, response(bench(), (), t, command))
    lossy = phasor(t, response(bench(), [f"command_loss:probability={p}"], t, command))
    z = np.exp(-1j * OMEGA * 0.02)
    assert lossy / nominal == pytest.approx((1 - p) / (1 - p * z), abs=1e-3)


def test_loss_variance_is_that_of_held_set_points() -> None:
    stages = assemble(bench(), ["command_loss:probability=0.3"])
    t, command = sine(step_s=0.02, duration_s=2.0)
    track = stages.link(t, command)
    assert track.variance_rad2 is not None
    rng = np.random.default_rng(5)
    held = np.empty((4000, t.size))
    for row in held:
        arrived = rng.random(t.size) >= 0.3
        arrived[0] = True
        row[:] = command[np.maximum.accumulate(np.where(arrived, np.arange(t.size), 0)), 0]
    assert np.allclose(track.setpoint_rad[:, 0], held.mean(axis=0), atol=0.01)
    assert np.allclose(np.sqrt(track.variance_rad2[:, 0]), held.std(axis=0), atol=0.01)


def test_wiring_swaps_and_reverses() -> None:
    t = np.arange(0, 4, 0.01)
    command = np.stack([np.sin(t), np.sin(2 * t), np.sin(3 * t)], axis=1)
    robot = bench(joints=3)
    nominal = predict(robot, (), t, command, quantise=False).encoder_rad
    found = predict(
        robot, ["wiring:permutation=3+2,signs=1+-1,joints=2+3"], t, command, quantise=False
    ).encoder_rad
    assert np.allclose(found, np.stack([nominal[:, 0], nominal[:, 2], -nominal[:, 1]], axis=1), atol=1e-12)


def test_rigid_joint_stands_still() -> None:
    t, command = sine()
    assert np.all(
        response(bench(), ["joint_rigid:angle_deg=20"], t, command) == pytest.approx(math.radians(20))
    )


def test_compliance_sags_by_load_over_stiffness() -> None:
    robot = bench(arm={"mass_kg": 2.0, "length_m": 0.25})
    t = np.arange(0, 3, 0.01)
    angle = response(robot, ["compliance:stiffness_nm_rad=40"], t, np.full((t.size, 1), 1.0))
    assert angle[-1] == pytest.approx(1.0 - 2.0 * 9.80665 * 0.25 * math.sin(1.0) / 40)


def test_a_load_that_is_given_makes_a_bench_sag() -> None:
    t = np.arange(0, 3, 0.01)
    load = np.full((t.size, 1), 0.6)
    angle = response(bench(), ["compliance:stiffness_nm_rad=10"], t, np.zeros((t.size, 1)), load_nm=load)
    assert angle[-1] == pytest.approx(-0.06)


def test_torque_limit_lets_a_heavy_arm_hang_short() -> None:
    """A servo that can bear 0.8 of the horizontal torque lifts the arm to asin(0.8), and no further."""
    arm = {"mass_kg": 1.0, "length_m": 0.2}
    limit = 0.8 * 9.80665 * 0.2
    t = np.arange(0, 10, 0.01)
    command = np.minimum(0.3 * t, math.pi / 2)[:, None]
    angle = response(bench(arm=arm), [f"torque_limit:limit_nm={limit}"], t, command)
    swing = math.sqrt(0.04 * 0.3**2 / (9.80665 * 0.2 * 0.6))  # what its speed carries it past the balance
    assert angle[t > 5].mean() == pytest.approx(math.asin(0.8), abs=0.02)
    assert angle.max() == pytest.approx(math.asin(0.8) + swing, abs=0.01)
    assert response(bench(arm=arm), ["torque_limit:limit_nm=10"], t, command)[-1] == pytest.approx(
        math.pi / 2
    )


def test_torque_speed_is_a_line_from_no_load_to_stall() -> None:
    """Lifting an arm of weight w goes at no_load (1 - w / stall), lowering it at no_load (1 + w / stall)."""
    robot = bench(arm={"mass_kg": 1.0, "length_m": 0.1, "down_deg": -90})
    t = np.arange(0, 0.2, 0.01)
    weight, specs = 9.80665 * 0.1, ["torque_speed:no_load_rad_s=0.5,stall_nm=3"]
    up = response(robot, specs, t, np.full((t.size, 1), 1.0), initial_rad=[0.0])
    down = response(robot, specs, t, np.full((t.size, 1), -1.0), initial_rad=[0.0])
    assert up[-1] == pytest.approx(0.5 * (1 - weight / 3) * t[-1], rel=0.01)
    assert down[-1] == pytest.approx(-0.5 * (1 + weight / 3) * t[-1], rel=0.01)


@pytest.mark.parametrize("joints", [None, (2, 4)])
def test_subset_of_joints(joints: tuple[int, ...] | None) -> None:
    robot = load_robot("penn_state")
    t = np.arange(0, 4, 0.01)
    command = 0.8 * np.sin(3 * t[:, None] + np.arange(5))
    text = "rate_limit:limit_rad_s=1" + ("" if joints is None else ",joints=" + "+".join(map(str, joints)))
    nominal = predict(robot, (), t, command, body=False).encoder_rad
    found = predict(robot, [text], t, command, body=False).encoder_rad
    touched = {j + 1 for j in range(5) if np.abs(found - nominal)[:, j].max() > 0.01}
    assert touched == set(joints or range(1, 6))
