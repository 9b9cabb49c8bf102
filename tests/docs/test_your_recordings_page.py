"""docs/your-recordings.md: every command on it runs, on recordings as the page has them."""

from __future__ import annotations

import re
import shlex
import sys
from pathlib import Path

import numpy as np
import pytest

from snakebot.cli.main import main
from snakebot.runlog import read_session

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "your-recordings.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"^\$ (snakebot .*)$", PAGE, re.MULTILINE)


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.syspath_prepend(str(ROOT / "tests" / "runlog"))
    from foreign_samples import NAMES, lerobot_folder, wave
    from log_commands import wave_log
    from ros_samples import ARRAY, JOINT_STATE, array, bag, joint_state

    t_s, command, measured = wave(100)
    for name in ("monday", "tuesday"):
        rows = np.column_stack([t_s, command, measured])
        heads = ["t", *(f"goal{j}" for j in (1, 2, 3)), *(f"pos{j}" for j in (1, 2, 3))]
        lines = [";".join(heads), *(";".join(f"{v:.4f}".replace(".", ",") for v in row) for row in rows)]
        (tmp_path / f"{name}.csv").write_text("\n".join(lines))
    (tmp_path / "bus.csv").write_text("goal1,goal2,pos1,pos2\n2048,2048,2050,2040\n2050,2046,2051,2039\n")
    (tmp_path / "odd.csv").write_text("T,u1,u2,y1,y2\n0,1,2,3,4\n10,1,2,3,4\n")
    (tmp_path / "bench.yaml").write_text("joints: 2\n")
    lerobot_folder(tmp_path / "my_arm", "v3.0", [(command, measured), (command, measured)])
    states = [
        ("/joint_states", JOINT_STATE, t, joint_state(t, NAMES, m))
        for t, m in zip(t_s, measured, strict=True)
    ]
    commands = [
        ("/position_controller/commands", ARRAY, t, array(c)) for t, c in zip(t_s, command, strict=True)
    ]
    named = [
        ("/joint_commands", JOINT_STATE, t, joint_state(t, NAMES, c))
        for t, c in zip(t_s, command, strict=True)
    ]
    bag(tmp_path / "my_bag", [*states, *named])
    bag(tmp_path / "other_bag", [*states, *named, *commands])
    wave_log(tmp_path / "run", duration_s=1.0)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_every_command_on_the_page_runs(lab: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert len(COMMANDS) == 8
    assert "ros_samples" in sys.modules
    for command in COMMANDS:
        with pytest.raises(SystemExit) as ended:
            main(shlex.split(command)[1:])
        assert ended.value.code == 0, (command, capsys.readouterr().err)
    assert len(read_session(lab / "arm").runs) == 2
    assert (lab / "as_bag" / "metadata.yaml").is_file()


def test_every_option_on_the_page_is_one_of_the_command() -> None:
    from snakebot.cli.log import export
    from snakebot.cli.session_import import import_session

    known = {
        name for command in (import_session, export) for option in command.params for name in option.opts
    }
    assert set(re.findall(r"--[a-z][a-z0-9-]+", PAGE)) <= known
