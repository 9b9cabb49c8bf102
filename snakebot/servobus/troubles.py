"""From a servo's hardware error register to the fault that the board reports."""

from __future__ import annotations

from firmware_protocol.catalogue import Fault
from firmware_protocol.servo_trouble import ServoTrouble
from snakebot.board.faults import fault_line
from snakebot.servobus.registers import ServoModel
from snakebot.softboard.hardware import HardwareFault


def words(fault: HardwareFault) -> str:
    """A fault in words, with joint and value."""
    return fault_line(fault.code, fault.joint, fault.detail)


def hardware_fault(
    model: ServoModel, joint: int, errors: int, *, load_share: float, temperature_c: int, voltage_v: float
) -> HardwareFault | None:
    """The gravest of what a servo's hardware error register says; None: it says nothing."""
    said = {name for bit, name in model.errors.items() if errors >> bit & 1}
    if "overheating" in said:
        return HardwareFault(Fault.OVERTEMPERATURE, joint, temperature_c)
    if said & {"overload", "overcurrent"}:
        return HardwareFault(Fault.OVERCURRENT, joint, max(1, round(100 * abs(load_share))))
    if "input voltage" in said:
        return HardwareFault(Fault.UNDERVOLTAGE, joint, round(10 * voltage_v))
    if said & {"angle sensor", "motor encoder"}:
        return HardwareFault(Fault.SERVO, joint, ServoTrouble.SENSOR)
    if "electrical shock" in said:
        return HardwareFault(Fault.SERVO, joint, ServoTrouble.SHOCK)
    return HardwareFault(Fault.SERVO, joint, ServoTrouble.UNKNOWN) if errors else None
