"""Where a run's poses come from, the board or a program beside it, and who gets them."""

from __future__ import annotations

import math
from typing import Protocol

from snakebot.board import PoseReading
from snakebot.control.guiding import Guide
from snakebot.control.journal import Journal
from snakebot.control.progress import Progress
from snakebot.errors import BadInputError
from snakebot.steering.pose_line import SaidPose

WAIT_S = 3.0  # for the first pose of a run that holds a course; chosen


class PoseSource(Protocol):
    """Poses from outside; ``snakebot.steering.pose_udp.UdpPoses`` is one."""

    bad: int  # lines that were no pose

    def take(self) -> list[tuple[float, SaidPose]]:
        """What has come since the last call, with the host clock's time; must not wait."""
        ...


class PoseIntake:
    """The poses of one run. With a ``source``, the board's own do not count."""

    def __init__(
        self, source: PoseSource | None, guide: Guide | None, progress: Progress, journal: Journal
    ) -> None:
        self._source = source
        self._guide = guide
        self._progress = progress
        self._journal = journal

    def from_board(self, pose: PoseReading) -> None:
        """The board has said where the robot is."""
        if self._source is None:
            self._progress.pose = pose
            self._journal.pose(pose)
            if self._guide is not None:
                self._guide.see(self._journal.since_s, pose.x_m, pose.y_m, pose.heading_rad)

    def look(self) -> None:
        """Take what has come from outside; the log gets the last of it."""
        if self._source is None:
            return
        newest: SaidPose | None = None
        for came_s, newest in self._source.take():
            if self._guide is not None:
                at_s = came_s - self._journal.origin_s
                self._guide.see(at_s, newest.x_m, newest.y_m, newest.heading_rad)
        if newest is not None:
            pose = PoseReading(0, newest.x_m, newest.y_m, newest.heading_rad, math.nan)
            self._progress.pose = pose
            self._journal.pose(pose)
        bad = self._source.bad
        if bad and not self._progress.bad_poses:
            self._journal.event(
                "pose_damaged",
                "a line that came as a pose is none: left out, and counted from now on",
                "warning",
            )
        self._progress.bad_poses = bad

    @property
    def missing(self) -> bool:
        """Whether a course is to be held and no pose has come."""
        return self._guide is not None and not self._guide.has_pose

    def refused(self, where: str) -> BadInputError:
        """What is said where none comes."""
        assert self._guide is not None
        if self._source is not None:
            return BadInputError(
                f"{self._guide.course} cannot be held: no pose came within {WAIT_S:g} s ({self._source}): start the "
                "tracker first"
            )
        return BadInputError(
            f"{self._guide.course} cannot be held: {where}: the board tells no pose: give one with "
            "--pose udp://127.0.0.1:9000"
        )
