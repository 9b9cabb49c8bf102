"""The whole of it on the simulated robot, in small spaces; and the command."""

from __future__ import annotations

import json
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from snakebot.cli.main import cli, main
from snakebot.effects import fault_spec
from snakebot.errors import BadInputError
from snakebot.gait import Gait, load_gait
from snakebot.optimise.goal import Goal
from snakebot.optimise.optimum import optimise
from snakebot.optimise.outcomes import GaitSimulator
from snakebot.optimise.promise import OptimiseOptions
from snakebot.optimise.space import Space
from snakebot.robot import Interval, Limits, load_robot

ROBOT = load_robot("penn_state")
SMALL = OptimiseOptions(
    within={"alpha": (20, 60), "beta": (50, 110), "omega": (2, 3)}, draws=0, grid=(3, 3, 2)
)


def test_simulator_and_paper_agree() -> None:
    """v(66, 80, 2) is 0.137 m/s with ideal tracking, 0.68 W (reference values of the model)."""
    gait = load_gait("penn_state_optimum")
    row = np.array([[gait.alpha_rad, gait.beta_rad, gait.omega_rad_s]])
    found = GaitSimulator([(ROBOT, ())])(row)
    assert found.speed_m_s[0, 0] == pytest.approx(0.137, rel=0.01)
    assert found.power_in_w[0, 0] == pytest.approx(0.68, rel=0.03)
    swept = GaitSimulator([(ROBOT, ())])(row, thorough=False)  # the compiled sweep
    assert swept.speed_m_s[0, 0] == pytest.approx(found.speed_m_s[0, 0], rel=0.01)


def test_a_bench_has_no_gait() -> None:
    bench = load_robot("penn_state").model_copy(update={"body": None})
    with pytest.raises(BadInputError, match="has no body"):
        optimise(bench, Goal("speed"), SMALL)


@pytest.mark.parametrize(("torque_nm", "told"), [(None, False), (5.0, True)])
def test_a_speed_that_no_gait_reaches_is_told_with_the_margin_where_torque_is_known(
    torque_nm: float | None, told: bool
) -> None:
    tiny = {"alpha": (35, 36), "beta": (80, 81), "omega": (2, 2.1)}
    options = OptimiseOptions(within=tiny, draws=0, grid=(2, 2, 2), torque_nm=torque_nm)
    with pytest.raises(BadInputError, match="no gait here reaches 9 m/s") as raised:
        optimise(ROBOT, Goal("power-at-speed", 9.0), options)
    assert ("10 % of the torque left" in str(raised.value)) is told


def test_choice_intervals_front_and_count_in_a_tiny_space() -> None:
    robot = ROBOT.model_copy(update={"effects": ("rate_limit:limit_rad_s=1.2",)})
    tiny = {"alpha": (35, 36), "beta": (80, 81), "omega": (4, 4.1)}
    options = OptimiseOptions(within=tiny, draws=2, robust=True, grid=(2, 2, 2))
    result = optimise(robot, Goal("speed"), options, beside={"other": Gait.from_degrees(30, 80, 4)})
    assert [row.what for row in result.others] == ["without the effects", "other"]
    assert result.effects == ("rate_limit:limit_rad_s=1.2",)
    assert result.found.speed_worst_m_s == pytest.approx(result.found.speed_m_s, rel=0.05)
    assert result.found.speed_ci95 is not None
    assert result.front
    assert result.simulated > 8
    assert json.loads(json.dumps(result.summary()))["draws"] == 2


@pytest.mark.slow
@pytest.mark.parametrize("torque_nm", [1.2, None])
def test_no_gait_of_the_front_is_faster_than_the_fastest(torque_nm: float | None) -> None:
    """Brief looks keep off the limit of torque; what they leave there is looked for at length."""
    within = {"alpha": (25.0, 60.0), "beta": (30.0, 110.0), "omega": (2.0, 5.0)}
    options = OptimiseOptions(within=within, draws=0, grid=(4, 4, 3), torque_nm=torque_nm)
    result = optimise(ROBOT, Goal("speed"), options)
    assert max(row.speed_m_s for row in result.front) <= result.found.speed_m_s * 1.001
    if torque_nm is not None:
        assert result.found.torque_nm <= 0.9 * torque_nm * (1 + 1e-9)
        assert result.found.torque_nm > 0.985 * 0.9 * torque_nm


