"""README.md: every command in it runs, every link in it leads somewhere."""

from __future__ import annotations

import fcntl
import json
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from snakebot.cli.main import main

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
# Commands that serve a page go on until somebody ends them: tests/docs/test_view_page.py.
SERVES_A_PAGE = re.compile(r"    snakebot (view |.* --view)")
COMMANDS = [
    line.strip()
    for line in README.splitlines()
    if line.startswith("    snakebot ") and not SERVES_A_PAGE.match(line)
] + re.findall(r"`(snakebot study pareto [^`]*)`", README)
SLOW = ("diagnose", "optimize", "study", "plan", "predict")
REAL_PORTS = ("serial:/dev/ttyUSB0", "can:socketcan/can0")


@pytest.fixture(scope="module")
def port() -> Iterator[str]:
    """A simulated board on a pseudo-terminal stands where the README has a robot."""
    command = [
        sys.executable,
        "-m",
        "snakebot.cli.main",
        "board",
        "sim",
        "--serial",
        "--watchdog-ms",
        "250",
        "--json",
    ]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    yield json.loads(process.stdout.readline())["port"]
    process.terminate()
    process.wait(10)


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory, of_all_workers: Path) -> Path:
    """A folder with a log and a session, as somebody has who has used the program."""
    made = of_all_workers / "readme-lab"
    with made.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not made.exists():
            half = Path(tempfile.mkdtemp(dir=of_all_workers))
            use_the_program(half)
            half.rename(made)
    return Path(shutil.copytree(made, tmp_path_factory.mktemp("lab"), dirs_exist_ok=True))


def use_the_program(folder: Path) -> None:
    for name, gait in (("REAL", "66 80 2"), ("second", "50 80 3"), ("third", "40 80 1.5")):
        alpha, beta, omega = gait.split()
        call("run", "--alpha", alpha, "--beta", beta, "--omega", omega, "--duration", "12", "--fast",
             "--effect", "servo_lag:time_constant_s=0.08", "--log", str(folder / "runs" / f"{name}.mcap"))  # fmt: skip
    call("session", "make", str(folder / "SESSION"), *map(str, sorted((folder / "runs").glob("*.mcap"))))


def call(*arguments: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 0, arguments


def words_of(command: str, port: str) -> list[str]:
    """The command with a simulated board in place of the robot, in virtual time where that can be."""
    words = shlex.split(command)[1:]
    for index, word in enumerate(words):
        for real in REAL_PORTS:
            if word.startswith(real):
                words[index] = word.replace(real, port)
    if words[0] == "run":
        words += ["--duration", "4.5"] if "--port" in words else [] if "--fast" in words else ["--fast"]
    return words


@pytest.mark.parametrize(
    "command",
    [pytest.param(c, marks=[pytest.mark.slow] if set(c.split()[1:3]) & set(SLOW) else []) for c in COMMANDS],
)
def test_a_command_of_the_readme_runs(
    command: str, port: str, lab: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(lab)
    words = words_of(command, port)
    if words[:2] == ["board", "sim"]:
        serve(words)
        return
    expanded = [str(path) for word in words for path in (sorted(lab.glob(word)) if "*" in word else [word])]
    if words[0] == "doctor":
        with pytest.raises(SystemExit) as ended:
            main(expanded)
        assert ended.value.code in (0, 3, 5)  # whatever it finds on this machine, it says so
        return
    call(*expanded)


def serve(words: list[str]) -> None:
    """Start the simulated board and see it print its port; multicast needs a network that allows it."""
    if any(word.startswith("udp_multicast") for word in words):
        words = [word.replace("udp_multicast/239.74.163.2", "virtual/readme") for word in words]
    process = subprocess.Popen(
        [sys.executable, "-m", "snakebot.cli.main", *words], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    line = process.stdout.readline()
    process.terminate()
    assert process.wait(20) in (0, 130, -15)
    assert line.startswith("--port ")


def test_the_readme_has_the_commands_that_it_should() -> None:
    assert len(COMMANDS) >= 15
    for name in ("run", "board", "doctor", "log", "analyze", "compare", "diagnose", "optimize", "study"):
        assert any(command.split()[1] == name for command in COMMANDS), name


PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    ROOT / "CHANGELOG.md",
    *sorted((ROOT / "docs").glob("*.md")),
    ROOT / "firmware_protocol" / "PROTOCOL.md",
]


@pytest.mark.parametrize("page", [path.relative_to(ROOT).as_posix() for path in PAGES])
def test_links_lead_somewhere(page: str) -> None:
    path = ROOT / page
    for target in re.findall(r"\]\(([^)#]+)\)", path.read_text(encoding="utf-8")):
        if not target.startswith("http"):
            assert (path.parent / target).exists(), f"{page}: {target}"


def test_the_two_make_targets_exist() -> None:
    make = shutil.which("make")
    assert make is not None
    for target in ("run", "test"):
        plan = subprocess.run([make, "-n", target], cwd=ROOT, capture_output=True, text=True, check=True)
        assert "snakebot run --alpha 66 --beta 80 --omega 2" in plan.stdout or "pytest" in plan.stdout
