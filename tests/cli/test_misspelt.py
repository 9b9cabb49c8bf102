"""What is misspelt is named, with the nearest right word; in a file with its line."""

from __future__ import annotations

from pathlib import Path

import pytest

from snakebot.cli.main import main
from snakebot.effects import load_effect_set
from snakebot.errors import BadInputError
from snakebot.gait import load_gait
from snakebot.robot import load_robot
from snakebot.runlog import LogWarning, read_session

ROBOT = """\
schema: snakebot.robot/1
links: 6
half_length_m: 0.08
link_mass_kg: 1.43
friction:
  ct: 0.83
  cn: 51.9
servo: {time_constant_s: 0.03}
limits:
  speed_rad_s: 8
provenance:
  links: {status: measured, source: rule}
"""


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ("half_length_m", "half_lenght_m", "line 3: half_lenght_m is not known; did you mean half_length_m?"),
        ("links: 6", "lnks: 6", "line 2: lnks is not known; did you mean links?"),
        ("friction:", "frictoin:", "line 5: frictoin is not known; did you mean friction?"),
        ("  cn:", "  ctn:", "line 7: friction.ctn is not known; did you mean"),
        ("speed_rad_s", "sped_rad_s", "line 10: limits.sped_rad_s is not known; did you mean speed_rad_s?"),
        ("provenance:", "tolerance: {masss: 1}\nprovenance:", "tolerance.masss is not known; did you mean mass?"),
        ("source:", "sorce:", "line 12: provenance.links.sorce is not known; did you mean source?"),
        ("schema", "shema", "line 1: shema is not known; did you mean schema?"),
        ("time_constant_s", "time_constnt_s", "line 8: servo.time_constnt_s is not known; did you mean"),
        ("time_constant_s", "time_constant_ms", "line 8: servo.time_constant_ms is not known; did you mean"),
        ("limits:", "colour: red\nlimits:", "line 9: colour is not known; a robot has schema, links"),
        ("half_length_m: 0.08\n", "", "line"),
        ("links: 6", "links: many", "line 2: links"),
        ("speed_rad_s: 8", "speed_rad_s: -8", "line 10: limits.speed_rad_s"),
    ],
)  # fmt: skip
def test_a_key_of_a_robot(tmp_path: Path, right: str, wrong: str, said: str) -> None:
    path = tmp_path / "robot.yaml"
    text = ROBOT.replace(right, wrong, 1)
    assert text != ROBOT
    path.write_text(text)
    with pytest.raises(BadInputError) as told:
        load_robot(path)
    assert str(told.value).startswith(f"{path}: ")
    if said == "line":  # nothing is misspelt: a key is missing, and has no line
        assert "half_length_m: Field required" in str(told.value)
    else:
        assert said in str(told.value)
    indented = "".join(f"  {line}\n" for line in text.splitlines())
    session = tmp_path / "session"
    session.mkdir()
    (session / "session.yaml").write_text(f"robot:\n{indented}runs:\n  - file: a.csv\n")
    with pytest.raises(BadInputError) as told:
        read_session(session)
    number, colon, rest = said.removeprefix("line ").partition(":")
    assert (f"session.yaml: robot: line {int(number) + 1}{colon}{rest}" if colon else "robot: ") in str(
        told.value
    )


