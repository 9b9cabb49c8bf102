"""How the tests of this folder run a command, and a run to run it on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from runlog_samples import ROBOT, START_NS

from snakebot.cli.main import main
from snakebot.gait import Gait
from snakebot.runlog import Run
from snakebot.runlog.importing import write_run

Capture = pytest.CaptureFixture[str]


def snakebot(capsys: Capture, *arguments: object, status: int = 0) -> str:
    """Run a command; its output, or, where it fails as expected, its one line."""
    with pytest.raises(SystemExit) as ended:
        main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    assert ended.value.code == status, err
    if status:
        assert err.count("\n") == 1, err
        assert err.startswith("snakebot: ")
        return err
    return out


def wave_log(path: Path, alpha_deg: float = 40.0, duration_s: float = 20.0) -> Path:
    """A run with ramps, without a pose."""
    gait = Gait.from_degrees(alpha_deg, 80, 2)
    t_s = np.arange(0, duration_s, 0.01)
    s = np.clip(np.minimum(t_s, duration_s - t_s) / 2, 0, 1)[:, None]
    ramp = s**3 * (10 - 15 * s + 6 * s**2)
    run = Run("w", t_s, gait.angles(t_s, 5) * ramp, gait.angles(t_s - 0.05, 5) * ramp, gait=gait)
    return write_run(path, ROBOT, run, {"robot": "penn_state"}, START_NS)
