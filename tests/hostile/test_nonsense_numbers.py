"""Runs whose form is right and whose numbers are nonsense: no command ends with a fault of its own, or fills memory."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from snakebot.cli.main import main
from snakebot.errors import BadInputError
from snakebot.robot import Robot
from snakebot.runlog import RunWriter, Tick, open_session

COLUMNS = (
    "t_s",
    "cmd_1_rad",
    "enc_1_rad",
    "supply_v",
    "current_1_a",
    "latency_s",
    "board_time_us",
    "sequence",
    "late",
)
WAVE = np.sin(np.arange(400) / 50)
TIMES = np.arange(400) / 100


def session(folder: Path, columns: dict[str, np.ndarray], robot: dict[str, object] | None = None) -> Path:
    folder.mkdir(exist_ok=True)
    rows = np.column_stack(list(columns.values()))
    text = "\n".join(",".join("" if value != value else repr(float(value)) for value in row) for row in rows)
    (folder / "run.csv").write_text(",".join(columns) + "\n" + text + "\n")
    described = {"robot": robot or {"joints": 1}, "runs": [{"file": "run.csv"}]}
    (folder / "session.yaml").write_text(json.dumps(described))
    return folder


@pytest.mark.parametrize(
    ("t_s", "factor", "said"),
    [
        (np.append(TIMES[:-1], 1e9), 1, "goes over 1e\\+09 s"),
        (np.append(TIMES[:200], TIMES[200:] + 1e7), 1, "cut the run at its gaps"),
        (TIMES * 1e-300, 1, "1e-302 s apart"),
        (TIMES, 1e308, "no robot gets there"),
    ],
)
def test_numbers_that_would_fill_memory_are_refused(
    tmp_path: Path, t_s: np.ndarray, factor: float, said: str
) -> None:
    folder = session(tmp_path / "s", {"t_s": t_s, "cmd_1_rad": WAVE * factor, "enc_1_rad": WAVE * factor})
    with pytest.raises(BadInputError, match=said):
        open_session(folder)
    with RunWriter(tmp_path / "log", Robot(joints=1), start_time_ns=0) as writer:
        for count, (now, angle) in enumerate(zip(t_s, WAVE[:, None] * factor, strict=True)):
            writer.tick(Tick(count, float(now), count, angle, angle, angle, angle, count, 0.001, False))
    with pytest.raises(BadInputError, match=said):
        open_session(writer.path)


def test_a_run_with_a_pause_is_none_of_them(tmp_path: Path) -> None:
    t_s = np.append(TIMES[:200], TIMES[200:] + 3600)
    (run,) = open_session(session(tmp_path / "s", {"t_s": t_s, "cmd_1_rad": WAVE, "enc_1_rad": WAVE})).runs
    assert len(run) == 400


NUMBERS = st.sampled_from([0.0, -0.0, 1.0, np.nan, 1e-320, 1e-9, 1e6, -1e6, 3.15, 1e15, 1e300, -1e300])
ANGLES = st.sampled_from([0.0, 1.0, -1.0, np.nan, 1e-320, 1e6, -1e6, 0.3])


@st.composite
def nonsense(draw: st.DrawFn) -> dict[str, np.ndarray]:
    """A run of up to 40 samples; smooth, constant or jumping between extremes."""
    count = draw(st.integers(1, 40))
    steps = draw(
        st.lists(st.sampled_from([1e-6, 0.01, 0.01, 0.01, 1.0, 1e4]), min_size=count, max_size=count)
    )
    columns = {"t_s": np.cumsum(steps)}
    for name in COLUMNS[1 : draw(st.integers(3, len(COLUMNS)))]:
        values = ANGLES if name.endswith("rad") else NUMBERS
        columns[name] = (
            np.sin(columns["t_s"])
            if draw(st.booleans())
            else np.array(draw(st.lists(values, min_size=count, max_size=count)))
        )
    return columns


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize("command", ["analyze", "compare", "diagnose"])
def test_every_command_ends_with_a_result_or_one_line(
    command: str, tmp_path_factory: pytest.TempPathFactory, capsys: pytest.CaptureFixture[str]
) -> None:
    place = tmp_path_factory.mktemp("nonsense")
    options = (
        ["--quick", "--only", "servo_lag"]
        if command == "diagnose"
        else ["--report", str(place / "page.html")]
    )

    @settings(max_examples=60, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @given(nonsense())
    def run(columns: dict[str, np.ndarray]) -> None:
        with pytest.raises(SystemExit) as ended:
            main([command, str(session(place / "s", columns)), *options])
        told = capsys.readouterr()
        assert (ended.value.code or 0) in (0, 2), told.err
        assert "internal error" not in told.err

    run()
