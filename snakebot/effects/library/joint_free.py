"""A dead servo."""

from __future__ import annotations

from typing import TYPE_CHECKING

from snakebot.arrays import Floats
from snakebot.effects.effect import Effect
from snakebot.physics import servo_layout as layout

if TYPE_CHECKING:
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


class JointFree(Effect):
    name = "joint_free"
    example = "joint_free:joints=3"
    stage = "servo"
    fault = "free"
    summary = "The joint has no torque and swings freely."
    title = "a joint without torque"
    sentence = "{where} [has|have] no torque and [swings|swing] freely"
    look = (
        "Look at the servo's plug and supply, at its overload flag, and at whether the horn's screw is there."
    )
    mark = (
        "The joint's angle has nothing to do with its set-point; it drifts with the motion of its neighbours."
    )
    confused_with = (("joint_rigid", "does not move at all"),)

    def can_explain(self, observed: Observed) -> bool:
        """On a bench nothing would say how the joint swings."""
        return observed.robot.body is not None

    def write_servo(self, rows: Floats, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
        rows[joints, layout.LOCKED] = layout.FREE_JOINT


EFFECT = JointFree()
