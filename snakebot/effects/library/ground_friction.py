"""Another ground than the one measured."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from snakebot.effects.effect import Effect
from snakebot.effects.parameter import Parameter

if TYPE_CHECKING:
    from snakebot.effects.effect import Start
    from snakebot.effects.ground import Ground
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


class GroundFriction(Effect):
    name = "ground_friction"
    example = "ground_friction:cn_scale=0.5"
    stage = "body"
    covers = frozenset({"friction"})
    summary = "The friction coefficients of the ground differ from the nominal ones by factors."
    title = "another friction of the ground"
    sentence = "The ground has another friction than stated"
    look = (
        "Look at the ground and at the wheels: dust, another mat, wheels that turn hard or slip sideways; "
        "pull the robot with a spring scale."
    )
    mark = "Joint angles are right, speed and path are not."
    confused_with = (("payload", "from speed alone the two cannot be told apart"),)
    per_joint = False
    parameters = tuple(
        Parameter(
            f"{key}_scale",
            "",
            0.05,
            20.0,
            doc,
            typical=1.0,
            spread=0.4,
            scale="log",
            default=1.0,
            neutral=1.0,
            words=words,
            shown=("times stated", 1.0),
        )
        for key, doc, words in (
            ("ct", "on viscous friction along the link", "viscous friction along the links"),
            ("cn", "on viscous friction across it", "viscous friction across the links"),
            ("ct0", "on Coulomb friction along it", "dry friction along the links"),
            ("cn0", "on Coulomb friction across it", "dry friction across the links"),
        )
    )

    def said(self, values: Mapping[str, float | tuple[float, ...]]) -> str:
        """Only the coefficients that differ."""
        parts = [f"{p.called} is {{{p.name}}}" for p in self.parameters if values.get(p.name, 1.0) != 1.0]
        return "On this ground " + " and ".join(parts) if parts else self.sentence

    def variants(self, start: Start) -> list[Start]:
        """One coefficient is off, or all may be."""
        names = [p.name for p in self.parameters]
        one: list[Start] = [{other: 1.0 for other in names if other != name} for name in names]
        return [*one, {}]

    def write_ground(self, ground: Ground, spec: EffectSpec, robot: Robot) -> None:
        for parameter in self.parameters:
            setattr(ground, parameter.name, getattr(ground, parameter.name) * spec.value(parameter.name))


EFFECT = GroundFriction()
