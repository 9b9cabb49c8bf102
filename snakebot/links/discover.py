"""Ports that this computer has: serial adapters and CAN interfaces."""

from __future__ import annotations

import logging
import os
from dataclasses import dataclass

# Their detection answers "always there", or listens to the network for seconds.
_NOT_ASKED = ("virtual", "serial", "socketcand", "udp_multicast")


@dataclass(frozen=True, slots=True)
class FoundPort:
    """One port, as ``--port`` takes it.

    ``usable`` is False where this user may not open it; ``what`` says what is known of it.
    """

    port: str
    what: str
    usable: bool = True


def serial_ports() -> list[FoundPort]:
    """Serial devices, USB adapters first."""
    from serial.tools import list_ports

    found = []
    for device in sorted(list_ports.comports(), key=lambda d: (d.vid is None, d.device)):
        parts = [device.manufacturer, device.product or device.description, device.serial_number]
        what = " ".join(part for part in parts if part and part != "n/a") or "serial port"
        usable = os.name != "posix" or os.access(device.device, os.R_OK | os.W_OK)
        found.append(FoundPort(f"serial:{device.device}", what, usable))
    return found


def can_ports() -> list[FoundPort]:
    """CAN interfaces that python-can finds. slcan adapters are among the serial ports: nothing tells them apart."""
    import can

    logging.getLogger("can").addHandler(logging.NullHandler())
    interfaces = sorted(set(can.VALID_INTERFACES) - set(_NOT_ASKED))
    return [
        FoundPort(f"can:{config['interface']}/{config['channel']}", f"CAN interface ({config['interface']})")
        for config in can.detect_available_configs(interfaces)
    ]
