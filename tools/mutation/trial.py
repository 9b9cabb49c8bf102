"""What a mutant is put to: every case of the conformance suite on every board that lives in virtual time."""

from __future__ import annotations

import ctypes
import importlib.abc
import importlib.util
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from mutation.child import begin_case
from mutation.mutant import Mutant

ROOT = Path(__file__).resolve().parents[2]
FIRMWARE = ROOT / "firmware_protocol/firmware"
_FLAGS = ["-std=c11", "-w", "-fPIC", f"-I{FIRMWARE / 'port'}"]


def failing_case(benches: Sequence[Callable[[], Any]], order: Sequence[str]) -> str:
    """The name of the first case that does not pass on one of these benches; empty where all do."""
    from snakebot.conformance import Verdict, cases, run_case

    named = {case.name: case for case in cases()}
    for number, bench in enumerate(benches):
        with bench() as board:
            for name in order:
                if number and named[name].long:
                    continue
                begin_case()
                if run_case(named[name], board).verdict is Verdict.FAILED:
                    return name
    return ""


class CoreTrial:
    """Builds the core with one file changed."""

    def __init__(self, scratch: Path) -> None:
        self._scratch = scratch
        self._objects = scratch / "objects"
        self._objects.mkdir(parents=True)
        sources = [*FIRMWARE.glob("core/*.c"), *FIRMWARE.glob("core/generated/*.c")]
        sources += [*FIRMWARE.glob("port/model/*.c"), FIRMWARE / "port/bench/bench.c"]
        self._sources = {str(source.relative_to(FIRMWARE)): source for source in sources}
        self._plain: dict[str, bytes] = {}
        for name, source in self._sources.items():
            self._compile(source, self._object(name), FIRMWARE)

    def _object(self, name: str) -> Path:
        return self._objects / (name.replace("/", "_") + ".o")

    @staticmethod
    def _compile(source: Path, to: Path, tree: Path) -> bool:
        command = ["cc", "-O0", *_FLAGS, f"-I{tree}", f"-I{tree / 'core'}"]
        done = subprocess.run([*command, "-c", str(source), "-o", str(to)], capture_output=True, check=False)
        return done.returncode == 0

    def _optimised(self, source: Path, tree: Path) -> bytes:
        """The code as the compiler shortens it most: the same code twice is the same board."""
        to = self._scratch / "optimised.s"
        done = subprocess.run(
            ["cc", "-O2", *_FLAGS, f"-I{tree}", f"-I{tree / 'core'}", "-S", str(source), "-o", str(to)],
            capture_output=True, check=False,
        )  # fmt: skip
        return to.read_bytes() if done.returncode == 0 else b""

    def prepare(self, mutant: Mutant | None, to: Path) -> str:
        """Build a mutant's library at ``to``; why it does not count, or empty."""
        if mutant is None:
            self._link([self._object(name) for name in self._sources], to)
            return ""
        tree, changed = self._changed(mutant)
        if self._is_the_same(tree, changed):
            return "the compiler makes the same code of it"
        objects = []
        for one in self._sources:
            if one not in changed:
                objects.append(self._object(one))
                continue
            made = tree / (one.replace("/", "_") + ".o")
            if not self._compile(self._source(one, tree), made, tree):
                return "does not compile"
            objects.append(made)
        self._link(objects, to)
        return ""

    def _is_the_same(self, tree: Path, changed: Sequence[str]) -> bool:
        """The optimising compiler makes the same code of it as of the board without the fault."""
        for one in changed:
            plain = self._plain.get(one) or self._optimised(self._sources[one], FIRMWARE)
            self._plain[one] = plain
            if self._optimised(self._source(one, tree), tree) != plain:
                return False
        return True

    def _source(self, name: str, tree: Path) -> Path:
        return tree / name if name.startswith("core/") else self._sources[name]

    def _changed(self, mutant: Mutant) -> tuple[Path, list[str]]:
        """A copy of the core with the fault in it, and the sources that must be compiled anew."""
        tree = self._scratch / "tree"
        shutil.rmtree(tree, ignore_errors=True)
        shutil.copytree(FIRMWARE / "core", tree / "core")
        name = str(Path(mutant.file).relative_to(FIRMWARE.relative_to(ROOT)))
        (tree / name).write_bytes(mutant.text)
        header = name.endswith(".h")
        return tree, [
            one for one in self._sources if one == name or (header and "generated/snakebot" not in one)
        ]

    @staticmethod
    def _link(objects: Sequence[Path], to: Path) -> None:
        subprocess.run(["cc", "-shared", "-o", str(to), *map(str, objects), "-lm"], check=True)

    @staticmethod
    def run(library: Path, order: Sequence[str]) -> str:
        import boards

        loaded = ctypes.CDLL(str(library))
        return failing_case(boards.cores_in_process(loaded), order)


class SimTrial:
    """Loads the simulated board anew with one module changed. The suite's own modules stay as they are."""

    MODULES = (
        "snakebot.softboard",
        "snakebot.gait.limits",
        "firmware_protocol.assembly",
        "firmware_protocol.whole_tick",
    )

    @staticmethod
    def prepare(mutant: Mutant | None, to: Path) -> str:
        if mutant is not None:
            try:
                compile(mutant.text, mutant.file, "exec")
            except SyntaxError:
                return "does not compile"
            to.write_bytes(mutant.text)
        return ""

    @classmethod
    def run(cls, mutant: Mutant | None, order: Sequence[str]) -> str:
        import boards

        if mutant is None:
            return failing_case(boards.sims_in_process(), order)
        target = mutant.file.removesuffix(".py").replace("/", ".")
        for name in [n for n in sys.modules if n.startswith(cls.MODULES)]:
            del sys.modules[name]
        if target == _COMPILED:
            sys.meta_path.insert(0, _beside(mutant))
        else:
            sys.meta_path.insert(0, _Finder(target, mutant.text, mutant.file))
        import snakebot.softboard

        vars(boards).update(
            SoftBoard=snakebot.softboard.SoftBoard, InProcessLink=snakebot.softboard.InProcessLink
        )
        return failing_case(boards.sims_in_process(), order)


_COMPILED = "snakebot.gait.slew"
_BESIDE = "snakebot.gait.slew_with_a_fault"


def _beside(mutant: Mutant) -> _Finder:
    """The board's limiter uses the faulty arithmetic, as plain Python; the suite's, which is its measure, does not."""
    plain = b"njit = lambda *types, **options: types[0] if callable(types[0]) else lambda function: function"
    text = mutant.text.replace(b"from numba import njit", plain)
    module = ModuleType(_BESIDE)
    sys.modules[_BESIDE] = module
    exec(compile(text, mutant.file, "exec"), module.__dict__)
    limits = ROOT / "snakebot/gait/limits.py"
    faulty = limits.read_bytes().replace(
        b"from snakebot.gait import slew", b"from snakebot.gait import slew_with_a_fault as slew"
    )
    return _Finder("snakebot.gait.limits", faulty, str(limits))


class _Finder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    def __init__(self, target: str, text: bytes, file: str) -> None:
        self._target, self._text, self._file = target, text, file

    def find_spec(self, fullname: str, path: Any, target: Any = None) -> Any:
        if fullname != self._target:
            return None
        return importlib.util.spec_from_loader(fullname, self)

    def exec_module(self, module: ModuleType) -> None:
        exec(compile(self._text, self._file, "exec"), module.__dict__)
