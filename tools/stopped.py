"""Ctrl-C at a tool that works through many cases: what has not begun is dropped, and one line says how to go on."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

AnyExecutor = TypeVar("AnyExecutor", bound=Executor)


def until_stopped(main: Callable[[], int], then: str = "the same command goes on") -> int:
    """The exit status of ``main``; 130 where Ctrl-C stopped it, with one line that ends in ``then``."""
    try:
        return main()
    except KeyboardInterrupt:
        print(f"\n{Path(sys.argv[0]).name}: stopped; {then}", file=sys.stderr)
        return 130


@contextmanager
def nothing_new_once_stopped(executor: AnyExecutor) -> Iterator[AnyExecutor]:
    """``with executor``, but what waits is dropped where an exception ends it; by itself it would do all of it."""
    with executor:
        try:
            yield executor
        except BaseException:
            executor.shutdown(wait=False, cancel_futures=True)
            raise


def worker_ends_at_ctrl_c() -> None:
    """For ``initializer=`` of a pool of processes: the tool speaks for them, and they print no traceback."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
