"""What the simulated board injects is what a fit predicts, effect by effect."""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from snakebot.arrays import Floats
from snakebot.effects import EffectSpec, Plant, assemble, effects, parse_effect, predict
from snakebot.effects.prediction import PredictedRun
from snakebot.errors import BadInputError
from snakebot.physics import ChainModel
from snakebot.physics.servo_chain import DrivenChain
from snakebot.robot import load_robot, robot_from_mapping

ROBOT = load_robot("penn_state")
# The plant steps the chain every 1 ms, a prediction every 2 ms: only joints that depend on the chain may differ.
LOAD_TOLERANCE_RAD = 0.01
SECONDS = 6.0


def gait(t: Floats, omega: float = 3.0) -> Floats:
    ramp = np.clip(t / 1.5, 0, 1)[:, None] ** 2
    swing: Floats = ramp * np.radians(60) * np.sin(omega * t[:, None] + np.arange(5) * np.radians(80))
    return swing


def com_of(found: PredictedRun) -> Floats:
    """(T, 2) m: where the body is predicted to be."""
    assert found.motion is not None
    return found.motion.com_m


def ticks(irregular: bool) -> Floats:
    t = np.arange(0.0, SECONDS, 0.01)
    return t + (np.random.default_rng(3).uniform(0, 0.006, t.size) if irregular else 0.0)


def drive(plant: Plant, t: Floats, command: Floats) -> tuple[Floats, Floats, Floats]:
    """Readings and poses as a control loop has them: read, then command."""
    encoders, applied, poses = [], [], []
    for now, setpoint in zip(t, command, strict=True):
        plant.advance(now)
        encoders.append(plant.encoder_rad())
        poses.append(plant.pose() or (0.0,) * 4)
        plant.command(now, setpoint)
        plant.advance(now)
        applied.append(plant.applied_rad)
    return np.array(encoders), np.array(applied), np.array(poses)


def neutral_chance(text: str) -> EffectSpec:
    """Without chance a plant equals its mean."""
    spec = parse_effect(text)
    chance = {"command_loss": {"probability": 0.0}, "encoder_noise": {"std_deg": 0.0}}
    return spec.with_values(**chance.get(spec.name, {}))


# Those of a bench's arm have tests of their own (test_position_loop).
ON_THE_SNAKE = {name: effect for name, effect in effects().items() if effect.applies_to(ROBOT)}


@pytest.mark.parametrize("irregular", [False, True])
@pytest.mark.parametrize("name", ON_THE_SNAKE)
def test_plant_equals_prediction(name: str, irregular: bool) -> None:
    spec = neutral_chance(effects()[name].example)
    t = ticks(irregular)
    command = gait(t)
    plant = Plant(ROBOT, [spec], t_s=t[0])
    encoders, applied, poses = drive(plant, t, command)
    found = predict(ROBOT, [spec], t, command)
    touches_load = plant.stages.feels_load or name == "joint_free"
    tolerance = LOAD_TOLERANCE_RAD if touches_load else 1.01 * ROBOT.rad_per_count
    assert np.abs(encoders - found.encoder_rad).max() < tolerance
    if not touches_load:
        assert np.mean(encoders != found.encoder_rad) < 0.01  # a count at a rounding edge
    assert np.allclose(applied, found.applied_rad, atol=1e-6, equal_nan=True)
    # Of about 1 m. Between readings the plant's joints go on in their own way, the prediction's on a smooth curve.
    assert np.hypot(*(poses[:, :2] - com_of(found)).T).max() < (0.03 if irregular else 0.01)


@pytest.mark.parametrize("name", [n for n, e in ON_THE_SNAKE.items() if e.stage in ("servo", "sensor")])
def test_effect_shows(name: str) -> None:
    """Each example leaves a mark well above an encoder count, on the joints it names and there only."""
    t = ticks(irregular=False)
    command = gait(t)
    spec = parse_effect(effects()[name].example)
    nominal = predict(ROBOT, (), t, command, quantise=False, body=False)
    found = predict(ROBOT, [spec], t, command, quantise=False, body=False)
    gap = np.abs(found.encoder_rad - nominal.encoder_rad).max(axis=0)
    gap += np.sqrt((found.variance_rad2 - nominal.variance_rad2).max(axis=0))
    assert np.all(gap[list(spec.joint_indices(5))] > 5 * ROBOT.rad_per_count)
    if spec.joints is not None:
        others = [j for j in range(5) if j + 1 not in spec.joints]
        assert np.all(gap[others] < 1e-9)


