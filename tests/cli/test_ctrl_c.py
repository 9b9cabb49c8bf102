"""Ctrl-C outside the run loop: one short line at most, and status 130, from the program's first line to its last."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

RUN = ["run", "--alpha", "40", "--beta", "60", "--omega", "2", "--duration", "1.5", "--ramp", "0.5", "--log"]

# Ctrl-C where the program imports its n-th module, whenever that is.
AT_IMPORT = """
import os, signal, sys
left = [int(sys.argv.pop(1))]
def see(event, details):
    if event == "import":
        left[0] -= 1
        if left[0] == 0:
            os.kill(os.getpid(), signal.SIGINT)
from snakebot.cli.entry import main
sys.addaudithook(see)
main()
"""

IN_A_FINALISER = """
import os, signal, sys, time
from snakebot.cli import entry, main
class Held:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        len("the handler is called here")
def work(**_):
    Held()
    time.sleep(20)
    print("went on")
main.main = work
entry.main()
"""

MADE_INTO_ANOTHER_ERROR = """
import os, signal
from snakebot.cli import entry, main
def work(**_):
    try:
        os.kill(os.getpid(), signal.SIGINT)
        len("")
    except KeyboardInterrupt:
        raise ImportError("some library failed to import") from None
main.cli.main = work
entry.main()
"""

IN_A_LIBRARY_THAT_PRINTS = """
import os, signal, sys, time
from pathlib import Path
from snakebot.cli import entry, main
folder = sys.argv.pop(1)
(Path(folder) / "prints.py").write_text(
    "import os, signal, sys\\n"
    "try:\\n"
    "    os.kill(os.getpid(), signal.SIGINT)\\n"
    "    len('')\\n"
    "except KeyboardInterrupt:\\n"
    "    print('ImportError: printed by the library', file=sys.stderr)\\n"
)
sys.path.insert(0, folder)
def work(**_):
    import prints
    time.sleep(20)
    print("went on")
main.main = work
entry.main()
"""

INTERRUPTED = """
import os, signal, sys, time, traceback
from snakebot.cli import entry, main
def interrupted(answer):
    def function(*arguments):
        importing = any(call.filename.startswith("<frozen importlib") for call in traceback.extract_stack())
        if not importing and not sent:
            sent.append(True)
            os.kill(os.getpid(), signal.SIGINT)
            len("the handler is called here")
        return answer(*arguments)
    return function
sent = []
"""

WHILE_MACHINE_CODE_IS_LOADED = (
    INTERRUPTED
    + """
from numba.core.codegen import JITCodeLibrary
JITCodeLibrary._object_getbuffer_hook = staticmethod(interrupted(JITCodeLibrary._object_getbuffer_hook))
entry.main()
assert sent
"""
)

TWO_ARRAYS = """
import numpy as np
from numba import njit
@njit(cache=True)
def two(n):
    return np.zeros((n, n)), np.zeros((n, n))
"""

WHILE_CONSTANTS_ARE_LOADED = (
    INTERRUPTED
    + """
sys.path.insert(0, sys.argv.pop(1))
from numba.core import serialize
import arrays
serialize.cloudpickle.loads = interrupted(serialize.cloudpickle.loads)
def work(**_):
    arrays.two(3)
    assert sent
    time.sleep(5)
    print("went on")
main.main = work
entry.main()
"""
)

LOST = """
import contextlib, os, signal
from snakebot.cli import entry
from snakebot.control import ports
opened = ports.open_port
def open_port(*arguments, **options):
    with contextlib.suppress(KeyboardInterrupt):
        os.kill(os.getpid(), signal.SIGINT)
        len("")
    return opened(*arguments, **options)
