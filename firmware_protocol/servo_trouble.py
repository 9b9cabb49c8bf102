"""What ``FaultEvent.detail`` says where the fault is a servo's own (code ``SERVO``)."""

from __future__ import annotations

from enum import IntEnum


class ServoTrouble(IntEnum):
    UNKNOWN = 0
    SILENT = 1
    TORQUE_OFF = 2
    POWER_CYCLED = 3
    BUS_WATCHDOG = 4
    REFUSES = 5
    LINE_LOST = 6
    SENSOR = 7
    SHOCK = 8