@pytest.mark.parametrize("name", [n for n, e in effects().items() if e.stage == "body"])
def test_body_effects_move_the_body_only(name: str) -> None:
    t = ticks(irregular=False)
    command = gait(t)
    nominal = predict(ROBOT, (), t, command)
    found = predict(ROBOT, [effects()[name].example], t, command)
    assert np.array_equal(found.encoder_rad, nominal.encoder_rad)
    apart = np.hypot(*(com_of(found) - com_of(nominal)).T).max()
    assert apart > 0.005


def test_effects_compose_in_the_order_of_the_signal() -> None:
    t = ticks(irregular=False)
    command = gait(t)
    specs = [
        "backlash:width_deg=4",
        "encoder_offset:offset_deg=2",
        "command_delay:delay_s=0.04",
        "rate_limit:limit_rad_s=1.5",
    ]
    a = predict(ROBOT, specs, t, command, body=False)
    b = predict(ROBOT, specs[::-1], t, command, body=False)
    assert np.array_equal(a.encoder_rad, b.encoder_rad)
    encoders, _, _ = drive(Plant(ROBOT, specs), t, command)
    assert np.abs(encoders - a.encoder_rad).max() <= 1.01 * ROBOT.rad_per_count


LOAD = ("torque_limit", "torque_speed", "compliance", "joint_friction", "position_loop")
SETS = st.lists(
    st.sampled_from([n for n in ON_THE_SNAKE if n not in LOAD]),
    min_size=2,
    max_size=4,
    unique=True,
)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(SETS)
def test_any_set_of_effects_is_the_same_online_and_in_batch(names: list[str]) -> None:
    t = ticks(irregular=True)[:300]
    command = gait(t)
    specs = [neutral_chance(effects()[name].example) for name in names]
    encoders, _, poses = drive(Plant(ROBOT, specs, t_s=t[0]), t, command)
    found = predict(ROBOT, specs, t, command)
    tolerance = LOAD_TOLERANCE_RAD if "joint_free" in names else 2.01 * ROBOT.rad_per_count
    assert np.abs(encoders - found.encoder_rad).max() < tolerance
    assert np.hypot(*(poses[:, :2] - com_of(found)).T).max() < 0.03


@pytest.mark.parametrize("links", [2, 9, 32])
def test_any_number_of_links(links: int) -> None:
    robot = robot_from_mapping({**ROBOT.to_mapping(), "links": links}, "long")
    t = np.arange(0.0, 1.0, 0.01)
    command = 0.3 * t[:, None] * np.sin(3 * t[:, None] + np.arange(links - 1) * 0.7)
    specs = [
        "torque_limit:limit_nm=0.5",
        "compliance:stiffness_nm_rad=20",
        "joint_free:joints=1",
        "backlash:width_deg=2",
    ]
    for chosen in (specs, specs[2:]):
        encoders, _, _ = drive(Plant(robot, chosen), t, command)
        found = predict(robot, chosen, t, command)
        assert np.abs(encoders - found.encoder_rad).max() < 2 * LOAD_TOLERANCE_RAD
        assert np.all(np.isfinite(com_of(found)))


@pytest.mark.parametrize(
    ("t", "command", "told"),
    [
        ([0.0, 0.1, 0.1], np.zeros((3, 5)), "rise"),
        ([0.0, np.nan, 0.2], np.zeros((3, 5)), "rise"),
        ([0.0], np.zeros((1, 5)), "two or more"),
        ([0.0, 0.1, 0.2], np.zeros((3, 4)), r"command_rad is \(3, 4\); expected \(3, 5\)"),
    ],
)
def test_runs_that_are_none(t: Sequence[float], command: Floats, told: str) -> None:
    with pytest.raises(BadInputError, match=told):
        predict(ROBOT, (), t, command)


@pytest.mark.parametrize(
    "arm", [{"mass_kg": 1}, {"mass_kg": 1, "length_m": 0}, {"mass": 1}, 3, {"mass_kg": "x", "length_m": 1}]
)
def test_an_arm_that_is_none(arm: object) -> None:
    robot = robot_from_mapping({"joints": 1, "servo": {"arm": arm}}, "bench")
    with pytest.raises(BadInputError, match=r"servo\.arm takes numbers for mass_kg, length_m"):
        Plant(robot)


