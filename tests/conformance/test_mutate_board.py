"""The mutants of tools/mutate_board: what they are, and that the suite finds a sample of them."""

from __future__ import annotations

import importlib.machinery
import importlib.util
import subprocess
import sys
from collections import Counter
from types import ModuleType

import pytest
from building import ROOT, need
from samples import sample

TOOL = ROOT / "tools/mutate_board"


@pytest.fixture(scope="module")
def tool() -> ModuleType:
    loader = importlib.machinery.SourceFileLoader("mutate_board", str(TOOL))
    spec = importlib.util.spec_from_loader("mutate_board", loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    before = list(sys.path)
    loader.exec_module(module)
    sys.path[:] = before
    return module


def test_every_operator_is_tried_on_both_boards(tool: ModuleType) -> None:
    mutants = tool.all_mutants(None, None)
    counts = Counter((mutant.part, mutant.operator) for mutant in mutants)
    operators = ("comparison", "condition", "logic", "arithmetic", "constant", "index", "value", "removal")
    assert {key for key, count in counts.items() if count >= 10} == {
        (part, operator) for part in ("core", "sim") for operator in operators
    }
    assert len(mutants) > 2000
    names = Counter(mutant.name for mutant in mutants)
    assert max(names.values()) == 1, "a reason must mean one mutant"


def test_every_mutant_is_one_change(tool: ModuleType) -> None:
    """The same file but for one place; and another file than every other mutant's."""
    for mutant in tool.all_mutants(None, None)[::50]:
        plain = (ROOT / mutant.file).read_bytes()
        assert mutant.text != plain
        same_before = next(i for i, (a, b) in enumerate(zip(plain, mutant.text, strict=False)) if a != b)
        assert plain[:same_before].count(b"\n") + 1 >= mutant.line - 1


def test_every_reason_is_one_of_a_mutant_that_there_is(tool: ModuleType) -> None:
    names = {mutant.name for mutant in tool.all_mutants(None, None)}
    reasons = tool.reasons()
    assert not set(reasons) - names, "the line has changed: look at tools/mutation/reasons.yaml"
    assert {kind for kind, _ in reasons.values()} <= {"equivalent", "wire", "joints", "hours", "unpromised"}
    assert all(len(why) > 20 for _, why in reasons.values())


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_sample_is_found() -> None:
    need("cc")
    # Of 24, 19 of the 20 that count are found, all 15 of the C core's; the other one only real time would show.
    words = ["--sample", str(sample(24, 8)), "--seed", "7", "--jobs", "2", "--least", "0.9"]
    command = [sys.executable, str(TOOL), *words]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "found: " in done.stdout
