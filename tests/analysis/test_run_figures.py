"""A run of the simulated robot with a known fault gives the known figures."""

from __future__ import annotations

import dataclasses
import json
import math
import re
from typing import Any

import numpy as np
import pytest
from sample_runs import BENCH, PENN_STATE, bench_run, snake_run

from snakebot.analysis import analyze_run, paper_tables
from snakebot.analysis.as_json import analysis_json
from snakebot.analysis.as_text import analysis_text, table_text
from snakebot.analysis.faults import JointFaults, joint_faults
from snakebot.analysis.power import dissipated_power
from snakebot.analysis.report import analysis_page
from snakebot.analysis.report_many import runs_table
from snakebot.analysis.run_analysis import RunAnalysis
from snakebot.gait import Gait
from snakebot.physics import ChainModel, replay
from snakebot.robot import load_robot


@pytest.fixture(scope="module")
def limited() -> RunAnalysis:
    effects = ("rate_limit:limit_rad_s=1.6,joints=3", "encoder_offset:offset_deg=2,joints=5")
    return analyze_run(snake_run(effects=effects, lost=0.05), PENN_STATE)


def test_nominal_servo_shows_its_own_lag() -> None:
    """First-order lag tau = 0.03 s at omega = 2: gain 1/sqrt(1 + x^2), lag atan(x)/omega, TE = x/sqrt(2 (1 + x^2))."""
    found = analyze_run(snake_run(rate_hz=100), PENN_STATE)
    x = 2 * 0.03
    for joint in found.joints:
        assert joint.gain == pytest.approx(1 / math.hypot(1, x), abs=1e-3)
        # Commands are held between ticks, which adds half a tick of 10 ms.
        assert joint.lag_s == pytest.approx(math.atan(x) / 2 + 0.005, abs=1e-3)
        assert joint.tracking.te == pytest.approx(math.sin((math.atan(x) + 0.01) / 2) * math.sqrt(2), rel=0.1)
        assert joint.thd < 2e-3
    assert found.steady.settled
    assert found.omega_source == "gait"
    assert found.warnings == ()


def test_the_faulty_joint_stands_out(limited: RunAnalysis) -> None:
    te = [joint.tracking.te for joint in limited.joints]
    assert int(np.argmax(te)) == 2
    assert limited.joints[2].thd > 0.05
    assert limited.joints[2].sine_residual == pytest.approx(limited.joints[2].thd, rel=0.15)
    assert math.degrees(limited.joints[4].tracking.mean_rad) == pytest.approx(2, abs=0.05)
    assert limited.te == pytest.approx(math.sqrt(np.mean(np.square(te))))
    assert all(joint.lost == pytest.approx(0.05, abs=0.02) for joint in limited.joints)


def test_prediction_from_measured_angles_explains_the_speed(limited: RunAnalysis) -> None:
    p = limited.predictions
    assert p.angle_replay is not None
    assert p.ideal is not None
    assert limited.speed_source == "pose"
    assert abs(p.angle_replay.speed_m_s / limited.speed_m_s - 1) < 0.02
    assert abs(p.angle_replay.speed_m_s - limited.speed_m_s) < abs(p.ideal.speed_m_s - limited.speed_m_s)


def test_ideal_prediction_is_the_reference_value() -> None:
    """v(66, 80, 2) = 0.137 m/s and 0.68 W, good to 1 % and 2 %: two independent engines agree on these."""
    found = analyze_run(snake_run(), PENN_STATE)
    assert found.predictions.ideal is not None
    assert found.predictions.ideal.speed_m_s == pytest.approx(0.137, rel=0.01)
    assert found.predictions.ideal.power_in_w == pytest.approx(0.68, rel=0.02)
    assert found.power_dissipated_w == pytest.approx(found.power_in_w, rel=0.03)


