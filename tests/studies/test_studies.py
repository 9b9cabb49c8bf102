"""The studies on small input: fronts, sweeps that go on where they were, grids, faults, speeds, friction."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.gait import Gait
from snakebot.physics.model import STANDARD_GRAVITY_M_S2
from snakebot.robot import load_robot, robot_from_mapping
from snakebot.studies import sweep as sweeps
from snakebot.studies.friction import (
    Measurement,
    fit_friction,
    forces,
    read_table,
)
from snakebot.studies.hyperredundancy import fault_cases
from snakebot.studies.near_optimum import near_optimum
from snakebot.studies.pareto import front_of, paper_grid, pareto
from snakebot.studies.speed import speed_study
from snakebot.studies.sweep import SPEED

ROBOT = load_robot("penn_state")
OPTIMUM = Gait.from_degrees(66, 80, 2)
FEW = np.array([[a, b, w] for a in np.radians([30, 66]) for b in np.radians([60, 80]) for w in (1.0, 2.0)])


def test_the_papers_grid_has_9000_gaits() -> None:
    """Claim 5: alpha 3..90 step 3, beta 6..180 step 6, omega 0.5..5 step 0.5."""
    grid = paper_grid()
    assert grid.shape == (9000, 3)
    assert len({tuple(row) for row in grid.round(9)}) == 9000
    assert np.degrees(grid[:, 0]).max() == pytest.approx(90)
    assert np.degrees(grid[:, 1]).max() == pytest.approx(180)
    assert (grid[:, 2].min(), grid[:, 2].max()) == (0.5, 5.0)


points = st.lists(st.tuples(st.floats(-1, 5), st.floats(0, 5)), min_size=1, max_size=60)


@given(points)
def test_no_gait_beats_one_of_the_front_and_each_other_gait_is_beaten(
    pairs: list[tuple[float, float]],
) -> None:
    speed, power = np.array(pairs).T
    front = front_of(speed, power)
    assert np.all(np.diff(speed[front]) > 0)
    assert np.all(np.diff(power[front]) > 0)
    for v, p in pairs:
        beaten = [
            speed[i] >= v
            and power[i] <= p
            and (speed[i] > v or power[i] < p or (speed[i], power[i]) == (v, p))
            for i in front
        ]
        assert v <= 0 or any(beaten)


def test_gaits_that_are_not_numbers_are_on_no_front() -> None:
    assert front_of([math.nan, 1.0, 2.0], [1.0, math.nan, 1.0]).tolist() == [2]


def test_a_sweep_goes_on_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweeps, "CHUNK", 3)
    conditions = sweeps.Conditions.of(ROBOT, cycles=2, averaged_cycles=1)
    whole = sweeps.sweep(conditions, FEW)
    computed: list[int] = []
    real = sweeps.compute

    def interrupted(given: sweeps.Conditions, gaits: Floats) -> Floats:
        if len(computed) == 2:
            raise KeyboardInterrupt
        computed.append(len(gaits))
        return real(given, gaits)

    monkeypatch.setattr(sweeps, "compute", interrupted)
    with pytest.raises(KeyboardInterrupt):
        sweeps.sweep(conditions, FEW, tmp_path)

    def counted(given: sweeps.Conditions, gaits: Floats) -> Floats:
        computed.append(len(gaits))
        return real(given, gaits)

    monkeypatch.setattr(sweeps, "compute", counted)
    seen: list[tuple[int, int]] = []
    resumed = sweeps.sweep(conditions, FEW, tmp_path, progress=lambda done, total: seen.append((done, total)))
    assert computed == [3, 3, 2]
    assert seen == [(6, 8), (8, 8)]
    np.testing.assert_array_equal(resumed, whole)


def test_another_sweep_is_refused_in_the_same_folder_and_a_damaged_chunk_is_made_again(
    tmp_path: Path,
) -> None:
    conditions = sweeps.Conditions.of(ROBOT, cycles=2, averaged_cycles=1)
    first = sweeps.sweep(conditions, FEW, tmp_path)
    with pytest.raises(BadInputError, match="another sweep"):
        sweeps.sweep(conditions, FEW * 0.5, tmp_path)
    chunk = next((tmp_path / "chunks").glob("*.parquet"))
    chunk.write_bytes(b"not parquet")
    np.testing.assert_array_equal(sweeps.sweep(conditions, FEW, tmp_path), first)


@pytest.mark.slow
def test_a_cluster_that_loses_a_worker_in_mid_sweep_gives_the_same_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from distributed import LocalCluster

    monkeypatch.setattr(sweeps, "CHUNK", 4)
    gaits = np.array(
        [[a, b, 2.0] for a in np.radians(range(20, 80, 5)) for b in np.radians(range(40, 120, 5))]
    )
    conditions = sweeps.Conditions.of(ROBOT)
    here = sweeps.sweep(conditions, gaits)
    killed: list[int] = []
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:

        def kill_one(done: int, total: int) -> None:
            if done and not killed:
                worker = next(iter(cluster.workers.values()))
                killed.append(worker.process.pid)
                worker.process.process.kill()

        there = sweeps.sweep(conditions, gaits, tmp_path, progress=kill_one, dask=cluster.scheduler_address)
    assert killed
    np.testing.assert_array_equal(there, here)


def test_a_scheduler_that_is_not_there_is_one_clear_line() -> None:
    with pytest.raises(BadInputError, match="no scheduler"):
        sweeps.sweep(sweeps.Conditions.of(ROBOT), FEW, dask="tcp://127.0.0.1:1")


def test_refinement_adds_gaits_near_the_front_and_never_makes_it_worse(tmp_path: Path) -> None:
    coarse = pareto(ROBOT, gaits=FEW)
    fine = pareto(ROBOT, tmp_path, gaits=FEW, refinements=1)
    assert len(fine.rows) > len(coarse.rows)
    for row in coarse.rows[coarse.front]:
        assert any(
            better[SPEED] >= row[SPEED] and better[6] <= row[6] + 1e-12 for better in fine.rows[fine.front]
        )
    assert (tmp_path / "pareto.parquet").exists()


def test_a_bench_has_no_pareto_front() -> None:
    bench = robot_from_mapping({"joints": 2}, "bench")
    with pytest.raises(BadInputError, match="no body"):
        pareto(bench)


def test_the_grid_around_the_optimum_holds_the_optimum() -> None:
    grid = near_optimum(ROBOT, OPTIMUM, 6, 10, reach=1)
    assert grid.speed_m_s.shape == (3, 3)
    assert grid.speed_m_s[1, 1] == pytest.approx(
        0.137, rel=0.01
    )  # the reference value of penn_state at (66, 80, 2)
    assert grid.power_w[1, 1] == pytest.approx(0.68, rel=0.02)


def test_faults_do_what_the_paper_says_of_them() -> None:
    """Claim 7 at (66, 80, 2), as far as single faults go."""
    cases = {case.label: case for case in fault_cases(ROBOT, OPTIMUM, most=1)}
    assert len(cases) == 11
    for joint in range(1, 6):
        assert cases[f"free {joint}"].speed_ratio < 1
    for joint in (1, 5):
        assert cases[f"rigid {joint}"].speed_ratio > 1
        assert cases[f"rigid {joint}"].power_ratio > 2
    for joint in (2, 3):
        assert cases[f"rigid {joint}"].speed_ratio < 0.8


def test_a_lag_alone_does_not_slow_the_robot_and_a_rate_limit_spoils_the_tracking() -> None:
    """Claim 6: what a first-order lag does to the angles, the ground hardly notices."""
    gaits = [Gait.from_degrees(66, 80, 4)]
    (lag,) = speed_study(ROBOT, gaits)
    (limited,) = speed_study(ROBOT, gaits, ["rate_limit:limit_rad_s=2.5"])
    assert lag.speed_m_s == pytest.approx(lag.ideal_speed_m_s, rel=0.02)
    assert lag.sine_replay_speed_m_s == pytest.approx(lag.speed_m_s, rel=0.01)
    # omega tau / sqrt(1 + (omega tau)^2) / sqrt(2), with half a tick of hold on top of the lag
    assert lag.tracking_error[0] == pytest.approx(0.099, rel=0.03)
    assert min(limited.tracking_error) > 0.4
    assert limited.speed_m_s < lag.speed_m_s


def bench_table(noise: float = 0.0, angles: tuple[float, ...] = (0, 7.5, 15)) -> list[Measurement]:
    """Equilibria of a link with the paper's coefficients (31), (34) on inclines that (32) gives."""
    rng = np.random.default_rng(5)
    table = []
    for degrees in angles:
        for speed in (0.05, 0.1, 0.2, 0.3, 0.4, 0.6):
            turned = math.radians(degrees)
            cos, sin = math.cos(turned), math.sin(turned)
            force = (0.83 * speed * cos + 0.49) * cos + ((51.9 * speed * sin + 2.33) * sin if degrees else 0)
            incline = math.asin(force / (1.43 * STANDARD_GRAVITY_M_S2)) * (1 + noise * rng.standard_normal())
            table.append(Measurement(incline, speed, turned))
    return table


