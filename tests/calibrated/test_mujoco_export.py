"""The exported model in MuJoCo against recordings, and what ``snakebot robot export`` says and refuses."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner, Result
from mujoco_export_peers import compare, exported
from sessions import bench, snake

from snakebot.cli.robot import command
from snakebot.robot import Robot

mujoco = pytest.importorskip("mujoco")

WITHIN = 1.2  # times our own prediction's error
HEALTHY: tuple[str, ...] = ()
# What MuJoCo shows as snakebot does; a bench's too.
SAME = (
    HEALTHY,
    ("rate_limit:limit_rad_s=1.6",),
    ("compliance:stiffness_nm_rad=20",),
    ("compliance:stiffness_nm_rad=5",),
    ("command_delay:delay_s=0.0337",),
    ("second_order:natural_freq_rad_s=12,damping_ratio=0.4",),
    ("deadband:width_deg=3",),
    ("backlash:width_deg=6,joints=4",),
    ("voltage_sag:initial_rad_s=2,drop_per_s=0.04",),
    ("wiring:permutation=3+2,signs=1+-1,joints=2+3", "payload:link=2,mass_kg=1"),
    ("servo_offset:offset_deg=3,joints=2", "encoder_gain:gain=1.1", "joint_rigid:angle_deg=20,joints=4"),
)
# What hinges on who catches up when: our own prediction moves as much when its step is a quarter as long.
NEARLY_SAME = 1.5  # times our own prediction's error
NEAR = (
    ("torque_speed:no_load_rad_s=3,stall_nm=0.8",),
    ("torque_limit:limit_nm=0.6,joints=3",),
    ("joint_friction:coulomb_nm=0.3,stiffness_nm_rad=6",),
    ("joint_free:joints=3",),
)


def assert_same(
    robot: Robot, effects: tuple[str, ...], folder: Path, duration_s: float, within: float = WITHIN
) -> None:
    found = compare(robot, effects, folder, duration_s)
    assert found.theirs_rad < within * found.ours_rad, found
    if robot.body is not None:
        assert found.their_way_m == pytest.approx(found.our_way_m, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("effects", SAME, ids=lambda effects: "+".join(effects) or "healthy")
def test_mujoco_shows_the_recording_as_our_own_prediction_does(
    effects: tuple[str, ...], tmp_path: Path
) -> None:
    assert_same(snake(), effects, tmp_path, 6.0)


@pytest.mark.slow
@pytest.mark.parametrize("effects", NEAR, ids=lambda effects: "+".join(effects))
def test_motors_that_are_overtaxed_stick_or_are_dead_do_nearly(
    effects: tuple[str, ...], tmp_path: Path
) -> None:
    assert_same(snake(), effects, tmp_path, 6.0, NEARLY_SAME)


def test_an_overtaxed_motor_of_the_run_before_is_put_right(tmp_path: Path) -> None:
    """The callbacks change the model; a second run on it is as the first."""
    robot = snake().model_copy(update={"effects": ("torque_limit:limit_nm=0.5",)})
    model, callbacks = exported(robot, tmp_path)
    ends = []
    for _ in range(2):
        held, data = callbacks.install(model), mujoco.MjData(model)
        held.put_down(data)
        data.ctrl[:] = [0.5, -0.5, 0.5, -0.5, 0.5]
        mujoco.mj_step(model, data, 100)
        ends.append(held.encoders(data))
        callbacks.remove()
    assert np.array_equal(*ends)


@pytest.mark.parametrize("effects", [HEALTHY, ("rate_limit:limit_rad_s=1.6",)])
def test_a_bench_of_servos_too(effects: tuple[str, ...], tmp_path: Path) -> None:
    assert_same(bench(1), effects, tmp_path, 2.0)


def test_a_position_loop_lifts_its_arm(tmp_path: Path) -> None:
    arm = {"time_constant_s": 0.03, "arm": {"mass_kg": 0.5, "length_m": 0.1}}
    robot = Robot.model_validate({"name": "arm", "joints": 1, "servo": arm})
    loop = "position_loop:stiffness_nm_rad=3,damping_nm_s_rad=0.3,coulomb_nm=0.05,full_drive_deg=60"
    assert_same(robot, (loop,), tmp_path, 2.0)


def test_the_model_is_the_robots(tmp_path: Path) -> None:
    robot = snake().model_copy(update={"effects": ("payload:link=2,mass_kg=1", "slope:angle_deg=2")})
    model, _ = exported(robot, tmp_path)
    assert model.nu == 5
    assert model.body_mass.sum() == pytest.approx(6 * 1.43 + 1)
    assert model.opt.gravity[0] == pytest.approx(-9.80665 * np.sin(np.radians(2)))


def call(*arguments: object) -> Result:
    return CliRunner().invoke(command, ["export", *map(str, arguments)], catch_exceptions=True)


def test_what_is_left_out_stands_in_the_file_and_on_the_terminal(tmp_path: Path) -> None:
    robot = snake().model_copy(update={"effects": ("command_loss:probability=0.1", "clock_drift:ppm=2000")})
    source, out = tmp_path / "robot.yaml", tmp_path / "my-snake.xml"
    source.write_text(robot.to_yaml())
    result = call(source, "--mujoco", out)
    assert result.exit_code == 0, result.output
    assert (tmp_path / "my_snake.py").is_file()
    text = out.read_text()
    for word in ("command_loss", "clock_drift"):
        assert word in result.output
        assert text.index(word) < text.index("<mujoco")
    mujoco.MjModel.from_xml_path(str(out))
    said = json.loads(call(source, "--mujoco", out, "--json").output)  # again, over itself
    assert said["written"] == [str(out), str(tmp_path / "my_snake.py")]
    assert any("command_loss" in line for line in said["not_expressed"])


def test_a_model_is_written_where_mujoco_is_not_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in [name for name in sys.modules if name.startswith("snakebot.calibrated.mujoco")]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, "mujoco", None)  # an import of it fails
    result = call("penn_state", "--mujoco", tmp_path / "snake.xml")
    assert result.exit_code == 0, result.output
    assert "import mujoco" in (tmp_path / "snake.py").read_text()


def test_a_name_from_a_stranger_breaks_no_xml(tmp_path: Path) -> None:
    robot = snake().model_copy(update={"name": '--></x> & "<b-'})
    exported(robot, tmp_path)


CALIBRATED = """\
schema: snakebot.robot/1
name: calibrated
links: 6
half_length_m: 0.08
link_mass_kg: 1.43
friction: {ct: 0.83, cn: 51.9, ct0: 0.49, cn0: 2.33}
effects: ["rate_limit:limit_rad_s=1.6,joints=3", "deadband:width_deg=1+2,joints=1+2"]
intervals:
  - {number: effects.rate_limit.limit_rad_s, joints: [3], estimate: 1.6, ci95: [1.5, 1.7066667]}
  - {number: effects.deadband.width_deg, joints: [2], estimate: 2, ci95: [1.5, 2.5]}
  - {number: effects.deadband.width_deg, joints: [1], estimate: 1, ci95: null}
