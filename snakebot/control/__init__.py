"""A run: set-points out on absolute deadlines, readings back, a log, and a safe end whatever happens.

``record`` makes one on a board that ``open_board`` gives; ``plan_run`` and ``plan_replay`` say what it is to do.

Names load on first use: `snakebot stop` needs the registry at once, and no run loop.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from snakebot.lazy import names_from

if TYPE_CHECKING:
    from snakebot.control.attending import Attendant
    from snakebot.control.faults import JointFault, parse_fault
    from snakebot.control.loop import RunLoop, RunResult
    from snakebot.control.plans import RunPlan, plan_replay, plan_run
    from snakebot.control.ports import open_board
    from snakebot.control.progress import Progress
    from snakebot.control.recording import RecordedRun, RunSettings, check_run, record

__all__ = [
    "Attendant",
    "JointFault",
    "Progress",
    "RecordedRun",
    "RunLoop",
    "RunPlan",
    "RunResult",
    "RunSettings",
    "check_run",
    "open_board",
    "parse_fault",
    "plan_replay",
    "plan_run",
    "record",
]

__getattr__ = names_from(
    __name__,
    {
        "Attendant": "attending",
        "JointFault": "faults",
        "Progress": "progress",
        "RecordedRun": "recording",
        "RunLoop": "loop",
        "RunPlan": "plans",
        "RunResult": "loop",
        "RunSettings": "recording",
        "check_run": "recording",
        "open_board": "ports",
        "parse_fault": "faults",
        "plan_replay": "plans",
        "plan_run": "plans",
        "record": "recording",
    },
)
