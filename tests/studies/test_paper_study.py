"""The paper's claims, the inferred links and the gap: that the code judges them, and can judge otherwise."""

from __future__ import annotations

import json
import math
import re
import shlex
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from snakebot.cli.main import main
from snakebot.effects.spec import load_effect_set
from snakebot.robot import load_robot
from snakebot.studies import gap, inference, paper
from snakebot.studies.figures_paper import optima_figure
from snakebot.studies.gap import TARGETS, GapFit, gap_study, paper_gait
from snakebot.studies.hyperredundancy import FaultCase
from snakebot.studies.inference import READINGS, Fact, evaluate
from snakebot.studies.optimum import cheapest, omega_over_speed, slope_through_origin
from snakebot.studies.paper_claims import Front, PaperEvidence, Row, rows, trend
from snakebot.studies.pareto import Pareto, front_of
from snakebot.studies.speed import SimulatedSpeed, speed_study

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "studies.md").read_text()
# What a test leaves out of the page's commands: readings, pairs of effects and most gaits.
LESS = {
    "paper": ["--quick"],
    "infer": ["--reading", "no_normal_coulomb"],
    "gap": ["--quick", "--effect", "torque_limit"],
}
PENN = load_robot("penn_state")
ALPHA, BETA, OMEGA = np.arange(9.0, 91.0, 3.0), np.arange(42.0, 121.0, 6.0), np.arange(0.5, 7.1, 0.5)


def swept(
    alpha_of_omega: tuple[float, float], beta: float, per_omega: float, watts: float = 1.0
) -> np.ndarray:
    """A sweep with a known answer: cheapest at speed v is omega = v / per_omega, with alpha on a line, and beta."""
    a, b, w = (x.ravel() for x in np.meshgrid(ALPHA, BETA, OMEGA, indexing="ij"))
    off = ((a - np.interp(w, (1, 5), alpha_of_omega)) / 30) ** 2 + ((b - beta) / 40) ** 2
    speed = per_omega * w * np.ones_like(off)
    power = watts * speed**2 * (1 + off)
    zeros = np.zeros_like(w)
    table = (np.radians(a), np.radians(b), w, zeros, speed, speed, power, power, zeros, zeros)
    return np.column_stack(table)


def front(robot_name: str, *args: float | tuple[float, float]) -> Front:
    found = swept(*args)  # type: ignore[arg-type]
    robot = load_robot("penn_state") if "penn" in robot_name else load_robot(robot_name)
    speeds = np.linspace(found[:, 4].min(), found[:, 4].max(), 40)
    optima = cheapest(found[:, :3], found[:, 4], found[:, 6], speeds.tolist())
    return Front(Pareto(robot, found, front_of(found[:, 4], found[:, 6])), tuple(optima))


