"""Whether the computer stood still while a test ran: seen by a process that only sleeps.

A virtual machine that gets no processor for a quarter of a second stops a robot, as it should, and fails a test that
holds programs to a clock. Such a failure says nothing, and such a test is asked again, with the computer to itself.
What fails on a computer that kept its time is a failure, and so is what fails each time.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import Any

import pytest

# Of standing still: the quickest tests lose a robot that is kept waiting for two ticks of 100 Hz.
ALLOWED_S = 0.02
TIMES_MORE = 3
DELAY_S = 4.0  # before a test is asked again; twice that before the next time

# What is said where a host or a board was kept waiting for longer than a watchdog waits.
KEPT_WAITING = re.compile(r"no set-point reached it for|this computer stood still|status \{.*\b5: \d")

WATCH = f"""
import os, time
parent, before = os.getppid(), time.monotonic()
while os.getppid() == parent:
    time.sleep(0.005)
    now = time.monotonic()
    if now - before > {ALLOWED_S}:
        print(now, flush=True)
    before = now
"""


class ComputerWatch:
    """Times at which the computer had stood still, of a process beside this one."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-S", "-c", WATCH], stdout=subprocess.PIPE, start_new_session=True
        )
        assert self._process.stdout is not None
        self._out = self._process.stdout.fileno()
        os.set_blocking(self._out, False)
        self._text = b""
        self._since_s = time.monotonic()

    @property
    def pid(self) -> int:
        return self._process.pid

    def begin(self) -> None:
        """A test begins."""
        self._since_s = time.monotonic()

    def kept_waiting(self, error: BaseException | None) -> bool:
        """Whether a failure of the test that runs is the computer's."""
        return self.stood_still() or (error is not None and bool(KEPT_WAITING.search(str(error))))

    def stood_still(self) -> bool:
        """Whether it has since the test began."""
        time.sleep(0.1)  # what has just happened is told by now
        with contextlib.suppress(BlockingIOError):
            self._text += os.read(self._out, 1 << 16)
        return any(float(at_s) > self._since_s for at_s in self._text.split())

    def end(self) -> None:
        self._process.kill()
        self._process.communicate()


class Turns:
    """The tests of all workers of one run go side by side, or one of them alone: locks on two files they share.

    Whoever wants to run, beside others or alone, goes through the gate; who wants to be alone holds it shut until the
    others have ended the test they are at.
    """

    def __init__(self, run: str) -> None:
        self._gate, self._room = (
            (Path(tempfile.gettempdir()) / f"snakebot-tests-{run}.{name}").open("w")
            for name in ("gate", "room")
        )

    def take(self, alone: bool) -> None:
        """Wait for the turn; a turn that is held is given back first."""
        self.give_back()
        fcntl.flock(self._gate, fcntl.LOCK_EX)
        fcntl.flock(self._room, fcntl.LOCK_EX if alone else fcntl.LOCK_SH)
        if not alone:
            fcntl.flock(self._gate, fcntl.LOCK_UN)

    def give_back(self) -> None:
        fcntl.flock(self._room, fcntl.LOCK_UN)
        fcntl.flock(self._gate, fcntl.LOCK_UN)

    def end(self) -> None:
        for file in (self._gate, self._room):
            file.close()
            Path(file.name).unlink(missing_ok=True)


class AskAgain:
    """Plugin: a test that fails while the computer stood still is asked again, alone."""

    def __init__(self, config: pytest.Config) -> None:
        self.watch = ComputerWatch()
        worker: dict[str, str] | None = getattr(config, "workerinput", None)
        self._turns = None if worker is None else Turns(worker["testrunuid"])
        self._asked: pytest.Item | None = None
        self._failed = False
        self._limit: Any = None  # settings of the time limit of the test that runs

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self) -> Iterator[Any]:
        self._asked = self._limit = None
        if self._turns is None:
            return (yield)
        self._turns.take(alone=False)
        try:
            return (yield)
        finally:
            self._turns.give_back()

    @pytest.hookimpl(wrapper=True)
    def pytest_timeout_set_timer(self, settings: Any) -> Iterator[Any]:
        self._limit = settings
        return (yield)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        if item is self._asked:  # before
            hooks = item.ihook
            if self._limit is not None:  # it is for one time
                hooks.pytest_timeout_cancel_timer(item=item)
            if self._turns is not None:
                self._turns.take(alone=True)
            if self._limit is not None:
                hooks.pytest_timeout_set_timer(item=item, settings=self._limit)
        self._asked = item
        self._failed = False
        self.watch.begin()

    @pytest.hookimpl(wrapper=True, trylast=True)
    def pytest_runtest_makereport(self) -> Generator[None, Any, Any]:
        report = yield
        self._failed |= report.failed
        return report

    def _ask_again(self, error: BaseException | None) -> bool:
        """Asked after every test: one that passed does not wait until it is told whether the computer stood still."""
        return self._failed and self.watch.kept_waiting(error)

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        for item in items:
            item.add_marker(
                pytest.mark.flaky(
                    reruns=TIMES_MORE, reruns_delay=DELAY_S, reruns_delay_backoff_factor=2.0,
                    condition=self._ask_again,
                )
            )  # fmt: skip

    def pytest_unconfigure(self) -> None:
        self.watch.end()
        if self._turns is not None:
            self._turns.end()
