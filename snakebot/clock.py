"""Time for loops: the machine's monotonic clock with sharp deadlines, the same without the standstills of this process,
or a virtual one that work drives."""

from __future__ import annotations

import contextlib
import ctypes
import math
import os
import threading
import time
from collections.abc import Iterator
from typing import Any, Protocol

RATE_HZ = 100.0  # ticks a second of a run where no others are asked for; chosen
_CLOCK_MONOTONIC = 1  # Linux, <time.h>
_TIMER_ABSTIME = 1  # Linux, <time.h>
_PR_SET_TIMERSLACK = 29  # Linux, <sys/prctl.h>
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


class StandstillClock(MonotonicClock):
    """The monotonic clock without the time in which this process could not run.

    Between two looks at it at most ``longest_step_s`` pass. A sleep that was asked for passes in full; what it lasts
    longer is a step like any other. The rest is a standstill: the scheduler ran something else, somebody stopped the
    process, or one computation held it up. A host and a simulated board in one process stand still together: on this
    clock no tick is late and no watchdog runs out for it.

    One thread drives the clock, the one that made it. Others may look at it and move nothing.
    """

    def __init__(self, longest_step_s: float) -> None:
        super().__init__()
        self._longest_step_s = longest_step_s
        self._driver = threading.get_ident()
        # Monotonic time up to which everything is accounted for (in a sleep: its end), and what was left out until
        # then. One tuple, replaced whole: a look of another thread, or of a signal handler, finds both or neither new.
        self._accounted = time.monotonic(), 0.0

    @property
    def left_out_s(self) -> float:
        """All standstills so far."""
        return self._accounted[1]

    def now_s(self) -> float:
        while True:
            # Before the time: what is left out until later would be too much for it.
            state = accounted_s, left_out_s = self._accounted
            real_s = time.monotonic()
            left_out_s += max(0.0, real_s - accounted_s - self._longest_step_s)
            new = max(real_s, accounted_s), left_out_s
            if threading.get_ident() != self._driver:
                return real_s - left_out_s
            if self._accounted is state:  # else a signal's handler has looked meanwhile: look again
                self._accounted = new
                return real_s - left_out_s

    def sleep_until(self, t_s: float) -> None:
        while self.now_s() < t_s:
            accounted_s, left_out_s = self._accounted
            wake_s = t_s + left_out_s
            while wake_s - left_out_s < t_s:  # rounded down: it would be a hair too early for ever
                wake_s = math.nextafter(wake_s, math.inf)
            if wake_s > accounted_s:
                self._accounted = wake_s, left_out_s
            try:
                super().sleep_until(wake_s)
            finally:
                self.now_s()
                accounted_s, left_out_s = self._accounted
                real_s = time.monotonic()
                if accounted_s > real_s:  # a signal's handler has raised in mid-sleep: the rest is not slept
                    self._accounted = real_s, left_out_s


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
