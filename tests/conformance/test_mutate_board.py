"""The mutants of tools/mutate_board: what they are, and that the suite finds a sample of them."""

from __future__ import annotations

import importlib.machinery
import importlib.util
import os
import subprocess
import sys
from collections import Counter
from contextlib import closing
from functools import partial
from pathlib import Path
from time import sleep
from types import ModuleType

import pytest
from building import ROOT, need
from mutation.child import start, wait_for_any
from mutation.mutant import Mutant
from mutation.trial import SimTrial
from samples import sample
from tool_calls import called

from snakebot.conformance import cases

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
    operators = (
        "comparison", "condition", "logic", "arithmetic", "constant", "index", "value", "removal", "name", "arguments",
    )  # fmt: skip
    on_both = {(part, operator) for part in ("core", "sim") for operator in operators}
    assert {key for key, count in counts.items() if count >= 8} == on_both | {("core", "bound")}
    assert len(mutants) > 2000
    names = Counter(mutant.name for mutant in mutants)
    assert max(names.values()) == 1, "a reason must mean one mutant"


C_FUNCTION = b"""
static bool may(const struct sb_modes *modes, uint32_t host, uint32_t now_us)
{
    if (host == 0u) {
        return false;
    }
    for (uint8_t i = 0u; i < joints; i++) {
        board->beat_due_us = next(wait_us, table[i], now_us);
    }
    return true;
}
"""
C_FAULTS = (
    "if (host == 0u) { ; }",  # an early return that is missing
    "i < joints - 1",
    "board->sample_due_us = next(",
    "next(table[i], wait_us, now_us)",
    "next(wait_us, now_us, table[i])",
    "table[i + 1]",
    "table[i - 1]",
)
PYTHON_FUNCTION = b"""
class Board:
    def may(self, joint, dt_s, wait_s):
        if joint == 0:
            return None
        self._sample_due_s = self._beat_due_s + self.next(dt_s, wait_s) + self.table[joint]
"""
PYTHON_FAULTS = (
    "if joint == 0: pass",
    "= self._sample_due_s + self.next",
    "self.next(wait_s, dt_s)",
    "self.table[(joint) - 1]",
)


def test_slips_of_the_pen_are_among_the_faults(tool: ModuleType) -> None:
    for text, changes, faults in (
        (C_FUNCTION, tool.of_c.changes, C_FAULTS),
        (PYTHON_FUNCTION, tool.of_python.changes, PYTHON_FAULTS),
    ):
        made = [
            (text[:first] + instead.encode() + text[last:]).decode()
            for _, first, last, instead in changes(text)
        ]
        for fault in faults:
            assert sum(fault in "\n".join(_folded(one)) for one in made) >= 1, fault


def _folded(text: str) -> list[str]:
    """Its lines, and its lines with every stretch of white space as one space."""
    return [text, " ".join(text.split())]


def test_a_fault_in_the_compiled_limiter_is_the_boards_and_not_the_suites(tool: ModuleType) -> None:
    cases()  # the suite has its own limiter before the board gets a faulty one
    file = "snakebot/gait/slew.py"
    text = (ROOT / file).read_bytes()
    allowed = b"start.speed - tick.change, start.speed + tick.change"
    for fault, found_by in (
        (allowed, ""),
        (allowed.replace(b"- tick", b"- 1.1 * tick"), "keeps_every_joints_limits"),
    ):
        changed = text.replace(allowed, fault) + b"\n# changed\n"
        mutant = Mutant("sim", file, "", 1, "", "", changed, 1)
        child = start(partial(SimTrial.run, mutant, ["keeps_every_joints_limits"]))
        while (word := child.ended()) is None:
            wait_for_any([child])
        assert word == found_by


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


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--jobs", "0"], "--jobs: 0: at least one"),
        (["--sample", "-1"], "--sample: -1: at least one"),
        (["--least", "nan"], "--least: nan: not a share"),
        (["--least", "95"], "--least: 95: not a share"),
        (["--again", "nowhere.txt"], "nowhere.txt"),
        (["--file", "nothing"], "no mutant is left to try"),
    ],
)
def test_what_cannot_be_tried_is_told_in_a_line(words: list[str], told: str) -> None:
    done = called(TOOL, *words)
    assert done.returncode == 2
    assert told in done.stderr.splitlines()[-1]


def _endless() -> str:
    while True:
        sleep(60)


def test_when_the_tool_is_stopped_its_trials_are(tool: ModuleType, tmp_path: Path) -> None:
    with closing(tool.Trials(tmp_path)) as trials:
        child = trials._begin(_endless)
    with pytest.raises(ChildProcessError):
        os.waitpid(child.pid, os.WNOHANG)


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_sample_is_found() -> None:
    need("cc")
    # One of 16 mutants survives, and any change of the boards draws others: of eight, two may.
    words = ["--sample", str(sample(24, 8)), "--seed", "7", "--jobs", "2", "--least", "0.75"]
    command = [sys.executable, str(TOOL), *words]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "found: " in done.stdout
