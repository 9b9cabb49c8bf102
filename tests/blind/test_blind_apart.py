"""Reality and the product's simulation share no code, or the check would check nothing."""

import ast
import subprocess
import sys
from pathlib import Path

FORBIDDEN = ("snakebot.physics", "snakebot.effects")


def imported(path: Path) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
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
    answer = root / "tools" / "blind" / "answer"
    assert not [n for n in imported(answer) if n.split(".")[0] in ("blind", "snakebot", "cryptography")]
    assert "labels.sealed" not in answer.read_text()


def test_all_public_effect_names_are_injected() -> None:
    from blind.faults import KNOWN, UNKNOWN

    from snakebot.effects import effects

    held = {
        name for name in effects() if name != "torque_speed"
    }  # a motor curve: the blind robot always has one
    assert set(KNOWN) == held
    assert not set(UNKNOWN) & set(effects())
    assert len(UNKNOWN) >= 5


def test_stages_agree_with_the_library() -> None:
    from blind.faults import FAULTS, KNOWN

    from snakebot.effects import effects

    assert {n: FAULTS[n].stage for n in KNOWN} == {n: effects()[n].stage for n in KNOWN}


def test_the_answering_process_is_refused_labels_and_key(root: Path, tmp_path: Path) -> None:
    from importlib.machinery import SourceFileLoader
    from importlib.util import module_from_spec, spec_from_loader

    loader = SourceFileLoader("blind_answer", str(root / "tools" / "blind" / "answer"))
    spec = spec_from_loader("blind_answer", loader)
    assert spec is not None
    answer = module_from_spec(spec)
    loader.exec_module(answer)
    tried = answer.GUARD.replace(
        "from snakebot.cli.main import main\nmain()", "print(open(sys.argv[1]).read())"
    )
    (tmp_path / "set").mkdir()
    for name in ("set/labels.sealed", "set.key", "elsewhere"):
        (tmp_path / name).write_text("secret")
        words = [sys.executable, "-c", tried, str(tmp_path / "set"), str(tmp_path / name)]
        done = subprocess.run(words, capture_output=True, text=True)
        if name == "elsewhere":
            assert done.stdout.strip() == "secret"
        else:
            assert "not for the one who answers" in done.stderr
            assert "secret" not in done.stdout
