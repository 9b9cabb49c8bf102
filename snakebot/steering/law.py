"""The law: from a cycle's mean pose to the offset of the next cycle, once a cycle.

Heading: proportional to the heading error, and an integral of what the model did not foresee. The error is taken where
the robot will head once the last change has blended in: the mean of a cycle is half a cycle old, and what the offsets
since have turned is known. Line: a cascade. Distance from the line gives a wanted heading, and that the offset; the
angle between where the body points and where it goes (on a slope it slips aside) is measured and added.

Both integrals are of a prediction's error, not of the course's: a robot that is still turning, or whose offset is at
its limit, winds nothing up.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from snakebot.gait.blend import blend
from snakebot.gait.offset_track import OffsetTrack
from snakebot.steering.authority import Authority
from snakebot.steering.course import Course
from snakebot.steering.poses import CycleMean
from snakebot.steering.response import Response

# In shares of a cycle's error, so that they hold for any robot and gait. Heading and track together then have both
# poles inside a circle of 0.5: an error halves at least with each cycle.
HEADING_GAIN = 0.9  # of the heading error is turned back within the next cycle
# Share of the distance from the line that is corrected within a cycle, if the heading follows at once; chosen.
TRACK_GAIN = 0.4
INTEGRAL_GAIN = 0.5  # of what the last cycle turned beyond the model's prediction counts as lasting
SLIP_GAIN = 0.5  # the same of the angle between heading and way
_MOST_SLIP_RAD = math.radians(40)  # angle between heading and way that is corrected at most; chosen
_LEAST_WAY = 0.02  # body lengths in a cycle: from less no direction can be taken
_POINTS = 24  # of the integrals over the offsets of the last two cycles
_CYCLE_TOLERANCE = 0.1  # by how much two decisions may be more or less than a cycle apart to be compared


class Decision(NamedTuple):
    """What is wanted, what is given, and why. ``cross_track_m`` is None without a line; positive: left of it."""

    offset_rad: float
    wanted_offset_rad: float
    heading_rad: float
    wanted_heading_rad: float
    error_rad: float
    cross_track_m: float | None

    @property
    def saturated(self) -> bool:
        """Whether limits keep the offset from what is wanted."""
        return abs(self.offset_rad - self.wanted_offset_rad) > 1e-9


class SteeringLaw:
    """One course, held by one gait of one robot.

    Args:
        ramp_s: from the start on the gait grows to its full size within this time.
    """

    def __init__(self, course: Course, response: Response, ramp_s: float) -> None:
        self.course = course
        self.response = response
        self._bias_rad_s = response.bias_rad_s
        self._slip_rad = 0.0
        self._from_s = self._ramp_s = ramp_s
        self._before: CycleMean | None = None
        end_s = max(ramp_s, response.period_s)
        step = end_s / _POINTS
        # For so long, at full size, the first offset acts: until the next decision, less what the ramp takes.
        self._first_acts_s = step * sum(self._size((number + 0.5) * step) for number in range(_POINTS))

    def take(self, response: Response) -> None:
        """Another gait: its own response, and what was learnt of the robot is kept."""
        self._bias_rad_s += response.bias_rad_s - self.response.bias_rad_s
        self.response = response
        self._before = None

    def decide(self, mean: CycleMean, now_s: float, track: OffsetTrack, authority: Authority) -> Decision:
        """The offset from ``now_s`` on, which ``track`` does not know yet."""
        model = self.response
        self._learn(mean, track)
        turning = model.turn_per_offset_1_s
        blending_s = 0.5 * authority.blend_s  # of the next cycle, in which the offset before still counts
        heading = mean.heading_rad
        if mean.whole:
            heading += self._turned_since(mean.end_s, now_s, track)
        heading += blending_s * (turning * track.target_rad + self._bias_rad_s) * (now_s > 0)
        wanted, cross_track = self._wanted(mean, heading, now_s)
        error = math.remainder(heading - wanted, math.tau)
        straight_rad = -self._bias_rad_s / turning
        acts_s = model.period_s - blending_s if now_s > 0 else self._first_acts_s
        offset = straight_rad - HEADING_GAIN * error / (turning * acts_s)
        given = self._given(offset, now_s, track, authority)
        shown = math.remainder(mean.heading_rad - wanted, math.tau)
        return Decision(given, offset, mean.heading_rad, wanted, shown, cross_track)

    def _given(self, offset_rad: float, now_s: float, track: OffsetTrack, authority: Authority) -> float:
        """What limits leave of an offset; the first one comes in with the wave, not as a change."""
        if now_s > 0:
            return authority.limited(offset_rad, track.target_rad)
        return min(max(offset_rad, authority.low_rad), authority.high_rad)

    def _wanted(self, mean: CycleMean, heading_rad: float, now_s: float) -> tuple[float, float | None]:
        """The heading that leads to the line, and how far from it the robot is by now."""
        course, model = self.course, self.response
        cross_track = course.cross_track_m(mean.x_m, mean.y_m)
        if cross_track is None:
            return course.heading_rad, None
        backwards = model.speed_m_s < 0
        if mean.whole:
            way_m = math.hypot(mean.dx_m, mean.dy_m) * (0.5 + (now_s - mean.end_s) / model.period_s)
            goes_rad = 0.5 * (mean.heading_rad + heading_rad) + self._slip_rad + math.pi * backwards
            ahead = cross_track + way_m * math.sin(goes_rad - course.heading_rad)
        else:
            ahead = cross_track
        cycle_m = abs(model.speed_m_s) * model.period_s
        turn = math.atan(TRACK_GAIN * ahead / cycle_m)
        return course.heading_rad - self._slip_rad + (turn if backwards else -turn), cross_track

    def _turned_since(self, end_s: float, now_s: float, track: OffsetTrack) -> float:
        """From the mean heading of the cycle up to ``end_s`` to the heading now, as the model has it."""
        period = self.response.period_s
        begin_s = end_s - period
        step = (now_s - begin_s) / _POINTS
        total = 0.0
        for number in range(_POINTS):
            t = begin_s + (number + 0.5) * step
            total += min((t - begin_s) / period, 1.0) * self._rate(t, track)
        return total * step

    def _size(self, t_s: float) -> float:
        """How much the gait turns at one time, as a share: as the square of its size while that grows."""
        since = self._from_s - t_s
        if since <= 0 or self._ramp_s <= 0:
            return 1.0
        return blend(1 - since / self._ramp_s) ** 2

    def _rate(self, t_s: float, track: OffsetTrack) -> float:
        """Turn rate at one time, as the model and what has been learnt have it."""
        return self._size(t_s) * (self.response.turn_per_offset_1_s * track.at(t_s) + self._bias_rad_s)

    def _learn(self, mean: CycleMean, track: OffsetTrack) -> None:
        """Compare the last cycle with what was to be expected of it."""
        before, self._before = self._before, mean
        model = self.response
        if not mean.whole:
            return
        way = math.hypot(mean.dx_m, mean.dy_m)
        if way >= _LEAST_WAY * model.body_m:
            goes = math.atan2(mean.dy_m, mean.dx_m) - math.pi * (model.speed_m_s < 0)
            slip = math.remainder(goes - mean.heading_rad, math.tau)
            if abs(slip) <= 2 * _MOST_SLIP_RAD:
                self._slip_rad += SLIP_GAIN * (slip - self._slip_rad)
                self._slip_rad = min(max(self._slip_rad, -_MOST_SLIP_RAD), _MOST_SLIP_RAD)
        if before is None or abs((mean.end_s - before.end_s) / model.period_s - 1) > _CYCLE_TOLERANCE:
            return
        step = 2 * model.period_s / _POINTS
        foreseen = 0.0
        for number in range(
            _POINTS
        ):  # the difference of two means weighs the rates of both cycles by a triangle
            back_s = (number + 0.5) * step
            weight = step * (1 - abs(back_s - model.period_s) / model.period_s)
            foreseen += weight * self._rate(mean.end_s - back_s, track)
        beyond = math.remainder(mean.heading_rad - before.heading_rad - foreseen, math.tau)
        self._bias_rad_s += INTEGRAL_GAIN * beyond / model.period_s