def as_the_paper_says() -> PaperEvidence:
    """Evidence under which every claim that a simulation can show holds."""
    ratio: dict[tuple[str, tuple[int, ...]], float] = {}
    for count in (1, 2, 3):
        for joints in combinations(range(1, 6), count):
            ratio["free", joints] = 0.95 if set(joints) <= {1, 2} or set(joints) <= {4, 5} else 0.3
            ratio["rigid", joints] = 1.1 if joints in ((1,), (5,), (1, 2), (4, 5)) else 0.3
            if joints in ((2,), (4,)):
                ratio["free", joints] = ratio["rigid", joints] = 0.7
    faults = [FaultCase("none", (), 0.137, 0.68, 1.0, 1.0)]
    faults += [FaultCase(kind, joints, 0.137 * r, 2.0, r, 3.0) for (kind, joints), r in ratio.items()]  # type: ignore[arg-type]
    published = {(t.omega_rad_s, t.quantity): t.value for t in TARGETS}
    servo = []
    for omega, error in ((2.0, 0.05), (3.0, 0.1), (4.0, 0.3), (5.0, 0.6)):
        speed = published.get((omega, "speed_m_s"), 0.2)
        sine = published.get((omega, "sine_replay_speed_m_s"), 0.2)
        servo.append(SimulatedSpeed(66, 80, omega, 0.2 if omega < 4 else 0.4, speed, sine, (error,) * 5, 0.0))
    return PaperEvidence(
        fronts={
            "saito": front("saito", (15.0, 25.0), 60.0, 1 / 0.83, 200 / 36),
            "saito_wheeled": front("saito_wheeled", (27.0, 27.0), 78.0, 1 / 0.88, 160 / 36),
            "penn_state": front("penn_state", (70.0, 40.0), 80.0, 1 / 8.5, 20.0),
            "penn_state_viscous": front("penn_state", (30.0, 30.0), 80.0, 1 / 9.30, 5.0),
        },
        joint_power_w={"saito": 180.0, "saito_wheeled": 160.0},
        settled=0.001,
        faults=faults,
        optimum_speed_m_s=0.131,
        optimum_power_w=0.4,
        servo=servo,
        servo_effects=("torque_speed:no_load_rad_s=6,stall_nm=0.4",),
        reading={"alpha at 0.131 m/s, deg": 60.0, "alpha at 0.511 m/s, deg": 45.0},
        sweep_s=20.0,
    )


def by_claim(evidence: PaperEvidence) -> dict[str, Row]:
    table = rows(evidence)
    assert len({row.claim for row in table}) == len(table)
    return {row.claim: row for row in table}


def test_the_cheapest_gait_is_found_between_the_gaits_of_a_sweep() -> None:
    found = swept((26.0, 26.0), 74.0, 0.1)
    optima = cheapest(found[:, :3], found[:, 4], found[:, 6], [0.13, 0.31, 0.47])
    assert [o.alpha_deg for o in optima] == pytest.approx([26.0] * 3, abs=0.3)
    assert [o.beta_deg for o in optima] == pytest.approx([74.0] * 3, abs=0.5)
    assert [o.omega_rad_s for o in optima] == pytest.approx([1.3, 3.1, 4.7], rel=0.01)
    assert slope_through_origin(optima) == pytest.approx(10.0, rel=0.01)
    assert omega_over_speed(optima) == pytest.approx((10.0, 0.0), abs=0.1)
    assert all(o.alpha_range_deg[0] <= o.alpha_deg <= o.alpha_range_deg[1] for o in optima)


def test_the_figure_of_the_optima_has_alpha_and_beta_in_their_ranges_and_the_paper() -> None:
    evidence = as_the_paper_says()
    figure = optima_figure(evidence)
    angles = figure.axes[0]
    assert [line.get_label() for line in angles.get_lines()] == [
        "alpha",
        "alpha, paper",
        "beta",
        "beta, paper",
    ]
    assert len(angles.collections) == 2
    for optimum in evidence.fronts["saito"].swept:
        assert optimum.beta_range_deg == pytest.approx(
            (60.0, 60.0)
        )  # steps of 6 deg: the neighbours cost more


def test_an_optimum_at_the_edge_of_the_sweep_is_none() -> None:
    found = swept((9.0, 9.0), 74.0, 0.1)
    assert cheapest(found[:, :3], found[:, 4], found[:, 6], [0.2]) == []
    inside = swept((26.0, 26.0), 74.0, 0.1)
    assert cheapest(inside[:, :3], inside[:, 4], inside[:, 6], [0.01, 5.0]) == []


@pytest.mark.parametrize(
    ("ends", "verdict"), [((15, 25), "rising"), ((70, 40), "falling"), ((30, 30), "constant")]
)
def test_a_trend_is_read_from_the_numbers(ends: tuple[float, float], verdict: str) -> None:
    assert trend(front("saito", ends, 78.0, 1.0), "alpha_deg") == verdict


