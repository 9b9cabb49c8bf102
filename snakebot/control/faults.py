"""Joint faults on a time table: ``free:3``, ``rigid:4+5``, ``rigid:2=30``, ``rigid:4@12s``, ``clear@20s``.

They go to the board over the protocol, so they are the same on a real robot: free is a servo without power, rigid one
that is held.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from firmware_protocol.catalogue import JointMode
from snakebot.errors import BadInputError
from snakebot.nearest import did_you_mean

if TYPE_CHECKING:
    from snakebot.robot import Robot

_KINDS = ("free", "rigid", "clear")
_GRAMMAR = re.compile(
    rf"(?P<kind>{'|'.join(_KINDS)})"
    r"(?::(?P<joints>\d{1,9}(?:\+\d{1,9})*)(?:=(?P<angle>[-+]?\d+(?:\.\d*)?))?)?"
    r"(?:@(?P<at>\d{1,9}(?:\.\d*)?)s?)?"
)
_EXAMPLES = "free:3, rigid:4+5, rigid:2=30 (degrees), rigid:4@12s, clear@20s"


@dataclass(frozen=True, slots=True)
class JointFault:
    """From ``at_s`` on, these joints (from 1) are in this mode. At 0 it holds from before the robot is armed."""

    at_s: float
    joints: tuple[int, ...]
    mode: JointMode
    angle_rad: float = 0.0

    def __str__(self) -> str:
        """In the grammar of ``--fault``."""
        kind = {JointMode.FREE: "free", JointMode.ACTIVE: "clear"}.get(self.mode, "rigid")
        angle = (
            f"={math.degrees(self.angle_rad):g}" if self.mode is JointMode.RIGID and self.angle_rad else ""
        )
        if self.mode is JointMode.RIGID and not self.angle_rad and self.at_s > 0:
            angle = "=0"  # without an angle it would be held where it is
        at = f"@{self.at_s:g}s" if self.at_s > 0 else ""
        return f"{kind}:{'+'.join(map(str, self.joints))}{angle}{at}"


def check_faults(faults: Sequence[JointFault], robot: Robot, duration_s: float = math.inf) -> None:
    """What every joint fault has to keep, wherever it was asked for.

    Args:
        duration_s: of the run, where it is known.

    Raises:
        BadInputError: there is no such joint, one is to be held beyond its limit (a board refuses that), or the
            fault would come only when the run is over: its log would name a fault that never was.
    """
    for fault in faults:
        if fault.at_s >= duration_s:
            raise BadInputError(
                f"--fault {fault}: the run is over after {duration_s:.4g} s; give an earlier time or a longer run"
            )
        for joint in fault.joints:
            if not 1 <= joint <= robot.joints:
                raise BadInputError(
                    f"--fault {fault}: there is no joint {joint}; robot {robot.name!r} has joints 1 to {robot.joints}"
                )
            limit = robot.angle_limit_rad[joint - 1]
            if fault.mode is JointMode.RIGID and abs(fault.angle_rad) > limit:
                raise BadInputError(
                    f"--fault rigid:{joint}={math.degrees(fault.angle_rad):g}: robot {robot.name!r} allows "
                    f"{math.degrees(limit):.4g} deg"
                )


def parse_fault(text: str, joints: int) -> JointFault:
    """One ``--fault``.

    A rigid joint is held straight when it is rigid from the start, and where it is when it becomes so in mid-run,
    unless an angle is given. ``clear`` without joints clears all.

    Raises:
        BadInputError: not in the grammar, or a joint that the robot does not have.
    """
    match = _GRAMMAR.fullmatch(text.strip())
    if match is None or (match["joints"] is None) != (match["kind"] == "clear" and match["joints"] is None):
        kind = re.split("[:@]", text.strip(), maxsplit=1)[0]
        hint = "" if kind in _KINDS else did_you_mean(kind, _KINDS)
        example = f"{hint} Give" if hint else "; give"
        raise BadInputError(f"--fault {text!r}: not understood{example} for example {_EXAMPLES}")
    chosen = tuple(range(1, joints + 1))
    if match["joints"] is not None:
        chosen = tuple(dict.fromkeys(int(joint) for joint in match["joints"].split("+")))
    for joint in chosen:
        if not 1 <= joint <= joints:
            raise BadInputError(
                f"--fault {text!r}: there is no joint {joint}; the robot has joints 1 to {joints}"
            )
    at_s = float(match["at"] or 0)
    if match["kind"] != "rigid":
        if match["angle"] is not None:
            raise BadInputError(f"--fault {text!r}: only a rigid joint has an angle")
        return JointFault(at_s, chosen, JointMode.FREE if match["kind"] == "free" else JointMode.ACTIVE)
    if match["angle"] is None and at_s > 0:
        return JointFault(at_s, chosen, JointMode.RIGID_HERE)
    angle = float(match["angle"] or 0)
    if abs(angle) > 180:
        raise BadInputError(f"--fault {text!r}: {angle:g} deg is more than half a turn")
    return JointFault(at_s, chosen, JointMode.RIGID, math.radians(angle))
