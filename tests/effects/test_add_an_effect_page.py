"""docs/add-an-effect.md: the effects on the page do what they say, and its commands run."""

from __future__ import annotations

import importlib.metadata
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sessions import make_session, snake

from snakebot.arrays import Floats
from snakebot.diagnosis import diagnose
from snakebot.effects import Effect, Plant, assemble, effects, parse_effect, predict
from snakebot.effects.registry import ENTRY_POINT_GROUP
from snakebot.robot import robot_from_mapping

PAGE = Path(__file__).resolve().parents[2] / "docs" / "add-an-effect.md"


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


class Entry:
    """As much of an entry point as the registry sees."""

    def __init__(self, effect: Effect) -> None:
        self.name, self.value, self.effect = effect.name, f"elsewhere:{effect.name}", effect

    def load(self) -> Effect:
        return self.effect


@pytest.fixture
def page(monkeypatch: pytest.MonkeyPatch) -> Iterator[dict[str, Any]]:
    """Names of the page's files, its effects installed."""
    space: dict[str, Any] = {}
    found: list[Entry] = []
    for code in blocks("python")[:2]:
        exec(code, space)
        found.append(Entry(space["EFFECT"]))
    original = importlib.metadata.entry_points
    monkeypatch.setattr(
        importlib.metadata,
        "entry_points",
        lambda **chosen: found if chosen.get("group") == ENTRY_POINT_GROUP else original(**chosen),
    )
    effects.cache_clear()
    yield space
    monkeypatch.undo()
    effects.cache_clear()


def on_the_board(spec: str, t_s: Floats, command: Floats) -> Floats:
    robot = robot_from_mapping({"joints": command.shape[1]}, "bench")
    plant = Plant(robot, [parse_effect(spec)])
    readings = []
    for now, setpoint in zip(t_s, command, strict=True):
        plant.advance(now)
        readings.append(plant.encoder_rad())
        plant.command(now, setpoint)
    return np.array(readings)


@pytest.mark.parametrize(
    "spec", ["encoder_eccentricity:amplitude_deg=2,joints=3", "creep:share=0.3,time_constant_s=0.4,joints=3"]
)
def test_the_simulated_board_and_a_prediction_agree(page: dict[str, Any], spec: str) -> None:
    robot = robot_from_mapping({"joints": 3}, "bench")
    t_s = np.arange(0, 2, 0.01)
    command = np.stack([np.sin(t_s)] * 3, axis=1)
    predicted = predict(robot, [spec], t_s, command).encoder_rad
    assert np.allclose(on_the_board(spec, t_s, command), predicted, atol=1.01 * robot.rad_per_count)
    assert np.abs(predicted[:, 2] - predicted[:, 0]).max() > 0.02
    assert np.array_equal(predicted[:, 0], predict(robot, [], t_s, command).encoder_rad[:, 0])


def test_the_test_on_the_page_holds(page: dict[str, Any]) -> None:
    names = {"np": np, "assemble": assemble, "robot_from_mapping": robot_from_mapping}
    exec(blocks("python")[2], names)
    names["test_mark"]()  # type: ignore[operator]


def test_the_diagnosis_names_the_effect_of_the_page(page: dict[str, Any]) -> None:
    """Its priors are written as whole numbers."""
    session = make_session(snake(), ["encoder_eccentricity:amplitude_deg=4,joints=3"], duration_s=6.0)
    found = diagnose(session, only=["encoder_eccentricity", "encoder_offset"], quick=True)
    assert [(cause.effect, cause.joints) for cause in found.causes] == [("encoder_eccentricity", (3,))]
    assert found.causes[0].parameters["amplitude_deg"].estimate == pytest.approx(4.0, rel=0.05)


def test_what_comes_late_is_the_closed_form_also_when_the_servo_was_off(page: dict[str, Any]) -> None:
    creeping = page["Creeping"](np.array([0.3]), 0.4)
    t_s = np.arange(0, 1, 0.002)
    step = np.where(t_s > 0, 1.0, 0.0)[:, None]
    late = 1 - 0.3 * np.exp(-t_s[1:] / 0.4)
    assert np.allclose(creeping.follow(t_s, step)[1:, 0], late)
    off = creeping.follow(t_s + 1, np.full((t_s.size, 1), np.nan))
    assert np.isnan(off).all()
    assert np.allclose(creeping.follow(t_s + 2, np.full((t_s.size, 1), 0.5)), 0.5)


def test_a_board_that_is_asked_at_odd_times_sees_the_same(page: dict[str, Any]) -> None:
    robot = robot_from_mapping({"joints": 1}, "bench")
    spec = parse_effect("creep:share=0.3,time_constant_s=0.4")
    often, seldom = Plant(robot, [spec]), Plant(robot, [spec])
    for plant in (often, seldom):
        plant.command(0.0, [0.4])
    for now in np.cumsum(np.random.default_rng(1).uniform(0.0001, 0.004, 200)):
        often.advance(float(now))
    seldom.advance(often.t_s)
    assert often.joint_angle_rad == pytest.approx(seldom.joint_angle_rad, abs=1e-6)


def test_the_entry_point_on_the_page_is_the_group_that_is_read() -> None:
    (table,) = blocks("toml")
    groups = tomllib.loads(table)["project"]["entry-points"]
    assert groups == {
        ENTRY_POINT_GROUP: {"encoder_eccentricity": "eccentric:EFFECT", "creep": "creep:EFFECT"}
    }


def test_the_command_on_the_page_writes_the_pages(tmp_path: Path) -> None:
    (command,) = [line for block in blocks("sh") for line in block.splitlines() if line.startswith("python")]
    words = command.split()
    target = tmp_path / "pages"
    arguments = [sys.executable, *words[1:-1], str(target)]
    done = subprocess.run(arguments, capture_output=True, text=True, check=True)
    assert f"{len(effects()) + 1} pages" in done.stdout
    stale = target / "gone.md"
    stale.write_text((target / "slope.md").read_text(encoding="utf-8"), encoding="utf-8")
    (target / "mine.md").write_text("# Mine\n", encoding="utf-8")
    subprocess.run(arguments, capture_output=True, check=True)
    assert not stale.exists()
    assert (target / "mine.md").exists()