def test_friction_coefficients_come_back_from_an_exact_table() -> None:
    fit = fit_friction(bench_table(), 1.43)
    assert fit.estimate == pytest.approx({"ct": 0.83, "ct0": 0.49, "cn": 51.9, "cn0": 2.33})
    tangential, normal = forces(bench_table(), fit)
    assert [v for v, _ in tangential] == pytest.approx([0.05, 0.1, 0.2, 0.3, 0.4, 0.6])
    assert all(force == pytest.approx(0.83 * v + 0.49) for v, force in tangential)
    assert all(force == pytest.approx(51.9 * v + 2.33) for v, force in normal)


def test_the_confidence_intervals_cover_the_truth_nineteen_times_in_twenty() -> None:
    truth = {"ct": 0.83, "ct0": 0.49, "cn": 51.9, "cn0": 2.33}
    rng = np.random.default_rng(11)
    exact = bench_table()
    hits = tries = 0
    for _ in range(200):
        force = [
            1.43 * STANDARD_GRAVITY_M_S2 * math.sin(row.incline_rad) + 0.02 * rng.standard_normal()
            for row in exact
        ]
        noisy = [
            Measurement(math.asin(f / (1.43 * STANDARD_GRAVITY_M_S2)), row.belt_speed_m_s, row.link_angle_rad)
            for f, row in zip(force, exact, strict=True)
        ]
        fit = fit_friction(noisy, 1.43)
        hits += sum(fit.ci95[name][0] <= value <= fit.ci95[name][1] for name, value in truth.items())
        tries += len(truth)
    assert 0.92 <= hits / tries <= 0.975