@pytest.mark.parametrize(
    ("robot", "gait"),
    [
        ("penn_state", (66, 80, 2)),
        ("penn_state", (40, 80, 5)),
        ("saito", (22, 60, 2)),
        ("saito_wheeled", (27, 78, 2)),
    ],
)
def test_power_from_encoders_is_what_the_simulation_dissipates(
    robot: str, gait: tuple[float, float, float]
) -> None:
    body = load_robot(robot).body
    assert body is not None
    model = ChainModel.from_body(body)
    wave = Gait.from_degrees(*gait)
    t = np.linspace(0, 8 * wave.period_s, 1601)
    angle = wave.angles(t, 5) * np.clip(t / wave.period_s, 0, 1)[:, None]
    moved = replay(model, t, angle)
    late = t >= 4 * wave.period_s
    speed = moved.forward_speed_m_s(4 * wave.period_s)
    alone = float(np.mean(dissipated_power(model, t[late], angle[late], speed)))
    assert alone == pytest.approx(float(np.mean(moved.power_dissipated_w[late])), rel=0.05)


def test_given_speed_goes_before_the_pose() -> None:
    run = dataclasses.replace(snake_run(), forward_speed_m_s=0.111)
    found = analyze_run(run, PENN_STATE)
    assert (found.speed_m_s, found.speed_source) == (0.111, "given")
    assert found.pose_speed is not None
    assert found.predictions.ideal is not None
    assert found.pose_speed.forward_m_s > 0.12
    assert found.speed_error_percent == pytest.approx(100 * (0.111 / found.predictions.ideal.speed_m_s - 1))


def test_a_gait_that_is_not_what_was_commanded_is_told() -> None:
    run = dataclasses.replace(snake_run(), gait=Gait.from_degrees(66, 80, 3))
    assert any("omega" in warning for warning in analyze_run(run, PENN_STATE, predict=False).warnings)


def test_without_a_gait_the_frequency_is_estimated() -> None:
    run = dataclasses.replace(snake_run(omega=3), gait=None)
    found = analyze_run(run, PENN_STATE)
    assert found.omega_rad_s == pytest.approx(3, rel=1e-3)
    assert found.omega_source == "estimated from the command"
    ideal, known = found.predictions.ideal, analyze_run(snake_run(omega=3), PENN_STATE).predictions.ideal
    assert ideal is not None
    assert known is not None
    assert ideal.speed_m_s == pytest.approx(known.speed_m_s, rel=0.02)


def test_a_bench_without_body_or_gait() -> None:
    found = analyze_run(bench_run(), BENCH)
    assert found.omega_rad_s is None
    assert found.joints[0].lag_s == pytest.approx(0.1, abs=0.01)
    assert found.joints[0].gain == pytest.approx(1, abs=0.05)
    assert math.isnan(found.speed_m_s)
    assert found.predictions.ideal is None
    assert "chirp" in analysis_text([found], paper_tables([found]))


@pytest.mark.parametrize("samples", [1, 2, 5])
def test_hardly_any_data(samples: int) -> None:
    run = snake_run()
    short = dataclasses.replace(
        run,
        t_s=run.t_s[:samples],
        command_rad=run.command_rad[:samples],
        measured_rad=np.full_like(run.measured_rad[:samples], np.nan),
        applied_rad=None,
        pose=None,
        extra={},
    )
    found = analyze_run(short, PENN_STATE)
    assert math.isnan(found.te)
    json.dumps(analysis_json([found], paper_tables([found])), allow_nan=False)


def test_a_joint_whose_encoder_is_dead_leaves_the_others() -> None:
    run = snake_run()
    run.measured_rad[:, 1] = np.nan
    found = analyze_run(run, PENN_STATE)
    assert math.isnan(found.joints[1].tracking.te)
    assert found.joints[0].gain == pytest.approx(1, abs=0.01)
    assert found.predictions.sine_replay is None
    assert any("joint 2" in warning for warning in found.warnings)


