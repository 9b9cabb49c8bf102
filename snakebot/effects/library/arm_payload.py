"""Something hung on the arm of a bench."""

from __future__ import annotations

from typing import TYPE_CHECKING

from snakebot.arrays import Floats
from snakebot.effects.effect import Effect
from snakebot.effects.parameter import Parameter
from snakebot.errors import BadInputError
from snakebot.physics import servo_layout as layout

if TYPE_CHECKING:
    from snakebot.effects.effect import Start
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


class ArmPayload(Effect):
    name = "arm_payload"
    example = "arm_payload:mass_kg=0.3"
    example_robot = """joints: 1
servo: {time_constant_s: 0.03, arm: {mass_kg: 0.25, length_m: 0.15}}
"""
    stage = "servo"
    summary = "On a bench, the arm of the joint carries extra mass at its end."
    title = "extra weight on the arm"
    sentence = "The arm of {on} carries {mass_kg} more than stated"
    look = "Weigh the arm with all that is on it, and compare with the description of the bench."
    mark = (
        "More sag, slower swings, slower upwards than downwards; shows only if the robot's servo feels its load "
        "(position_loop, torque_speed, compliance ... in its description)."
    )
    confused_with = (
        ("position_loop", "softer and heavier are one in slow motion; swings, or a drop without power, tell"),
        ("servo_offset", "constant whatever the pose"),
    )
    parameters = (
        Parameter(
            "mass_kg", "kg", 0.0, 100.0, "added at the arm's end", typical=0.2, spread=0.5,
            words="extra mass", shown=("g", 1000.0),
        ),
    )  # fmt: skip

    def write_servo(self, rows: Floats, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
        from snakebot.effects.stages import arm_of
        from snakebot.physics.model import STANDARD_GRAVITY_M_S2

        arm = arm_of(robot)
        assert arm is not None  # see check
        mass = spec.value("mass_kg")
        rows[joints, layout.ARM_GRAVITY_NM] += mass * STANDARD_GRAVITY_M_S2 * arm.length_m
        rows[joints, layout.ARM_INERTIA_KG_M2] += mass * arm.length_m**2

    def check(self, spec: EffectSpec, robot: Robot) -> None:
        super().check(spec, robot)
        if not self.applies_to(robot):
            raise BadInputError(
                f"effect {self.name}: robot {robot.name} is no bench with an arm (servo.arm: mass_kg, length_m)"
            )

    def applies_to(self, robot: Robot) -> bool:
        return robot.body is None and "arm" in (robot.servo.model_extra or {})

    def can_explain(self, observed: Observed) -> bool:
        """A servo that is nominal whatever it bears shows no weight."""
        from snakebot.effects.stages import assemble

        return assemble(observed.robot, ()).feels_load

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        from snakebot.effects.stages import arm_of

        arm = arm_of(observed.robot)
        mass = 0.2 if arm is None else arm.mass_kg
        return [{"mass_kg": self.parameters[0].clip(share * mass)} for share in (0.5, 2.0)]


EFFECT = ArmPayload()
