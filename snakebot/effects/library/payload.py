"""Something carried along."""

from __future__ import annotations

from typing import TYPE_CHECKING

from snakebot.effects.effect import Effect
from snakebot.effects.parameter import Parameter
from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.effects.effect import Start
    from snakebot.effects.ground import Ground
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


class Payload(Effect):
    name = "payload"
    example = "payload:link=1,mass_kg=1"
    stage = "body"
    summary = "One link carries extra mass."
    mark = (
        "Joint angles are right, speed changes a little and the path bends; on a slope, or with "
        "weak servos, a lot."
    )
    confused_with = (("ground_friction", "from speed alone the two cannot be told apart"),)
    per_joint = False
    parameters = (
        Parameter("link", "", 1, 32, "which one, from 1 at the tail", typical=3, spread=1, integer=True),
        Parameter("mass_kg", "kg", 0.0, 100.0, "added at its centre", typical=0.5, spread=1.0),
    )

    def write_ground(self, ground: Ground, spec: EffectSpec, robot: Robot) -> None:
        ground.added_mass_kg[int(spec.value("link")) - 1] += spec.value("mass_kg")

    def check(self, spec: EffectSpec, robot: Robot) -> None:
        super().check(spec, robot)
        if robot.body is not None and spec.value("link") > robot.body.links:
            raise BadInputError(
                f"effect payload: link {int(spec.value('link'))} of a robot with {robot.body.links} links"
            )

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        body = observed.robot.body
        if body is None:
            return []
        mass = body.link_mass_kg if isinstance(body.link_mass_kg, float) else max(body.link_mass_kg)
        return [
            {"link": float(link), "mass_kg": self.parameters[1].clip(0.5 * mass)}
            for link in range(1, body.links + 1)
        ]


EFFECT = Payload()
