"""Time for loops: the machine's monotonic clock with sharp deadlines, or a virtual one that work drives."""

from __future__ import annotations

import contextlib
import ctypes
import math
import os
import threading
import time
from collections.abc import Iterator
from typing import Any, Protocol

_CLOCK_MONOTONIC = 1
_TIMER_ABSTIME = 1
_PR_SET_TIMERSLACK = 29
_PRIORITY = 10  # of 1 to 99: before ordinary work, after the drivers of the wire
_HELPER_PRIORITY = 1  # of the other threads of an urgent process


class Clock(Protocol):
    """Seconds that never go back; their zero means nothing."""

    def now_s(self) -> float:
        """The time."""
        ...

    def sleep_until(self, t_s: float) -> None:
        """Return at ``t_s`` or as soon after it as can be; at once when it is past."""
        ...


class _Timespec(ctypes.Structure):
    _fields_ = (("tv_sec", ctypes.c_long), ("tv_nsec", ctypes.c_long))


def _libc() -> Any | None:
    """The C library with ``clock_nanosleep``, or None where the platform has none (macOS, Windows)."""
    try:
        libc = ctypes.CDLL(None, use_errno=True)
        libc.clock_nanosleep.restype = ctypes.c_int
        libc.clock_nanosleep.argtypes = (
            ctypes.c_int,
            ctypes.c_int,
            ctypes.POINTER(_Timespec),
            ctypes.POINTER(_Timespec),
        )
    except (OSError, AttributeError, TypeError):
        return None
    return libc


def sharpen_thread(libc: Any | None = None) -> None:
    """Timer slack of the calling thread to 1 ns, where there is such a thing: its waits end when they should."""
    prctl = getattr(libc or _libc(), "prctl", None)
    if prctl is not None:
        prctl(_PR_SET_TIMERSLACK, ctypes.c_ulong(1), 0, 0, 0)


class MonotonicClock:
    """The machine's monotonic clock.

    A sleep is one ``clock_nanosleep`` to an absolute deadline: what happens between reading the clock and going to
    sleep cannot make it late, unlike a relative sleep. The thread's timer slack is set to 1 ns (Linux's default lets
    the kernel wake a thread 50 us late). Where there is no ``clock_nanosleep``, ``time.sleep`` stands in.
    """

    def __init__(self) -> None:
        self._libc = _libc()
        self._thread = threading.local()

    def now_s(self) -> float:
        return time.monotonic()

    def sleep_until(self, t_s: float) -> None:
        if t_s <= time.monotonic():
            return
        if self._libc is None:
            while (left_s := t_s - time.monotonic()) > 0:
                time.sleep(left_s)
            return
        if not getattr(self._thread, "sharp", False):
            self._thread.sharp = True
            sharpen_thread(self._libc)
        whole = math.floor(t_s)
        deadline = _Timespec(whole, int((t_s - whole) * 1e9))
        # EINTR brings us back between bytecodes, so that a signal's handler has run (and may have raised).
        while time.monotonic() < t_s:
            self._libc.clock_nanosleep(_CLOCK_MONOTONIC, _TIMER_ABSTIME, ctypes.byref(deadline), None)


@contextlib.contextmanager
def urgent() -> Iterator[None]:
    """Run this thread before the ordinary work of a busy computer (SCHED_FIFO), where the user may ask for that.

    The threads that are there already (panel, log) come right behind it: each holds the interpreter's lock now and
    then, and if ordinary work of others could keep it waiting meanwhile, this thread would wait with it. Threads and
    processes that are started later are ordinary ones. Without the permission (``ulimit -r``, or root) nothing
    changes: the loop is then as punctual as the computer is idle.
    """
    if not hasattr(os, "sched_setscheduler"):
        yield
        return
    before = {}
    for thread in threading.enumerate():
        number = thread.native_id
        assert number is not None  # only a thread that has not started has none
        priority = _PRIORITY if thread is threading.current_thread() else _HELPER_PRIORITY
        with contextlib.suppress(OSError):  # forbidden, or it has just ended
            was = os.sched_getscheduler(number), os.sched_getparam(number)
            os.sched_setscheduler(number, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(priority))
            before[number] = was
    try:
        yield
    finally:
        for number, (policy, parameters) in before.items():
            with contextlib.suppress(OSError):
                os.sched_setscheduler(number, policy, parameters)


class VirtualClock:
    """A clock that stands until somebody sleeps: a sleep moves it, and takes no time."""

    def __init__(self, start_s: float = 0.0) -> None:
        self._now_s = start_s

    def now_s(self) -> float:
        return self._now_s

    def sleep_until(self, t_s: float) -> None:
        self._now_s = max(self._now_s, t_s)
