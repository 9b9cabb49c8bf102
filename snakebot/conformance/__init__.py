"""The conformance suite: what PROTOCOL.md promises, asked of any board over the wire.

``cases()`` are plain functions on a ``Bench`` (a link, a clock, and what the lab can do besides: push raw bytes, press
reset). ``run_case`` runs one. The tests run them against every board of this project, ``snakebot board test`` against
the one on the user's bench.
"""

from __future__ import annotations

from snakebot.conformance.bench import Bench
from snakebot.conformance.case import Case, Outcome, Verdict, cases, run_case
from snakebot.conformance.lab import Lab, Plate
from snakebot.conformance.violations import HostStalledError, NotApplicableError, ViolationError

__all__ = [
    "Bench",
    "Case",
    "HostStalledError",
    "Lab",
    "NotApplicableError",
    "Outcome",
    "Plate",
    "Verdict",
    "ViolationError",
    "cases",
    "run_case",
]
