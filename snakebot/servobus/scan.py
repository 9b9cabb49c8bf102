"""Finding servos: who answers on a line, and at which bit rate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from snakebot.clock import Clock
from snakebot.links.port import ServoPort
from snakebot.servobus.joints import SCAN_IDS, Identity, look_around
from snakebot.servobus.opening import open_master

USUAL_BAUD = {
    "feetech": (1_000_000, 500_000, 115_200),
    "dynamixel": (1_000_000, 57_600, 115_200, 2_000_000, 3_000_000, 4_000_000),
}
_WAIT_S = 0.006  # for one who may not be there; low-latency mode is asked for when the port is opened


def find_servos(
    port: ServoPort, clock: Clock, ids: Sequence[int] = SCAN_IDS, *, every_rate: bool = True
) -> tuple[ServoPort, list[Identity]]:
    """The servos with one of these ids, at the port's bit rate or, where nobody answers there, at a usual one.

    Returns:
        The port with the bit rate at which they answer, and who they are; nobody: the port as it was.

    Raises:
        NoBoardError: the port cannot be opened.
    """
    rates = [port.baud, *(USUAL_BAUD[port.family] if every_rate else ())]
    for baud in dict.fromkeys(rates):
        tried = replace(port, baud=baud)
        master = open_master(tried, clock)
        try:
            master.latency_s = _WAIT_S
            found = look_around(master, ids)
        finally:
            master.close()
        if found:
            return tried, found
    return port, []
