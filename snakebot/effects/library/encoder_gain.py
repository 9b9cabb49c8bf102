"""Encoders with the wrong counts per revolution."""

from __future__ import annotations

from typing import TYPE_CHECKING

from snakebot.effects.effect import Affine, Effect, on_joints
from snakebot.effects.parameter import Parameter

if TYPE_CHECKING:
    from snakebot.effects.effect import Start
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


class EncoderGain(Effect):
    name = "encoder_gain"
    example = "encoder_gain:gain=1.1,joints=5"
    stage = "sensor"
    summary = "The reading is gain times the joint angle; the joint itself is right."
    title = "an encoder of wrong scale"
    sentence = (
        "The [encoder|encoders] of {on} [reads|read] {gain} times the true angle; the motion itself is right"
    )
    look = "Look at the counts per turn in the description; turn the joint by 90 deg by hand and read it."
    mark = "As a gain on the command, but speed and path stay those of the full motion."
    confused_with = (("command_gain", "the joint really moves less: speed or pose tells"),)
    parameters = (
        Parameter(
            "gain",
            "",
            0.2,
            3.0,
            "reading over joint angle",
            typical=1.0,
            spread=0.1,
            scale="log",
            neutral=1.0,
            words="read over true",
            in_mjcf="numeric encoder_gain, entry {j}",
        ),
    )

    def sensor_filter(self, spec: EffectSpec, robot: Robot) -> Affine:
        joints = spec.joint_indices(robot.joints)
        return Affine(gain=on_joints(spec.value("gain"), joints, robot.joints, 1.0))

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        gain = self.parameters[0].clip(observed.over(observed.gain, joints, 1.0))
        return [{"gain": gain if abs(gain - 1) > 0.02 else 0.95}]


EFFECT = EncoderGain()
