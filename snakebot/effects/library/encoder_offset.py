"""Encoders with the wrong zero."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from snakebot.effects.effect import Affine, Effect, on_joints
from snakebot.effects.parameter import Parameter

if TYPE_CHECKING:
    from snakebot.effects.effect import Start
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


class EncoderOffset(Effect):
    name = "encoder_offset"
    example = "encoder_offset:offset_deg=3,joints=1"
    stage = "sensor"
    summary = "The reading is off by an angle; the joint itself is right."
    title = "an encoder that reads off"
    sentence = "The [encoder|encoders] of {on} [reads|read] {offset_deg} off; the motion itself is right"
    look = "Put the joint straight by a ruler and read it: look at the encoder's zero and its magnet or disc."
    mark = "A constant difference between measured and commanded angle while the robot runs straight."
    confused_with = (("servo_offset", "the joint really is off: the robot curves"),)
    parameters = (
        Parameter(
            "offset_deg",
            "deg",
            -180.0,
            180.0,
            "reading minus joint angle",
            typical=0.0,
            spread=5.0,
            words="reads off by",
            in_mjcf="numeric encoder_offset_rad, entry {j}, in rad",
        ),
    )

    def sensor_filter(self, spec: EffectSpec, robot: Robot) -> Affine:
        joints = spec.joint_indices(robot.joints)
        return Affine(offset_rad=on_joints(math.radians(spec.value("offset_deg")), joints, robot.joints, 0.0))

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        offset = math.degrees(observed.over(observed.offset_rad, joints, 0.0))
        return [{"offset_deg": self.parameters[0].clip(offset if abs(offset) > 0.2 else 1.0)}]


EFFECT = EncoderOffset()
