"""Another ground than the one measured."""

from __future__ import annotations

from typing import TYPE_CHECKING

from snakebot.effects.effect import Effect
from snakebot.effects.parameter import Parameter

if TYPE_CHECKING:
    from snakebot.effects.ground import Ground
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


class GroundFriction(Effect):
    name = "ground_friction"
    example = "ground_friction:cn_scale=0.5"
    stage = "body"
    covers = frozenset({"friction"})
    summary = "The friction coefficients of the ground differ from the nominal ones by factors."
    mark = "Joint angles are right, speed and path are not."
    confused_with = (("payload", "from speed alone the two cannot be told apart"),)
    per_joint = False
    parameters = tuple(
        Parameter(f"{key}_scale", "", 0.05, 20.0, doc, typical=1.0, spread=0.4, scale="log", default=1.0)
        for key, doc in (
            ("ct", "on viscous friction along the link"),
            ("cn", "on viscous friction across it"),
            ("ct0", "on Coulomb friction along it"),
            ("cn0", "on Coulomb friction across it"),
        )
    )

    def write_ground(self, ground: Ground, spec: EffectSpec, robot: Robot) -> None:
        for parameter in self.parameters:
            setattr(ground, parameter.name, getattr(ground, parameter.name) * spec.value(parameter.name))


EFFECT = GroundFriction()