def test_tables_have_the_papers_layout_and_no_invented_cell() -> None:
    runs = [
        snake_run(a, b, 2, name=f"{a}_{b}", cycles=4, pose=False) for a, b in ((63, 76), (66, 80), (63, 80))
    ]
    faulty = [
        snake_run(effects=(f"joint_{kind}:joints={j}",), name=f"{kind} {j}", cycles=4)
        for kind, j in (("rigid", "1+2"), ("free", "3"))
    ]
    analyses = [analyze_run(run, PENN_STATE) for run in (*runs, *faulty)]
    tables = paper_tables(analyses)
    assert [(r.alpha_deg, r.beta_deg) for r in tables.speeds] == [(63, 76), (63, 80), (66, 80)]
    assert all(math.isnan(r.measured_m_s) and math.isnan(r.error_percent) for r in tables.speeds)
    (near,) = tables.neighbours
    assert near.alphas_deg == (63, 66)
    assert near.betas_deg == (76, 80)
    assert near.cells[1][0] is None
    (faults,) = tables.faults
    assert [(r.fault, r.joints) for r in faults.rows] == [("none", ""), ("free", "3"), ("rigid", "1 + 2")]
    assert faults.rows[1].measured_m_s < 0.6 * faults.rows[2].measured_m_s
    assert faults.rows[2].predicted_power_w > 2
    text = analysis_text(analyses, tables)
    assert "Speed of gaits" in text
    assert "Speed predicted / measured, and error, at" in text
    assert "Speed with joints that failed" in text
    assert "Table I" not in text
    assert "(36)" not in text
    listed = table_text(runs_table(analyses))
    head = listed.splitlines()[0]
    assert head.index("ω") < head.index("effect") < head.index("steady cycles")  # seen first, however narrow
    assert "joint_rigid" in listed


def test_a_run_whose_joints_failed_for_a_while_is_none_of_the_set_points_drawn() -> None:
    well = [analyze_run(snake_run(omega=omega, name=f"w{omega}", cycles=4), PENN_STATE) for omega in (2, 3)]
    slow = snake_run(omega=2, name="failed", cycles=4, effects=("servo_lag:time_constant_s=0.2",))
    for_a_while = dataclasses.replace(analyze_run(slow, PENN_STATE), faults=JointFaults(changed=True))
    runs = [*well, for_a_while]
    titles = re.findall(r"<figcaption>(\w+): ω = ", analysis_page(runs, paper_tables(runs)).html())
    assert titles == ["w2", "w3"]


def test_repeats_of_a_gait_are_one_row() -> None:
    one = analyze_run(
        dataclasses.replace(snake_run(pose=False, cycles=4), forward_speed_m_s=0.12), PENN_STATE
    )
    two = dataclasses.replace(one, name="again", speed_m_s=0.14)
    (row,) = paper_tables([one, two]).speeds
    assert row.runs == 2
    assert row.measured_m_s == pytest.approx(0.13)


@pytest.mark.parametrize(
    ("metadata", "free", "rigid", "changed"),
    [
        ({"faults": ["free:3"]}, (3,), (), False),
        ({"faults": ["rigid:4+5"]}, (), (4, 5), False),
        ({"faults": ["rigid:2=30"]}, (), (2,), False),
        ({"faults": ["rigid:4@12s", "clear@20s"]}, (), (), True),
        ({"effects": ["joint_free:joints=3+4", "rate_limit:limit_rad_s=2"]}, (3, 4), (), False),
        ({"effects": "joint_rigid:angle_deg=10,joints=1"}, (), (1,), False),
        ({"faults": ["free:9"]}, (), (), False),
        ({"faults": 7, "effects": [None, {}, "joint_free:joints=x"]}, (), (), False),
        ({}, (), (), False),
    ],
)
def test_faults_are_read_from_what_the_log_says(
    metadata: dict[str, Any], free: tuple[int, ...], rigid: tuple[int, ...], changed: bool
) -> None:
    found = joint_faults(metadata, 5)
    if metadata.get("effects") == [None, {}, "joint_free:joints=x"]:
        return  # nothing but: no exception
    assert (found.free, found.rigid, found.changed) == (free, rigid, changed)


