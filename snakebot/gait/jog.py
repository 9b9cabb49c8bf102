"""A motion that is made up while it runs: steps of single joints, each spread over half a second."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.gait.blend import blend
from snakebot.gait.motion import Motion

STEP_S = 0.5  # that one step of a joint takes; chosen
LONGEST_JOG_S = 3600.0  # an hour; chosen


class JogMotion(Motion):
    """Starts at rest and stays there; each ``step`` moves one joint on.

    Args:
        start_rad: the posture that it starts from, one angle a joint.
        limit_rad: how far each joint may be sent to either side.
    """

    def __init__(self, start_rad: Sequence[float], limit_rad: Sequence[float]) -> None:
        self.joints = len(start_rad)
        self.duration_s = LONGEST_JOG_S
        self._start_rad = list(start_rad)
        self._limit_rad = list(limit_rad)
        self._target_rad = list(start_rad)
        self._steps: list[tuple[int, float, float]] = []  # joint, when, by how much

    @property
    def target_rad(self) -> tuple[float, ...]:
        """Where the steps so far lead."""
        return tuple(self._target_rad)

    def step(self, joint: int, t_s: float, by_rad: float) -> None:
        """Move a joint (from 1) on, from ``t_s`` on.

        Raises:
            BadInputError: beyond its limit; nothing changes.
        """
        wanted = self._target_rad[joint - 1] + by_rad
        limit = self._limit_rad[joint - 1]
        if abs(wanted) > limit and abs(wanted) > abs(self._target_rad[joint - 1]):
            raise BadInputError(f"joint {joint} is at its limit")
        self._target_rad[joint - 1] = wanted
        self._forget(t_s)
        self._steps.append((joint - 1, t_s, by_rad))

    def _forget(self, t_s: float) -> None:
        """Steps that are done become part of the start."""
        live = []
        for joint, at_s, by_rad in self._steps:
            if t_s - at_s > 2 * STEP_S:
                self._start_rad[joint] += by_rad
            else:
                live.append((joint, at_s, by_rad))
        self._steps = live

    def angles(self, t_s: float) -> list[float]:
        angles = list(self._start_rad)
        for joint, at_s, by_rad in list(self._steps):
            angles[joint] += by_rad * blend((t_s - at_s) / STEP_S)
        return angles

    def sampled(self, t_s: Floats) -> Floats:
        if self._steps:
            return super().sampled(t_s)
        return np.tile(np.array(self._start_rad), (len(t_s), 1))

    def ended(self, t_s: float) -> Motion:
        self.duration_s = t_s + STEP_S
        return self
