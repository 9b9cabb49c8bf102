"""The vendors' own SDKs, and another driver, drive the emulated servos over a pseudo-terminal."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import pytest
from rigs import emulated, on_a_pty

from snakebot.servobus.emulated.end import ServoBusEnd


@pytest.fixture
def dxl() -> Iterator[tuple[Any, Any, ServoBusEnd]]:
    import dynamixel_sdk as sdk

    with on_a_pty(emulated("xl330")) as end:
        port = sdk.PortHandler(end.path)
        assert port.openPort()
        assert port.setBaudRate(1_000_000)
        yield port, sdk.PacketHandler(2.0), end
        port.closePort()


@pytest.fixture
def sts() -> Iterator[tuple[Any, Any, ServoBusEnd]]:
    import scservo_sdk as sdk

    with on_a_pty(emulated("sts3215")) as end:
        port = sdk.PortHandler(end.path)
        assert port.openPort()
        assert port.setBaudRate(1_000_000)
        yield port, sdk.PacketHandler(0), end
        port.closePort()


TIMEOUTS = (-3001, -3002, -6, -7)  # of both SDKs, after 34 ms: nothing came, or a part


class Patient:
    """An SDK's packet handler whose questions are asked again where this computer was too busy for its 34 ms."""

    def __init__(self, handler: Any) -> None:
        self._handler = handler

    def __getattr__(self, name: str) -> Any:
        def ask(*arguments: Any) -> Any:
            for _ in range(10):
                answer = getattr(self._handler, name)(*arguments)
                if not any(part in TIMEOUTS for part in answer if isinstance(part, int)):
                    break
            return answer

        return ask


def test_dynamixel_ping_read_write(dxl: Any) -> None:
    port, plain, end = dxl
    handler = Patient(plain)
    assert handler.ping(port, 3) == (1190, 0, 0)
    assert handler.ping(port, 9)[1] != 0, "nobody has the id 9"
    found, result = handler.broadcastPing(port)
    assert result == 0
    assert found == {number: [1190, 45] for number in range(1, 6)}
    assert handler.write1ByteTxRx(port, 3, 64, 1) == (0, 0)
    assert end.bus.servos[2].driving
    assert handler.read1ByteTxRx(port, 3, 64) == (1, 0, 0)
    assert handler.read4ByteTxRx(port, 3, 132)[0] == 2048
    _, error = handler.write1ByteTxRx(port, 3, 11, 4)
    assert error == 7, "the operating mode cannot be written with torque on"
    _, error = handler.write4ByteTxRx(port, 3, 116, 5000)
    assert error == 6, "a goal beyond the servo's limits"


def test_dynamixel_sync_write_and_both_sync_reads(dxl: Any) -> None:
    import dynamixel_sdk as sdk

    port, handler, _end = dxl
    for servo in range(1, 6):
        Patient(handler).write1ByteTxRx(port, servo, 64, 1)
    write = sdk.GroupSyncWrite(port, handler, 116, 4)
    for servo in range(1, 6):
        assert write.addParam(servo, list((2048 + 100 * servo).to_bytes(4, "little")))
    assert write.txPacket() == 0
    deadline = time.monotonic() + 3.0
    read = sdk.GroupSyncRead(port, handler, 132, 4)
    for servo in range(1, 6):
        read.addParam(servo)
    for ask in (read.txRxPacket, read.fastSyncRead):
        positions: list[int] = []
        while time.monotonic() < deadline and positions != [2148, 2248, 2348, 2448, 2548]:
            if ask() != 0:  # this computer was busy: both SDKs wait for 34 ms
                continue
            positions = [read.getData(servo, 132, 4) for servo in range(1, 6)]
        assert positions == [2148, 2248, 2348, 2448, 2548]


def test_dynamixel_bus_watchdog(dxl: Any) -> None:
    """It stops the joint, refuses goals until it is cleared, and any instruction feeds it."""
    port, plain, _end = dxl
    handler = Patient(plain)
    handler.write4ByteTxRx(port, 1, 112, 20)  # slow: 0.48 rad/s
    handler.write1ByteTxRx(port, 1, 64, 1)
    handler.write1ByteTxRx(port, 1, 98, 10)  # 200 ms
    handler.write4ByteTxRx(port, 1, 116, 4000)
    for _ in range(10):
        time.sleep(0.03)
        plain.ping(port, 2)
    assert handler.read1ByteTxRx(port, 1, 98)[0] == 10, "pings of another servo feed it"
    time.sleep(0.3)
    assert handler.read1ByteTxRx(port, 1, 98)[0] == 0xFF
    stopped = handler.read4ByteTxRx(port, 1, 132)[0]
    assert stopped < 3900, "it stopped before it was there"
    assert handler.read1ByteTxRx(port, 1, 64)[0] == 1, "it holds: torque is on"
    assert handler.write4ByteTxRx(port, 1, 116, 2048) == (0, 4)
    assert handler.write1ByteTxRx(port, 1, 98, 0) == (0, 0)
    assert handler.write4ByteTxRx(port, 1, 116, 2048) == (0, 0)


def test_feetech_ping_read_write(sts: Any) -> None:
    port, plain, end = sts
    handler = Patient(plain)
    assert handler.ping(port, 2) == (777, 0, 0)
    assert handler.ping(port, 9)[1] != 0
    assert handler.write1ByteTxRx(port, 2, 40, 1) == (0, 0)
    assert end.bus.servos[1].driving
    assert handler.read2ByteTxRx(port, 2, 56)[0] == 2048
    assert handler.write2ByteTxRx(port, 2, 42, 2100) == (0, 0)
    deadline = time.monotonic() + 3.0
    while handler.read2ByteTxRx(port, 2, 56)[0] != 2100:
        assert time.monotonic() < deadline


def test_feetech_sync_write_and_read(sts: Any) -> None:
    import scservo_sdk as sdk

    port, handler, _end = sts
    write = sdk.GroupSyncWrite(port, handler, 40, 4)  # torque, acceleration, goal
    for servo in range(1, 6):
        goal = 2048 - 100 * servo
        assert write.addParam(servo, [1, 0, goal & 0xFF, goal >> 8])
    assert write.txPacket() == 0
    read = sdk.GroupSyncRead(port, handler, 56, 2)
    for servo in range(1, 6):
        read.addParam(servo)
    deadline = time.monotonic() + 3.0
    positions: list[int] = []
    while time.monotonic() < deadline and positions != [1948, 1848, 1748, 1648, 1548]:
        if read.txRxPacket() != 0:
            continue
        positions = [read.getData(servo, 56, 2) for servo in range(1, 6)]
    assert positions == [1948, 1848, 1748, 1648, 1548]


@pytest.mark.parametrize(
    ("model", "controller"),
    [("sts3215", "Sts3215PyController"), ("scs0009", "Scs0009PyController"), ("xl330", "Xl330PyController")],
)
def test_a_third_driver_reads_angles(model: str, controller: str) -> None:
    import rustypot

    with on_a_pty(emulated(model, start_rad=[0.0, 0.5, -0.5, 0.1, 0.2])) as end:
        driver = getattr(rustypot, controller)(end.path, 1_000_000, 0.5)
        found = [driver.read_present_position(servo)[0] for servo in range(1, 6)]
    assert found == pytest.approx([0.0, 0.5, -0.5, 0.1, 0.2], abs=0.01)
