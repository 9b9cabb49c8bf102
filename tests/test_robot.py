"""Robot descriptions: what is read, what is refused and in which words."""

from __future__ import annotations

import contextlib
import math
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from snakebot.errors import BadInputError
from snakebot.robot import Robot, load_robot, robot_from_mapping, robot_option, shipped_name

SHIPPED = sorted(path.stem for path in (Path(__file__).parent.parent / "configs" / "robots").glob("*.yaml"))


def mapping(**changes: object) -> dict[str, object]:
    return {**load_robot("penn_state").to_mapping(), **changes}


@pytest.mark.parametrize("name", SHIPPED)
def test_each_shipped_robot_loads_and_comes_back_from_its_own_yaml(name: str) -> None:
    robot = load_robot(name)
    assert robot.name == name
    assert robot_from_mapping(yaml.safe_load(robot.to_yaml()), "again") == robot


def test_penn_state_holds_the_papers_numbers() -> None:
    robot = load_robot("penn_state")
    assert robot.body is not None
    friction = robot.body.friction
    assert (robot.body.links, robot.joints, robot.encoder_counts_per_rev) == (6, 5, 8192)
    # eqs. (31) and (34), SI
    assert (friction.ct, friction.ct0, friction.cn, friction.cn0) == (0.83, 0.49, 51.9, 2.33)
    # 0.49 N of rolling friction at 2 degrees of incline
    assert robot.body.link_mass_kg == pytest.approx(0.49 / (9.81 * math.sin(math.radians(2))), rel=0.01)


@pytest.mark.parametrize("name", SHIPPED)
def test_every_number_of_a_shipped_robot_says_where_it_comes_from(name: str) -> None:
    robot = load_robot(name)
    told = set(robot.provenance)
    for key in ("half_length_m", "link_mass_kg", "servo.time_constant_s"):
        assert key in told
    assert {"friction"} <= told or {"friction.ct", "friction.cn", "friction.ct0", "friction.cn0"} <= told


def test_a_robot_that_comes_with_snakebot_is_known_by_its_name() -> None:
    for name in SHIPPED:
        robot = load_robot(name)
        again = robot_from_mapping(robot.model_copy(update={"provenance": {}}).to_mapping(), "again")
        assert shipped_name(again) == name
        assert robot_option(again) == ("" if name == "penn_state" else f" --robot {name}")
        other = robot.model_copy(update={"encoder_counts_per_rev": 1000})
        assert robot_option(other) == " --robot ROBOT.yaml"


def test_a_bench_has_joints_and_no_body() -> None:
    bench = robot_from_mapping(
        {"joints": 1, "servo": {"time_constant_s": 0.03}, "encoder_counts_per_rev": 4096}, "b"
    )
    assert (bench.joints, bench.body) == (1, None)
    assert bench.rad_per_count == pytest.approx(2 * math.pi / 4096)


def test_keys_of_a_servo_that_are_not_known_are_kept() -> None:
    robot = robot_from_mapping(mapping(servo={"time_constant_s": 0.03, "arm_mass_kg": 0.2}), "here")
    assert robot.servo.model_extra == {"arm_mass_kg": 0.2}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"links": 1}, ("links",)),
        ({"links": 33}, ("links",)),
        ({"links": "08"}, ("links", "08")),  # a leading zero makes text of it
        ({"links": 6.0}, ("links",)),
        ({"half_length_m": -1}, ("half_length_m", "-1")),
        ({"half_length_m": math.nan}, ("half_length_m",)),
        ({"link_mass_kg": [1, 2]}, ("link_mass_kg", "2 values", "6 links")),
        ({"friction": {"ct": 1}}, ("friction.cn",)),
        ({"friction": {"ct": -1, "cn": 1}}, ("friction.ct",)),
        ({"frction": {}}, ("frction",)),
        ({"limits": {"angle_deg": [1, 2, 3]}}, ("limits.angle_deg", "3 values", "5 joints")),
        ({"joints": 7}, ("joints is 7", "6 links")),
        ({"schema": "snakebot.robot/9"}, ("snakebot.robot/9", "snakebot.robot/1")),
    ],
)
def test_what_is_wrong_is_named_with_its_key(changes: dict[str, object], words: tuple[str, ...]) -> None:
    with pytest.raises(BadInputError) as caught:
        robot_from_mapping(mapping(**changes), "file.yaml")
    message = str(caught.value)
    assert "\n" not in message
    for word in ("file.yaml", *words):
        assert word in message


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        (
            {"link_mass_kg": [1, 1, 1, 1, 1, -1]},
            "file.yaml: link_mass_kg.5: Input should be greater than 0 (found -1)",
        ),
        (
            {"provenance": {"servo-lag": {"status": "guess", "source": "x"}}},
            "file.yaml: provenance.servo-lag.status: ",
        ),
        ({"link_mass_kg": 0}, "file.yaml: link_mass_kg: Input should be greater than 0 (found 0)"),
        (
            {"limits": {"speed_rad_s": 0}},
            "file.yaml: limits.speed_rad_s: Input should be greater than 0 (found 0)",
        ),
    ],
)
def test_one_fault_is_told_as_one_in_the_words_of_the_file(changes: dict[str, object], told: str) -> None:
    with pytest.raises(BadInputError) as caught:
        robot_from_mapping(mapping(**changes), "file.yaml")
    assert str(caught.value).startswith(told)
    assert "more" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "joints: 1\nlimits: {angle_deg: 10}\njoints: 2\n",
            "line 3: joints is given twice, before on line 1",
        ),
        (
            "joints: 1\nlimits: {angle_deg: 10, angle_deg: 170}\n",
            "line 2: angle_deg is given twice, before on line 2",
        ),
    ],
)
def test_a_key_that_is_given_twice_is_refused(tmp_path: Path, text: str, told: str) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(text)
    with pytest.raises(BadInputError) as caught:
        load_robot(path)
    assert str(caught.value) == f"{path}: {told}"


@pytest.mark.parametrize(
    "text", ["[1, 2", "just words", "- a\n- b\n", "!!python/object:os.system {}", "\x00"]
)
def test_a_file_that_is_no_description_is_one_clear_line(tmp_path: Path, text: str) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(text)
    with pytest.raises(BadInputError, match=r"robot\.yaml"):
        load_robot(path)


plain = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=12,
)


@given(st.sampled_from(sorted(mapping())), plain)
def test_any_value_under_any_key_is_read_or_refused(key: str, value: object) -> None:
    with contextlib.suppress(BadInputError):
        assert isinstance(robot_from_mapping(mapping(**{key: value}), "fuzz"), Robot)


def test_recordings_given_for_a_robot_name_the_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "run.csv").write_text("t_s\n0\n")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    (tmp_path / "saito").mkdir()
    for source in ("lab", "run.csv", tmp_path / "lab"):
        with pytest.raises(
            BadInputError, match=r"recordings, no robot description; `snakebot diagnose .* --apply"
        ):
            load_robot(source)
    assert load_robot("saito").name == "saito", "a folder of the name of a robot that comes with snakebot"
