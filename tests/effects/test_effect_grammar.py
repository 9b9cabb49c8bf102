"""The grammar of --effect: what is written comes back, and what is wrong is told in one line."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from snakebot.effects import EffectSpec, effects, load_effect_set, parse_effect, parse_effects, robot_effects
from snakebot.errors import BadInputError
from snakebot.resources import configs_root
from snakebot.robot import load_robot, robot_from_mapping

ROBOT = load_robot("penn_state")


@st.composite
def specs(draw: st.DrawFn) -> EffectSpec:
    effect = draw(st.sampled_from(list(effects().values())))
    values: dict[str, float | tuple[float, ...]] = {}
    for p in effect.parameters:
        if p.default is not None and draw(st.booleans()):
            continue
        if p.integer:
            number = st.integers(int(p.lower), int(p.upper)).map(float)
        else:
            number = st.floats(p.lower, p.upper, allow_nan=False, allow_subnormal=False)
        if p.many and draw(st.booleans()):
            values[p.name] = tuple(draw(st.lists(number, min_size=2, max_size=5)))
        else:
            values[p.name] = draw(number)
    joints = None
    if effect.per_joint and draw(st.booleans()):
        joints = tuple(draw(st.lists(st.integers(1, 31), min_size=1, max_size=5, unique=True)))
    return EffectSpec(effect.name, values, joints)


@given(specs())
def test_round_trip(spec: EffectSpec) -> None:
    again = parse_effect(str(spec))
    assert again == spec
    assert hash(again) == hash(spec)


@given(st.text(max_size=60))
def test_any_text_is_read_or_refused_in_one_line(text: str) -> None:
    check_refusal(text)


@given(st.sampled_from(list(effects())), st.text("abcdefj_=,+-:. 0123456789einfa", max_size=40))
def test_nearly_right_text_is_read_or_refused_in_one_line(name: str, rest: str) -> None:
    check_refusal(f"{name}:{rest}")


def check_refusal(text: str) -> None:
    try:
        spec = parse_effect(text)
    except BadInputError as error:
        told = str(error)
    else:
        assert parse_effect(str(spec)) == spec
        return
    assert told.count("\n") <= text.count("\n")


def test_example_of_the_contract() -> None:
    spec = parse_effect("rate_limit:limit_rad_s=1.6,joints=3+4")
    assert spec == EffectSpec("rate_limit", {"limit_rad_s": 1.6}, (3, 4))
    assert str(spec) == "rate_limit:limit_rad_s=1.6,joints=3+4"
    assert spec.joint_indices(5) == (2, 3)
    assert parse_effect(" rate_limit : limit_rad_s = 1.6 , joints = 3+4 ") == spec
    assert parse_effect("rate_limit:limit_rad_s=1.6e+0") == EffectSpec("rate_limit", {"limit_rad_s": 1.6})


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("rate_limits:limit_rad_s=1", "did you mean rate_limit? Known: command_delay, command_loss"),
        ("", "Known: command_delay"),
        ("rate_limit", "needs limit_rad_s; it takes limit_rad_s (0.05 to 50 rad/s), joints (as in 3+4)"),
        ("rate_limit:", "nothing after the colon"),
        ("rate_limit:1.6", "'1.6' is not parameter=value"),
        ("rate_limit:limit=1.6", "has no parameter 'limit'; did you mean limit_rad_s? it takes"),
        ("rate_limit:limit_rad_s=fast", "limit_rad_s=fast is not a number"),
        ("rate_limit:limit_rad_s=nan", "not a number"),
        ("rate_limit:limit_rad_s=1e9", "limit_rad_s=1000000000 is out of bounds (0.05 to 50 rad/s)"),
        ("rate_limit:limit_rad_s=1,limit_rad_s=2", "limit_rad_s is given twice"),
        ("rate_limit:limit_rad_s=1+2", "limit_rad_s takes one value"),
        ("rate_limit:limit_rad_s=1,joints=3+3", "each once"),
        ("rate_limit:limit_rad_s=1,joints=0", "numbered from 1"),
        ("rate_limit:limit_rad_s=1,joints=1.5", "are not joint numbers"),
        ("rate_limit:limit_rad_s=1,joints=6", "joint 6 of a robot with 5 joints"),
        ("clock_drift:ppm=100,joints=1", "works on the whole robot"),
        ("payload:link=7,mass_kg=1", "link 7 of a robot with 6 links"),
        ("payload:link=1.5,mass_kg=1", "a whole number"),
        ("wiring:permutation=2+2+3+4+5", "permutation must name each of the joints 1+2+3+4+5 once"),
        ("wiring:permutation=2+1", "permutation has 2 values for 5 joints"),
        ("wiring:signs=0", "signs are 1 or -1"),
    ],
)
def test_what_is_wrong_is_told(text: str, told: str) -> None:
    with pytest.raises(BadInputError) as caught:
        parse_effect(text, ROBOT)
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.exit_status == 2


def test_bodies_only() -> None:
    with pytest.raises(BadInputError, match="has no body"):
        parse_effect("slope:angle_deg=2", robot_from_mapping({"joints": 1}, "bench"))


@pytest.mark.parametrize("path", sorted((configs_root() / "effects").glob("*.yaml")), ids=lambda p: p.stem)
def test_sets_of_effects_that_come_along(path: Path) -> None:
    found = load_effect_set(path.stem, ROBOT)
    assert found
    assert parse_effects([path.stem, "slope:angle_deg=1"], ROBOT) == (
        *found,
        parse_effect("slope:angle_deg=1"),
    )
    assert parse_effects([str(path)]) == found


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("effects: [1]", "needs effects:"),
        ("- a", "needs effects:"),
        ("effects: 'rate_limit'", "needs effects:"),
        ("effects: [rate_limit]", "needs limit_rad_s"),
        ("schema: other/1\neffects: []", "schema is 'other/1'"),
        ("effects: [", "not YAML"),
        ("!!python/object/apply:os.getcwd []", "not YAML"),
    ],
)
def test_a_bad_set_is_told_with_its_file(tmp_path: Path, text: str, told: str) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(BadInputError) as caught:
        parse_effects([str(path)])
    assert told in str(caught.value)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_neither_effect_nor_set() -> None:
    with pytest.raises(BadInputError, match="Known: command_delay"):
        parse_effects(["no_such_thing"])


def test_effects_of_a_description() -> None:
    robot = ROBOT.model_copy(update={"effects": ("slope:angle_deg=2", "tired_battery")})
    assert [spec.name for spec in robot_effects(robot)] == ["slope", "voltage_sag"]
    with pytest.raises(BadInputError, match=r"robot penn_state: effects: .*did you mean slope"):
        robot_effects(ROBOT.model_copy(update={"effects": ("slop:angle_deg=2",)}))


def test_priors_and_bounds_of_all_parameters() -> None:
    import numpy as np

    rng = np.random.default_rng(0)
    for effect in effects().values():
        for p in effect.parameters:
            drawn = [p.sample(rng) for _ in range(20)]
            assert all(p.contains(v) for v in drawn), (effect.name, p.name)
            assert p.contains(p.clip(1e9))
            assert p.contains(p.clip(-1e9))
