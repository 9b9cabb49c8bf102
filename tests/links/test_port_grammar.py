"""``--port``: what is understood, and how what is not is refused."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from snakebot.errors import BadInputError
from snakebot.links import CanPort, Port, SerialPort, SimPort, open_link, parse_port
from snakebot.links.port import ServoPort

UNDERSTOOD: dict[str, Port] = {
    "sim:": SimPort(),
    "serial:/dev/ttyUSB0": SerialPort("/dev/ttyUSB0"),
    "serial:/dev/ttyUSB0?baud=115200": SerialPort("/dev/ttyUSB0", 115_200),
    "serial:/dev/ttyUSB0?baud=2000000&rtscts=1&dtr=0": SerialPort("/dev/ttyUSB0", 2_000_000, True, False),
    "serial:COM4?dtr=on": SerialPort("COM4", dtr=True),
    "serial:socket://127.0.0.1:5555": SerialPort("socket://127.0.0.1:5555"),
    "serial:rfc2217://lab:2217?ign_set_control&baud=57600&timeout=3": SerialPort(
        "rfc2217://lab:2217?ign_set_control&timeout=3", 57_600
    ),
    "serial:loop://": SerialPort("loop://"),
    "serial:ttyUSB0": SerialPort("ttyUSB0"),
    "/dev/ttyACM0": SerialPort("/dev/ttyACM0"),
    "/dev/serial/by-id/usb-FTDI_FT232R_A10-if00-port0?baud=500000": SerialPort(
        "/dev/serial/by-id/usb-FTDI_FT232R_A10-if00-port0", 500_000
    ),
    "./snake": SerialPort("./snake"),
    "com7": SerialPort("com7"),
    "socket://[::1]:5555": SerialPort("socket://[::1]:5555"),
    "can:socketcan/can0": CanPort("socketcan", "can0"),
    "can:slcan//dev/ttyACM0?bitrate=1000000": CanPort("slcan", "/dev/ttyACM0", (("bitrate", "1000000"),)),
    "can:slcan/socket://lab:3333": CanPort("slcan", "socket://lab:3333"),
    "can:udp_multicast/239.74.163.2": CanPort("udp_multicast", "239.74.163.2"),
    "can:udp_multicast/ff15:7079::1?port=43113": CanPort(
        "udp_multicast", "ff15:7079::1", (("port", "43113"),)
    ),
    "can:pcan/PCAN_USBBUS1?bitrate=500000&listen_only=True": CanPort(
        "pcan", "PCAN_USBBUS1", (("bitrate", "500000"), ("listen_only", "True"))
    ),
    "can:kvaser/0": CanPort("kvaser", "0"),
    "feetech:/dev/ttyUSB0": ServoPort("feetech", "/dev/ttyUSB0"),
    "feetech:/dev/ttyUSB0?baud=500000&ids=1-5": ServoPort(
        "feetech", "/dev/ttyUSB0", 500_000, (1, 2, 3, 4, 5)
    ),
    "Dynamixel:COM4?ids=1,7-9,20": ServoPort("dynamixel", "COM4", ids=(1, 7, 8, 9, 20)),
}

REFUSED = [
    "feetech:",
    "feetech:?ids=1-5",
    "feetech:socket://lab:5555",
    "feetech:/dev/ttyUSB0?ids=",
    "feetech:/dev/ttyUSB0?ids=5-1",
    "feetech:/dev/ttyUSB0?ids=1,1",
    "feetech:/dev/ttyUSB0?ids=300",
    "feetech:/dev/ttyUSB0?ids=1-999999999",
    "dynamixel:/dev/ttyUSB0?baud=fast",
    "dynamixel:/dev/ttyUSB0?parity=even",
    "",
    " ",
    "usb",
    "ttyUSB0",
    "simulated",
    "sim:5",
    "serial:",
    "serial:?baud=9600",
    "serial:socket://",
    "serial:/dev/ttyUSB0?baud",
    "serial:/dev/ttyUSB0?baud=",
    "serial:/dev/ttyUSB0?baud=fast",
    "serial:/dev/ttyUSB0?baud=0",
    "serial:/dev/ttyUSB0?baud=-9600",
    "serial:/dev/ttyUSB0?baud=9600.5",
    "serial:/dev/ttyUSB0?baud=٣",
    "serial:/dev/ttyUSB0?speed=9600",
    "serial:/dev/ttyUSB0?rtscts=maybe",
    "serial:/dev/tty\nUSB0",
    "can:",
    "can:socketcan",
    "can:socketcan/",
    "can:/can0",
    "can:socketcan/can0?bitrate",
    "can:socketcan/can0?bitrate=",
    "can:socketcan/can0?bit rate=3",
    "can:socketcan/can0?channel=can1",
    "tcp:127.0.0.1:5",
]


@pytest.mark.parametrize("text", UNDERSTOOD)
def test_understood(text: str) -> None:
    assert parse_port(text) == UNDERSTOOD[text]
    assert parse_port(str(UNDERSTOOD[text])) == UNDERSTOOD[text]


@pytest.mark.parametrize("text", REFUSED)
def test_refused_in_one_line_that_names_it_and_an_example(text: str) -> None:
    with pytest.raises(BadInputError) as caught:
        parse_port(text)
    line = str(caught.value)
    assert "\n" not in line
    assert repr(text) in line
    assert re.search(r"sim:|serial:|can:|feetech:|dynamixel:|must be 0 or 1|rising, each once", line)


@given(
    st.text()
    | st.sampled_from(["serial:", "can:", "sim:", "/", "socket://"]).flatmap(
        lambda p: st.text().map(p.__add__)
    )
)
def test_any_text_is_a_port_or_one_line(text: str) -> None:
    port, line = None, ""
    try:
        port = parse_port(text)
    except BadInputError as error:
        line = str(error)
    assert "\n" not in line
    assert port is None or parse_port(str(port)) == port


WORD = st.from_regex(r"[A-Za-z0-9_.:/-]+", fullmatch=True)


@given(WORD.filter(lambda w: "://" not in w), st.integers(1, 10**8), st.booleans(), st.none() | st.booleans())
def test_serial_ports_come_back(device: str, baud: int, rtscts: bool, dtr: bool | None) -> None:
    port = SerialPort(device, baud, rtscts, dtr)
    assert parse_port(str(port)) == port


@given(
    st.from_regex(r"[a-z_0-9]+", fullmatch=True),
    WORD,
    st.dictionaries(
        st.from_regex(r"[a-z_]+", fullmatch=True).filter(lambda k: k not in ("interface", "channel")), WORD
    ),
)
def test_can_ports_come_back(interface: str, channel: str, options: dict[str, str]) -> None:
    port = CanPort(interface, channel, tuple(options.items()))
    assert parse_port(str(port)) == port


def test_the_simulated_board_in_this_process_is_not_a_link_to_open() -> None:
    with pytest.raises(BadInputError, match="board sim"):
        open_link("sim:")
