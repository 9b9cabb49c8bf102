"""docs/logs.md: every command and every piece of code in it runs, and what it says of the format is so."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from runlog_samples import ROBOT, START_NS, make_ticks, write_everything, write_ticks

from snakebot.cli.main import main
from snakebot.gait import Gait
from snakebot.runlog import Run, read_session
from snakebot.runlog.channels import CHANNELS
from snakebot.runlog.importing import write_run

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "logs.md").read_text()


def _blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder as the page takes it: some runs, a torn one, a damaged one, tables of other programs."""
    t_s = np.arange(0, 20, 0.01)
    s = np.clip(np.minimum(t_s, 20 - t_s) / 2, 0, 1)[:, None]
    ramp = s**3 * (10 - 15 * s + 6 * s**2)
    for name, alpha in (("first", 40), ("second", 30)):
        gait = Gait.from_degrees(alpha, 80, 2)
        run = Run(name, t_s, gait.angles(t_s, 5) * ramp, gait.angles(t_s - 0.05, 5) * ramp, gait=gait)
        write_run(tmp_path / "runs" / name, ROBOT, run, {}, START_NS)
    whole = write_ticks(tmp_path / "runs" / "damaged", make_ticks(3000))
    data = bytearray(whole.read_bytes())
    data[len(data) // 2] ^= 1
    whole.write_bytes(data)
    cut = write_everything(tmp_path / "runs" / "cut")
    cut.rename(tmp_path / "runs" / "cut.mcap.part")
    (tmp_path / "lab.csv").write_text("Time,goal0,goal1,pos0,pos1\n0,1,2,3,4\n10,1,2,3,4\n")
    (tmp_path / "bench.yaml").write_text("joints: 2\n")
    track = "".join(
        f"{t + 1.5:.3f},{1000 * x:.3f},0\n" for t, x in zip(t_s, np.cumsum(ramp[:, 0]) * 0.002, strict=True)
    )
    (tmp_path / "camera.csv").write_text("t,X,Y\n" + track)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_every_command_and_all_code_on_the_page_runs(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    commands = [line[2:] for block in _blocks("console") for line in block.splitlines()]
    assert len(commands) >= 10
    for command in commands:
        words = shlex.split(command)
        assert words[0] == "snakebot"
        with pytest.raises(SystemExit) as ended:
            main(words[1:])
        assert ended.value.code == 0, (command, capsys.readouterr().err)
    for code in _blocks("python"):
        exec(compile(code, "docs/logs.md", "exec"), {})
    assert read_session(folder / "my_session")["second.csv"].hold_out


def test_the_session_on_the_page_reads(tmp_path: Path) -> None:
    (tmp_path / "session.yaml").write_text(_blocks("yaml")[0])
    names = ["t_s", *(f"{kind}_{joint}_rad" for kind in ("cmd", "enc") for joint in range(1, 6))]
    for name in ("run_01.csv", "run_03.csv"):
        (tmp_path / name).write_text(",".join(names) + "\n" + ",".join("0" * len(names)) + "\n")
    assert [run.name for run in read_session(tmp_path).runs] == ["run_01.csv", "run_03.csv"]


def test_the_page_names_every_channel_and_field() -> None:
    rows = dict(re.findall(r"^\| `(/\w+)` \|(.*)\|$", PAGE, re.MULTILINE))
    assert set(rows) == {channel.topic for channel in CHANNELS}
    for channel in CHANNELS:
        for field in channel.properties:
            if not channel.schema_name.startswith("foxglove") and field not in (
                "current_1_a",
                "temperature_1_c",
            ):
                assert f"`{field}`" in rows[channel.topic], (channel.topic, field)
