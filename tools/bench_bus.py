#!/usr/bin/env python3
"""Cycles a second on a servo bus, beside both vendors' SDKs and rustypot, on the same pseudo-terminal in one run.

    tools/bench_bus.py                          5 and 16 joints, Feetech and Dynamixel
    tools/bench_bus.py --joints 5 --seconds 2 --family feetech

A cycle is one sync write of all goals and one sync read of all positions. Each driver has a process of its own, one at
a time, in short slices that take turns; the emulated servos are another process that does nothing else. A
pseudo-terminal has no bits: on a real line of 1 Mbaud the bits alone of a cycle of five joints take 1.0 to 1.6 ms.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
MODEL = {"feetech": "sts3215", "dynamixel": "xl330"}
DRIVERS = {
    "feetech": ("snakebot", "scservo_sdk", "rustypot"),
    "dynamixel": ("snakebot", "snakebot, plain", "dynamixel_sdk", "dynamixel_sdk, fast", "rustypot"),
}
Cycle = Callable[[int], None]


def serve(family: str, joints: int) -> None:
    """The servos' side; prints the device."""
    import threading

    from snakebot.clock import MonotonicClock
    from snakebot.servobus.emulated import EmulatedBus, EmulatedServo
    from snakebot.servobus.emulated.end import ServoBusEnd
    from snakebot.servobus.models import model_named

    servos = [EmulatedServo(model_named(MODEL[family]), number) for number in range(1, joints + 1)]
    end = ServoBusEnd(EmulatedBus(servos), MonotonicClock())
    print(end.path, flush=True)

    def close_with_parent() -> None:
        sys.stdin.read()
        end.close()

    threading.Thread(target=close_with_parent, daemon=True).start()
    while True:
        end.receive(1.0)


def ours(family: str, joints: int, device: str, *, fast: bool) -> Cycle:
    from snakebot.links.port import SerialPort
    from snakebot.links.serial_link import open_stream
    from snakebot.servobus.joints import dialect_of
    from snakebot.servobus.master import BusMaster
    from snakebot.servobus.models import model_named

    model = model_named(MODEL[family])
    stream, _ = open_stream(SerialPort(device), device)
    master = BusMaster(device, stream, dialect_of(family), baud=1_000_000, now_s=time.monotonic, fast=fast)
    position, goal = model["present_position"], model["goal_position"]
    ids = list(range(1, joints + 1))

    def cycle(count: int) -> None:
        master.sync_write(goal.address, {i: model.pack("goal_position", 2048 + count % 50) for i in ids})
        heard = master.sync_read(ids, position.address, position.size)
        assert [model.unpack("present_position", heard[i]) for i in ids]

    return cycle


def dynamixel(joints: int, device: str, *, fast: bool) -> Cycle:
    import dynamixel_sdk as sdk

    port, handler = sdk.PortHandler(device), sdk.PacketHandler(2.0)
    assert port.openPort()
    assert port.setBaudRate(1_000_000)
    write, read = sdk.GroupSyncWrite(port, handler, 116, 4), sdk.GroupSyncRead(port, handler, 132, 4)
    for servo in range(1, joints + 1):
        read.addParam(servo)
    ask = read.fastSyncRead if fast else read.txRxPacket

    def cycle(count: int) -> None:
        write.clearParam()
        for servo in range(1, joints + 1):
            write.addParam(servo, list((2048 + count % 50).to_bytes(4, "little")))
        write.txPacket()
        assert ask() == 0
        assert [read.getData(servo, 132, 4) for servo in range(1, joints + 1)]

    return cycle


def feetech(joints: int, device: str) -> Cycle:
    import scservo_sdk as sdk

    port, handler = sdk.PortHandler(device), sdk.PacketHandler(0)
    assert port.openPort()
    assert port.setBaudRate(1_000_000)
    write, read = sdk.GroupSyncWrite(port, handler, 42, 2), sdk.GroupSyncRead(port, handler, 56, 2)
    for servo in range(1, joints + 1):
        read.addParam(servo)

    def cycle(count: int) -> None:
        write.clearParam()
        for servo in range(1, joints + 1):
            write.addParam(servo, list((2048 + count % 50).to_bytes(2, "little")))
        write.txPacket()
        assert read.txRxPacket() == 0
        assert [read.getData(servo, 56, 2) for servo in range(1, joints + 1)]

    return cycle


