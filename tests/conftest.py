"""No test finds, stops or shows anything that runs on this computer beside it.

This is the only file of this name: fixtures of one folder stand in a module named after what they are.
"""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from computer_watch import AskAgain
from hypothesis import settings

# A busy computer fails no test. The same code is asked the same examples; `--hypothesis-profile explore` asks new ones.
settings.register_profile("untimed", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None)
settings.load_profile("untimed")

# The suite starts hundreds of Python processes, each of which would compile the package again. What is kept stands
# where numba keeps its own whatever this variable says.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# A shell has Ctrl-C ignored by what it starts in the background, and all that is started from there has: a suite that
# runs in the background gives its programs Ctrl-C as a terminal does.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# New objects between two looks of Python's collector. What is frozen does not count for it, so that it would look
# through all that is new again and again; 10 000 objects are looked through in less than a millisecond.
GARBAGE = 10_000

pytest_plugins = ["built_boards", "core_and_tools", "recordings", "servo_ends", "viewed_run", "visits"]


def pytest_configure(config: pytest.Config) -> None:
    gc.disable()  # until all is collected: it would be looked through again and again
    config.pluginmanager.register(AskAgain(config))


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files whose tests may take longest come first: at the end, one long test would keep all other workers waiting."""
    limit_s: dict[Path, float] = {}
    for item in items:
        limit = item.get_closest_marker("timeout")
        limit_s[item.path] = max(limit_s.get(item.path, 0.0), float(limit.args[0]) if limit else 0.0)
    items.sort(key=lambda item: -limit_s[item.path])


def pytest_collection_finish() -> None:
    """Thousands of collected tests are not looked through by Python's collector while a robot waits."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(GARBAGE)
    gc.enable()


STOP_THESE = """
import sys
from snakebot.control import registry
pids, look = set(map(int, sys.argv[1].split(","))), registry.look
def only(kind=registry.RUNS):
    found = look(kind)
    unclear = {pid: path for pid, path in found.unclear.items() if pid in pids}
    return registry.RegisteredRuns([run for run in found.runs if run.pid in pids], unclear)
registry.look = only
from snakebot.cli.main import main
main(["stop", *sys.argv[2:]])
"""


@pytest.fixture(scope="session")
def root() -> Path:
    """The repository."""
    return Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def of_all_workers(tmp_path_factory: pytest.TempPathFactory, pytestconfig: pytest.Config) -> Path:
    """A folder of this run of the suite, for what is made once and read by all of its processes."""
    base = tmp_path_factory.getbasetemp()
    return base.parent if hasattr(pytestconfig, "workerinput") else base


@pytest.fixture(scope="session")
def places(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Where this process registers and looks."""
    from snakebot.control import registry

    place = tmp_path_factory.mktemp("places")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(registry, "SHARED", (place,))
        patch.setattr(registry, "EACH_USERS", place / "no-user")
        yield place


@pytest.fixture(autouse=True)
def _places_of_our_own(places: Path) -> None:
    pass


@pytest.fixture
def stop_only() -> Callable[..., subprocess.CompletedProcess[str]]:
    """``snakebot stop`` in a process of its own, for these processes: others run here, too."""

    def stop(pids: list[int], *arguments: str) -> subprocess.CompletedProcess[str]:
        words = [sys.executable, "-c", STOP_THESE, ",".join(map(str, pids)), *arguments]
        return subprocess.run(words, capture_output=True, text=True, timeout=60, check=False)

    return stop
