"""The messages with which a board in software says who it is and how it is; samples are in ``sample``."""

from __future__ import annotations

import snakebot
from firmware_protocol import catalogue as msg
from snakebot.robot import Robot
from snakebot.softboard.hardware import HardwareFault
from snakebot.softboard.modes import ModeMachine
from snakebot.softboard.register import SetpointRegister

_MASK16 = 0xFFFF  # counters have 16 bits and wrap (PROTOCOL.md)


def identity(
    robot: Robot, serial_number: int, boot_id: int, watchdog_ms: int, *, simulated: bool
) -> list[msg.Message]:
    """The answer to an ``InfoRequest``; the limits go after it."""
    major, minor, patch = (int(part) for part in snakebot.__version__.split(".")[:3])
    return [
        msg.InfoProtocol(
            msg.PROTOCOL_MAJOR, msg.PROTOCOL_MINOR, robot.joints, int(simulated), msg.catalogue_hash()
        ),
        msg.InfoFirmware(major, minor, patch, watchdog_ms, robot.encoder_counts_per_rev, boot_id),
        msg.InfoSerial(serial_number),
    ]


def heartbeat(machine: ModeMachine, boot_id: int, *, simulated: bool) -> msg.BoardHeartbeat:
    """The mode, and who holds the board."""
    return msg.BoardHeartbeat(
        boot_id, machine.mode, machine.powered, int(simulated), machine.fault, machine.holder
    )


def fault_event(machine: ModeMachine, about: HardwareFault, since_us: int) -> msg.FaultEvent:
    """The latch; ``about`` has the joint and the value of a fault of the hardware."""
    return msg.FaultEvent(machine.fault, about.joint, machine.latch, about.detail, since_us)


def counters(received: int, corrupt: int, register: SetpointRegister) -> msg.Counters:
    """Frames that came, and packets and set-points that were not as they should be."""
    return msg.Counters(
        received & _MASK16, corrupt & _MASK16, register.dropped & _MASK16, register.clamped & _MASK16
    )
