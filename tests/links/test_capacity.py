"""How many frames a wire carries: by the baud rate of a serial line, by the bit rate of a bus."""

from __future__ import annotations

import contextlib
import json
import math
import os
import re
from pathlib import Path

import pytest

from snakebot.control.copies import Copies
from snakebot.errors import BadInputError
from snakebot.links import parse_port
from snakebot.links.capacity import can_frames_per_s, serial_frames_per_s
from snakebot.links.opening import open_link
from snakebot.links.port import CanPort, SerialPort


def frames_per_s(port: str) -> float:
    parsed = parse_port(port)
    if isinstance(parsed, SerialPort):
        return serial_frames_per_s(parsed)
    assert isinstance(parsed, CanPort)
    return can_frames_per_s(parsed)


@pytest.mark.parametrize(
    ("port", "expected"),
    [
        ("serial:/dev/ttyUSB0", 1_000_000 / 140),  # 14 bytes of ten bits
        ("serial:/dev/ttyUSB0?baud=115200", 115_200 / 140),
        ("serial:rfc2217://lab:2217?baud=115200", 115_200 / 140),  # the far end's serial port
        ("serial:socket://127.0.0.1:5555", math.inf),
        ("can:slcan//dev/ttyACM0?bitrate=125000", 125_000 / 135),  # a USB device has no baud rate
        ("can:slcan//dev/ttyUSB0?bitrate=1000000", 115_200 / 220),  # 22 characters a frame
        ("can:slcan//dev/ttyUSB0?bitrate=1000000&tty_baudrate=2000000", 1_000_000 / 135),
        ("can:slcan//dev/ttyUSB0@1000000?bitrate=1000000", 1_000_000 / 220),
        ("can:pcan/PCAN_USBBUS1?bitrate=250000", 250_000 / 135),
        ("can:pcan/PCAN_USBBUS1", 1_000_000 / 135),  # does not say: as the protocol recommends
        ("can:pcan/PCAN_USBBUS1?bitrate=fast", 1_000_000 / 135),
        ("can:udp_multicast/239.74.163.2", math.inf),
        ("can:virtual/test", math.inf),
        ("can:socketcan/vcan0", math.inf),
    ],
)
def test_capacity_of_a_port(port: str, expected: float) -> None:
    assert frames_per_s(port) == pytest.approx(expected)


def test_a_socketcan_interface_is_asked_for_its_bit_rate(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said = [{"linkinfo": {"info_data": {"bittiming": {"bitrate": 125000}}}}]
    program = tmp_path / "ip"
    program.write_text(f"#!/bin/sh\necho '{json.dumps(said)}'\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    assert frames_per_s("can:socketcan/can0") == pytest.approx(125_000 / 135)
    program.write_text("#!/bin/sh\nexit 1\n")
    assert frames_per_s("can:socketcan/can0") == pytest.approx(1_000_000 / 135)


def test_an_open_link_knows_its_capacity() -> None:
    with open_link("can:virtual/capacity") as link:
        assert link.frames_per_s == math.inf
    with open_link("serial:loop://?baud=230400") as link:
        assert link.frames_per_s == pytest.approx(230_400 / 140)


def test_the_table_in_the_docs() -> None:
    page = (Path(__file__).resolve().parents[2] / "docs" / "connect.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(\S+)`[^|]*\| (\d+) \| (\d+) Hz \|$", page, re.MULTILINE)
    assert len(rows) == 4
    for port, frames, highest_hz in rows:
        carries = frames_per_s(port)
        assert int(frames) == int(carries)
        assert [rate for rate in range(20, 1001) if _fits(rate, carries)] == list(
            range(20, int(highest_hz) + 1)
        )


def _fits(rate_hz: int, carries: float) -> bool:
    with contextlib.suppress(BadInputError):
        Copies(1 / rate_hz, 5, carries, 0.1)
        return True
    return False
