"""What effects of the body share that sit on one link."""

from __future__ import annotations

from typing import TYPE_CHECKING

from snakebot.effects.effect import Effect
from snakebot.effects.parameter import Parameter
from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot

LINK = Parameter(
    "link",
    "",
    1,
    32,
    "which one, from 1 at the tail",
    typical=3,
    spread=1,
    integer=True,
    words="link, from 1 at the tail",
)


class OneLinkEffect(Effect):
    """An effect of the body whose first parameter is ``LINK``."""

    stage = "body"
    per_joint = False

    def check(self, spec: EffectSpec, robot: Robot) -> None:
        super().check(spec, robot)
        if robot.body is not None and spec.value("link") > robot.body.links:
            raise BadInputError(
                f"effect {self.name}: link {int(spec.value('link'))} of a robot with {robot.body.links} links"
            )
