"""Zeros and directions of bus servos, found with the robot in somebody's hands. No servo gets torque."""

from __future__ import annotations

import statistics
from collections.abc import Sequence

from snakebot.errors import BoardFaultError, NoBoardError
from snakebot.robot import JointServo, Robot, robot_from_mapping
from snakebot.servobus.joints import Joint
from snakebot.servobus.master import BusMaster
from snakebot.servobus.settings import read_register

_READS = 9  # of a position, whose median counts; chosen
_STILL_COUNTS = 6  # of 4096: half a degree
MOVED_RAD = 0.17  # ten degrees: a turn that was meant


def check_limp(master: BusMaster, joints: Sequence[Joint]) -> None:
    """Nobody acknowledges that all were told to let go: each is asked.

    Raises:
        NoBoardError: one does not answer.
        BoardFaultError: one still has torque.
    """
    for joint in joints:
        torque = read_register(master, joint, "torque_enable")
        if torque is None:
            raise NoBoardError(f"{master.where}: {joint.what} stopped answering")
        if torque:
            raise BoardFaultError(
                f"{master.where}: {joint.what} still has torque: switch its supply off and on, and again"
            )


def positions(master: BusMaster, joints: Sequence[Joint]) -> list[int]:
    """Where the servos stand, in counts: the median of some readings.

    Raises:
        NoBoardError: one does not answer.
        BoardFaultError: one is moving.
    """
    places = []
    for joint in joints:
        reads = [read_register(master, joint, "present_position") for _ in range(_READS)]
        known = [value for value in reads if value is not None]
        if len(known) < _READS // 2:
            raise NoBoardError(f"{master.where}: {joint.what} stopped answering")
        if max(known) - min(known) > _STILL_COUNTS:
            raise BoardFaultError(f"{master.where}: {joint.what} is moving: hold it still, and again")
        places.append(round(statistics.median(known)))
    return places


def direction(joint: Joint, straight: int, turned: int) -> int | None:
    """The sign of a turn that was made towards larger angles; None: it was too small to be one."""
    turn = joint.model.counts_per_rev
    away = (turned - straight + turn / 2) % turn - turn / 2
    if abs(away) * joint.model.rad_per_count < MOVED_RAD:
        return None
    return 1 if away > 0 else -1


def calibrated(
    robot: Robot, joints: Sequence[Joint], zeros: Sequence[int], directions: Sequence[int]
) -> Robot:
    """The description with these servos, their zeros in the turn that the servo counts from."""
    servos = []
    for joint, zero, sign in zip(joints, zeros, directions, strict=True):
        counts = round(joint.model.counts_per_rev)
        servos.append(
            JointServo.model_validate(
                {
                    "id": joint.id,
                    "model": joint.model.name,
                    "direction": sign,
                    "zero_counts": zero % counts,
                    "torque_limit": joint.torque_limit,
                }
            )
        )
    data = robot.to_mapping()
    data["servos"] = [servo.model_dump(mode="json") for servo in servos]
    data["encoder_counts_per_rev"] = round(joints[0].model.counts_per_rev)
    data["provenance"] = {
        **data["provenance"],
        "servos": {"status": "measured", "source": "snakebot robot calibrate, the robot held straight"},
        "encoder_counts_per_rev": {"status": "measured", "source": f"{joints[0].model.name} answered"},
    }
    return robot_from_mapping(data, "the calibrated description")
