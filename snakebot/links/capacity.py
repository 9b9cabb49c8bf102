"""How many frames a wire carries: what a run may put on it follows from that."""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import subprocess
from typing import Any

from firmware_protocol.frame import Frame
from firmware_protocol.framing import pack_all
from snakebot.links.port import CanPort, Port, SerialPort
from snakebot.links.slcan import format_frame

_FULL = Frame(0x7FF, bytes(8))  # the longest frame, and the usual one: a set-point fills it
BITS_OF_A_BYTE = 10  # on a serial line, with start and stop bit
_SERIAL_BITS = BITS_OF_A_BYTE * (len(pack_all([_FULL] * 2)) - len(pack_all([_FULL])))  # in a row
_SLCAN_BITS = BITS_OF_A_BYTE * len(format_frame(_FULL))

# A classic frame with an 11-bit identifier and n bytes takes at most 55 + 10 n bit times, stuff bits and the space
# between frames included: Davis, Burns, Bril, Lukkien, "Controller Area Network (CAN) schedulability analysis", 2007.
_CAN_BITS = 55 + 10 * 8

_USUAL_CAN_BIT_RATE = 1_000_000.0  # that PROTOCOL.md recommends: of an interface that does not tell its own
_IN_MEMORY = ("virtual", "udp_multicast")  # no bit timing
_SLCAN_BAUD = 115_200.0  # python-can's default
# A real UART behind the adapter's name; a USB device (ttyACM) and a pseudo-terminal only pretend to have a baud rate.
_UART = re.compile(r"/dev/tty(S|USB|AMA|O|mxc|THS)\d")


def frames_per_s(port: Port) -> float:
    """Of the wire behind a port, without opening it; infinity for one that limits nothing."""
    if isinstance(port, SerialPort):
        return serial_frames_per_s(port)
    return can_frames_per_s(port) if isinstance(port, CanPort) else math.inf


def serial_frames_per_s(port: SerialPort) -> float:
    """Of a serial line by its baud rate; a TCP connection is no bottleneck."""
    if port.device.lower().startswith("socket://"):
        return math.inf
    return port.baud / _SERIAL_BITS


def can_frames_per_s(port: CanPort) -> float:
    """Of a CAN bus by its bit rate, all nodes together; an adapter on a slow serial line may carry less."""
    if port.interface in _IN_MEMORY or port.channel.startswith("vcan"):
        return math.inf
    options = dict(port.options)
    bit_rate = _positive(options.get("bitrate"))
    if bit_rate is None and port.interface == "socketcan":
        bit_rate = socketcan_bit_rate(port.channel)
    frames_per_s = (bit_rate or _USUAL_CAN_BIT_RATE) / _CAN_BITS
    if port.interface == "slcan":
        device, _, at = port.channel.partition("@")
        if _UART.match(os.path.realpath(device)):
            baud = _positive(options.get("tty_baudrate")) or _positive(at) or _SLCAN_BAUD
            frames_per_s = min(frames_per_s, baud / _SLCAN_BITS)
    return frames_per_s


def socketcan_bit_rate(channel: str) -> float | None:
    """The bit rate that a SocketCAN interface was brought up with, bit/s; None where the system does not tell."""
    return _positive(ip_details(channel).get("bittiming", {}).get("bitrate"))


def ip_details(channel: str) -> dict[str, Any]:
    """What ``ip`` says of the CAN side of an interface; empty where it cannot say."""
    program = shutil.which("ip")
    if program is None:
        return {}
    result = subprocess.run(
        [program, "-json", "-details", "link", "show", channel], capture_output=True, text=True, check=False
    )
    try:
        links = json.loads(result.stdout)
        data = links[0].get("linkinfo", {}).get("info_data", {})
    except (ValueError, IndexError, AttributeError):
        return {}
    return data if isinstance(data, dict) else {}


def _positive(text: object) -> float | None:
    """A number of an option; None where there is none that can be a rate."""
    try:
        value = float(str(text))
    except ValueError:
        return None
    return value if math.isfinite(value) and value > 0 else None
