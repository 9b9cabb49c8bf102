"""The motion of a run while it streams: it may go over to another gait, and end early; other threads ask for both."""

from __future__ import annotations

import contextlib
import threading

from snakebot.control.guiding import Guide
from snakebot.control.journal import Journal
from snakebot.control.progress import Progress
from snakebot.errors import BadInputError
from snakebot.gait import Gait, GaitMotion, Motion, check_motion
from snakebot.robot import Robot

_CHANGE_AHEAD_S = (0.25, 1.0, 4.0)  # time to check a new gait before it begins; more for a long run; chosen


class StreamedMotion:
    """The motion that the loop makes set-points of.

    Args:
        guide: steers it; None: nobody does.

    Attributes:
        now: the motion as it is; one of no joint until the loop puts the real one here.
    """

    def __init__(self, robot: Robot, progress: Progress, journal: Journal, guide: Guide | None) -> None:
        self.now: Motion = GaitMotion(Gait(0, 0, 0), robot.joints, 0, 0)
        self._robot = robot
        self._progress = progress
        self._journal = journal
        self._guide = guide
        self._changing = threading.Lock()  # of the motion: keys and signals come from elsewhere

    @property
    def gait(self) -> Gait | None:
        """The gait that was asked for last; None for a motion that is no gait."""
        return self.now.gait if isinstance(self.now, GaitMotion) else None

    def change(self, gait: Gait, blend_s: float) -> None:
        """Go over to another gait without a jump, as soon as the change before has blended in.

        Asked for several times meanwhile, the last one counts.

        Raises:
            BadInputError: the motion is not a gait, the new gait breaks a limit, or checking that took so long that the
                change would begin in the past; the run goes on as it was.
        """
        motion = self.now
        if not isinstance(motion, GaitMotion):
            raise BadInputError("only a running gait can be changed")
        with self._guide.standing_still() if self._guide is not None else contextlib.nullcontext():
            self._change(motion, gait, blend_s)

    def _change(self, motion: GaitMotion, gait: Gait, blend_s: float) -> None:
        for ahead_s in _CHANGE_AHEAD_S:
            soonest_s = self._progress.t_s + ahead_s
            base = motion.unchanged_from(soonest_s)
            start_s = max(soonest_s, base.settled_s)
            changed = base.changed(start_s, gait, blend_s)
            check_motion(changed, self._robot, start_s)
            if self._guide is not None:
                self._guide.prepare(changed)
            if self._progress.t_s < soonest_s:
                break
        else:
            raise BadInputError("this computer was too slow to check the new gait in time: try again")
        with self._changing:
            if self.now is not motion:  # a stop came in between
                return
            self.now = changed
        self._journal.event("gait", f"changed to {gait}", data=gait.plain())

    def end(self, t_s: float) -> None:
        """Ramp down from here on."""
        with self._changing:
            self.now = self.now.ended(t_s)
