"""Poses of the robot as they come, and what they are on average over one cycle: the body undulates."""

from __future__ import annotations

import itertools
import math
from collections import deque
from typing import NamedTuple

STALE_S = 0.5  # a pose source that has said nothing for so long is stale
_KEPT_A_CYCLE = 128  # a faster source is thinned: the mean of a cycle is to take no part of a tick
_COVERED = 0.9  # share of a cycle that must be covered by poses; chosen
# What a robot cannot do from one pose to the next; a pose beyond it is damaged, or the robot was put elsewhere.
_JUMP_M, _FASTEST_M_S = 0.1, 2.0  # chosen: a jump of this and what the speed makes in between
_JUMP_RAD, _FASTEST_RAD_S = math.radians(30), 6.0
_BELIEVED = 3  # poses in a row that agree with each other and not with those before; chosen


class TimedPose(NamedTuple):
    """Centre of mass and mean link angle at one time (s since the motion began)."""

    t_s: float
    x_m: float
    y_m: float
    heading_rad: float


class CycleMean(NamedTuple):
    """What a cycle's poses come to.

    Attributes:
        end_s: the cycle's end: the last pose.
        x_m, y_m, heading_rad: means over the cycle, the heading unwrapped from pose to pose.
        dx_m, dy_m: from the cycle's start to its end; 0 where not a whole cycle is known.
        whole: whether a whole cycle is known.
    """

    end_s: float
    x_m: float
    y_m: float
    heading_rad: float
    dx_m: float
    dy_m: float
    whole: bool


class PoseWindow:
    """The poses of the last cycle, each looked at before it is believed.

    Attributes:
        doubted: poses that were too far from the one before to be believed, as long as they stood alone.
    """

    def __init__(self, period_s: float) -> None:
        self.doubted = 0
        self._poses: deque[TimedPose] = deque()
        self._odd: list[TimedPose] = []
        self._last: TimedPose | None = None
        self.set_period(period_s)

    def set_period(self, period_s: float) -> None:
        """Another gait has another cycle."""
        self._period_s = period_s
        self._thin_s = period_s / _KEPT_A_CYCLE

    @property
    def last(self) -> TimedPose | None:
        """The last pose that was believed."""
        return self._last

    def stale(self, now_s: float) -> bool:
        """Whether nothing has been believed for too long."""
        return self._last is None or now_s - self._last.t_s > STALE_S

    def add(self, pose: TimedPose) -> bool:
        """Take in a pose. Returns whether it is believed; one of times past is not."""
        last = self._last
        if last is not None:
            if pose.t_s < last.t_s:
                return False
            gap_s = pose.t_s - last.t_s
            if gap_s > STALE_S:
                self._poses.clear()  # nobody knows the way in between
            elif _jumps(last, pose):
                self.doubted += 1
                if self._odd and _jumps(self._odd[-1], pose):
                    self._odd.clear()
                self._odd.append(pose)
                if len(self._odd) < _BELIEVED:
                    return False
                self._poses.clear()  # it has been put elsewhere
            pose = pose._replace(heading_rad=_near(pose.heading_rad, last.heading_rad))
        self._odd.clear()
        self._last = pose
        if not self._poses or pose.t_s - self._poses[-1].t_s >= self._thin_s * 0.999:
            self._poses.append(pose)
            while len(self._poses) > 2 and self._poses[1].t_s <= pose.t_s - self._period_s:
                self._poses.popleft()
        return True

    def mean(self) -> CycleMean | None:
        """Over the last cycle, or over what is known of it; None where nothing is."""
        if not self._poses:
            return None
        poses, end_s = list(self._poses), self._poses[-1].t_s
        begin_s = end_s - self._period_s
        whole = poses[0].t_s <= begin_s + (1 - _COVERED) * self._period_s
        if len(poses) > 1 and poses[0].t_s < begin_s:
            first, second = poses[0], poses[1]
            share = (begin_s - first.t_s) / (second.t_s - first.t_s)
            poses[0] = TimedPose(
                begin_s, *(a + share * (b - a) for a, b in zip(first[1:], second[1:], strict=True))
            )
        span_s = end_s - poses[0].t_s
        if span_s <= 0:
            return CycleMean(*poses[-1], 0.0, 0.0, False)
        sums = [0.0, 0.0, 0.0]
        for before, after in itertools.pairwise(poses):
            half = 0.5 * (after.t_s - before.t_s)
            for column in range(3):
                sums[column] += half * (before[column + 1] + after[column + 1])
        x, y, heading = (total / span_s for total in sums)
        scale = self._period_s / span_s if whole else 0.0
        dx, dy = (scale * (poses[-1][column] - poses[0][column]) for column in (1, 2))
        return CycleMean(end_s, x, y, heading, dx, dy, whole)


def _near(angle_rad: float, to_rad: float) -> float:
    """The same angle, whole turns apart, that is nearest to another."""
    return to_rad + math.remainder(angle_rad - to_rad, math.tau)


def _jumps(before: TimedPose, after: TimedPose) -> bool:
    since_s = after.t_s - before.t_s
    way = math.hypot(after.x_m - before.x_m, after.y_m - before.y_m)
    turn = abs(math.remainder(after.heading_rad - before.heading_rad, math.tau))
    return way > _JUMP_M + _FASTEST_M_S * since_s or turn > _JUMP_RAD + _FASTEST_RAD_S * since_s