def rustypot(family: str, joints: int, device: str) -> Cycle:
    import rustypot as library

    kind = library.Sts3215PyController if family == "feetech" else library.Xl330PyController
    driver = kind(device, 1_000_000, 0.05)
    ids = list(range(1, joints + 1))

    def cycle(count: int) -> None:
        driver.sync_write_goal_position(ids, [0.001 * (count % 50)] * joints)
        assert driver.sync_read_present_position(ids)

    return cycle


def drive(driver: str, family: str, joints: int, device: str, seconds: float) -> None:
    """One slice; prints the time of each cycle as JSON. A cycle that the driver gives up counts as lost."""
    if driver.startswith("snakebot"):
        cycle = ours(family, joints, device, fast="plain" not in driver)
    elif driver.startswith("dynamixel_sdk"):
        cycle = dynamixel(joints, device, fast="fast" in driver)
    elif driver == "scservo_sdk":
        cycle = feetech(joints, device)
    else:
        cycle = rustypot(family, joints, device)
    for count in range(20):
        cycle(count)
    took: list[float] = []
    lost = 0
    end_s = time.perf_counter() + seconds
    while (start_s := time.perf_counter()) < end_s:
        try:
            cycle(len(took))
        except Exception:
            lost += 1
            continue
        took.append(time.perf_counter() - start_s)
    print(json.dumps({"took_s": took, "lost": lost}))


def child(*words: str) -> list[str]:
    return [sys.executable, __file__, "--child", *words]


def measure(family: str, joints: int, seconds: float, rounds: int) -> None:
    servos = subprocess.Popen(
        child("serve", family, str(joints)), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert servos.stdout is not None
    device = servos.stdout.readline().strip()
    took: dict[str, list[float]] = {driver: [] for driver in DRIVERS[family]}
    lost = dict.fromkeys(took, 0)
    try:
        for _ in range(rounds):
            for driver in took:
                words = ("drive", driver, family, str(joints), device, str(seconds / rounds))
                done = subprocess.run(child(*words), capture_output=True, text=True)
                if done.returncode:
                    lost[driver] += 1
                    continue
                found = json.loads(done.stdout)
                took[driver] += found["took_s"]
                lost[driver] += found["lost"]
    finally:
        servos.kill()
        servos.wait()
    for driver, times in took.items():
        if not times:
            print(f"{family:10} {joints:2} joints  {driver:20} no cycle went through")
            continue
        times.sort()
        print(
            f"{family:10} {joints:2} joints  {driver:20} {len(times) / sum(times):6.0f} cycles/s, "
            f"median {1e3 * times[len(times) // 2]:.2f} ms, p99 {1e3 * times[int(0.99 * len(times))]:.2f} ms, "
            f"{len(times)} cycles, {lost[driver]} lost",
            flush=True,
        )


def main() -> int:
    if sys.argv[1:2] == ["--child"]:
        what, *words = sys.argv[2:]
        if what == "serve":
            serve(words[0], int(words[1]))
        else:
            drive(words[0], words[1], int(words[2]), words[3], float(words[4]))
        return 0
    assert __doc__ is not None
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--joints", type=int, action="append", help="[5 and 16]; may be repeated")
    parser.add_argument("--family", choices=tuple(MODEL), action="append", help="[both]")
    parser.add_argument("--seconds", type=float, default=4.0, help="of each driver")
    parser.add_argument("--rounds", type=int, default=4, help="slices that each driver's time is cut into")
    options = parser.parse_args()
    for family in options.family or MODEL:
        for joints in options.joints or (5, 16):
            measure(family, joints, options.seconds, options.rounds)
    return 0


if __name__ == "__main__":
    sys.exit(main())
