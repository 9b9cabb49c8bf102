"""A robot's limits as the wire carries them to the board, and as the board reports them."""

from __future__ import annotations

import math
from collections.abc import Iterator

from firmware_protocol.catalogue import MAX_JOINTS, JointLimits, LimitKind, LimitRequest, database
from snakebot.errors import BadInputError, BoardFaultError
from snakebot.robot import Robot

_STEP = 0.002  # of a limit on the wire
_UNITS = {LimitKind.ANGLE: "rad", LimitKind.SPEED: "rad/s", LimitKind.ACCELERATION: "rad/s2"}


def check_limits(robot: Robot) -> None:
    """Raises: BadInputError: more joints than a board has, or a limit that the wire cannot carry."""
    if robot.joints > MAX_JOINTS:
        raise BadInputError(
            f"robot {robot.name!r} has {robot.joints} joints; a board has at most {MAX_JOINTS}"
        )
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


class LimitsInForce:
    """The limits that the board was asked for, against those that it reports once it is armed.

    Until it is armed another host may change them; what it reports after that holds until it is disarmed.
    """

    def __init__(self, where: str) -> None:
        self._where = where
        self._asked: dict[int, dict[LimitKind, float]] = {}
        self._reported: dict[int, JointLimits] | None = None  # None: what comes now may change yet

    def asked(self, joint: int, kind: LimitKind, value: float) -> None:
        """The board has accepted a limit, as the wire carries it."""
        self._asked.setdefault(joint, {})[kind] = value

    def forget_reports(self) -> None:
        """The board is to be armed: what it has reported so far may change until it is."""
        self._reported = None

    def begin(self) -> None:
        """The board is armed: what it reports from now on is in force."""
        if self._reported is None:
            self._reported = {}

    def take(self, report: JointLimits) -> None:
        if self._reported is not None:
            self._reported[report.joint] = report

    def missing(self) -> list[int]:
        """Joints whose limits were asked for, and are not reported."""
        return [joint for joint in sorted(self._asked) if joint not in (self._reported or {})]

    def check(self) -> None:
        """Raises: BoardFaultError: a joint without a report, or with a limit that is not the one asked for."""
        missing = self.missing()
        if missing:
            raise BoardFaultError(
                f"{self._where}: the board does not report the limits of joint {', '.join(map(str, missing))}: "
                "nothing was moved; check the cable, then start again"
            )
        for joint, wanted in sorted(self._asked.items()):
            assert self._reported is not None
            report = self._reported[joint]
            there = dict(
                zip(
                    LimitKind,
                    (report.angle_rad, report.speed_rad_s, report.acceleration_rad_s2),
                    strict=True,
                )
            )
            for kind, value in wanted.items():
                if abs(there[kind] - value) > _STEP / 2:
                    raise BoardFaultError(
                        f"{self._where}: joint {joint}: the {kind.name.lower()} limit in force is "
                        f"{there[kind]:.6g} {_UNITS[kind]}, {value:.6g} {_UNITS[kind]} was asked for: another host "
                        "has changed it; nothing was moved"
                    )
