"""``snakebot run`` end to end: the paper's speed, a log, and a safe end when host or board goes away."""

from __future__ import annotations

import contextlib
import io
import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import yaml

from snakebot.cli.main import main
from snakebot.robot import load_robot
from snakebot.runlog import read_log

StopOnly = Callable[..., "subprocess.CompletedProcess[str]"]

COMMAND = [sys.executable, "-m", "snakebot.cli.main"]
WAVE = ["run", "--alpha", "66", "--beta", "80", "--omega", "2"]
RUN = [*COMMAND, *WAVE]


def run(*arguments: str) -> dict[str, object]:
    """The command, in this process; what it says."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), pytest.raises(SystemExit) as ended:
        main([*WAVE, *arguments, "--json"])
    assert ended.value.code in (0, None), err.getvalue()
    result = json.loads(out.getvalue())
    assert isinstance(result, dict)
    return result


@pytest.fixture
def board(tmp_path: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A simulated board in a process of its own, on a pseudo-terminal."""
    process = subprocess.Popen(
        [*COMMAND, "board", "sim", "--serial", "--watchdog-ms", "250", "--json"],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    port = json.loads(process.stdout.readline())["port"]
    yield process, port
    process.kill()
    process.wait()


def started(arguments: list[str], log: Path) -> subprocess.Popen[str]:
    """A run in a process of its own that has been moving for a moment."""
    process = subprocess.Popen(
        [*RUN, *arguments, "--log", str(log)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    part = log.with_name(log.name + ".part")
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and process.poll() is None:
        if part.exists() and part.stat().st_size > 60_000:
            return process
        time.sleep(0.05)
    raise AssertionError(f"the run did not start: {process.communicate()}")


def test_ideal_tracking_at_the_optimum_reaches_the_papers_speed(tmp_path: Path) -> None:
    """0.137 m/s within 3 %: two independent engines agree on it for penn_state at (66, 80, 2)."""
    ideal = load_robot("penn_state").to_mapping() | {"servo": {"time_constant_s": 0.0}}
    description = tmp_path / "ideal.yaml"
    description.write_text(yaml.safe_dump(ideal))
    result = run("--robot", str(description), "--fast", "--log", str(tmp_path / "a.mcap"))
    assert result["forward_speed_m_s"] == pytest.approx(0.137, rel=0.03)
    assert result["lost"] == result["late"] == 0


@pytest.mark.slow
def test_the_log_holds_the_run_and_is_the_same_each_time(tmp_path: Path) -> None:
    """In this process and in one of its own."""
    words = ["--duration", "5", "--fast", "--seed", "3", "--frames", "--log"]
    run(*words, str(tmp_path / "a.mcap"))
    subprocess.run([*RUN, *words, str(tmp_path / "b.mcap")], capture_output=True, timeout=110, check=True)
    a, b = (read_log(tmp_path / f"{name}.mcap") for name in "ab")
    assert len(a.t_s) == 501
    np.testing.assert_array_equal(a.measured_rad, b.measured_rad)
    np.testing.assert_array_equal(a.pose, b.pose)
    assert a.metadata["gait"]["alpha_deg"] == 66
    assert a.metadata["simulated"] is True
    assert "snakebot.dbc" in a.attachments
    assert a.robot == load_robot("penn_state")
    assert [event.kind for event in a.events][-1] == "finished"
    assert len(a.frames) > 501 * 8


def test_killed_in_mid_run_the_log_reads_and_the_next_start_needs_no_clean_up(
    board: tuple[subprocess.Popen[str], str], tmp_path: Path
) -> None:
    _, port = board
    log = tmp_path / "killed.mcap"
    process = started(["--port", port, "--duration", "60"], log)
    process.send_signal(signal.SIGKILL)
    process.wait()
    left = read_log(log.with_name("killed.mcap.part"))
    assert len(left.t_s) > 0
    np.testing.assert_allclose(np.diff(left.sequence) % 65536, 1)
    again = run("--port", port, "--duration", "4.5", "--log", str(tmp_path / "again.mcap"))
    assert again["ended"] == "finished"
    assert read_log(tmp_path / "again.mcap").events[0].kind == "cleared"


def test_a_board_that_dies_is_one_line_status_4_and_the_log_is_whole(
    board: tuple[subprocess.Popen[str], str], tmp_path: Path
) -> None:
    process, port = board
    log = tmp_path / "lost.mcap"
    host = started(["--port", port, "--duration", "60"], log)
    process.kill()
    _, error = host.communicate(timeout=20)
    assert host.returncode == 4, error
    lines = error.splitlines()
    assert sum(line.startswith("snakebot: ") for line in lines) == 1
    assert "Traceback" not in error
    assert port.removeprefix("serial:") in error
    assert read_log(log).complete


def test_ctrl_c_ramps_down_and_leaves_with_130(tmp_path: Path) -> None:
    log = tmp_path / "interrupted.mcap"
    host = started(["--duration", "60", "--ramp", "1"], log)
    host.send_signal(signal.SIGINT)
    output, error = host.communicate(timeout=20)
    assert host.returncode == 130, error
    assert "interrupted" in output
    read = read_log(log)
    assert read.complete
    assert np.abs(np.diff(read.sent_rad[-4:], axis=0)).max() < 2e-3


def test_stop_from_a_second_terminal_cuts_the_power(tmp_path: Path, stop_only: StopOnly) -> None:
    host = started(["--duration", "60"], tmp_path / "stopped.mcap")
    stop = stop_only([host.pid])
    assert stop.returncode == 0, stop.stderr
    assert str(host.pid) in stop.stdout
    _, error = host.communicate(timeout=20)
    assert host.returncode == 5
    assert "emergency stop" in error
    assert read_log(tmp_path / "stopped.mcap").complete
