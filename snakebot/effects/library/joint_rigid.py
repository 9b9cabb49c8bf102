"""A seized joint."""

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


class JointRigid(Effect):
    name = "joint_rigid"
    example = "joint_rigid:angle_deg=20,joints=2"
    stage = "servo"
    fault = "rigid"
    summary = "The joint is stuck at one angle."
    title = "a stuck joint"
    sentence = "{where} [is|are] stuck at {angle_deg}"
    look = "Switch off and turn the joint by hand: something blocks it, or the servo holds an old command."
    mark = "The measured angle is constant whatever the set-point."
    confused_with = (("joint_free", "moves with its neighbours"),)
    parameters = (
        Parameter(
            "angle_deg",
            "deg",
            -180.0,
            180.0,
            "where it is stuck",
            typical=0.0,
            spread=20.0,
            default=0.0,
            words="stuck at",
        ),
    )

    def write_servo(self, rows: Floats, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
        rows[joints, layout.LOCKED] = layout.RIGID_JOINT
        rows[joints, layout.LOCK_RAD] = math.radians(spec.value("angle_deg"))

    def fault_values(self, angle_rad: float) -> dict[str, float]:
        return {"angle_deg": round(math.degrees(angle_rad), 9)}  # 30, not 29.999999999999996

    def fault_angle_rad(self, spec: EffectSpec) -> float:
        return math.radians(spec.value("angle_deg"))

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        return [
            {
                "angle_deg": self.parameters[0].clip(
                    math.degrees(observed.over(observed.median_rad, joints, 0.0))
                )
            }
        ]


EFFECT = JointRigid()