def test_stuck_angle_reaches_the_prediction() -> None:
    straight = analyze_run(snake_run(effects=("joint_rigid:angle_deg=0,joints=3",), pose=False), PENN_STATE)
    bent = analyze_run(snake_run(effects=("joint_rigid:angle_deg=40,joints=3",), pose=False), PENN_STATE)
    assert bent.faults.rigid_angle_rad[3] == pytest.approx(math.radians(40))
    assert bent.predictions.ideal is not None
    assert straight.predictions.ideal is not None
    assert bent.predictions.ideal.speed_m_s != pytest.approx(straight.predictions.ideal.speed_m_s, rel=0.02)


def test_json_has_no_nan_and_names_its_units(limited: RunAnalysis) -> None:
    text = json.dumps(analysis_json([limited], paper_tables([limited])), allow_nan=False)
    data = json.loads(text)
    assert data["schema"] == "snakebot.analysis/1"
    run = data["runs"][0]
    assert run["joints"][2]["joint"] == 3
    assert run["predictions"]["sine_replay"]["speed_m_s"] > 0
    assert run["link"]["latency_median_s"] == pytest.approx(0.0045, abs=2e-4)
    assert run["joints"][0]["harmonics"][0] == pytest.approx(1)


@pytest.mark.parametrize("how", ["interrupted", "cut short", "error: the board was lost\x1b[2J"])
def test_a_run_that_did_not_finish_is_listed_and_not_averaged(how: str) -> None:
    one = analyze_run(dataclasses.replace(snake_run(cycles=4), forward_speed_m_s=0.12), PENN_STATE)
    run = snake_run(cycles=4, name="broken off")
    run = dataclasses.replace(run, forward_speed_m_s=0.9, metadata={**run.metadata, "ended": how})
    two = analyze_run(run, PENN_STATE)
    tables = paper_tables([one, two])
    (row,) = tables.speeds
    assert (row.runs, row.measured_m_s) == (1, 0.12)
    text = analysis_text([one, two], tables)
    assert "ended" in text
    assert "broken off" in text
    assert f"did not finish ({how.split(chr(27))[0]}" in text
    assert "\x1b" not in text
    (listed,) = [
        entry for entry in analysis_json([one, two], tables)["runs"] if entry["name"] == "broken off"
    ]
    assert listed["ended"].startswith(how[:5])
    assert "ended" not in analysis_text([one, one], paper_tables([one, one]))


def test_other_effects_robots_and_bends_are_not_averaged() -> None:
    one = analyze_run(dataclasses.replace(snake_run(cycles=4), forward_speed_m_s=0.12), PENN_STATE)

    def under(**metadata: Any) -> RunAnalysis:
        return dataclasses.replace(one, run=dataclasses.replace(one.run, metadata=metadata), speed_m_s=0.2)

    gait = one.gait
    assert gait is not None
    bent_gait = dataclasses.replace(gait, offset_rad=math.radians(10))
    bent = dataclasses.replace(one, run=dataclasses.replace(one.run, gait=bent_gait))
    slow = under(effects=["rate_limit:limit_rad_s=1", "joint_rigid:joints=2"])
    runs = [one, bent, slow, under(), one]  # the samples are simulated ones, and say so
    rows = paper_tables(runs).speeds
    assert [row.runs for row in rows] == [1, 1, 2, 1]
    text = analysis_text(runs, paper_tables(runs))
    for told in ("offset deg", "10.0", "rate_limit:limit_rad_s=1", "(simulated)"):
        assert told in text
    assert "tracking error: rms" in text  # what TE is
    assert "Speed of gaits" in text
    assert "offset deg" not in analysis_text([one, one], paper_tables([one, one]))


def test_a_joint_stuck_at_another_angle_is_another_failure() -> None:
    straight, bent = (joint_faults({"faults": [text]}, 5) for text in ("rigid:2+4", "rigid:2=30"))
    assert straight.described == "2 + 4"
    assert bent.described == "2 at 30°"
