"""Whether a choice paid: by turns, with intervals, and said as it is."""

from __future__ import annotations

import json
from itertools import count
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from snakebot.cli.main import cli, main
from snakebot.gait import Gait
from snakebot.optimise.goal import Goal
from snakebot.optimise.optimum import optimise
from snakebot.optimise.promise import OptimiseOptions, Promise
from snakebot.optimise.proof import Proof, prove
from snakebot.robot import load_robot

FAST = Goal("speed")


def promise(what: str, alpha: float, speed: float, band: float = 0.01) -> Promise:
    ends = (speed - band, speed + band)
    return Promise(
        what, alpha, 80.0, 2.0, speed, 1.0, 0.1, 0.5, 0.0, (), speed_ci95=ends, power_ci95=(0.9, 1.1)
    )


def proved(alphas: tuple[float, float], noise: float, goal: Goal = FAST, stop: int = 99) -> Proof:
    """A robot whose speed in m/s is 0.1 of alpha in rad, and its power a tenth of a watt for each degree."""
    rng, number = np.random.default_rng(1), count()

    def run(gait: Gait, what: str) -> tuple[float, float] | None:
        if next(number) >= stop:
            return None
        return 0.1 * gait.alpha_rad + noise * rng.normal(), np.degrees(gait.alpha_rad) / 10

    plain, chosen = (promise(what, a, 0.1 * np.radians(a)) for what, a in zip("ab", alphas, strict=True))
    return prove(goal, plain, chosen, [promise("c", 55.0, 0.3)], run)


def test_a_clear_gain_paid_and_a_clear_loss_did_not() -> None:
    assert proved((40, 50), 1e-4).verdict == "paid"
    assert proved((40, 50), 1e-4).gain == pytest.approx(0.25, abs=0.01)
    assert proved((50, 40), 1e-4).verdict == "did not pay"


def test_less_power_is_a_gain_where_power_counts() -> None:
    found = proved((50, 40), 1e-4, Goal("power-at-speed", 0.1))
    assert found.verdict == "paid"
    assert found.gain == pytest.approx(0.2)


def test_what_noise_hides_cannot_be_told() -> None:
    found = proved((40, 41.5), 0.02)
    assert found.verdict == "cannot be told"
    assert found.gain_ci95 is not None
    assert found.gain_ci95[0] < 0 < found.gain_ci95[1]


def test_promises_that_held_are_counted() -> None:
    assert proved((40, 50), 1e-4).held == (2, 3)  # the neighbour was promised 0.3 m/s


def test_one_choice_is_run_alone() -> None:
    found = proved((50, 50.5), 1e-4)
    assert found.verdict == "same choice"
    assert found.nominal is None
    assert found.calibrated is not None
    assert len(found.calibrated.speed_m_s) == 3


def test_who_says_no_ends_it_and_nothing_is_claimed() -> None:
    found = proved((40, 50), 1e-4, stop=1)
    assert found.verdict == "cannot be told"
    assert found.calibrated is None
    assert found.neighbours == ()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--budget", "5"], "only with --live"),
        (["--live", "sim:"], "--logs"),
        (["--live", "sim:", "--logs", "x", "--fault", "free:3"], "not with --live"),
        (["--live", "sim:", "--logs", "x"], "nobody to ask"),
        (["--live", "sim:", "--logs", "x", "--dask", "tcp://127.0.0.1:1"], "not with --live"),
    ],
)
def test_live_options_that_do_not_fit_are_refused(
    words: list[str],
    said: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(["optimize", "penn_state", "--for", "speed", *words])
    assert ended.value.code == 2
    assert said in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("port", ["serial:no_such_device", "serial:socket://127.0.0.1:1"])
def test_a_board_that_is_missing_is_told_before_anything_is_computed(
    port: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def computed(*_: object, **__: object) -> None:
        raise AssertionError("a gait was chosen for a board that is not there")

    monkeypatch.setattr("snakebot.optimise.optimum.optimise", computed)
    monkeypatch.chdir(tmp_path)
    words = ["optimize", "penn_state", "--for", "speed", "--live", port, "--logs", "x", "--yes"]
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 3
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_live_on_the_simulated_board(tmp_path: Path) -> None:
    words = ["optimize", "penn_state", "--for", "power-at-speed", "--speed", "0.12", "--draws", "4", "--json"]
    words += [
        "--within",
        "alpha=25..60,beta=70..90,omega=1..4",
        "--grid",
        "4,3,3",
        "--live",
        "sim:",
        "--fast",
        "--yes",
    ]
    words += [
        "--logs",
        str(tmp_path / "logs"),
        "--out",
        str(tmp_path / "out"),
        "--budget",
        "5",
        "--repeats",
        "2",
    ]
    result = CliRunner().invoke(cli, [*words, "--effect", "rate_limit:limit_rad_s=0.9"])
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert any(effect.startswith("rate_limit") for effect in told["effects"])  # found by the diagnosis
    proof = told["proof"]
    assert proof["verdict"] in ("paid", "did not pay", "cannot be told", "same choice")
    assert proof["calibrated"]["speed_m_s"] == pytest.approx([told["found"]["speed_m_s"]] * 2, rel=0.05)
    calibrated = load_robot(tmp_path / "logs" / "calibrated.yaml")
    assert f"wrote {tmp_path / 'logs' / 'calibrated.yaml'}" in result.stderr
    assert calibrated.recorded is not None
    assert calibrated.recorded.omega_rad_s == pytest.approx(4.0)  # of the starting set
    assert len(list((tmp_path / "logs" / "gaits").glob("*.mcap"))) >= 2


def test_live_ends_with_the_line_that_runs_the_choice_on_that_robot_and_board(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not on the robot and the simulated board that `snakebot run` takes by itself."""
    monkeypatch.chdir(tmp_path)
    mine, said = tmp_path / "mine.yaml", list[str]()
    mine.write_text(load_robot("penn_state").model_copy(update={"name": "mine"}).to_yaml())
    within = {"alpha": (35.0, 36.0), "beta": (80.0, 81.0), "omega": (2.0, 2.1)}
    options = OptimiseOptions(within=within, draws=0, grid=(2, 2, 2))
    found = optimise(load_robot(mine), Goal("speed"), options)
    nothing = Proof(None, None, (), None, None, (0, 0))
    monkeypatch.setattr("snakebot.cli.optimize_live.optimize_live", lambda *_: (found, nothing))
    monkeypatch.setattr("snakebot.cli.diagnose_live.check_runs", lambda *_: None)
    monkeypatch.setattr("click.echo", lambda text="", **_: said.append(str(text)))
    words = ["optimize", str(mine), "--for", "speed", "--live", "sim:", "--logs", "x", "--yes"]
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 0
    (line,) = [text for text in said if text.startswith("snakebot run")]
    assert line.endswith(f" --robot {mine} --port sim:")


@pytest.mark.parametrize(
    ("held", "said"), [("", "nobody to ask"), ("live_01.mcap", "holds something already")]
)
def test_folders_that_a_no_left_behind_are_as_good_as_new(
    held: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    folder = Path("x") / "diagnosis"
    folder.mkdir(parents=True)
    if held:
        (folder / held).touch()
    with pytest.raises(SystemExit) as ended:
        main(["optimize", "penn_state", "--for", "speed", "--live", "sim:", "--logs", "x"])
    assert ended.value.code == 2
    assert said in capsys.readouterr().err