@pytest.mark.slow
def test_no_gait_of_a_grid_is_better() -> None:
    robot = ROBOT.model_copy(update={"effects": ("rate_limit:limit_rad_s=1.2",)})
    goal = Goal("power-at-speed", 0.2)
    found = optimise(robot, goal, SMALL).found
    grid = Space.of(robot, SMALL.within).grid(8, 7, 4)
    best = GaitSimulator([(robot, ())])(grid, thorough=False)
    assert found.speed_m_s == pytest.approx(0.2, rel=3e-3)
    assert -found.power_w >= 1.01 * float(goal.worst(best).max())


@pytest.mark.slow
def test_the_least_power_has_the_papers_beta() -> None:
    """Mehta, Brennan & Gandhi 2008, Section VIII: on the front of the robot beta is near 80 deg."""
    options = replace(SMALL, within={"alpha": (20, 70), "beta": (50, 120), "omega": (1, 4)}, grid=(4, 4, 4))
    found = optimise(ROBOT, Goal("power-at-speed", 0.15), options).found
    assert found.beta_deg == pytest.approx(80, abs=6)


@pytest.mark.slow
def test_limits_and_margin_are_kept_and_told() -> None:
    limits = Limits(angle_deg=40, speed_rad_s=1.2, acceleration_rad_s2=60)
    robot = ROBOT.model_copy(update={"limits": limits})
    result = optimise(robot, Goal("speed"), replace(SMALL, torque_nm=1.5, margin=0.2))
    for row in (result.found, *result.front):
        assert row.alpha_deg <= 40 * (1 + 1e-9)
        assert np.radians(row.alpha_deg) * row.omega_rad_s <= 1.2 * (1 + 1e-9)
        assert row.torque_nm <= 1.2 * 1.01
    assert result.found.binds


@pytest.mark.slow
def test_a_broken_joint_changes_the_choice() -> None:
    goal = Goal("power-at-speed", 0.1)
    options = replace(SMALL, within={"alpha": (20, 60), "beta": (50, 110), "omega": (0.8, 3)}, grid=(3, 3, 3))
    whole = optimise(ROBOT, goal, options).found
    free = (fault_spec("free", (3,)),)
    broken = optimise(ROBOT, goal, replace(options, faults=free)).found
    row = np.array([[np.radians(whole.alpha_deg), np.radians(whole.beta_deg), whole.omega_rad_s]])
    same_gait = GaitSimulator([(ROBOT, free)])(row)
    assert same_gait.speed_m_s[0, 0] < 0.95 * whole.speed_m_s  # the choice of the whole robot no longer does
    assert broken.speed_m_s == pytest.approx(0.1, rel=3e-3)
    moved = abs(broken.alpha_deg - whole.alpha_deg) + abs(broken.beta_deg - whole.beta_deg)
    assert moved > 3 or abs(broken.omega_rad_s / whole.omega_rad_s - 1) > 0.05


@pytest.mark.slow
def test_the_robust_worst_case_is_no_better_than_the_promise_and_no_worse_than_the_others() -> None:
    known = Interval(number="effects.torque_limit.limit_nm", estimate=0.8, ci95=(0.6, 1.2))
    robot = ROBOT.model_copy(update={"effects": ("torque_limit:limit_nm=0.8",), "intervals": (known,)})
    options = replace(SMALL, margin=0.0, draws=6)
    best = optimise(robot, Goal("speed"), options).found
    careful = optimise(robot, Goal("speed"), replace(options, robust=True)).found
    assert careful.speed_worst_m_s is not None
    assert best.speed_worst_m_s is not None
    assert careful.speed_worst_m_s <= best.speed_m_s
    assert careful.speed_worst_m_s >= 0.999 * best.speed_worst_m_s
    assert best.speed_ci95 is not None
    assert best.speed_ci95[0] <= best.speed_m_s * 1.001


