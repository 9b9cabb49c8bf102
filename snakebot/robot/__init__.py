"""Robot description: from ``configs/robots/*.yaml`` or the ``robot:`` part of a session folder, and checked."""

from snakebot.robot.checked import robot_from_mapping
from snakebot.robot.description import (
    MAX_LINKS,
    SERVO_LAG,
    Body,
    Friction,
    Interval,
    JointServo,
    Limits,
    Provenance,
    Recorded,
    Robot,
    Servo,
    Tolerance,
)
from snakebot.robot.files import ITS_FILE, load_robot, robot_option, shipped_name

__all__ = [
    "ITS_FILE",
    "MAX_LINKS",
    "SERVO_LAG",
    "Body",
    "Friction",
    "Interval",
    "JointServo",
    "Limits",
    "Provenance",
    "Recorded",
    "Robot",
    "Servo",
    "Tolerance",
    "load_robot",
    "robot_from_mapping",
    "robot_option",
    "shipped_name",
]
