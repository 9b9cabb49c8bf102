"""x and y without a heading: path and speed count, heading does not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sessions import GAITS, make_session, snake

from snakebot.analysis.bodies import recorded_path
from snakebot.analysis.run_analysis import analyze_run
from snakebot.diagnosis import diagnose
from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.ground import Feature, measured_ground, predicted
from snakebot.physics import ChainModel
from snakebot.runlog import Session, read_session, write_session

ALREADY_TURNED_RAD = 1.1  # of the camera's axes against the robot's start


def _without_headings(session: Session) -> Session:
    """Seen by a camera whose axes nobody aligned, and that sees no heading."""
    runs = []
    for run in session.runs:
        assert run.pose is not None
        c, s = np.cos(ALREADY_TURNED_RAD), np.sin(ALREADY_TURNED_RAD)
        x, y = run.pose[:, 0], run.pose[:, 1]
        seen = np.column_stack([c * x - s * y, s * x + c * y, np.full(len(run), np.nan)])
        runs.append(replace(run, pose=seen))
    return replace(session, runs=tuple(runs))


def test_a_table_may_have_x_and_y_alone(tmp_path: Path) -> None:
    session = _without_headings(make_session(snake(), gaits=GAITS[:1], pose=True))
    write_session(tmp_path / "lab", session.robot, session.runs)
    for table in (tmp_path / "lab").glob("*.csv"):
        lines = [line.split(",") for line in table.read_text().splitlines()]
        at = lines[0].index("heading_rad")
        table.write_text("".join(",".join(row[:at] + row[at + 1 :]) + "\n" for row in lines))
    read = read_session(tmp_path / "lab").runs[0]
    seen = session.runs[0].pose
    assert read.pose is not None
    assert seen is not None
    assert np.array_equal(read.pose, seen, equal_nan=True)


def test_only_the_speed_along_the_way_is_compared_and_a_true_model_predicts_it() -> None:
    session = make_session(snake(), gaits=GAITS[:2], pose=True, noise_deg=0.0)
    data = prepare(_without_headings(session))
    ground = measured_ground(data, set())
    assert ground is not None
    assert set(ground.kind) == {Feature.FORWARD}
    assert ground.count >= 3
    assert data.robot.body is not None
    made = predicted(
        ground, data, [run.measured_rad for run in data.runs], ChainModel.from_body(data.robot.body)
    )
    assert np.abs(made - ground.value).max() < 0.004
    assert ground.value.max() > 0.05


def test_the_analysis_draws_the_way_and_tells_its_speed() -> None:
    session = make_session(snake(), gaits=GAITS[:1], pose=True)
    seen = _without_headings(session).runs[0]
    found, told = (analyze_run(run, session.robot, predict=False) for run in (seen, session.runs[0]))
    assert found.speed_source == "pose"
    assert found.speed_m_s == pytest.approx(told.speed_m_s, abs=0.02)
    path = recorded_path(seen)
    assert path is not None
    assert np.isfinite(path.heading_rad).all()


@pytest.mark.slow
def test_a_gap_over_ground_is_found_without_headings() -> None:
    session = _without_headings(
        make_session(snake(), ["ground_friction:ct_scale=3"], gaits=GAITS[:2], pose=True)
    )
    found = diagnose(session, quick=True, only=["ground_friction", "payload"])
    assert found.causes[0].effect == "ground_friction"
    speed = found.closure.forward_speed
    assert speed is not None
    assert speed.error_after < speed.error_before / 2