def test_plant_refuses_what_does_not_fit() -> None:
    plant = Plant(ROBOT)
    for attempt in (
        lambda: plant.command(0.0, [0.0] * 4),
        lambda: plant.set_joint_mode(6, "free"),
        lambda: Plant(ROBOT, dt_s=0.0),
        lambda: Plant(ROBOT, ["rate_limit:limit_rad_s=1,joints=6"]),
    ):
        with pytest.raises(BadInputError):
            attempt()


def test_same_effect_on_other_joints_and_last_one_holds() -> None:
    t = ticks(irregular=False)
    command = gait(t)
    specs = ["rate_limit:limit_rad_s=1", "rate_limit:limit_rad_s=2,joints=3"]
    rate = (
        np.abs(np.diff(predict(ROBOT, specs, t, command, quantise=False, body=False).encoder_rad, axis=0))
        / 0.01
    )
    assert np.allclose(rate.max(axis=0), [1, 1, 2, 1, 1], rtol=1e-6)


def test_effects_of_the_description_are_part_of_the_robot() -> None:
    slow = ROBOT.model_copy(update={"effects": ("rate_limit:limit_rad_s=1",)})
    t = ticks(irregular=False)
    command = gait(t)
    expected = predict(ROBOT, ["rate_limit:limit_rad_s=1"], t, command, body=False).encoder_rad
    assert np.array_equal(predict(slow, (), t, command, body=False).encoder_rad, expected)
    encoders, _, _ = drive(Plant(slow), t, command)
    assert np.mean(encoders != expected) < 0.01


def test_losses_average_to_the_prediction() -> None:
    t = np.arange(0.0, 2.0, 0.02)
    command = gait(t, omega=6.0)
    robot = robot_from_mapping({"joints": 5}, "bench")
    found = predict(robot, ["command_loss:probability=0.4"], t, command, quantise=False)
    runs = np.array(
        [drive(Plant(robot, ["command_loss:probability=0.4"], seed), t, command)[0] for seed in range(150)]
    )
    nominal = predict(robot, (), t, command, quantise=False).encoder_rad
    gap = np.abs(nominal - found.encoder_rad).max()
    error = np.abs(runs.mean(axis=0) - found.encoder_rad).max()
    assert gap > 0.05
    assert error < 0.35 * gap  # 150 runs leave a standard error of a tenth of it
    assert np.all(runs[:, 50:].var(axis=0) < found.variance_rad2[50:] * 1.6)  # told as an upper bound
    assert found.variance_rad2[50:].mean() < 4 * runs[:, 50:].var(axis=0).mean()


def test_noise_of_the_plant_is_the_variance_of_the_prediction() -> None:
    robot = robot_from_mapping({"joints": 2}, "bench")
    t = np.arange(0.0, 3.0, 0.1)
    still = np.zeros((t.size, 2))
    spec = ["encoder_noise:std_deg=0.4,lost_per_s=200,joints=2"]
    runs = np.array([drive(Plant(robot, spec, seed), t, still)[0] for seed in range(400)])
    variance = predict(robot, spec, t, still).variance_rad2
    assert np.allclose(runs.var(axis=0)[:, 1], variance[:, 1], rtol=0.3)
    assert variance[-1, 1] > 2 * variance[0, 1]
    assert np.all(runs[:, :, 0] == 0.0)


def test_same_seed_same_run() -> None:
    t = np.arange(0.0, 1.0, 0.01)
    specs = ["command_loss:probability=0.3", "encoder_noise:std_deg=0.4"]
    a, b, c = (drive(Plant(ROBOT, specs, seed), t, gait(t))[0] for seed in (1, 1, 2))
    assert np.array_equal(a, b)
    assert not np.array_equal(a, c)


def test_boundaries_can_be_fed() -> None:
    """Feeding a stage what it would have got from the stage before changes nothing."""
    t = ticks(irregular=True)
    command = gait(t)
    specs = [
        "command_delay:delay_s=0.2",
        "rate_limit:limit_rad_s=1.5",
        "encoder_offset:offset_deg=2",
        "slope:angle_deg=2",
    ]
    whole = predict(ROBOT, specs, t, command)
    from_angle = predict(ROBOT, specs, t, command, joint_angle_rad=whole.joint_angle_rad)
    assert np.array_equal(from_angle.encoder_rad, whole.encoder_rad)
    assert np.array_equal(com_of(from_angle), com_of(whole))
    from_applied = predict(
        ROBOT, specs, t, command, applied_rad=whole.applied_rad, initial_rad=whole.joint_angle_rad[0]
    )
    assert (
        np.abs(from_applied.encoder_rad - whole.encoder_rad).max() < 0.03
    )  # applied is known at samples only
    without_link = predict(ROBOT, specs[1:], t, command)
    assert np.abs(without_link.encoder_rad - whole.encoder_rad).max() > 0.2


