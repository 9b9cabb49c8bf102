"""A run's set-points, made before their deadlines: at a deadline there are bytes to send and nothing to compute."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from snakebot.board import Board, MadeSetpoint
from snakebot.control.progress import Progress
from snakebot.gait import Motion, SlewLimiter
from snakebot.robot import Robot

_LONGEST_INTERVAL_S = 0.1  # that a set-point declares


class Ready(NamedTuple):
    """A tick whose set-point is made."""

    tick: int
    wanted_rad: Sequence[float]  # before the limits
    made: MadeSetpoint


class Maker:
    """Makes the ticks of one run, within the robot's limits.

    A tick that is made and not sent (it was slept through) stays part of the path that the limits look at: the later
    one that is sent in its place goes on from there.
    """

    def __init__(self, board: Board, robot: Robot, interval_s: float, progress: Progress) -> None:
        # The motion is not rounded yet: the slack is left to the board, which sees it rounded.
        self._limiter = SlewLimiter(
            robot.angle_limit_rad, robot.speed_limit_rad_s, robot.acceleration_limit_rad_s2, slack_rad=0.0
        )
        self._board = board
        self._interval_s = interval_s
        self._progress = progress
        self._made = self._sent = -1  # ticks

    def start(self, start_rad: Sequence[float]) -> None:
        """The joints are at rest, here."""
        self._limiter.reset(start_rad)

    def make(self, motion: Motion, tick: int) -> Ready:
        """The set-point of a tick."""
        wanted = motion.angles(tick * self._interval_s)
        since_made_s = self._span_s(self._made, tick)
        executed = self._limiter.execute(wanted, since_made_s, 1, since_made_s)
        assert executed is not None  # the loop's own interval is never too short
        limited, clamped = executed
        self._progress.clamped += clamped
        self._made = tick
        return Ready(tick, wanted, self._board.make_setpoint(limited, self._span_s(self._sent, tick)))

    def sent(self, ready: Ready) -> None:
        """This one is on its way."""
        self._sent = ready.tick

    def _span_s(self, before: int, tick: int) -> float:
        return min((tick - before) * self._interval_s, _LONGEST_INTERVAL_S)
