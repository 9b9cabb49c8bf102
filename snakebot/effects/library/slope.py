"""Ground that is not level."""

from __future__ import annotations

from typing import TYPE_CHECKING

from snakebot.effects.effect import Effect
from snakebot.effects.parameter import Parameter

if TYPE_CHECKING:
    from snakebot.effects.effect import Start
    from snakebot.effects.ground import Ground
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


class Slope(Effect):
    name = "slope"
    example = "slope:angle_deg=2"
    stage = "body"
    summary = "The ground rises along +x by an angle."
    title = "ground that is not level"
    sentence = "The ground rises by {angle_deg} along +x"
    look = "Put a spirit level on the ground, along the way of the robot."
    mark = "Faster one way than the other: drive the same gait in both directions."
    confused_with = (("ground_friction", "the same in both directions"),)
    per_joint = False
    parameters = (
        Parameter(
            "angle_deg",
            "deg",
            -30.0,
            30.0,
            "positive: uphill along +x",
            typical=0.0,
            spread=2.0,
            words="slope",
        ),
    )

    def write_ground(self, ground: Ground, spec: EffectSpec, robot: Robot) -> None:
        ground.slope_deg += spec.value("angle_deg")

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        return [{"angle_deg": 0.5}, {"angle_deg": -0.5}]


EFFECT = Slope()
