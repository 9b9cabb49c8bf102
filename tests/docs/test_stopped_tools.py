"""tools/stopped.py: Ctrl-C ends a tool with a line and status 130, and nothing that waited is begun any more."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from threading import Event

import pytest
from stopped import nothing_new_once_stopped, until_stopped


def test_a_stopped_tool_says_so_in_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    def main() -> int:
        raise KeyboardInterrupt

    assert until_stopped(main) == 130
    said = capsys.readouterr().err
    assert said.strip().endswith("stopped; the same command goes on")
    assert "Traceback" not in said


def test_the_status_of_a_tool_that_is_not_stopped_is_its_own() -> None:
    assert until_stopped(lambda: 3) == 3


def test_what_waits_when_a_tool_is_stopped_is_not_begun() -> None:
    begun, go_on = Event(), Event()
    worked: list[int] = []

    def first() -> None:
        begun.set()
        go_on.wait()

    with (
        pytest.raises(KeyboardInterrupt),
        nothing_new_once_stopped(ThreadPoolExecutor(1)) as threads,
    ):
        threads.submit(first)
        waiting = [threads.submit(worked.append, i) for i in range(5)]
        begun.wait()
        threads.submit(worked.append, 5)
        # The one that runs ends only after the rest has been dropped.
        waiting[0].add_done_callback(lambda _: go_on.set())
        raise KeyboardInterrupt
    assert worked == []
    assert all(one.cancelled() for one in waiting)


def test_without_being_stopped_all_of_it_is_done() -> None:
    worked: list[int] = []
    with nothing_new_once_stopped(ThreadPoolExecutor(1)) as threads:
        for i in range(5):
            threads.submit(worked.append, i)
    assert worked == [0, 1, 2, 3, 4]
