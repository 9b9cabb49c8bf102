"""A robot lifted off the ground: the same links and servos, and nothing that rubs."""

from __future__ import annotations

from snakebot.robot import Friction, Robot


def lifted(robot: Robot) -> Robot:
    """The robot with links that touch nothing; a bench, which has no ground, as it is."""
    if robot.body is None:
        return robot
    nothing = Friction(ct=0.0, cn=0.0)
    return robot.model_copy(
        update={"body": robot.body.model_copy(update={"friction": nothing, "slope_deg": 0.0})}
    )
