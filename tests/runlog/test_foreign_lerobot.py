"""LeRobot datasets of both versions, written by pyarrow as LeRobot does, become sessions with the same numbers."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from foreign_samples import lerobot_folder, wave
from log_commands import Capture, snakebot

from snakebot.runlog import read_session


def _episodes(count: int = 2) -> list[tuple[np.ndarray, np.ndarray]]:
    made = []
    for number in range(count):
        _, command, measured = wave(90 + 10 * number, 30)
        made.append((command, measured))
    return made


@pytest.mark.parametrize("version", ["v2.1", "v3.0"])
def test_episodes_become_runs_with_the_same_angles(version: str, tmp_path: Path, capsys: Capture) -> None:
    episodes = _episodes()
    lerobot_folder(tmp_path / "arm", version, episodes)
    said = snakebot(capsys, "session", "import", tmp_path / "arm", "-o", tmp_path / "out", "--units", "deg")
    assert f"LeRobot {version}, 2 episodes at 30 Hz" in said
    session = read_session(tmp_path / "out")
    assert [run.name for run in session.runs] == ["episode_000000.csv", "episode_000001.csv"]
    for run, (command, measured) in zip(session.runs, episodes, strict=True):
        assert np.allclose(run.command_rad, np.radians(command), atol=1e-6)
        assert np.allclose(run.measured_rad, np.radians(measured), atol=1e-6)
        assert np.allclose(np.diff(run.t_s), 1 / 30, atol=1e-6)
        assert run.metadata["joints"] == ["pan.pos", "lift.pos", "elbow.pos"]


def test_a_range_makes_angles_of_per_cent(tmp_path: Path, capsys: Capture) -> None:
    lerobot_folder(
        tmp_path / "arm", "v3.0", [(np.array([[-100.0], [0.0], [100.0]]), np.array([[-50.0], [0.0], [50.0]]))]
    )
    arm, out = tmp_path / "arm", tmp_path / "out"
    command = ["session", "import", arm, "-o", out, "--units", "percent"]
    assert "--range LOW:HIGH" in snakebot(capsys, *command, status=2)
    assert not out.exists()
    snakebot(capsys, *command, "--range", "-110:90", "--json")
    run = read_session(out).runs[0]
    assert np.allclose(np.degrees(run.command_rad[:, 0]), [-110, -10, 90])
    assert np.allclose(np.degrees(run.measured_rad[:, 0]), [-60, -10, 40])


def test_joints_and_episodes_can_be_chosen(tmp_path: Path, capsys: Capture) -> None:
    episodes = _episodes(4)
    arm = lerobot_folder(tmp_path / "arm", "v2.1", episodes)
    choice = ["--joints", "elbow.pos,pan.pos", "--episodes", "1-2", "--direction", "-1,1"]
    snakebot(capsys, "session", "import", arm, "-o", tmp_path / "out", "--units", "deg", *choice)
    runs = read_session(tmp_path / "out").runs
    assert [run.name for run in runs] == ["episode_000001.csv", "episode_000002.csv"]
    assert np.allclose(runs[0].command_rad, np.radians(episodes[1][0][:, [2, 0]]) * [-1, 1], atol=1e-6)


def test_each_fault_is_one_line_and_nothing_is_written(tmp_path: Path, capsys: Capture) -> None:
    def told(name: str, *options: str) -> str:
        out = tmp_path / "out"
        line = snakebot(capsys, "session", "import", tmp_path / name, "-o", out, *options, status=2)
        assert not out.exists()
        return line

    arm = lerobot_folder(tmp_path / "arm", "v3.0", _episodes())
    assert "give --units" in told("arm")
    assert "has no joint hand; it has pan.pos" in told("arm", "--units", "deg", "--joints", "hand")
    assert "no episode 7" in told("arm", "--units", "deg", "--episodes", "7")
    assert "such as 0-9,12" in told("arm", "--units", "deg", "--episodes", "x")
    data = arm / "data" / "chunk-000" / "file-000.parquet"
    whole = data.read_bytes()
    data.write_bytes(whole[:200])
    assert "file-000.parquet: not a Parquet table" in told("arm", "--units", "deg")
    pq.write_table(pa.table({"action": [[1.0, 2.0, 3.0], [1.0]], "observation.state": [[1.0] * 3] * 2,
                             "episode_index": [0, 0], "timestamp": [0.0, 0.1]}), data)  # fmt: skip
    assert "column action: not 3 numbers in every row" in told("arm", "--units", "deg")
    data.unlink()
    data.symlink_to(tmp_path / "elsewhere.parquet")
    (tmp_path / "elsewhere.parquet").write_bytes(whole)
    assert "leads out of the dataset's folder" in told("arm", "--units", "deg")
    info = arm / "meta" / "info.json"
    said = json.loads(info.read_text())
    for change, line in (
        ({"codebase_version": "v9"}, "v3.0 are read here"),
        ({"fps": 0}, "fps: no rate"),
        ({"features": {}}, "features has no action"),
    ):
        info.write_text(json.dumps(said | change))
        assert line in told("arm", "--units", "deg")
    info.write_text("{")
    assert "info.json: not JSON" in told("arm", "--units", "deg")