def test_servo_off_takes_the_measured_angle_and_wakes_there() -> None:
    robot = robot_from_mapping({"joints": 1, "servo": {"time_constant_s": 0.1}}, "bench")
    t = np.arange(0, 3, 0.01)
    command = np.where((t > 1) & (t < 2), np.nan, 0.5)[:, None]
    measured = np.where(t > 1, -0.3, 0.5)[:, None]
    found = predict(robot, (), t, command, measured_rad=measured, quantise=False)
    assert np.array_equal(found.powered, np.isfinite(command))
    off = (t > 1.02) & (t < 1.99)
    assert np.all(found.encoder_rad[off, 0] == -0.3)
    awake = t > 2.02
    expected = 0.5 - 0.8 * np.exp(-(t[awake] - 2.0) / 0.1)
    assert np.allclose(found.encoder_rad[awake, 0], expected, atol=0.01)


def test_servo_off_swings_in_the_plant_too() -> None:
    robot = robot_from_mapping(
        {"joints": 1, "servo": {"time_constant_s": 0.03, "arm": {"mass_kg": 0.5, "length_m": 0.2}}}, "bench"
    )
    plant = Plant(robot, initial_rad=0.3)
    plant.set_joint_mode(None, "free")
    t = np.arange(0, 3, 0.01)
    angles = []
    for now in t:
        plant.advance(now)
        angles.append(plant.joint_angle_rad[0])
    period = 2 * math.pi * math.sqrt(0.2 / 9.80665) * (1 + 0.3**2 / 16)
    assert np.allclose(angles, 0.3 * np.cos(2 * math.pi * t / period), atol=0.02)
    found = predict(robot, (), t, np.full((t.size, 1), np.nan), initial_rad=[0.3], quantise=False)
    assert np.allclose(found.encoder_rad[:, 0], angles, atol=0.01)


def test_before_the_first_set_point_comes_joints_stay() -> None:
    robot = robot_from_mapping({"joints": 2}, "bench")
    t = np.arange(0, 1, 0.01)
    specs = [
        "command_delay:delay_s=0.2",
        "servo_offset:offset_deg=10",
        "command_gain:gain=0.5",
        "wiring:permutation=2+1",
    ]
    command = np.full((t.size, 2), 0.4)
    found = predict(robot, specs, t, command, initial_rad=[0.3, -0.2], quantise=False).encoder_rad
    assert np.allclose(found[t <= 0.2], [0.3, -0.2])
    assert np.allclose(found[-1], 0.2 + math.radians(10))
    plant = Plant(robot, specs, initial_rad=[0.1, 0.6])
    start = plant.joint_angle_rad
    assert np.allclose(start, np.array([0.3, 0.05]) + math.radians(10))
    plant.advance(0.5)
    assert np.allclose(plant.joint_angle_rad, start)
    plant.set_joint_mode(None, "free")
    plant.set_joint_mode(None, "active")
    plant.advance(1.0)
    assert np.allclose(plant.joint_angle_rad, start)


def test_a_servo_that_sags_starts_where_the_joint_is() -> None:
    arm = {"mass_kg": 2.0, "length_m": 0.25, "down_deg": -90}
    robot = robot_from_mapping({"joints": 1, "servo": {"time_constant_s": 0.3, "arm": arm}}, "bench")
    t = np.arange(0, 1, 0.01)
    sag = 2.0 * 9.80665 * 0.25 / 50
    found = predict(
        robot,
        ["compliance:stiffness_nm_rad=50"],
        t,
        np.zeros((t.size, 1)),
        initial_rad=[-sag],
        quantise=False,
    )
    assert np.abs(found.encoder_rad + sag).max() < 0.002


def test_drift_is_told_to_the_board() -> None:
    assert Plant(ROBOT, ["clock_drift:ppm=300"]).clock_ppm == 300


