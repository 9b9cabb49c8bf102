"""Reality and the product's simulation share no code, or the check would check nothing."""

import ast
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from file_imports import imports_of

FORBIDDEN = ("snakebot.physics", "snakebot.effects")


def imported(path: Path) -> set[str]:
    names: set[str] = set()
    for node in imports_of(path):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif node.module and not node.level:
            names |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return names


def is_python(path: Path) -> bool:
    return path.is_file() and (path.suffix == ".py" or path.read_bytes().startswith(b"#!/usr/bin/env python"))


def test_the_blind_robot_imports_neither_physics_nor_effects(root: Path) -> None:
    files = [f for f in (root / "tools" / "blind").iterdir() if is_python(f)]
    assert {"make", "answer", "score", "chain.py", "faults.py"} <= {f.name for f in files}
    for file in files:
        assert not [n for n in imported(file) if n.startswith(FORBIDDEN)], file


def test_the_product_does_not_import_the_blind_robot(root: Path) -> None:
    for file in (root / "snakebot").rglob("*.py"):
        assert not [n for n in imported(file) if n.split(".")[0] in ("blind", "tools")], file


def test_no_forbidden_module_is_loaded_behind_the_scenes(root: Path) -> None:
    code = (
        f"import sys; sys.path.insert(0, {str(root / 'tools')!r})\n"
        "import blind.cases, blind.session_files, blind.scores, blind.seal\n"
        f"print([m for m in sys.modules if m.startswith({FORBIDDEN!r})])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_answering_script_knows_nothing_of_labels(root: Path) -> None:
    for name in ("answer", "answering.py"):
        file = root / "tools" / "blind" / name
        ours = {n for n in imported(file) if n.split(".")[0] in ("blind", "snakebot", "cryptography")}
        assert ours <= {"blind.answering", "blind.answering.Pool"}
        assert "labels.sealed" not in file.read_text()


def test_all_public_effect_names_are_injected() -> None:
    from blind.faults import KNOWN, UNKNOWN

    from snakebot.effects import effects

    # Of a bench with an arm, of which the sets have none; a name more would change every case of the sealed sets.
    on_an_arm = {"position_loop", "arm_payload"}
    assert set(KNOWN) == set(effects()) - on_an_arm
    assert not set(UNKNOWN) & set(effects())
    assert len(UNKNOWN) >= 5


def test_stages_agree_with_the_library() -> None:
    from blind.faults import FAULTS, KNOWN

    from snakebot.effects import effects

    assert {n: FAULTS[n].stage for n in KNOWN} == {n: effects()[n].stage for n in KNOWN}


TRIES = {
    "open": "print(open(path).read())",
    "listing": "import os; print('secret', os.listdir(os.path.dirname(path)))",
    "another process": "import subprocess; subprocess.run(['cat', path])",
    "link": "import os; os.symlink(path, 'here'); print(open('here').read())",
}


@pytest.mark.parametrize("how", TRIES)
def test_the_answering_process_is_refused_labels_and_key(tmp_path: Path, how: str) -> None:
    from blind.answering import GUARD

    (tmp_path / "set").mkdir()
    for name in ("set/labels.sealed", "set.key"):
        (tmp_path / name).write_text("secret")
        if how == "listing" and name == "set.key":
            continue  # of the folder above
        tried = f"{GUARD}\npath = {str(tmp_path / name)!r}\n{TRIES[how]}"
        words = [sys.executable, "-c", tried, str(tmp_path / "set")]
        done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path)
        assert "the one who answers" in done.stderr, done.stderr
        assert "secret" not in done.stdout


def test_the_guard_lets_everything_else_be_read(tmp_path: Path) -> None:
    from blind.answering import GUARD

    (tmp_path / "elsewhere").write_text("free")
    words = [sys.executable, "-c", GUARD + "print(open(sys.argv[1]).read())", str(tmp_path / "set")]
    done = subprocess.run([*words, str(tmp_path / "elsewhere")], capture_output=True, text=True)
    assert done.stdout.strip() == "free", done.stderr


def test_one_process_answers_many_folders_and_outlives_bad_ones(tmp_path: Path) -> None:
    from blind.answering import Diagnostician

    (tmp_path / "set" / "cases" / "a").mkdir(parents=True)
    one = Diagnostician(tmp_path / "set")
    try:
        first = one.ask(tmp_path / "set" / "cases" / "a")
        process = one._process
        second = one.ask(tmp_path / "set" / "cases" / "a", "--no-such-option")
        assert (first.status, second.status) == (2, 2)
        assert first.answer is second.answer is None
        assert "no-such-option" in second.said
        assert one._process is process
        assert process is not None
        os.kill(process.pid, signal.SIGSTOP)
        late = one.ask(tmp_path / "set" / "cases" / "a", limit_s=0.2)
        assert late.status == -1
        assert one._process is None
    finally:
        one.close()