def test_each_claim_of_the_paper_is_in_the_table_and_can_hold() -> None:
    table = by_claim(as_the_paper_says())
    assert {claim[0] for claim in table} >= set("12345678")
    fixed = {"3c", "3d", "5a"}  # a synthetic sweep is no line with an offset, and has its own number of gaits
    wrong = [row.claim for row in table.values() if row.agrees is False and row.claim not in fixed]
    assert wrong == []


def test_claims_fail_when_the_numbers_say_otherwise() -> None:
    good = as_the_paper_says()
    fronts = dict(good.fronts)
    fronts["saito"], fronts["penn_state"] = fronts["penn_state"], fronts["saito"]
    faults = [replace(case, speed_ratio=2.0 - case.speed_ratio, power_ratio=1.0) for case in good.faults]
    servo = [
        replace(row, speed_m_s=0.5, sine_replay_speed_m_s=0.5, tracking_error=(0.1,) * 5)
        for row in good.servo
    ]
    bad = replace(good, fronts=fronts, faults=faults, servo=servo, settled=0.5, optimum_speed_m_s=0.3)
    table = by_claim(bad)
    for claim in ("1a", "1b", "1c", "1d", "1f", "3a", "3b", "3e", "5c"):
        assert table[claim].agrees is False, claim
    for claim in (*(f"6{x}" for x in "abcdefg"), *(f"7{x}" for x in "abcdef")):
        assert table[claim].agrees is False, claim


def test_a_quick_look_says_nothing_of_how_many_gaits_there_are_and_what_they_take() -> None:
    table = by_claim(replace(as_the_paper_says(), quick=True, sweep_s=None))
    assert table["5a"].agrees is None
    assert "quick" in table["5a"].why
    assert "earlier run" not in table["5b"].ours


def test_nothing_is_said_of_the_tables_that_the_source_does_not_show() -> None:
    row = by_claim(as_the_paper_says())["-"]
    assert (row.ours, row.agrees) == ("not compared", None)


def test_the_papers_gaits_go_through_the_three_that_its_text_gives() -> None:
    for omega, alpha in ((1, 70), (2, 66), (5, 40)):
        assert math.degrees(paper_gait(omega).alpha_rad) == pytest.approx(alpha)
        assert math.degrees(paper_gait(omega).beta_rad) == pytest.approx(80)


def test_the_inferred_servo_meets_all_published_speeds_and_the_nominal_one_does_not() -> None:
    """Claim 6; the paper's numbers are in ``gap.TARGETS`` with their sources."""
    gaits = [paper_gait(omega) for omega in (2.0, 3.0, 4.0, 5.0)]
    effects = [str(spec) for spec in load_effect_set("paper_servo")]
    assert np.abs(gap.errors(speed_study(PENN, gaits, effects))).max() < 2
    assert np.abs(gap.errors(speed_study(PENN, gaits))).max() > 5


def test_a_bound_costs_nothing_on_its_right_side() -> None:
    assert Fact("x", 1.0, 0.1, bound=+1).error(1.5) == 0
    assert Fact("x", 1.0, 0.1, bound=+1).error(0.8) == pytest.approx(-2)
    assert Fact("x", 1.0, 0.1, bound=-1).error(0.5) == 0
    assert Fact("x", 1.0, 0.1).error(1.2) == pytest.approx(2)
    assert math.isfinite(Fact("x", 1.0, 0.1).error(math.nan))


def test_fits_of_the_gap_are_kept_and_damaged_ones_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[tuple[str, ...]] = []

    def fit(robot: object, names: tuple[str, ...], *effort: int, starts: object = ()) -> GapFit:
        made.append(tuple(names))
        return GapFit(tuple(names), 10.0 / (1 + len(names)), (1.0,) * len(names), {})

    monkeypatch.setattr(gap, "fit_effects", fit)
    which = [("rate_limit",), ("servo_lag", "rate_limit")]
    first = gap_study(PENN, tmp_path, which=which)
    assert made == [(), *which]
    assert gap_study(PENN, tmp_path, which=which) == first
    assert len(made) == 3
    (tmp_path / "gap_fits.json").write_text('{"study": ')
    assert gap_study(PENN, tmp_path, which=which) == first
    assert len(made) == 6


