"""A dead servo."""

from __future__ import annotations

from typing import TYPE_CHECKING

from snakebot.effects.effect import Effect
from snakebot.physics import servo_layout as layout

if TYPE_CHECKING:
    from snakebot.effects.effect import Vector
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


class JointFree(Effect):
    name = "joint_free"
    example = "joint_free:joints=3"
    stage = "servo"
    summary = "The joint has no torque and swings freely."
    mark = (
        "The joint's angle has nothing to do with its set-point; it drifts with the motion of its neighbours."
    )
    confused_with = (("joint_rigid", "does not move at all"),)

    def write_servo(self, rows: Vector, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
        rows[joints, layout.LOCKED] = layout.FREE_JOINT


EFFECT = JointFree()