ports.open_port = open_port
entry.main()
"""


def quiet(status: int, said: str) -> None:
    assert status == 130, said
    assert said in ("", "snakebot: aborted\n")


def start(*arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def python(code: str, *arguments: str) -> tuple[int, str, str]:
    """Exit status, standard output, standard error."""
    process = start("-c", code, *arguments)
    out, said = process.communicate(timeout=60)
    return process.returncode, out, said


@pytest.mark.parametrize("number", [1, 30, 400])
def test_while_it_imports(number: int, tmp_path: Path) -> None:
    status, _, said = python(AT_IMPORT, str(number), *RUN, str(tmp_path / "a.mcap"))
    quiet(status, said)
    assert not list(tmp_path.iterdir())


def test_in_a_finaliser() -> None:
    status, out, said = python(IN_A_FINALISER)
    quiet(status, said)
    assert not out


def test_where_a_library_that_is_imported_would_print_it(tmp_path: Path) -> None:
    status, out, said = python(IN_A_LIBRARY_THAT_PRINTS, str(tmp_path))
    quiet(status, said)
    assert not out


def test_where_a_library_makes_another_error_of_it() -> None:
    status, _, said = python(MADE_INTO_ANOTHER_ERROR)
    quiet(status, said)


def test_where_a_library_loses_it_no_run_begins(tmp_path: Path) -> None:
    status, _, said = python(LOST, *RUN, str(tmp_path / "a.mcap"))
    quiet(status, said)
    assert not list(tmp_path.glob("*.mcap"))


def test_where_the_compiler_would_crash_of_it(tmp_path: Path) -> None:
    status, _, said = python(WHILE_MACHINE_CODE_IS_LOADED, *RUN, str(tmp_path / "a.mcap"))
    quiet(status, said)
    assert said
    assert not list(tmp_path.glob("*.mcap"))


def test_where_the_compiler_does_not_look_whether_it_came(tmp_path: Path) -> None:
    """A function that makes arrays has constants, which are loaded when it first begins."""
    (tmp_path / "arrays.py").write_text(TWO_ARRAYS)
    compiled = python(
        "import sys; sys.path.insert(0, sys.argv[1]); import arrays; arrays.two(3)", str(tmp_path)
    )
    assert compiled == (0, "", "")
    status, out, said = python(WHILE_CONSTANTS_ARE_LOADED, str(tmp_path))
    quiet(status, said)
    assert not out


def test_after_the_work_the_status_stands() -> None:
    code = "from snakebot.cli import entry, main\nimport atexit, os, signal, sys\n"
    code += "atexit.register(lambda: os.kill(os.getpid(), signal.SIGINT))\nentry.main()"
    status, out, said = python(code, "--version")
    assert (status, said) == (0, "")
    assert out.startswith("snakebot")


def not_begun(said: str) -> bool:
    """Python was still being loaded: of ours there is no more than the first import, and what that imports itself."""
    ours = re.findall(r'File "\S*snakebot(?:/cli)?(?:/(\w+)\.py)?", line \d+, in (\S+)', said)
    return all(file in ("", "__main__", "main", "entry") and where == "<module>" for file, where in ours)


# The interpreter prints a Ctrl-C that comes while it looks for a program to run, and goes on.
LOST_BY_PYTHON = "Failed checking if argv[0] is an import path entry"

WAYS = [["-m", "snakebot.cli.main"], ["-m", "snakebot"], [str(Path(sys.executable).with_name("snakebot"))]]


@pytest.mark.slow
@pytest.mark.real_time
@pytest.mark.parametrize("way", WAYS, ids=["module", "package", "script"])
@pytest.mark.parametrize("after_s", [0.0, 0.02, 0.05, 0.08, 0.12, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8, 1.0])
def test_at_any_moment(after_s: float, way: list[str], tmp_path: Path) -> None:
    process = start(*way, *RUN, str(tmp_path / "a.mcap"))
    time.sleep(after_s)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    if after_s < 0.5 and process.returncode in (-signal.SIGINT, 1) and not_begun(said):
        return
    if LOST_BY_PYTHON in said and not_begun(said):
        return
    quiet(process.returncode, said)
