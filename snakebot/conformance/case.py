"""A case: one promise of PROTOCOL.md and the function that asks for it."""

from __future__ import annotations

import contextlib
import importlib
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from functools import cache

from snakebot.clock import VirtualClock
from snakebot.conformance.bench import Bench
from snakebot.conformance.violations import HostStalledError, NotApplicableError, ViolationError

_MODULES = (
    "identity", "beats", "frames", "bad_frames", "setpoints", "unfinished", "watchdog", "feeding", "modes", "latches",
    "holder", "power", "by_hand", "one_by_hand", "joints", "trims", "every_joint", "trims_and_zeros", "requests",
    "limits", "limits_tape", "tracking", "clamping", "beside", "where", "reboot", "after_reset", "clock", "hardware",
    "faults_told",
)  # fmt: skip
_TRIES = 5  # of a case in which this computer, not the board, was late

Function = Callable[[Bench], None]


@dataclass(frozen=True, slots=True)
class Case:
    """One promise. ``long`` cases take more than a few seconds on a real wire; ``needs`` is what a bench must have."""

    name: str
    rule: str  # what a board must do
    function: Function
    long: bool = False
    needs: tuple[str, ...] = ()


_registered: dict[str, Case] = {}


_NEEDS = {
    "send_bytes": "raw bytes cannot be put on this link",
    "reset": "nobody here can reset the board: switch it off and on by hand, and look at its boot id",
    "reset_at": "nobody here can set the board's clock",
    "turn_joint": "nobody here can turn a joint by hand",
    "lose_encoder": "nobody here can unplug an encoder",
    "fail": "nobody here can break the board's hardware",
    "supply": "nobody here can change what the board's supply measures",
    "draw": "nobody here can tell the board what number to draw",
    "store_trim": "nobody here can damage what the board has stored",
    "plate": "nobody here knows what this board should say of itself",
}


def case(rule: str, *, long: bool = False, needs: tuple[str, ...] = ()) -> Callable[[Function], Function]:
    """Register a function as a case; its name is the case's."""

    def register(function: Function) -> Function:
        name = function.__name__
        assert name not in _registered, name
        _registered[name] = Case(name, rule, function, long, needs)
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
    for need in case.needs:
        if not bench.can(need):
            return Outcome(case, Verdict.SKIPPED, _NEEDS[need])
    for attempt in range(_TRIES):
        try:
            bench.fresh()
            case.function(bench)
            bench.fresh()
            return Outcome(case, Verdict.PASSED)
        except NotApplicableError as reason:
            return Outcome(case, Verdict.SKIPPED, str(reason))
        except HostStalledError as stall:
            if isinstance(bench.clock, VirtualClock):
                return Outcome(
                    case, Verdict.FAILED, f"time is virtual, and yet {stall}", tuple(bench.traffic())
                )
            if attempt == _TRIES - 1:
                return Outcome(case, Verdict.SKIPPED, f"this computer is too busy to measure it: {stall}")
        except ViolationError as violation:
            stalled = not isinstance(bench.clock, VirtualClock) and bench.stalled_s() > bench.stall_s
            if stalled and attempt < _TRIES - 1:
                continue  # we were late ourselves: what was seen proves nothing
            traffic = tuple(bench.traffic())
            with contextlib.suppress(ViolationError):  # the case has failed already; the next one finds out
                bench.make_safe()
            return Outcome(case, Verdict.FAILED, str(violation), traffic)
    raise AssertionError("not reached")