@pytest.mark.slow
def test_the_command_writes_picture_and_gait(tmp_path: Path) -> None:
    words = ["optimize", "penn_state", "--for", "power-at-speed", "--speed", "0.15", "--draws", "2", "--json"]
    words += ["--within", "alpha=30..50,beta=60..100,omega=1..3", "--out", str(tmp_path)]
    result = CliRunner().invoke(cli, words)
    assert result.exit_code == 0, result.output
    told = json.loads(result.output)
    assert told["schema"] == "snakebot.optimum/1"
    assert told["found"]["speed_m_s"] == pytest.approx(0.15, rel=3e-3)
    assert {path.name for path in tmp_path.iterdir()} == {"optimum.png", "optimum.svg", "gait.yaml"}
    assert load_gait(tmp_path / "gait.yaml").omega_rad_s == pytest.approx(
        told["found"]["omega_rad_s"], rel=1e-3
    )


@pytest.mark.slow
def test_the_last_line_runs_the_choice_on_the_same_robot(tmp_path: Path) -> None:
    mine = tmp_path / "mine.yaml"
    mine.write_text(yaml.safe_dump(ROBOT.to_mapping() | {"name": "mine"}))
    words = [
        "optimize",
        str(mine),
        "--for",
        "speed",
        "--draws",
        "0",
        "--grid",
        "2,2,2",
        "--out",
        str(tmp_path),
    ]
    words += ["--within", "alpha=35..36,beta=80..81,omega=2..2.1", "--effect", "rate_limit:limit_rad_s=1.2"]
    result = CliRunner().invoke(cli, words)
    assert result.exit_code == 0, result.output
    (line,) = [line for line in result.output.splitlines() if line.startswith("snakebot run ")]
    assert line.endswith(f" --robot {mine} --effect rate_limit:limit_rad_s=1.2")
    dry = CliRunner().invoke(cli, [*shlex.split(line)[1:], "--dry-run"])
    assert dry.exit_code == 0, dry.output


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["no_such_robot", "--for", "speed"], "no_such_robot"),
        (["penn_state", "--for", "power-at-speed"], "--speed 0.2"),
        (["penn_state", "--for", "speed", "--speed", "0.2"], "only with"),
        (["penn_state", "--for", "speed", "--within", "alpha=5"], "--within"),
        (["penn_state", "--for", "speed", "--fault", "free:9"], "no joint 9"),
        (["penn_state", "--for", "speed", "--fault", "rigid:3@4s"], "all the time"),
        (["penn_state", "--for", "speed", "--fault", "free:3", "--fault", "rigid:3"], "has a fault already"),
        (["penn_state", "--for", "speed", "--fault", "free:1+2+3+4+5"], "no joint is left"),
        (["penn_state", "--for", "speed", "--effect", "rate_limt"], "did you mean"),
        (["penn_state", "--for", "speed", "--torque", "-1"], "--torque"),
        (["penn_state", "--for", "speed", "--margin", "2"], "--margin"),
        (["penn_state", "--for", "speed", "--robust", "--draws", "0"], "--robust"),
        (["penn_state", "--for", "speed", "--within", "alpha=100..120"], "allows 95 deg"),
        (["penn_state", "--for", "sped"], "sped"),
    ],
)
def test_bad_input_is_told_before_anything_is_computed(
    words: list[str],
    said: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(["optimize", *words])
    assert ended.value.code == 2
    line = capsys.readouterr().err
    assert said in line
    assert len(line.splitlines()) <= 2  # the second one: where help is
    assert list(tmp_path.iterdir()) == []