def test_straight_rows_alone_give_the_tangential_coefficients_only() -> None:
    fit = fit_friction(bench_table(angles=(0,)), 1.43)
    assert fit.estimate["ct"] == pytest.approx(0.83)
    assert math.isnan(fit.estimate["cn"])
    assert fit.summary()["coefficients"]["cn"]["estimate"] is None


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("incline_deg,belt_speed_m_s\n2,0.1\n", ("link_angle_deg", "missing")),
        ("incline_deg,belt_speed_m_s,link_angle_deg\n2,fast,0\n", ("row 2", "belt_speed_m_s", "fast")),
        ("incline_deg,belt_speed_m_s,link_angle_deg\n2,0.1,0\n-2,0.1,0\n", ("row 3", "incline_deg")),
        ("incline_deg,belt_speed_m_s,link_angle_deg\n2,0.1\n", ("row 2", "link_angle_deg")),
    ],
)
def test_a_table_that_is_wrong_is_named_by_row_and_column(
    tmp_path: Path, text: str, words: tuple[str, ...]
) -> None:
    path = tmp_path / "bench.csv"
    path.write_text(text)
    with pytest.raises(BadInputError) as caught:
        fit_friction(read_table(path), 1.43)
    for word in ("bench.csv", *words):
        assert word in str(caught.value)


def test_rows_that_are_all_alike_are_refused() -> None:
    with pytest.raises(BadInputError, match="too much alike"):
        fit_friction([Measurement(0.04, 0.1, 0.0)] * 6, 1.43)
    with pytest.raises(BadInputError, match="rows"):
        fit_friction(bench_table()[:2], 1.43)


