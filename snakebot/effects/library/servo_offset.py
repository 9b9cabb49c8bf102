"""A horn one tooth off."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from snakebot.arrays import Floats
from snakebot.effects.effect import Effect
from snakebot.effects.parameter import Parameter
from snakebot.physics import servo_layout as layout

if TYPE_CHECKING:
    from snakebot.effects.effect import Start
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


class ServoOffset(Effect):
    name = "servo_offset"
    example = "servo_offset:offset_deg=5,joints=1"
    stage = "servo"
    everyday = True
    summary = "The joint really stands at an angle from where it is told: horn or trim."
    title = "a joint that stands off"
    sentence = "{where} [stands|stand] {offset_deg} from where [it is|they are] told to be"
    look = "Look at the horn on its spline and at the zero (trim) of the servo; command 0 deg and measure."
    mark = "Measured minus commanded angle has the same mean at all speeds, and the robot curves."
    confused_with = (
        ("encoder_offset", "only the reading is off: without a pose the two cannot be told apart"),
        ("compliance", "gravity sag on a loaded axis; absent on a vertical one"),
    )
    parameters = (
        Parameter(
            "offset_deg",
            "deg",
            -45.0,
            45.0,
            "joint angle minus set-point",
            typical=0.0,
            spread=5.0,
            words="off by",
        ),
    )

    def write_servo(self, rows: Floats, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
        rows[joints, layout.OFFSET_RAD] = math.radians(spec.value("offset_deg"))

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        offset = math.degrees(observed.over(observed.offset_rad, joints, 0.0))
        return [{"offset_deg": self.parameters[0].clip(offset if abs(offset) > 0.2 else 1.0)}]


EFFECT = ServoOffset()