"""


def test_ranges_are_those_of_the_intervals_and_tolerances(tmp_path: Path) -> None:
    source, out = tmp_path / "robot.yaml", tmp_path / "ranges.yaml"
    source.write_text(CALIBRATED)
    result = call(source, "--ranges", out)
    assert result.exit_code == 0, result.output
    data = yaml.safe_load(out.read_text())
    rows = {(row["number"], *row.get("joints", ())): row for row in data["ranges"]}
    assert data["schema"] == "snakebot.ranges/1"
    limit = rows["effects.rate_limit.limit_rad_s", 3]
    assert limit["range"] == pytest.approx([1.5, 1.7066667], rel=1e-3)
    assert limit["distribution"] == "lognormal"
    assert "servo_3" in limit["mjcf"]
    assert rows["effects.deadband.width_deg", 2]["range"] == pytest.approx([1.5, 2.5])
    assert rows["effects.deadband.width_deg", 1]["source"] == "prior"
    assert rows["friction.ct",]["sigma"] == pytest.approx(0.05 * 0.83)
    assert rows["link_mass_kg",]["sigma"] == pytest.approx(0.03 * 1.43)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("penn_state",), "give --mujoco"),
        (("nobody", "--ranges", "x.yaml"), "nobody"),
        (("penn_state", "--mujoco", "snake.txt"), "ends in .xml"),
        (("penn_state", "--mujoco", "1.xml"), "cannot import"),
        (("penn_state", "--mujoco", "nowhere/snake.xml"), "does not exist"),
        (("penn_state", "--mujoco", "taken.xml"), "exists, and is no MJCF"),
        (("bad.yaml", "--ranges", "x.yaml"), "the robot has no such effect"),
        (("worse.yaml", "--ranges", "x.yaml"), "does not hold its estimate"),
    ],
)
def test_bad_input_is_one_line_and_writes_nothing(
    words: tuple[str, ...], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("taken.xml").write_text("<mujoco/>")
    Path("bad.yaml").write_text(CALIBRATED.replace("joints: [3]", "joints: [4]"))
    Path("worse.yaml").write_text(CALIBRATED.replace("[1.5, 2.5]", "[2.5, 1.5]"))
    before = {path.name: path.read_text() for path in tmp_path.iterdir()}
    result = call(*words)
    assert type(result.exception).__name__ in ("BadInputError", "SystemExit")
    assert said in str(result.exception)
    assert "\n" not in str(result.exception)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == before
