"""What a user is told when a board has stopped the joints itself, or will not give them power."""

from __future__ import annotations

from firmware_protocol.catalogue import Fault, Mode
from firmware_protocol.servo_trouble import ServoTrouble

LATCHED = (Mode.STOPPED, Mode.FAULT)  # left only by a request of its own

FAULT_LINES = {
    Fault.NONE: "the board reports a fault without a code",
    Fault.WATCHDOG: "the board's watchdog stopped the joints: no set-point reached it in time",
    Fault.EMERGENCY_STOP: "emergency stop: the joints are without power",
    Fault.SERVO: "the board reports a servo fault",
    Fault.UNDERVOLTAGE: "the board reports that the supply voltage is too low",
    Fault.OVERCURRENT: "the board reports too much current",
    Fault.OVERTEMPERATURE: "the board reports that it is too hot",
    Fault.ENCODER: "the board reports an encoder fault",
    Fault.INTERNAL: "the board reports an internal fault",
}


_SERVO_LINES = {
    ServoTrouble.SILENT: "the servo has not answered for five cycles: cable, supply, or another servo of its id?",
    ServoTrouble.TORQUE_OFF: "the servo has switched its torque off by itself",
    ServoTrouble.POWER_CYCLED: "the servo has lost its supply and started again: its settings are gone",
    ServoTrouble.BUS_WATCHDOG: "the servo's bus watchdog has stopped it: nothing was said on the bus for too long",
    ServoTrouble.REFUSES: "the servo does not take what it is told",
    ServoTrouble.LINE_LOST: "the line to the servos is gone: check adapter and cable",
    ServoTrouble.SENSOR: "the servo's own angle sensor reports an error",
    ServoTrouble.SHOCK: "the servo reports an electrical shock, or too little power for its motor",
}


def fault_line(code: Fault, joint: int = 0, detail: int = 0, *, watchdog_ms: int | None = None) -> str:
    """One line about a fault.

    Args:
        joint: from 1; 0: not one joint's.
        detail: as in a ``FaultEvent``; 0: not known.
        watchdog_ms: how long this board waits for a set-point, where it has said so.
    """
    if code is Fault.WATCHDOG and watchdog_ms is not None:
        return f"the board's watchdog stopped the joints: no set-point reached it for {watchdog_ms} ms"
    where = f"joint {joint}: " if joint else ""
    if detail > 0 or code is Fault.ENCODER:
        match code:
            case Fault.SERVO if detail in _SERVO_LINES:
                return where + _SERVO_LINES[ServoTrouble(detail)]
            case Fault.ENCODER if detail:
                return f"{where}stands at {detail / 10:.1f} deg, beyond its limit: turn it back by hand"
            case Fault.OVERTEMPERATURE:
                return f"{where}the servo is too hot: {detail} degC"
            case Fault.UNDERVOLTAGE:
                return f"{where}the servo's supply is outside its limits: {detail / 10:.1f} V"
            case Fault.OVERCURRENT:
                return f"{where}the servo is overloaded: {detail} % of its torque"
            case _:
                pass
    return FAULT_LINES[code] + (f" on joint {joint}" if joint else "")
