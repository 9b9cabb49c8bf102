"""The enumerations of ``snakebot.dbc``; a test holds them against its value tables."""

from __future__ import annotations

from enum import IntEnum


class Mode(IntEnum):
    """What the board is doing. PROTOCOL.md has the table of transitions."""

    DISARMED = 0
    ARMED = 1
    HOLDING = 2
    STOPPED = 3
    FAULT = 4


class Fault(IntEnum):
    """Why the board is in mode FAULT or STOPPED."""

    NONE = 0
    WATCHDOG = 1
    EMERGENCY_STOP = 2
    SERVO = 3
    UNDERVOLTAGE = 4
    OVERCURRENT = 5
    OVERTEMPERATURE = 6
    ENCODER = 7
    INTERNAL = 8


class StopReason(IntEnum):
    USER = 0
    LATE = 1
    EXCEPTION = 2
    EXTERNAL = 3


class JointMode(IntEnum):
    """RIGID holds the joint at the angle given, RIGID_HERE at the angle where it is."""

    ACTIVE = 0
    FREE = 1
    RIGID = 2
    RIGID_HERE = 3


class LimitKind(IntEnum):
    ANGLE = 0
    SPEED = 1
    ACCELERATION = 2


class Result(IntEnum):
    """Answer to a request. ``detail`` of the acknowledgement: BAD_JOINT the number of joints, FAULTY the fault."""

    OK = 0
    BAD_VALUE = 1
    BAD_JOINT = 2
    FORBIDDEN = 3
    HELD = 4
    UNSUPPORTED = 5
    FAULTY = 6
