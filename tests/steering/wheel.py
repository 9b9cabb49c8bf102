"""A robot without a body for tests of the law: it turns in proportion to the offset, undulates, and slips aside."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Floats
from snakebot.gait import OffsetTrack
from snakebot.steering import Course
from snakebot.steering.authority import Authority
from snakebot.steering.law import Decision, SteeringLaw
from snakebot.steering.poses import PoseWindow, TimedPose
from snakebot.steering.response import Response

MODEL = Response(1.15, 0.0, 0.17, math.pi, 0.96)  # as the built-in robot at (37, 80, 2)
ROOM = Authority(-math.radians(30), math.radians(30), math.radians(60), 1.0)
UNDULATION_RAD = math.radians(6)
POSE_S = 0.02


@dataclass
class Wheel:
    """What the robot really is; the law believes ``model``."""

    model: Response = MODEL
    turn_share: float = 1.0  # of what the model has
    bias_rad_s: float = 0.0
    slip_rad: float = 0.0
    speed_share: float = 1.0
    ramp_s: float = 2.0

    def run(
        self, course: Course, start: tuple[float, float, float], cycles: int = 12, room: Authority = ROOM
    ) -> tuple[Floats, list[Decision]]:
        """Cycle means (decisions, 3: end_s, cross-track or 0, heading) and the decisions."""
        model, period = self.model, self.model.period_s
        law, window, track = SteeringLaw(course, model, self.ramp_s), PoseWindow(period), OffsetTrack()
        x, y, heading = start
        seen: list[tuple[float, float, float]] = []
        decisions: list[Decision] = []
        due_s = 0.0
        for step in range(int((cycles + 1) * period / POSE_S)):
            t = step * POSE_S
            share = min(t / self.ramp_s, 1.0)
            swing = share * UNDULATION_RAD * math.sin(math.tau * t / period)
            window.add(TimedPose(t, x, y, heading + swing))
            if t >= due_s:
                mean = window.mean()
                assert mean is not None
                decision = law.decide(mean, t, track, room)
                if t == 0:
                    track.change(0.0, decision.offset_rad, 0.0)
                else:
                    track.change(t, decision.offset_rad, room.blend_s)
                due_s = max(self.ramp_s, period) if t == 0 else due_s + period
                decisions.append(decision)
                seen.append((t, course.cross_track_m(mean.x_m, mean.y_m) or 0.0, mean.heading_rad))
            rate = self.turn_share * model.turn_per_offset_1_s * track.at(t) + self.bias_rad_s
            heading += share * rate * POSE_S
            way = share * self.speed_share * model.speed_m_s * POSE_S
            x += way * math.cos(heading + swing + self.slip_rad)
            y += way * math.sin(heading + swing + self.slip_rad)
        return np.array(seen), decisions