def test_joint_modes() -> None:
    plant = Plant(ROBOT)
    plant.command(0.0, np.full(5, 0.5))
    plant.advance(1.0)
    plant.set_joint_mode(2, "rigid")
    plant.set_joint_mode(3, "rigid", 0.2)
    plant.set_joint_mode(4, "free")
    plant.command(1.0, np.full(5, -0.5))
    plant.advance(2.0)
    assert np.allclose(plant.joint_angle_rad[[0, 1, 2, 4]], [-0.5, 0.5, 0.2, -0.5], atol=1e-6)
    assert abs(plant.joint_angle_rad[3] + 0.5) > 0.05
    assert np.isnan(plant.applied_rad[3])
    assert plant.applied_rad[2] == 0.2
    here = plant.joint_angle_rad.copy()
    plant.set_joint_mode(None, "active")
    plant.advance(2.5)
    assert np.allclose(plant.joint_angle_rad, here, atol=0.01)  # wakes where it stands
    plant.command(2.5, np.zeros(5))
    plant.advance(3.5)
    assert np.allclose(plant.joint_angle_rad, 0, atol=1e-6)


def test_a_broken_joint_stays_broken() -> None:
    plant = Plant(ROBOT, ["joint_rigid:angle_deg=10,joints=2"])
    for mode in ("free", "active"):
        plant.set_joint_mode(2, mode)
        plant.command(plant.t_s, np.full(5, 0.5))
        plant.advance(plant.t_s + 1)
        assert plant.joint_angle_rad[1] == pytest.approx(math.radians(10))


def test_unpowered_robot_does_not_move() -> None:
    plant = Plant(ROBOT)
    plant.set_joint_mode(None, "free")
    plant.command(0.0, np.full(5, 1.0))
    plant.advance(1.0)
    assert np.allclose(plant.joint_angle_rad, 0)
    pose = plant.pose()
    assert pose is not None
    assert pose.speed_m_s == 0


def test_gait_of_the_paper() -> None:
    """(66, 80, 2): 0.137 m/s and 0.68 W, the reference values of the model, and the tracking error of a lag."""
    t = np.arange(0, 8 * math.pi, 0.01)
    command = (
        np.clip(t / math.pi, 0, 1)[:, None]
        * np.radians(66)
        * np.sin(2 * t[:, None] + np.arange(5) * np.radians(80))
    )
    plant = Plant(ROBOT)
    power, encoders, _, poses = [], *drive(plant, t, command)
    steady = t >= 4 * math.pi
    way = poses[-1, :2] - poses[steady][0, :2]
    assert np.hypot(*way) / (t[-1] - t[steady][0]) == pytest.approx(0.137, rel=0.01)
    error = np.sqrt(np.mean((encoders - command)[steady] ** 2)) / np.radians(66)
    tau = 0.03 + 0.005  # the lag, and half a tick of hold
    assert error == pytest.approx(2 * tau / math.sqrt(1 + (2 * tau) ** 2) / math.sqrt(2), rel=0.01)
    for now, setpoint in zip(t, command, strict=True):
        plant.command(t[-1] + 0.01 + now, setpoint)
        plant.advance(t[-1] + 0.01 + now)
        power.append(plant.power_w)
    assert np.mean(np.array(power)[steady], axis=0) == pytest.approx([0.685, 0.685], rel=0.02)


def test_going_on_in_many_small_steps_is_one_run() -> None:
    """``go_to`` uses its arrays again and again; ``run`` makes new ones."""
    assert ROBOT.body is not None
    rows = assemble(ROBOT, ()).servo_rows
    steps, whole = (DrivenChain(rows, np.zeros(5), model=ChainModel.from_body(ROBOT.body)) for _ in range(2))
    times = np.sort(np.random.default_rng(3).uniform(0, 0.5, 200))
    switch_s, setpoint = np.array([0.05, 0.2]), np.array([[0.3] * 5, [-0.2, 0.1, 0.0, 0.1, -0.2]])
    out = whole.run(times, switch_s, setpoint)
    for number, t_s in enumerate(times):
        due = (switch_s <= t_s) & (switch_s > (times[number - 1] if number else -1.0))
        one = steps.go_to(t_s, switch_s[due], setpoint[due]) if due.any() else steps.go_to(t_s)
        for ours, theirs in zip(vars(one).values(), vars(out).values(), strict=True):
            assert np.array_equal(ours[0], theirs[number])
        assert np.array_equal(steps.base, out.base[number])
