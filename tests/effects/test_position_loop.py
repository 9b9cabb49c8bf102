"""A position loop against an independent integrator and closed forms; what hangs on the arm of a bench."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from snakebot.arrays import Floats
from snakebot.effects import Observed, Plant, assemble, effects, parse_effect, predict
from snakebot.errors import BadInputError
from snakebot.robot import Robot, load_robot, robot_from_mapping

G = 9.80665
MASS, LENGTH, DOWN_DEG = 0.49, 0.1, 10.0
ARM = {"mass_kg": MASS, "length_m": LENGTH, "down_deg": DOWN_DEG}
STIFFNESS, DAMPING, ARMATURE = 2.0, 0.05, 0.002
LOOP = f"position_loop:stiffness_nm_rad={STIFFNESS},damping_nm_s_rad={DAMPING},armature_kg_m2={ARMATURE}"
STEP_S = 0.005


def bench(arm: dict[str, float] | None = ARM, joints: int = 1) -> Robot:
    servo = {"arm": arm} if arm else {}
    return robot_from_mapping({"joints": joints, "encoder_counts_per_rev": 4096, "servo": servo}, "bench")


def response(robot: Robot, spec: str, t: Floats, command: Floats, start_rad: float = 0.0) -> Floats:
    found = predict(robot, [spec], t, command[:, None], quantise=False, initial_rad=[start_rad])
    return found.joint_angle_rad[:, 0]


def integrated(
    t: Floats, command: Floats, coulomb_nm: float, load_friction: float, drive_friction: float
) -> Floats:
    """The same by an integrator that knows nothing of it; dry friction is smooth below a millirad a second."""
    weight, inertia = MASS * G * LENGTH, MASS * LENGTH**2 + ARMATURE

    def slope(_: float, y: Floats, target: float) -> list[float]:
        pull = weight * math.sin(y[0] - math.radians(DOWN_DEG))
        drive = STIFFNESS * (target - y[0])
        friction = coulomb_nm + load_friction * abs(pull) + drive_friction * drive**2
        torque = drive - DAMPING * y[1] - pull - friction * math.tanh(y[1] / 1e-3)
        return [y[1], torque / inertia]

    states = [np.zeros(2)]
    for now, then, target in zip(t[:-1], t[1:], command[:-1], strict=True):
        found = solve_ivp(
            slope, (now, then), states[-1], args=(target,), method="LSODA", rtol=1e-8, atol=1e-10
        )
        states.append(found.y[:, -1])
    return np.array(states)[:, 0]


@pytest.mark.parametrize(
    ("coulomb", "load", "drive", "within_rad"), [(0.0, 0.0, 0.0, 1e-5), (0.03, 0.2, 0.3, 1.5e-3)]
)
def test_against_an_independent_integrator(
    coulomb: float, load: float, drive: float, within_rad: float
) -> None:
    t = np.arange(0, 4, STEP_S)
    command = 0.8 * np.sin(3 * t)
    spec = f"{LOOP},coulomb_nm={coulomb},load_friction={load},drive_friction_per_nm={drive}"
    made = response(bench(), spec, t, command)
    assert np.abs(made - integrated(t, command, coulomb, load, drive)).max() < within_rad


def test_small_signals_see_a_second_order_system() -> None:
    """About where it hangs: gravity is a spring beside that of the loop."""
    omega, size = 11.0, 0.01
    t = np.arange(0, 12, 0.002)
    arm = {"mass_kg": MASS, "length_m": LENGTH}
    made = response(bench(arm), LOOP, t, size * np.sin(omega * t))
    late = t > 6
    basis = np.stack([np.sin(omega * t[late]), np.cos(omega * t[late])], axis=1)
    a, b = np.linalg.lstsq(basis, made[late], rcond=None)[0]
    inertia = MASS * LENGTH**2 + ARMATURE
    spring = STIFFNESS + MASS * G * LENGTH
    expected = np.exp(-1j * omega * 0.001) * STIFFNESS / (spring - inertia * omega**2 + 1j * DAMPING * omega)
    assert abs(complex(a, b) / size - expected) < 1e-3
    assert complex(a, b) / size == pytest.approx(1.0891 - 0.3774j, abs=1e-3)


def test_sags_by_its_weight_over_the_stiffness() -> None:
    t = np.arange(0, 8, STEP_S)
    end = response(bench(), LOOP, t, np.full(t.size, 1.2))[-1]
    assert STIFFNESS * (1.2 - end) == pytest.approx(
        MASS * G * LENGTH * math.sin(end - math.radians(DOWN_DEG)), rel=1e-6
    )


def test_stands_still_until_friction_is_overcome() -> None:
    """No arm: a triangle's loop is twice coulomb / stiffness wide."""
    t = np.arange(0, 40, STEP_S)
    command = 0.5 * (2 / np.pi) * np.arcsin(np.sin(2 * np.pi * t / 40))
    made = response(bench(None), f"{LOOP},coulomb_nm=0.1", t, command)
    up, down = (np.interp(0.2, *sides) for sides in _sides(command, made))
    assert down - up == pytest.approx(2 * 0.1 / STIFFNESS, abs=0.004)


