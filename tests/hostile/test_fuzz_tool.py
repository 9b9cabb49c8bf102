"""tools/fuzz_parsers.py: the commands of docs/hostile-input.md run, and it finds what there is to be found."""

from __future__ import annotations

import importlib.util
import re
import shlex
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import parsers
import pytest

from snakebot.errors import BadInputError

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = re.findall(
    r"^    \.venv/bin/python (tools/fuzz_parsers\.py[^#\n]*)",
    (ROOT / "docs" / "hostile-input.md").read_text(),
    re.M,
)


@pytest.fixture
def tool(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location("fuzz_parsers", ROOT / "tools" / "fuzz_parsers.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "OUT", tmp_path)
    monkeypatch.setattr(module, "ROOT", tmp_path)
    return module


def test_each_finding_is_counted_once_and_its_input_kept(
    tool: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def parse(data: bytes) -> None:
        if data == b"documented":
            raise BadInputError("no")
        if data == b"fault":
            raise KeyError(data)
        if data == b"trespass":
            (tmp_path / "written").write_bytes(data)

    monkeypatch.setitem(parsers.PARSERS, "test", parse)
    counted = tool.Counted("test")
    for data in (b"sound", b"documented", b"fault", b"fault", b"trespass"):
        counted(data)
    assert counted.cases == 5
    assert len(counted.findings) == 2
    assert {path.read_bytes() for path in tmp_path.glob("finding-test-*")} == {b"fault", b"trespass"}


def test_the_case_that_takes_too_much_memory_is_kept(
    tool: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    taken = {b"small": 100, b"greedy": 500, b"after": 500}
    now = 100
    monkeypatch.setattr(tool, "peak_mib", lambda: now)

    def parse(data: bytes) -> None:
        nonlocal now
        now = taken[data]

    monkeypatch.setitem(parsers.PARSERS, "test", parse)
    counted = tool.Counted("test")
    counted.base_mib = counted.peak_mib = now
    for data in taken:
        counted(data)
    assert list(counted.findings) == ["too much memory"]
    assert (tmp_path / "finding-test-0").read_bytes() == b"greedy"


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize("command", COMMANDS)
def test_the_commands_of_the_page_run(command: str, tmp_path: Path) -> None:
    if "hypothesis" not in command:
        pytest.importorskip("atheris", reason="extra `fuzz`")
    words = [*shlex.split(command), "port", "fault", "--runs", "300", "--ledger", str(tmp_path / "cases.csv")]
    done = subprocess.run([sys.executable, *words], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(re.findall(r"^(?:port|fault) .* 300 cases, 0 distinct findings", done.stdout, re.M)) == 2
    assert done.stdout.endswith("findings: 0\n")


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_what_an_earlier_run_did_counts(tmp_path: Path) -> None:
    ledger = tmp_path / "cases.csv"
    ledger.write_text("fault,hypothesis,1,200,0\nfault,hypothesis,2,50,1\nport,hypothesis,1,300,0\n")
    words = [
        "tools/fuzz_parsers.py",
        "port",
        "fault",
        "--runs",
        "300",
        "--engine",
        "hypothesis",
        "--go-on",
        "--ledger",
    ]
    done = subprocess.run([sys.executable, *words, str(ledger)], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    port, fault, _ = done.stdout.splitlines()
    assert "300 cases in 1 runs before" in port
    assert re.search(r" 100 cases, .*; 300 with those before", fault)
    assert ledger.read_text().splitlines()[-1] == "fault,hypothesis,3,100,0"


def test_the_page_has_commands() -> None:
    assert len(COMMANDS) == 4
