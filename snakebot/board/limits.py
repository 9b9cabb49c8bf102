"""A robot's limits as the wire carries them to the board."""

from __future__ import annotations

import math
from collections.abc import Iterator

from firmware_protocol.catalogue import LimitKind, LimitRequest, database
from snakebot.errors import BadInputError
from snakebot.robot import Robot

_UNITS = {LimitKind.ANGLE: "rad", LimitKind.SPEED: "rad/s", LimitKind.ACCELERATION: "rad/s2"}


def check_limits(robot: Robot) -> None:
    """Raises: BadInputError: a limit that the wire cannot carry: the joint, the limit and what it can carry."""
    for _ in wire_limits(robot):
        pass


def wire_limits(robot: Robot) -> Iterator[tuple[LimitKind, int, float]]:
    """Each joint's limits, (kind, joint from 1, rad or rad/s or rad/s2), rounded down to what the wire can say.

    Raises:
        BadInputError: a limit is smaller or larger than any that the wire carries.
    """
    signal = database().get_message_by_name(LimitRequest.__name__).get_signal_by_name("value")
    assert signal.maximum is not None  # the DBC gives each signal its range
    step, most = signal.scale, signal.maximum
    for kind, values in (
        (LimitKind.ANGLE, robot.angle_limit_rad),
        (LimitKind.SPEED, robot.speed_limit_rad_s),
        (LimitKind.ACCELERATION, robot.acceleration_limit_rad_s2),
    ):
        for joint, value in enumerate(values, start=1):
            steps = math.floor(value / step)
            if not 1 <= steps <= round(most / step):
                raise BadInputError(
                    f"joint {joint} of robot {robot.name!r}: {kind.name.lower()} limit {value:.6g} {_UNITS[kind]}: "
                    f"a board can be told {step:g} to {most:g} {_UNITS[kind]}"
                )
            yield kind, joint, steps * step