def _sides(command: Floats, made: Floats) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    top, bottom = int(np.argmax(command)), int(np.argmin(command))
    return (command[:top], made[:top]), (command[top:bottom][::-1], made[top:bottom][::-1])


def test_more_is_needed_to_break_away_than_to_go_on() -> None:
    t = np.arange(0, 6, STEP_S)
    command = np.minimum(0.05 * t, 0.2)
    plain = response(bench(None), f"{LOOP},coulomb_nm=0.05", t, command)
    stuck = response(bench(None), f"{LOOP},coulomb_nm=0.05,breakaway_nm=0.1,stribeck_rad_s=0.02", t, command)
    assert command[np.flatnonzero(plain > 1e-6)[0]] == pytest.approx(0.05 / STIFFNESS, abs=1e-3)
    assert command[np.flatnonzero(stuck > 1e-6)[0]] == pytest.approx(0.15 / STIFFNESS, abs=1e-3)


def test_a_drive_at_its_limit_lifts_no_further() -> None:
    t = np.arange(0, 12, STEP_S)
    full_deg = 8.0
    end = response(bench(), f"{LOOP},full_drive_deg={full_deg}", t, np.minimum(0.3 * t, 1.5))[-1]
    limit = STIFFNESS * math.radians(full_deg)
    assert end - math.radians(DOWN_DEG) == pytest.approx(math.asin(limit / (MASS * G * LENGTH)), abs=1e-3)


def test_without_power_it_swings_as_a_pendulum_and_friction_stops_it() -> None:
    t = np.arange(0, 6, STEP_S)
    command = np.where(t < 0.05, 0.25, np.nan)
    down = math.radians(DOWN_DEG)
    made = response(bench(), LOOP, t, command, 0.25) - down
    crossings = t[1:][(made[1:] > 0) & (made[:-1] <= 0)]
    expected = 2 * math.pi * math.sqrt((MASS * LENGTH**2 + ARMATURE) / (MASS * G * LENGTH))
    assert np.diff(crossings).mean() == pytest.approx(expected, rel=0.003)
    rubs = response(bench(), f"{LOOP},coulomb_nm=0.01,load_friction=0.1", t, command, 0.25) - down
    assert np.ptp(rubs[t > 5]) == 0.0


@pytest.mark.parametrize("coulomb", [0.0, 0.05])
def test_the_simulated_bench_does_what_the_prediction_says(coulomb: float) -> None:
    t = np.arange(0, 3, 0.01)
    command = 0.8 * np.sin(4 * t)[:, None]
    spec = f"{LOOP},coulomb_nm={coulomb},load_friction=0.2"
    plant = Plant(bench(), [spec], dt_s=2e-3)
    readings = []
    for now, setpoint in zip(t, command, strict=True):
        plant.advance(now)
        readings.append(plant.encoder_rad())
        plant.command(now, setpoint)
    found = predict(bench(), [spec], t, command)
    assert np.abs(np.array(readings) - found.encoder_rad).max() < 3 * bench().rad_per_count


def test_on_a_body_the_load_is_that_of_the_links() -> None:
    """A stiff loop follows, a soft one falls behind."""
    robot = load_robot("penn_state")
    t = np.arange(0, 4, 0.01)
    command = np.minimum(t, 1)[:, None] * 0.6 * np.sin(3 * t[:, None] + 1.4 * np.arange(5))
    far = []
    for stiffness in (200.0, 3.0):
        spec = f"position_loop:stiffness_nm_rad={stiffness},damping_nm_s_rad={0.02 * stiffness}"
        found = predict(robot, [spec], t, command, quantise=False)
        far.append(np.sqrt(np.mean((found.joint_angle_rad - command)[t > 2] ** 2)))
    assert far[0] < 0.1
    assert far[1] > 2 * far[0]


@dataclass
class Run:
    t_s: Floats
    command_rad: Floats
    measured_rad: Floats


