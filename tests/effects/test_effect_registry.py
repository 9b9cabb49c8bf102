"""Names are those of the contract, and other packages can add theirs."""

import importlib.metadata
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NoReturn

import pytest

from snakebot.effects import effects, find_effect, parse_effect, parse_effects
from snakebot.effects.effect import STAGES
from snakebot.effects.library.rate_limit import RateLimit
from snakebot.effects.registry import ENTRY_POINT_GROUP, LIBRARY, look_alikes
from snakebot.robot import load_robot, robot_from_mapping
from snakebot.safe_yaml import load_yaml

REPOSITORY = Path(__file__).resolve().parents[2]

PUBLIC = {
    "command_delay": ("link", ["delay_s"]),
    "command_loss": ("link", ["probability"]),
    "clock_drift": ("link", ["ppm"]),
    "servo_lag": ("servo", ["time_constant_s"]),
    "second_order": ("servo", ["natural_freq_rad_s", "damping_ratio"]),
    "rate_limit": ("servo", ["limit_rad_s"]),
    "torque_limit": ("servo", ["limit_nm"]),
    "voltage_sag": ("servo", ["initial_rad_s", "drop_per_s"]),
    "deadband": ("servo", ["width_deg"]),
    "backlash": ("servo", ["width_deg"]),
    "joint_friction": ("servo", ["coulomb_nm", "stiffness_nm_rad"]),
    "compliance": ("servo", ["stiffness_nm_rad"]),
    "servo_offset": ("servo", ["offset_deg"]),
    "command_gain": ("servo", ["gain"]),
    "joint_free": ("servo", []),
    "joint_rigid": ("servo", []),
    "wiring": ("servo", []),
    "encoder_offset": ("sensor", ["offset_deg"]),
    "encoder_gain": ("sensor", ["gain"]),
    "encoder_noise": ("sensor", ["std_deg"]),
    "ground_friction": ("body", ["ct_scale", "cn_scale", "ct0_scale", "cn0_scale"]),
    "wheel_drag": ("body", ["link", "extra_n"]),
    "payload": ("body", ["link", "mass_kg"]),
    "slope": ("body", ["angle_deg"]),
}


def test_public_names() -> None:
    for name, (stage, parameters) in PUBLIC.items():
        effect = find_effect(name)
        assert effect.stage == stage
        assert set(parameters) <= {p.name for p in effect.parameters}
        assert effect.per_joint == (stage in ("servo", "sensor") or name == "command_delay")


@pytest.mark.parametrize("name", effects())
def test_every_effect_tells_about_itself(name: str) -> None:
    effect = effects()[name]
    assert effect.stage in STAGES
    assert effect.summary.endswith(".")
    assert effect.mark.endswith(".")
    assert parse_effect(effect.example).name == name
    assert all(other in effects() and text for other, text in effect.confused_with)
    assert all(p.doc and p.lower < p.upper for p in effect.parameters)


def test_registry_follows_the_signal() -> None:
    stages = [STAGES.index(effect.stage) for effect in effects().values()]
    assert stages == sorted(stages)


class Entry:
    """As much of an entry point as the registry sees."""

    def __init__(self, name: str, load: Callable[[], object]) -> None:
        self.name, self.value, self.load = name, f"elsewhere:{name}", load


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Entry]]:
    """Effects of packages that are not there: fill in entries, look, and forget."""
    entries: list[Entry] = []
    original = importlib.metadata.entry_points

    def entry_points(**chosen: str) -> object:
        return entries if chosen.get("group") == ENTRY_POINT_GROUP else original(**chosen)

    monkeypatch.setattr(importlib.metadata, "entry_points", entry_points)
    effects.cache_clear()
    yield entries
    monkeypatch.undo()
    effects.cache_clear()


def test_a_broken_package_is_warned_about_and_left_out(installed: list[Entry]) -> None:
    def broken() -> NoReturn:
        raise ImportError("no module named magic")

    class Taken(RateLimit):
        pass

    installed += [
        Entry("broken", broken),
        Entry("no_effect", lambda: 42),
        Entry("taken", Taken),
        Entry("taken", lambda: Taken()),
    ]
    effects.cache_clear()
    with pytest.warns(UserWarning, match="effect") as warned:
        found = effects()
    told = " | ".join(str(w.message) for w in warned)
    assert "effect broken cannot be loaded: no module named magic" in told
    assert "elsewhere:no_effect is not a sound Effect" in told
    assert "the name is taken" in told
    assert not isinstance(found["rate_limit"], Taken)


def test_words_cost_no_compiler() -> None:
    """--effect is read, and refused, without numba."""
    code = "import sys; from snakebot.effects import parse_effects; parse_effects(['worn_servo']); "
    code += "print('numba' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


@pytest.mark.parametrize("name", LIBRARY)
def test_the_example_is_one_of_the_robot_that_the_page_tries_it_on(name: str) -> None:
    effect = find_effect(name)
    text = effect.example_robot
    robot = robot_from_mapping(load_yaml(text, "bench.yaml"), "bench") if text else load_robot("penn_state")
    (spec,) = parse_effects([effect.example], robot)
    effect.check(spec, robot)


def test_pages_are_current() -> None:
    from snakebot.effects.page import pages

    folder = REPOSITORY / "docs" / "effects"
    made = pages()
    assert {path.name for path in folder.glob("*.md")} == set(made)
    for name, text in made.items():
        assert (folder / name).read_text(encoding="utf-8") == text, (
            f"{name}: python -m snakebot.effects.page docs/effects"
        )


def test_the_arm_of_the_index_is_one() -> None:
    import yaml

    from snakebot.effects.page import index_page
    from snakebot.effects.stages import arm_of

    (block,) = re.findall(r"```yaml\n(.*?)```", index_page(), re.DOTALL)
    arm = arm_of(robot_from_mapping(yaml.safe_load(block), "index"))
    assert arm is not None
    for name in ("drag_nm_s", "coulomb_nm"):
        assert name in index_page()
        assert hasattr(arm, name)


def test_look_alikes_are_so_both_ways() -> None:
    for name in effects():
        for other in look_alikes(name):
            assert name in look_alikes(other)