def test_the_commands_print_json_and_write_parquet_and_figures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from snakebot.cli.main import main

    monkeypatch.chdir(tmp_path)
    (tmp_path / "bench.csv").write_text(
        "incline_deg,belt_speed_m_s,link_angle_deg\n"
        + "".join(
            f"{math.degrees(row.incline_rad)},{row.belt_speed_m_s},{math.degrees(row.link_angle_rad)}\n"
            for row in bench_table()
        )
    )
    for arguments, name in (
        (["grid", "--reach", "1"], "grid"),
        (["faults", "--most", "1"], "faults"),
        (["speed", "--omega", "2"], "speed"),
        (["friction", "bench.csv"], "friction"),
    ):
        with pytest.raises(SystemExit) as ended:
            main(["study", *arguments, "--json"])
        assert ended.value.code == 0
        result = json.loads(capsys.readouterr().out)
        kinds = {Path(path).suffix for path in result["files"]}
        assert kinds == {".parquet", ".png", ".svg"}
        assert all(Path(path).stat().st_size > 500 and name in path for path in result["files"])


def test_dissipation_of_a_logged_run_agrees_with_the_simulation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """At steady state power in equals power lost; 0.68 W is the reference value of penn_state at (66, 80, 2)."""
    from snakebot.cli.main import main

    monkeypatch.chdir(tmp_path)
    run = [
        "run",
        "--alpha",
        "66",
        "--beta",
        "80",
        "--omega",
        "2",
        "--cycles",
        "5",
        "--fast",
        "--log",
        "run.mcap",
    ]
    for arguments in (run, ["study", "dissipation", "run.mcap", "--json"]):
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            main(arguments)
        assert ended.value.code == 0
    result = json.loads(capsys.readouterr().out)
    assert result["power_dissipated_w"] == pytest.approx(0.68, rel=0.05)
    assert result["speed_m_s"] == pytest.approx(0.137, rel=0.02)
    with pytest.raises(SystemExit) as ended:
        main(["study", "dissipation", "run.mcap", "--speed", "nan"])
    assert ended.value.code == 2


def test_the_picture_of_a_front_shows_each_of_its_gaits() -> None:
    from snakebot.studies.figures import pareto_figure

    swept = pareto(ROBOT, gaits=np.radians([[30.0, 60.0, 115.0], [10.0, 180.0, 115.0]]))
    result = replace(swept, front=np.arange(len(swept.rows)))  # whichever gait is cheapest
    angles = pareto_figure(result).axes[1]
    shown = np.concatenate([np.asarray(line.get_ydata(), float) for line in angles.lines])
    assert shown.max() == pytest.approx(180.0)
    assert angles.get_ylim()[0] == 0.0
    assert angles.get_ylim()[1] > 180.0


def test_a_grid_has_a_readable_number_in_every_cell_and_says_its_units() -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.colors import to_rgb

    from snakebot.studies.figures import grid_figure
    from snakebot.studies.near_optimum import Grid

    alphas, betas = np.arange(30.0, 72.0, 2.0), np.arange(40.0, 145.0, 5.0)
    values = np.add.outer(alphas, betas) / 500
    figure = grid_figure(Grid(load_robot("penn_state"), 2.0, alphas, betas, values, 10 * values))
    speed, _, bar, _ = figure.axes
    assert len(speed.texts) == alphas.size * betas.size
    assert speed.get_yticks().tolist() == alphas.tolist()
    assert bar.get_ylabel() == "speed, m/s"
    assert "penn_state" in speed.get_title()
    FigureCanvasAgg(figure).draw()  # type: ignore[no-untyped-call]
    places = sorted(text.get_window_extent().x0 for text in speed.texts[: betas.size])
    widths = [text.get_window_extent().width for text in speed.texts[: betas.size]]
    assert min(np.diff(places)) > max(widths), "numbers touch"
    darkest, brightest = speed.texts[0], speed.texts[-1]
    assert sum(to_rgb(darkest.get_color())) > 2
    assert sum(to_rgb(brightest.get_color())) < 1