def test_keys_of_other_programs_stay_with_the_servo(tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text("joints: 1\nservo: {brand: x, dead_time_s: 0.1, gear: 2}\n")
    assert load_robot(path).servo.model_extra == {"brand": "x", "dead_time_s": 0.1, "gear": 2}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("alpha_deg: 1\nbeta_deg: 2\nomga_rad_s: 3\n", "line 3: omga_rad_s is not known; did you mean omega_rad_s?"),
        ("alpha_deg: 1\nbeta_deg: 2\nomega_rad_s: 3\nsorce: x\n", "line 4: sorce is not known; did you mean source?"),
        ("wheels: 1\n", "line 1: wheels is not known; a gait has alpha_deg"),
        ("alpha_deg: 1\nbeta_deg: [2]\nomega_rad_s: 3\n", "line 2: beta_deg is [2], not a number"),
    ],
)  # fmt: skip
def test_a_key_of_a_gait(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "gait.yaml"
    path.write_text(text)
    with pytest.raises(BadInputError) as told:
        load_gait(path)
    assert f"{path}: {said}" in str(told.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("schema: snakebot.effects/1\nefects:\n  - backlash\n", "line 2: efects is not known; did you mean effects?"),
        ("effects:\n  - backlash:width_deg=1\n  - backlsh\n", "line 3: no effect is called 'backlsh'; did you mean ba"),
        ("effects:\n- backlash:widht_deg=1\n", "line 2: effect backlash: has no parameter 'widht_deg'; did you mean w"),
    ],
)  # fmt: skip
def test_a_key_of_a_set_of_effects(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "set.yaml"
    path.write_text(text)
    with pytest.raises(BadInputError) as told:
        load_effect_set(path)
    assert f"{path}: {said}" in str(told.value)


SESSION = (
    "robot: {joints: 1}\nruns:\n  - file: run.csv\n    gait: {alpha_deg: 1, beta_deg: 2, omega_rad_s: 3}\n"
)


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ("robot:", "robt:", "session.yaml: line 1: robt is not known; did you mean robot?"),
        ("runs:", "runns:", "session.yaml: line 2: runns is not known; did you mean runs?"),
        ("file:", "fiel:", "runs[1]: line 3: fiel is not known; did you mean file?"),
        ("beta_deg", "bta_deg", "runs[1]: gait: line 4: bta_deg is not known; did you mean beta_deg?"),
        ("omega_rad_s: 3", "omega_rad_s: .inf", "runs[1]: gait: line 4: omega_rad_s: not a finite number"),
    ],
)
def test_a_key_of_a_session(tmp_path: Path, right: str, wrong: str, said: str) -> None:
    (tmp_path / "session.yaml").write_text(SESSION.replace(right, wrong, 1))
    (tmp_path / "run.csv").write_text("t_s,cmd_1_rad,enc_1_rad\n0,0,0\n1,0,0\n")
    with pytest.raises(BadInputError) as told:
        read_session(tmp_path)
    assert said in str(told.value)


def test_a_key_of_a_run_that_is_kept_is_told_with_the_nearest(tmp_path: Path) -> None:
    (tmp_path / "session.yaml").write_text(SESSION + "    hold_ot: true\n    colour: red\n")
    (tmp_path / "run.csv").write_text("t_s,cmd_1_rad,enc_1_rad\n0,0,0\n1,0,0\n")
    with pytest.warns(LogWarning, match=r"kept, not used: colour, hold_ot \(did you mean hold_out\?\)"):
        read_session(tmp_path)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("rnu", "No such command 'rnu'; did you mean run?"),
        ("studdy", "did you mean study?"),
        ("xyzzy", "No such command 'xyzzy'."),
        ("log lst", "did you mean list?"),
        ("log mergespeed", "did you mean merge-speed?"),
        ("log repaly", "did you mean replay?"),
        ("board simm", "did you mean sim?"),
        ("session chek", "did you mean check?"),
        ("study frictoin", "did you mean friction?"),
        ("run --alhpa 66", "--alpha"),
        ("run --gait penn_state_optimun", "did you mean penn_state_optimum?"),
        ("run --robot pen_state --gait gentle", "did you mean penn_state?"),
        ("run --gait gentle --effect backlsh", "did you mean backlash?"),
        ("run --gait gentle --effect rate_limit:limit_rad=2", "did you mean limit_rad_s?"),
        ("run --gait gentle --effect worn_serv", "did you mean"),
        ("run --probe triangel:amplitude_deg=5", "did you mean triangle?"),
        ("run --probe triangle:amplitud_deg=5", "did you mean amplitude_deg?"),
        ("run --gait gentle --port can:soketcan/can0 --yes", "did you mean socketcan?"),
        ("board test --case stops_from_any_mod", "did you mean stops_from_any_mode?"),
    ],
)
def test_a_word_on_the_command_line(capsys: pytest.CaptureFixture[str], words: str, said: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main(words.split())
    assert ended.value.code == 2
    err = capsys.readouterr().err
    assert said in err
    assert err.startswith("snakebot: ")


def test_a_file_of_strange_keys_takes_no_time_to_guess_at(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[object] = []

    def counted(word: str, *rest: object) -> list[str]:
        asked.append(word)
        return []

    monkeypatch.setattr("difflib.get_close_matches", counted)
    many = "".join(f"k{number}: 1\n" for number in range(20_000))
    (tmp_path / "session.yaml").write_text(many)
    with pytest.raises(BadInputError, match="a robot description is a mapping"):
        read_session(tmp_path)
    servo = "".join(f"  {line}\n" for line in many.splitlines())
    (tmp_path / "robot.yaml").write_text(f"joints: 1\nservo:\n{servo}")
    assert len(load_robot(tmp_path / "robot.yaml").servo.model_extra or {}) == 20_000
    assert len(asked) < 1000


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("run", "--alpha", "ten"), "'--alpha': 'ten' is not a number."),
        (("jog", "sim:", "--joint", "two"), "'--joint': 'two' is not a whole number."),
    ],
)
def test_a_word_in_place_of_a_number(
    words: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 2
    assert said in capsys.readouterr().err
