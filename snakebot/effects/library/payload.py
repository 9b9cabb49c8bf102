"""Something carried along."""

from __future__ import annotations

from typing import TYPE_CHECKING

from snakebot.effects.one_link import LINK, OneLinkEffect
from snakebot.effects.parameter import Parameter

if TYPE_CHECKING:
    from snakebot.effects.effect import Start
    from snakebot.effects.ground import Ground
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


class Payload(OneLinkEffect):
    name = "payload"
    example = "payload:link=1,mass_kg=1"
    summary = "One link carries extra mass."
    title = "extra weight on a link"
    sentence = "Link {link} carries {mass_kg} more than stated"
    look = "Weigh that link with all that is on it: battery, board, cables."
    mark = (
        "Joint angles are right, speed changes a little and the path bends; on a slope, or with "
        "weak servos, a lot."
    )
    confused_with = (("ground_friction", "from speed alone the two cannot be told apart"),)
    parameters = (
        LINK,
        Parameter(
            "mass_kg",
            "kg",
            0.0,
            100.0,
            "added at its centre",
            typical=0.5,
            spread=1.0,
            words="extra mass",
            in_mjcf="inertial of the link: mass",
        ),
    )

    def write_ground(self, ground: Ground, spec: EffectSpec, robot: Robot) -> None:
        ground.added_mass_kg[int(spec.value("link")) - 1] += spec.value("mass_kg")

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