def recorded(robot: Robot, specs: list[str], omegas: tuple[float, ...] = (2.0, 6.0)) -> list[Run]:
    t = np.arange(0, 6, 0.01)
    runs = []
    for omega in omegas:
        command = (np.sin(omega * t) * np.minimum(t, 1))[:, None]
        runs.append(Run(t, command, predict(robot, specs, t, command).encoder_rad))
    return runs


def test_the_start_reads_the_stiffness_off_the_sag() -> None:
    runs = recorded(bench(), [LOOP])
    start = effects()["position_loop"].starts(Observed(bench(), runs), (0,))[0]
    assert start["stiffness_nm_rad"] == pytest.approx(STIFFNESS, rel=0.5)


def test_the_start_of_a_drive_that_has_no_more_to_give_is_not_that_of_a_softer_one() -> None:
    """It cannot lift the arm as far as it is told; errors grow, and torque does not."""
    runs = recorded(bench(), [f"{LOOP},full_drive_deg=10"], omegas=(0.5, 1.0))
    start = effects()["position_loop"].starts(Observed(bench(), runs), (0,))[0]
    assert start["stiffness_nm_rad"] == pytest.approx(STIFFNESS, rel=0.3)
    assert start["full_drive_deg"] == pytest.approx(10, rel=0.3)


def test_the_armature_is_read_off_a_swing_without_power() -> None:
    t = np.arange(0, 6, STEP_S)
    command = np.where(t < 1, 1.0, np.nan)[:, None]
    spec = f"{LOOP},coulomb_nm=0.01,load_friction=0.1"
    run = Run(t, command, predict(bench(), [spec], t, command, initial_rad=[0.8]).encoder_rad)
    held = effects()["position_loop"].held(Observed(bench(), [run]))
    assert held["armature_kg_m2"] == pytest.approx(ARMATURE, rel=0.05)


def test_an_arm_that_nobody_described_is_missed_and_its_weight_is_the_unit() -> None:
    loop, bare = effects()["position_loop"], bench(None)
    assert loop.lacks(bench()) is None
    assert loop.lacks(load_robot("penn_state")) is None
    said = loop.lacks(bare)
    assert said is not None
    assert "describe the arm" in said
    assert loop.held(Observed(bare, recorded(bare, [LOOP]))) == {"gravity_nm": 1.0}
    assert loop.held(Observed(bench(), recorded(bench(), [LOOP]))) == {}
    t = np.arange(0, 4, STEP_S)
    weight, down = MASS * G * LENGTH, math.radians(DOWN_DEG)
    own = f"{LOOP},gravity_nm={weight},down_deg={DOWN_DEG}"
    end = response(bare, own, t, np.full(t.size, 1.2))[-1]
    assert STIFFNESS * (1.2 - end) == pytest.approx(weight * math.sin(end - down), rel=1e-6)
    turned = response(bench(), f"{LOOP},down_deg=-3", t, np.full(t.size, 1.2))[-1]  # beside the stated angle
    assert STIFFNESS * (1.2 - turned) == pytest.approx(
        weight * math.sin(turned - down + math.radians(3)), rel=1e-5
    )
    starts = loop.starts(Observed(bare, recorded(bare, [LOOP])), (0,))
    assert {start["down_deg"] for start in starts} == {0.0, -90.0, 90.0}  # where it hangs is not known


def test_a_payload_is_more_of_the_arm() -> None:
    specs = [LOOP, "arm_payload:mass_kg=0.2,joints=2"]
    rows = assemble(bench(joints=2), specs).servo_rows
    heavier = assemble(bench({**ARM, "mass_kg": MASS + 0.2}, joints=2), [LOOP]).servo_rows
    lighter = assemble(bench(joints=2), [LOOP]).servo_rows
    assert np.allclose(rows[1], heavier[1])
    assert np.array_equal(rows[0], lighter[0])


def test_a_payload_needs_an_arm_and_a_servo_that_feels_it() -> None:
    payload = effects()["arm_payload"]
    assert not payload.applies_to(bench(None))
    assert not payload.applies_to(load_robot("penn_state"))
    with pytest.raises(BadInputError, match="no bench with an arm"):
        parse_effect("arm_payload:mass_kg=0.2", bench(None))
    calibrated = bench().model_copy(update={"effects": (LOOP,)})
    assert not payload.can_explain(Observed(bench(), recorded(bench(), [])))
    assert payload.can_explain(Observed(calibrated, recorded(calibrated, [])))
