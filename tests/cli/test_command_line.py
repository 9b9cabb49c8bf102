"""The command line as a whole: help with examples everywhere, nothing heavy imported, bad input in one line."""

from __future__ import annotations

import importlib
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from snakebot.cli.main import COMMANDS, cli

RUN = ["run", "--alpha", "66", "--beta", "80", "--omega", "2"]


def walk(command: click.Command, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], click.Command]]:
    yield path, command
    if isinstance(command, click.Group):
        with click.Context(command) as context:
            for name in command.list_commands(context):
                inner = command.get_command(context, name)
                assert inner is not None
                yield from walk(inner, (*path, name))


def snakebot(*arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "snakebot.cli.main", *arguments],
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        cwd=cwd,
        timeout=100,
        check=False,
    )


def test_every_command_in_the_table_exists_and_every_help_has_examples() -> None:
    for name, (module, _) in COMMANDS.items():
        assert isinstance(importlib.import_module(module).command, click.Command), name
    for path, command in walk(cli, ("snakebot",)):
        name = " ".join(path)
        assert "Example" in (command.epilog or ""), f"{name}: help without examples"
        assert command.help or path == ("snakebot",), f"{name}: help says nothing"


def test_help_imports_nothing_that_takes_long() -> None:
    code = (
        "import sys; from snakebot.cli.main import main\n"
        "try: main(['--help'])\n"
        "except SystemExit as end: assert not end.code\n"
        "heavy = {'numpy', 'scipy', 'numba', 'can', 'cantools', 'serial', 'pandas', 'matplotlib', 'rich', 'pydantic',"
        " 'pyarrow', 'mcap', 'yaml'}\n"
        "print('HEAVY', sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stdout.splitlines()[-1] == "HEAVY []"
    assert "Examples:" in done.stdout


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_scripts_are_printed(shell: str) -> None:
    done = snakebot("completion", shell)
    assert done.returncode == 0
    assert "_SNAKEBOT_COMPLETE" in done.stdout


BAD = [
    (["run"], "--alpha"),
    ([*RUN, "--alpha", "nan"], "alpha"),
    ([*RUN, "--alpha", "ninety"], "--alpha"),
    ([*RUN, "--alpha", "120"], "joint"),
    ([*RUN, "--omega", "9"], "speed"),
    ([*RUN, "--omega", "0"], "--duration"),
    ([*RUN, "--seed", "-1"], "--seed"),
    ([*RUN, "--duration", "1e12", "--dry-run"], "duration is 1e+12 s"),
    ([*RUN, "--ramp", "1e9", "--duration", "1e10"], "zero to"),
    (["diagnose", "x.mcap", "--effect", "backlash:gap_rad=0.1"], "--effect: only with --live"),
    (["diagnose", "x.mcap", "--fast"], "--fast: only with --live"),
    (["diagnose", "x.mcap", "--known", "a.b=1", "--known", "a.b=2"], "given twice"),
    ([*RUN, "--cycles", "0"], "--cycles"),
    ([*RUN, "--cycles", "2", "--duration", "9"], "not both"),
    ([*RUN, "--duration", "1"], "ramp"),
    ([*RUN, "--ramp", "-1"], "ramp"),
    ([*RUN, "--rate", "3"], "--rate"),
    ([*RUN, "--rate", "nan"], "--rate"),
    ([*RUN, "--robot", "nobody"], "penn_state"),
    ([*RUN, "--gait", "nowhere"], "nowhere"),
    ([*RUN, "--fault", "free:9"], "joints 1 to 5"),
    ([*RUN, "--fault", "broken"], "--fault"),
    ([*RUN, "--effect", "gremlins"], "gremlins"),
    ([*RUN, "--effect", "rate_limit:limit_rad_s=-3"], "limit_rad_s"),
    ([*RUN, "--port", "carrier-pigeon:7"], "carrier-pigeon"),
    ([*RUN, "--port", "serial:/dev/ttyUSB0?baud=fast"], "baud"),
    ([*RUN, "--port", "can:nothing/can0"], "nothing"),
    ([*RUN, "--fast", "--port", "serial:/dev/ttyUSB0"], "--fast"),
    ([*RUN, "--effect", "servo_lag:time_constant_s=0.1", "--port", "serial:/dev/ttyUSB0"], "--effect"),
    ([*RUN, "--speed", "inf"], "--speed"),
    ([*RUN, "--speed=-1e9"], "--speed -1e+09"),
    ([*RUN, "--gait", "."], "a folder"),
    (["log", "merge-speed", __file__, "--speed", "1e9"], "--speed 1e+09"),
    (["log", "list", __file__], "a file, no folder"),
    (["log", "info", "."], "a folder"),
    (["jog", "sim:", "--joint", "9"], "joints 1 to 5"),
    (
        ["board", "sim", "--feetech", "--robot", "sts3215_snake", "--damage", "flip=7"],
        "--damage 'flip=7'",
    ),
    (["optimize", "penn_state"], "Choose from: speed, power-at-speed"),
    (
        ["optimize", "penn_state", "--for", "speed", "--live", "carrier-pigeon:7", "--logs", "new"],
        "carrier-pigeon",
    ),
    (["rnu"], "rnu"),
    (["stop"], "no run"),
]


@pytest.mark.parametrize(("arguments", "word"), BAD, ids=[" ".join(a) for a, _ in BAD])
def test_bad_input_is_one_clear_line_status_2_and_nothing_moved(
    arguments: list[str],
    word: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    from snakebot.cli.main import main

    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    error = capfd.readouterr().err
    assert ended.value.code == 2, error
    lines = [line for line in error.splitlines() if not line.startswith("Try: ")]
    assert len(lines) == 1, error
    assert word in lines[0]
    assert "Traceback" not in error
    assert not (tmp_path / "runs").exists()


def test_a_port_that_is_not_there_is_status_3_and_leaves_no_log(tmp_path: Path) -> None:
    done = snakebot(*RUN, "--port", "serial:/dev/tty-not-there", cwd=tmp_path)
    assert done.returncode == 3
    assert "/dev/tty-not-there" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_a_limit_that_the_wire_cannot_carry_is_status_2_before_a_port_is_opened(tmp_path: Path) -> None:
    (tmp_path / "wild.yaml").write_text("joints: 5\nlimits: {acceleration_rad_s2: 300}\n")
    done = snakebot(*RUN, "--robot", "wild.yaml", "--port", "serial:/dev/tty-not-there", cwd=tmp_path)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert "joint 1" in done.stderr
    assert "262.142 rad/s2" in done.stderr


def test_dry_run_opens_nothing_and_says_what_would_be_sent(tmp_path: Path) -> None:
    done = snakebot(
        *RUN, "--cycles", "4", "--port", "serial:/dev/tty-not-there", "--dry-run", "--json", cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    plan = json.loads(done.stdout)
    assert plan["ticks"] == 1658  # (4 cycles of pi s + two ramps of 2 s) at 100 Hz, both ends included
    assert [row["angle_deg"] for row in plan["joints"]] == pytest.approx([66] * 5, abs=0.01)
    assert all(row["speed_rad_s"] < row["speed_limit_rad_s"] for row in plan["joints"])
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("group", [[], ["log"], ["board"]], ids=" ".join)
def test_a_group_alone_is_its_help_page(group: list[str]) -> None:
    done = snakebot(*group)
    assert done.returncode == 2
    assert done.stderr.splitlines()[0].startswith(" ".join(["Usage: snakebot", *group]))
    assert len(done.stderr.splitlines()) > 10


def test_module_errors_are_not_tracebacks() -> None:
    done = snakebot("log", "info", "/nowhere/at/all.mcap")
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
