"""``--dry-run`` makes every check that the run makes: what one refuses, the other refuses in the same words."""

from __future__ import annotations

from pathlib import Path

import pytest

from snakebot.cli.main import main

GAIT = ("--alpha", "20", "--beta", "80", "--omega", "2", "--duration", "5")
PROBE = ("--probe", "triangle:amplitude_deg=5,rate_deg_s=10")


def snakebot(capsys: pytest.CaptureFixture[str], *words: object) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as ended:
        main([str(word) for word in words])
    said = capsys.readouterr()
    return int(ended.value.code or 0), said.out, said.err


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "j20.yaml").write_text("joints: 20\n")
    (tmp_path / "fast.yaml").write_text("joints: 2\nlimits: {speed_rad_s: 1.0e+6}\n")
    (tmp_path / "wild.yaml").write_text("joints: 2\neffects: [no_such_effect]\n")
    (tmp_path / "there.mcap").write_text("something")
    (tmp_path / "folder").mkdir()
    (tmp_path / "nowhere.mcap").symlink_to(tmp_path / "other" / "x.mcap")
    return tmp_path


@pytest.mark.parametrize("motion", [GAIT, PROBE])
@pytest.mark.parametrize(
    ("more", "status", "said"),
    [
        (("--rate", "0"), 2, "--rate 0: give 20 to 1000 Hz"),
        (("--rate", "-5"), 2, "--rate -5: give"),
        (("--rate", "1e6"), 2, "--rate 1e+06: give"),
        (("--rate", "1500"), 2, "--rate 1500: give"),
        (("--rate", "19.9"), 2, "--rate 19.9: give"),
        (("--rate", "nan"), 2, "--rate nan: must be a finite number"),
        (("--rate", "inf"), 2, "--rate inf"),
        (("--ramp", "nan"), 2, "--ramp nan"),
        (("--ramp", "-1"), 2, "ramp is -1 s"),
        (("--speed", "inf"), 2, "--speed inf"),
        (("--robot", "j20.yaml"), 2, "20 joints; a board has at most 16"),
        (("--robot", "fast.yaml"), 2, "a board can be told"),
        (("--robot", "wild.yaml"), 2, "no_such_effect"),
        (("--port", "foo"), 2, "must begin with"),
        (("--port", "can:socketcan/can0", "--effect", "backlash"), 2, "--effect changes the simulated board"),
        (("--effect", "rate_limt"), 2, "did you mean rate_limit?"),
        (("--effect", "rate_limit:limit_rad_s=3,joints=9"), 2, "joint 9 of a robot with"),
        (("--fault", "rigid:2=150"), 2, "allows 95 deg"),
        (("--fault", "free:9"), 2, "no joint 9"),
        (("--log", "there.mcap"), 6, "exists already"),
        (("--log", "there"), 6, "exists already"),
        (("--log", "nowhere.mcap"), 6, "exists already"),
        (("--log", "folder"), 6, "is a folder"),
        (("--log", "."), 6, "is a folder"),
        (("--log", "there.mcap/x"), 6, "there.mcap is not a folder"),
    ],
)
def test_both_refuse_in_the_same_words(
    capsys: pytest.CaptureFixture[str],
    folder: Path,
    motion: tuple[str, ...],
    more: tuple[str, ...],
    status: int,
    said: str,
) -> None:
    before = sorted(folder.rglob("*"))
    refused = [snakebot(capsys, "run", *motion, *more, "--fast", *dry) for dry in ((), ("--dry-run",))]
    assert refused[0] == refused[1]
    assert refused[0][:2] == (status, "")
    assert said in refused[0][2]
    assert len(refused[0][2].splitlines()) == 1
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--alpha", "66", "--beta", "80", "--omega", "1e308"), "swings at 1e+308 rad/s"),
        (("--alpha", "66", "--beta", "80", "--omega", "1e308", "--duration", "5"), "swings at 1e+308 rad/s"),
        (("--alpha", "1e308", "--beta", "80", "--omega", "2"), "asks for angle"),
        (("--alpha", "inf", "--beta", "80", "--omega", "2"), "alpha_rad is inf"),
        (("--alpha", "6", "--beta", "nan", "--omega", "2"), "beta_rad is nan"),
        (("--alpha", "6", "--beta", "80", "--omega", "2", "--cycles", "1e18"), "duration is 3.14159e+18 s"),
        (("--alpha", "6", "--beta", "80", "--omega", "1e-308"), "has no cycle that ends"),
        (("--alpha", "6", "--beta", "80", "--omega", "2", "--duration", "-1"), "--duration -1"),
        (("--alpha", "6", "--beta", "80", "--omega", "2", "--duration", "nan"), "--duration nan"),
        (("--probe", "sine:amplitude_deg=1,omega_rad_s=1e308"), "no room"),
        (("--probe", "sine:amplitude_deg=1,omega_rad_s=1e308", "--duration", "9"), "swings at 1e+308"),
        (("--probe", "steps:amplitude_deg=1e-320,acceleration_rad_s2=1e-320"), "duration is inf s"),
        (("--probe", "triangle:amplitude_deg=1e308,rate_deg_s=1e-308"), "duration is inf s"),
    ],
)
def test_a_motion_that_no_joint_can_follow_is_refused_by_both(
    capsys: pytest.CaptureFixture[str], folder: Path, words: tuple[str, ...], said: str
) -> None:
    refused = [snakebot(capsys, "run", *words, "--fast", *dry) for dry in ((), ("--dry-run",))]
    assert refused[0] == refused[1]
    assert refused[0][0] == 2
    assert said in refused[0][2]
    assert not (folder / "runs").exists()


@pytest.mark.parametrize("dry", [(), ("--dry-run",)])
def test_a_rate_for_which_the_line_is_too_slow_is_refused_before_it_is_opened(
    capsys: pytest.CaptureFixture[str], dry: tuple[str, ...]
) -> None:
    line = "serial:/dev/tty-not-there?baud=57600"
    status, _, told = snakebot(capsys, "run", *GAIT, "--rate", "1000", "--port", line, "--yes", *dry)
    assert (status, f"and {line} carries 411" in told, "Hz or less" in told) == (2, True, True), told
    assert snakebot(capsys, "run", *GAIT, "--rate", "50", "--port", line, "--dry-run")[0] == 0


def test_a_log_of_any_name_is_in_nobodys_way(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    (folder / "runs").mkdir()
    (folder / "runs" / "run.mcap").write_text("")
    assert snakebot(capsys, "run", *GAIT, "--dry-run")[0] == 0


def test_a_run_of_a_single_tick_can_be_tried_too(capsys: pytest.CaptureFixture[str]) -> None:
    words = ("run", "--alpha", "0", "--beta", "80", "--omega", "2", "--ramp", "0", "--duration", "1e-9")
    status, out, _ = snakebot(capsys, *words, "--dry-run")
    assert status == 0
    assert "1 ticks" in out
