"""A set-point taken by a board that nobody hears, just before a real one is due.

What a processor has not run for some milliseconds is no longer in its caches, and Python is a lot of code: the first
answer after a pause takes two to three times as long as the next one. The microcontroller of a real board knows no
such pause. So the simulated one does just before what it will have to do: same code, other data.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from firmware_protocol.assembly import SEQUENCE_MASK
from firmware_protocol.catalogue import Mode, ModeRequest, encode
from firmware_protocol.framing import StreamDecoder, pack_all
from firmware_protocol.whole_tick import SetpointWriter
from snakebot.robot import Robot
from snakebot.softboard.board import SoftBoard
from snakebot.softboard.plant import make_plant

_INTERVAL_S = 0.01  # of set-points: the default rate of a run
_HOST = 1  # any number but zero


class Rehearsal:
    """The way of a set-point from bytes to bytes, as often as wanted; nothing of it can be seen.

    Args:
        simulated: behind the board whose part is rehearsed are simulated joints: theirs is rehearsed with it.
    """

    def __init__(self, robot: Robot, *, simulated: bool = False) -> None:
        plant = make_plant(robot, (), 0, None) if simulated else _Still(robot.joints)
        self._board = SoftBoard(robot, plant=plant)
        self._decoder = StreamDecoder().quicken()
        self._setpoints = SetpointWriter(robot.joints)
        self._angles_rad = [0.0] * robot.joints
        self._ticks = 0
        self._board.receive(encode(ModeRequest(0, Mode.ARMED, _HOST)), 0.0)

    def once(self) -> int:
        """Take one set-point; the number of bytes of the answer."""
        self._ticks += 1
        now_s = self._ticks * _INTERVAL_S
        written = self._setpoints.write(self._ticks & SEQUENCE_MASK, self._angles_rad, _INTERVAL_S)
        assert written is not None
        self._board.take(self._decoder.feed(pack_all(written[0])), now_s)
        return len(pack_all(self._board.advance(now_s)))


class _Still:
    """Joints that stay where they are; with a pose, as that is part of an answer."""

    clock_ppm = 0.0

    def __init__(self, joints: int) -> None:
        self._counts = [0] * joints

    def command(self, t_s: float, setpoint_rad: Sequence[float]) -> None: ...

    def set_joint_mode(self, joint: int, mode: Literal["active", "free"], /) -> None: ...

    def advance(self, t_s: float) -> None: ...

    def encoder_counts(self) -> list[int]:
        return self._counts

    def pose(self) -> tuple[float, float, float, float]:
        return 0.0, 0.0, 0.0, 0.0
