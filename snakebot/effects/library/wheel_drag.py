"""A wheel that rubs."""

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


class WheelDrag(OneLinkEffect):
    name = "wheel_drag"
    example = "wheel_drag:link=2,extra_n=2"
    summary = "One link's wheels have extra rolling friction."
    title = "wheels that drag"
    sentence = "The wheels of link {link} drag, by {extra_n} more than the others"
    look = (
        "Turn the wheels of that link by hand: hair, dirt, a bent axle, or a cable that scrapes the ground."
    )
    mark = "Slower, and a heading that drifts to one side unless the link is in the middle."
    confused_with = (
        ("ground_friction", "all links alike: the heading does not drift"),
        ("payload", "slower by weight, not by friction"),
    )
    parameters = (
        LINK,
        Parameter(
            "extra_n",
            "N",
            0.0,
            50.0,
            "Coulomb friction along the link",
            typical=0.5,
            spread=1.0,
            words="extra drag",
        ),
    )

    def write_ground(self, ground: Ground, spec: EffectSpec, robot: Robot) -> None:
        ground.extra_drag_n[int(spec.value("link")) - 1] += spec.value("extra_n")

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        links = observed.robot.body.links if observed.robot.body else 0
        return [{"link": float(link), "extra_n": 0.5} for link in range(1, links + 1)]


EFFECT = WheelDrag()
