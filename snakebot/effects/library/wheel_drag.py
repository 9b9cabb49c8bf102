"""A wheel that rubs."""

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


class WheelDrag(Effect):
    name = "wheel_drag"
    example = "wheel_drag:link=2,extra_n=2"
    stage = "body"
    summary = "One link's wheels have extra rolling friction."
    mark = "Slower, and a heading that drifts to one side unless the link is in the middle."
    confused_with = (
        ("ground_friction", "all links alike: the heading does not drift"),
        ("payload", "slower by weight, not by friction"),
    )
    per_joint = False
    parameters = (
        Parameter("link", "", 1, 32, "which one, from 1 at the tail", typical=3, spread=1, integer=True),
        Parameter("extra_n", "N", 0.0, 50.0, "Coulomb friction along the link", typical=0.5, spread=1.0),
    )

    def write_ground(self, ground: Ground, spec: EffectSpec, robot: Robot) -> None:
        ground.extra_drag_n[int(spec.value("link")) - 1] += spec.value("extra_n")

    def check(self, spec: EffectSpec, robot: Robot) -> None:
        super().check(spec, robot)
        if robot.body is not None and spec.value("link") > robot.body.links:
            raise BadInputError(
                f"effect wheel_drag: link {int(spec.value('link'))} of a robot with {robot.body.links} links"
            )

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        links = observed.robot.body.links if observed.robot.body else 0
        return [{"link": float(link), "extra_n": 0.5} for link in range(1, links + 1)]


EFFECT = WheelDrag()
