"""The loop before ordinary work, and the threads that share the interpreter's lock with it right behind."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator

import pytest

from snakebot.clock import urgent

FIFO = getattr(os, "SCHED_FIFO", None)


@pytest.fixture
def helper() -> Iterator[threading.Thread]:
    done = threading.Event()
    thread = threading.Thread(target=done.wait)
    thread.start()
    yield thread
    done.set()
    thread.join()


def policy(thread: threading.Thread) -> int:
    assert thread.native_id is not None
    return os.sched_getscheduler(thread.native_id) & ~os.SCHED_RESET_ON_FORK


def priority(thread: threading.Thread) -> int:
    assert thread.native_id is not None
    return os.sched_getparam(thread.native_id).sched_priority


@pytest.fixture
def permitted() -> None:
    if FIFO is None:
        pytest.skip("no scheduling policies on this platform")
    with urgent():
        if policy(threading.current_thread()) != FIFO:
            pytest.skip("no permission to go before ordinary work here (ulimit -r)")


@pytest.mark.usefixtures("permitted")
def test_threads_that_share_the_interpreter_are_urgent_too(helper: threading.Thread) -> None:
    """Otherwise the loop waits for whoever keeps a thread from running that holds the interpreter's lock."""
    with urgent():
        assert policy(helper) == FIFO
        assert 0 < priority(helper) < priority(threading.current_thread())
    assert policy(helper) != FIFO
    assert policy(threading.current_thread()) != FIFO


@pytest.mark.usefixtures("permitted")
def test_what_is_started_meanwhile_is_ordinary_and_an_ended_thread_does_no_harm(
    helper: threading.Thread,
) -> None:
    seen: list[int] = []
    with urgent():
        started = threading.Thread(target=lambda: seen.append(os.sched_getscheduler(0)))
        started.start()
        started.join()
        ending = threading.Thread(target=lambda: None)
        ending.start()
        with urgent():
            ending.join()
        assert policy(helper) == FIFO
    assert FIFO not in seen
    assert policy(helper) != FIFO


def test_without_the_permission_nothing_changes(
    monkeypatch: pytest.MonkeyPatch, helper: threading.Thread
) -> None:
    def forbidden(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", forbidden)
    before = policy(helper), policy(threading.current_thread())
    with urgent():
        assert (policy(helper), policy(threading.current_thread())) == before
