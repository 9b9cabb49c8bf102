"""One trial in a process of its own: a mutant may crash, loop, or eat memory.

What ends a loop is processor time, case by case: a busy machine makes no mutant look found.
"""

from __future__ import annotations

import os
import resource
import select
import signal
from collections.abc import Callable
from dataclasses import dataclass

_MEMORY_BYTES = 4 << 30
CASE_CPU_S = 5.0  # for one case: the longest take a third of it


def begin_case() -> None:
    """Another case begins: it has this much processor time before the process is ended."""
    signal.setitimer(signal.ITIMER_PROF, CASE_CPU_S)


@dataclass(slots=True)
class Child:
    """A running trial. Its word is the name of the case that failed, or empty where all passed."""

    pid: int
    pipe: int

    def ended(self) -> str | None:
        """Its word once it has ended; None before."""
        pid, status = os.waitpid(self.pid, os.WNOHANG)
        if pid == 0:
            return None
        with os.fdopen(self.pipe, "rb") as pipe:
            word = pipe.read().decode()
        if os.WIFSIGNALED(status):
            which = os.WTERMSIG(status)
            return "no end" if which == signal.SIGPROF else f"crash ({signal.Signals(which).name})"
        return word if os.WEXITSTATUS(status) == 0 else "crash (exit)"

    def end(self) -> None:
        """Nobody waits for its word any more."""
        os.kill(self.pid, signal.SIGKILL)
        os.waitpid(self.pid, 0)
        os.close(self.pipe)


def start(trial: Callable[[], str]) -> Child:
    """Run a trial in a copy of this process."""
    reading, writing = os.pipe()
    pid = os.fork()
    if pid:
        os.close(writing)
        return Child(pid, reading)
    try:
        os.close(reading)
        for number in (signal.SIGPROF, signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_DFL)
        begin_case()
        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY_BYTES, _MEMORY_BYTES))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        devnull = os.open(os.devnull, os.O_WRONLY)
        os.dup2(devnull, 2)
        try:
            word = trial()
        except Exception as error:
            word = f"error ({type(error).__name__})"
        os.write(writing, word.encode()[:4000])
        os._exit(0)
    finally:
        os._exit(1)


def wait_for_any(children: list[Child]) -> None:
    """Until one of them may have ended."""
    select.select([child.pipe for child in children], [], [], 0.2)
