"""A joint that gives way."""

from __future__ import annotations

from typing import TYPE_CHECKING

from snakebot.arrays import Floats
from snakebot.effects.effect import Effect, knows_load
from snakebot.effects.parameter import STIFFNESS_IN_MJCF, Parameter
from snakebot.physics import servo_layout as layout

if TYPE_CHECKING:
    from snakebot.effects.effect import Start
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


class Compliance(Effect):
    name = "compliance"
    example = "compliance:stiffness_nm_rad=5"
    stage = "servo"
    summary = "Shaft, horn and frame bend: the joint sags from where the motor is by load over stiffness."
    title = "a joint that bends"
    sentence = "{where} [bends|bend] under load, with a stiffness of {stiffness_nm_rad}"
    look = "Hold the motor side and push the link: look where horn, bracket or frame gives way."
    mark = (
        "An error in phase with the load, not with the speed: with gravity an offset that "
        "depends on the pose."
    )
    confused_with = (
        ("servo_offset", "constant whatever the load"),
        ("joint_friction", "a loop as well as a sag"),
    )
    parameters = (
        Parameter(
            "stiffness_nm_rad",
            "N m/rad",
            0.1,
            5000.0,
            "between motor and output",
            typical=20.0,
            spread=1.0,
            scale="log",
            words="stiffness",
            in_mjcf=STIFFNESS_IN_MJCF,
        ),
    )

    def write_servo(self, rows: Floats, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
        rows[joints, layout.COMPLIANCE_RAD_NM] = 1.0 / spec.value("stiffness_nm_rad")

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        load = observed.over(observed.peak_load_nm, joints, 0.5)
        rest = max(observed.over(observed.residual_rms_rad, joints, 0.03), 0.005)
        return [{"stiffness_nm_rad": self.parameters[0].clip(load / rest)}]

    def applies_to(self, robot: Robot) -> bool:
        return knows_load(robot)


EFFECT = Compliance()
