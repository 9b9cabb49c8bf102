"""The joint faults of one run: those of its time table, and those that are asked for meanwhile."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import replace

from snakebot.board import Board
from snakebot.control.faults import JointFault, check_faults
from snakebot.control.journal import Journal
from snakebot.robot import Robot


class FaultSchedule:
    """Brings about joint faults when they are due.

    Raises:
        BadInputError: see ``check_faults``.
    """

    def __init__(self, faults: Sequence[JointFault], robot: Robot, board: Board, journal: Journal) -> None:
        check_faults(faults, robot)
        self._robot = robot
        self._board = board
        self._journal = journal
        self._waiting = sorted(faults, key=lambda fault: fault.at_s)
        self._changing = threading.Lock()  # pages and keys ask from other threads

    def request(self, fault: JointFault) -> None:
        """Have it with the next tick, whatever its own time is. Raises: BadInputError: see ``check_faults``."""
        check_faults([fault], self._robot)
        with self._changing:
            self._waiting.insert(0, replace(fault, at_s=0.0))

    def due(self, t_s: float) -> list[JointFault]:
        """Those that have become due; each is handed out once."""
        with self._changing:
            due = [fault for fault in self._waiting if fault.at_s <= t_s]
            self._waiting = self._waiting[len(due) :]
        return due

    def set(self, fault: JointFault, *, wait: bool) -> None:
        """Tell the board. Raises: BoardFaultError: it refuses (without ``wait``, a later ``poll`` raises it)."""
        for joint in fault.joints:
            self._board.set_joint_mode(joint, fault.mode, fault.angle_rad, wait=wait)
        names = "+".join(map(str, fault.joints))
        mode = fault.mode.name.lower()
        data = {"joints": list(fault.joints), "mode": mode, "angle_rad": fault.angle_rad}
        words = mode.replace("rigid_here", "rigid where it stands")
        self._journal.event("joint_mode", f"joint {names}: {words}", data=data)
