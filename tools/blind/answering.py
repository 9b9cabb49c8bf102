"""Processes that diagnose one folder after the other and are not told where labels or key are.

Each sees a copy of one folder at a time in an empty directory of its own. An audit hook, which cannot be taken off
again, refuses whatever else of the set has a name that begins like it (sealed labels, key, other cases), and refuses
to start other processes, which would have no hook. Starting Python and compiled code is paid for once.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

CASES_PER_PROCESS = 40  # then a fresh one: what leaks, leaks little

GUARD = """
import os, sys
forbidden = sys.argv.pop(1)
PATHS = ("open", "os.listdir", "os.scandir", "os.rename", "os.link", "os.symlink", "shutil.copyfile", "shutil.copytree")
OTHERS = ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.spawn", "os.fork", "os.forkpty")
def watch(event, arguments):
    if event in OTHERS:
        raise PermissionError("the one who answers starts no other process")
    if event in PATHS:
        for path in arguments[:2]:
            if isinstance(path, (str, bytes, os.PathLike)):
                if os.path.realpath(os.fsdecode(path)).startswith(forbidden):
                    raise PermissionError(f"{path}: not for the one who answers")
sys.addaudithook(watch)
"""

SERVE = """
import contextlib, io, json, time, traceback
if hasattr(os, "sched_setscheduler"):  # whoever asks from a realtime thread must not starve the board beside it
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
replies = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)
from snakebot.cli.main import main
for line in sys.stdin:
    room, words = json.loads(line)
    os.chdir(room)
    said = io.StringIO()
    status = 0
    begun = time.process_time()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
        try:
            main(words)
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else int(end.code is not None)
        except BaseException:
            said.write(traceback.format_exc())
            status = 1
    os.chdir("/")
    replies.write(json.dumps([status, said.getvalue().strip()[-500:], time.process_time() - begun]) + chr(10))
    replies.flush()
"""


@dataclass(frozen=True)
class Answered:
    """``status``: that of ``snakebot diagnose``; -1: out of time. ``answer``: what it wrote, as text.

    ``seconds`` went by; ``cpu_s`` were spent computing, on all cores together.
    """

    status: int
    said: str
    seconds: float
    answer: str | None
    cpu_s: float = 0.0

    @property
    def mapping(self) -> dict[str, Any] | None:
        return None if self.answer is None else json.loads(self.answer)


@dataclass
class Diagnostician:
    """One such process; not for several threads.

    Attributes:
        forbidden: the beginning of all paths that are not for it.
        source: a checkout whose snakebot is to answer; that of this interpreter if None.
    """

    forbidden: Path
    source: Path | None = None
    _process: subprocess.Popen[str] | None = field(default=None, repr=False)
    _replies: SimpleQueue[str | None] = field(default_factory=SimpleQueue, repr=False)
    _served: int = 0

    def ask(self, folder: Path, *extra: str, limit_s: float = 600.0) -> Answered:
        """Diagnose a copy of the folder; ``extra``: further options of ``snakebot diagnose``."""
        begun = time.monotonic()
        with tempfile.TemporaryDirectory(prefix="case_") as room:
            shutil.copytree(folder, Path(room) / "session")
            words = ["diagnose", "session", "--json", "answer.json", "--quiet", *extra]
            status, said, cpu_s = self._serve(room, words, limit_s)
            path = Path(room) / "answer.json"
            answer = path.read_text() if status == 0 and path.exists() else None
        return Answered(status, said, round(time.monotonic() - begun, 1), answer, round(cpu_s, 1))

    def close(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None

    def _serve(self, room: str, words: list[str], limit_s: float) -> tuple[int, str, float]:
        """Exit status, last words and CPU seconds."""
        if self._served >= CASES_PER_PROCESS:
            self.close()
        process = self._process or self._start()
        assert process.stdin is not None
        self._served += 1
        try:
            process.stdin.write(json.dumps([room, words]) + "\n")
            process.stdin.flush()
            reply = self._replies.get(timeout=limit_s)
        except BrokenPipeError:
            reply = None
        except Empty:
            self.close()
            return -1, f"no answer in {limit_s:.0f} s", 0.0
        if reply is None:
            self.close()
            return 1, "the process that diagnoses has ended", 0.0
        status, said, cpu_s = json.loads(reply)
        return int(status), str(said), float(cpu_s)

    def _start(self) -> subprocess.Popen[str]:
        environment = os.environ | dict.fromkeys(
            ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"
        )
        if self.source is not None:
            environment["PYTHONPATH"] = str(self.source.resolve())
        process = subprocess.Popen(
            [sys.executable, "-c", GUARD + SERVE, str(self.forbidden.resolve())],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=environment,
            cwd="/",
        )  # fmt: skip
        self._process, self._served, self._replies = process, 0, SimpleQueue()
        replies = self._replies

        def listen() -> None:
            assert process.stdout is not None
            for line in process.stdout:
                replies.put(line)
            replies.put(None)

        threading.Thread(target=listen, daemon=True).start()
        return process


class Pool:
    """As many as there are jobs; each thread of a pool takes one for a folder and gives it back."""

    def __init__(self, forbidden: Path, jobs: int) -> None:
        self._all = [Diagnostician(forbidden) for _ in range(jobs)]
        self._free: SimpleQueue[Diagnostician] = SimpleQueue()
        for one in self._all:
            self._free.put(one)

    def ask(self, folder: Path, *extra: str, limit_s: float = 600.0) -> Answered:
        one = self._free.get()
        try:
            return one.ask(folder, *extra, limit_s=limit_s)
        finally:
            self._free.put(one)

    def __enter__(self) -> Pool:
        return self

    def __exit__(self, *_: object) -> None:
        for one in self._all:
            one.close()