def test_alpha_falls_only_without_the_normal_coulomb_part(monkeypatch: pytest.MonkeyPatch) -> None:
    """Why claim 3 does not come out, see docs/studies.md. On a coarser sweep than the study's."""
    monkeypatch.setattr(inference, "ALPHA_DEG", np.arange(20.0, 91.0, 10.0))
    monkeypatch.setattr(inference, "OMEGA_RAD_S", np.array([0.5, 1.0, 2.0, 4.0, 8.0]))
    sizes = {"half_length_m": 0.118, "link_mass_kg": 1.43}
    printed, without = (evaluate(PENN, READINGS[i], sizes) for i in (0, 2))
    slow, fast = "alpha at 0.131 m/s, deg", "alpha at 0.385 m/s, deg"
    assert printed[fast] > printed[slow] - 1.5
    assert without[fast] < without[slow] - 5
    assert without[slow] > printed[slow] + 10


def test_nonsense_is_answered_by_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    for words, said in (
        (["infer", "--reading", "tea"], "known are printed"),
        (["gap", "--effect", "rate_limit+tea"], "known are servo_lag"),
        (["grid", "--alpha-step", "nan"], "step of alpha: nan deg"),
        (["grid", "--alpha-step", "1000"], "step of alpha: 2 of 1000 deg are more than half a turn"),
        (["friction", "nowhere.csv"], "nowhere.csv: cannot read the table: No such file or directory"),
    ):
        with pytest.raises(SystemExit) as ended:
            main(["study", *words])
        assert ended.value.code not in (0, None)
        error = capsys.readouterr().err
        assert said in error
        assert error.count("\n") == 1


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_fit_finds_the_links_that_made_the_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    reading = READINGS[2]
    truth = {"half_length_m": 0.11, "link_mass_kg": 1.6}
    made = evaluate(PENN, reading, truth)
    facts = [replace(fact, paper=made[fact.name], bound=0) for fact in inference.facts()]
    monkeypatch.setattr(inference, "facts", lambda: facts)
    found = inference.fit_reading(PENN, reading)
    assert found.estimate["half_length_m"] == pytest.approx(0.11, rel=0.01)
    assert found.estimate["link_mass_kg"] == pytest.approx(1.6, rel=0.03)
    low, high = found.ci95["half_length_m"]
    assert low <= 0.11 <= high


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_the_papers_claims_that_hold_do_hold(tmp_path: Path) -> None:
    table, _ = paper.paper_study(tmp_path)
    held = {row.claim for row in table if row.agrees}
    assert held >= {"1a", "1b", "1c", "1d", "1e", "2a", "2b", "2d", "2e", "3b", "3e", "4a", "4b", "4e", "4f"}
    assert held >= {"5a", "5c", *(f"6{x}" for x in "abcdeg"), *(f"7{x}" for x in "abcde"), "8a"}
    assert all(row.why for row in table if row.agrees is False)
    again, kept = paper.paper_study(tmp_path)
    assert kept.sweep_s is None
    assert [row for row in again if row.claim != "5b"] == [row for row in table if row.claim != "5b"]


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_every_command_of_the_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    section = PAGE.partition("## How far the paper is reproduced")[2]
    commands = [line[2:] for line in re.findall(r"^\$ .*$", section, re.MULTILINE)]
    assert len(commands) >= 3
    for command in commands:
        words = shlex.split(command)
        with pytest.raises(SystemExit) as ended:
            main([*words[1:], *LESS[words[2]], "--json"])
        said = capsys.readouterr()
        assert ended.value.code == 0, f"{command}\n{said.err}"
        answer = json.loads(said.out)
        assert all(Path(name).stat().st_size > 0 for name in answer["files"])
