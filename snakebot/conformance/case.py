"""A case: one promise of PROTOCOL.md and the function that asks for it."""

from __future__ import annotations

import contextlib
import importlib
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from functools import cache

from snakebot.conformance.bench import Bench
from snakebot.conformance.violations import HostStalledError, NotApplicableError, ViolationError

_MODULES = ("identity", "frames", "setpoints", "watchdog", "modes", "joints", "limits", "reboot")
_TRIES = 5  # of a case in which this computer, not the board, was late

Function = Callable[[Bench], None]


@dataclass(frozen=True, slots=True)
class Case:
    """One promise. ``long`` cases take more than a few seconds on a real wire."""

    name: str
    rule: str  # what a board must do
    function: Function
    long: bool = False


_registered: dict[str, Case] = {}


def case(rule: str, *, long: bool = False) -> Callable[[Function], Function]:
    """Register a function as a case; its name is the case's."""

    def register(function: Function) -> Function:
        name = function.__name__
        assert name not in _registered, name
        _registered[name] = Case(name, rule, function, long)
        return function

    return register


@cache
def cases() -> tuple[Case, ...]:
    """All cases, in the order in which a firmware author would want to see them."""
    for module in _MODULES:
        importlib.import_module(f"snakebot.conformance.{module}")
    return tuple(_registered.values())


class Verdict(Enum):
    PASSED = "passed"
    FAILED = "failed"
    SKIPPED = "skipped"


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of one case. ``traffic`` are the last frames before a failure, decoded."""

    case: Case
    verdict: Verdict
    detail: str = ""
    traffic: tuple[str, ...] = ()


def run_case(case: Case, bench: Bench) -> Outcome:
    """Bring the board to a known state, ask, and bring it back, whatever happened.

    Raises:
        SnakebotError: the link is gone.
    """
    for attempt in range(_TRIES):
        try:
            bench.fresh()
            case.function(bench)
            bench.fresh()
            return Outcome(case, Verdict.PASSED)
        except NotApplicableError as reason:
            return Outcome(case, Verdict.SKIPPED, str(reason))
        except HostStalledError as stall:
            if attempt == _TRIES - 1:
                return Outcome(case, Verdict.SKIPPED, f"this computer is too busy to measure it: {stall}")
        except ViolationError as violation:
            if bench.stalled_s() > bench.stall_s and attempt < _TRIES - 1:
                continue  # we were late ourselves: what was seen proves nothing
            traffic = tuple(bench.traffic())
            with contextlib.suppress(ViolationError):  # the case has failed already; the next one finds out
                bench.make_safe()
            return Outcome(case, Verdict.FAILED, str(violation), traffic)
    raise AssertionError("not reached")
