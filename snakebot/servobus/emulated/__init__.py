"""Servos that are not there: their registers, the snake that they move, and the end of a bus that hosts open."""

from __future__ import annotations

from snakebot.servobus.emulated.bus import EmulatedBus
from snakebot.servobus.emulated.chain import ServoChain
from snakebot.servobus.emulated.servo import EmulatedServo

__all__ = ["EmulatedBus", "EmulatedServo", "ServoChain"]
