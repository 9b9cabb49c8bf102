"""Every board of the project at the end of a link, ready for the suite."""

from __future__ import annotations

import contextlib
import json
import math
import os
import random
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from building import need
from core_bench import CoreBench, CoreLink
from lagging_plant import LaggingHardware, LaggingPlant

import snakebot
from firmware_protocol.catalogue import Fault
from snakebot.clock import MonotonicClock, VirtualClock
from snakebot.conformance import Bench, Case, Lab, Plate, cases
from snakebot.links import Link, open_link
from snakebot.links.stream_link import StreamLink
from snakebot.robot import Robot, load_robot, robot_from_mapping
from snakebot.softboard import InProcessLink, SoftBoard
from snakebot.softboard.hardware import HardwareFault

STARTS_S = 20.0
SERIAL_NUMBER = 0x0123456789ABCDEF
_DRIFT_PPM = 4000.0  # a clock without a crystal: fast enough to show whether it is used the right way round
CORE_SERIAL_NUMBER = 0xFEDCBA9876543210  # port/bench


def bytes_of(link: Link) -> Callable[[bytes], None]:
    """Raw bytes onto the stream under a serial link."""
    assert isinstance(link, StreamLink)
    return link.send_bytes


@contextmanager
def ahead_of_others() -> Iterator[None]:
    """Board and bench before whatever else the machine does, where it lets us: a board has its processor to itself."""
    before = os.getpriority(os.PRIO_PROCESS, 0)
    with contextlib.suppress(PermissionError):
        os.setpriority(os.PRIO_PROCESS, 0, -15)
    try:
        yield
    finally:
        with contextlib.suppress(PermissionError):
            os.setpriority(os.PRIO_PROCESS, 0, before)


class Draws(random.Random):
    """A source of random numbers that gives some numbers first."""

    def __init__(self, numbers: Sequence[int]) -> None:
        super().__init__(1)
        self._next = list(numbers)

    def randrange(self, start: int, stop: int | None = None, step: int = 1) -> int:
        while self._next:
            number = self._next.pop(0)
            if stop is None or start <= number < stop:
                return number
        return super().randrange(start, stop, step)


def draw_next(board: SoftBoard, numbers: Sequence[int]) -> None:
    board._boots = Draws(numbers)


def built_in(robot: Robot) -> tuple[tuple[float, float, float], ...]:
    """Each joint's limits, which are those of its board."""
    limits = (robot.angle_limit_rad, robot.speed_limit_rad_s, robot.acceleration_limit_rad_s2)
    return tuple((float(a), float(v), float(c)) for a, v, c in zip(*limits, strict=True))


def _limits_of(joint: int) -> tuple[float, float, float]:
    """Limits of a joint (from 1): each has its own, at the edge of what rounds to one step of the wire or the other.

    The speed of the sixteenth is more than the wire can say.
    """
    odd = joint % 2 == 1
    angle = 1.65 - 0.002 * joint - (4.75e-5 if odd else 5.25e-5)
    speed = 8.0 - 0.02 * joint - (0.95e-3 if odd else 1.05e-3)
    return angle, speed if joint < 16 else 300.0, 60.0 - 0.1 * joint


def _sim_bench(board: SoftBoard, clock: VirtualClock, *, simulated: bool, pose: bool, **hands: Any) -> Bench:
    raw: list[bytes] = []
    link = InProcessLink(board, clock, to_board=lambda data: raw.pop() if raw else data)

    def send_bytes(data: bytes) -> None:
        raw.append(data)
        link.send([])

    major, minor, patch = (int(part) for part in snakebot.__version__.split(".")[:3])
    plate = Plate(
        board.robot.joints,
        board.robot.encoder_counts_per_rev,
        SERIAL_NUMBER,
        (major, minor, patch),
        simulated,
        pose,
        built_in(board.robot),
    )

    def fail(fault: Fault, joint: int, detail: int) -> None:
        board.fail(HardwareFault(fault, joint, detail), clock.now_s())

    lab = Lab(
        reset_at=lambda clock_us: board.reset(clock.now_s(), clock_us),
        fail=hands.pop("fail", fail),
        draw=lambda numbers: draw_next(board, numbers),
        plate=plate,
        **hands,
    )
    return Bench(
        link,
        clock,
        send_bytes=send_bytes,
        reset=lambda: board.reset(clock.now_s()),
        lab=lab,
        tolerance_s=0.003,
    )


@contextmanager
def sim_in_process() -> Iterator[Bench]:
    """The simulated board with its robot, on a virtual clock."""
    board = SoftBoard(load_robot("penn_state"), serial_number=SERIAL_NUMBER)
    yield _sim_bench(board, VirtualClock(), simulated=True, pose=True)


@contextmanager
def sim_with_hands(joints: int = 5, *, counts_per_rev: int = 8192, drift_ppm: float = 0.0) -> Iterator[Bench]:
    """The simulated board with joints that hands can turn, on a virtual clock; its own may run fast."""
    plant = LaggingPlant(joints, counts_per_rev)
    clock = VirtualClock(-1000.0)  # a host's time may be any
    board = _board_of(plant, joints, counts_per_rev, drift_ppm)
    yield _sim_bench(board, clock, simulated=True, pose=False, turn_joint=plant.turn, lose_encoder=plant.lose)


@contextmanager
def sim_with_hardware(joints: int = 3) -> Iterator[Bench]:
    """The simulated board's protocol before joints that are there: they fail and measure themselves."""
    plant = LaggingHardware(joints)
    clock = VirtualClock(1000.0)
    board = _board_of(plant, joints, 8192, 0.0)

    def fail(fault: Fault, joint: int, detail: int) -> None:
        button = fault is Fault.EMERGENCY_STOP
        plant.fail(Fault.NONE if button else fault, joint, detail)
        board.fail(HardwareFault(fault if button else Fault.NONE), clock.now_s())

    yield _sim_bench(
        board, clock, simulated=False, pose=False, turn_joint=plant.turn, lose_encoder=plant.lose, fail=fail,
        supply=plant.measure, supply_is_of_joints=True,
    )  # fmt: skip


def _board_of(plant: LaggingPlant, joints: int, counts_per_rev: int, drift_ppm: float) -> SoftBoard:
    angle, speed, acceleration = zip(*(_limits_of(joint) for joint in range(1, joints + 1)), strict=True)
    limits = {
        "angle_deg": [math.degrees(value) for value in angle],
        "speed_rad_s": list(speed),
        "acceleration_rad_s2": list(acceleration),
    }
    described = {"joints": joints, "limits": limits, "encoder_counts_per_rev": counts_per_rev}
    robot = robot_from_mapping(described, "bench")
    return SoftBoard(robot, serial_number=SERIAL_NUMBER, plant=plant, drift_ppm=drift_ppm)


@contextmanager
def core_in_process(
    library: Any,
    *,
    can: bool = False,
    start_us: int = 0,
    joints: int = 5,
    simulated: bool = True,
    counts_per_rev: int = 8192,
) -> Iterator[Bench]:
    """The C core on a virtual clock."""
    clock = VirtualClock()
    bench = CoreBench(
        library,
        joints,
        start_us=start_us,
        time_constant_s=0.03,
        simulated=simulated,
        counts_per_rev=counts_per_rev,
    )
    limits = [_limits_of(joint) for joint in range(1, joints + 1)]
    for joint, of_joint in enumerate(limits, start=1):
        bench.limit(joint, of_joint)
    bench.reset()
    link = CoreLink(bench, clock, can=can)
    send_bytes = None if can else link.send_bytes
    lab = Lab(
        reset_at=bench.reset_at,
        turn_joint=bench.place,
        lose_encoder=bench.lose_encoder,
        fail=bench.fail,
        supply=bench.supply,
        draw=bench.draw,
        store_trim=bench.store_trim,
        plate=Plate(joints, counts_per_rev, CORE_SERIAL_NUMBER, (2, 0, 0), simulated, False, tuple(limits)),
    )
    yield Bench(link, clock, send_bytes=send_bytes, reset=bench.reset, lab=lab, tolerance_s=0.003)


@contextmanager
def _program(*command: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A program that prints the port to use in its first line."""
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        ready, _, _ = select.select([process.stdout], [], [], STARTS_S)
        assert ready, f"{command[0]} printed no port within {STARTS_S} s"
        yield process, process.stdout.readline().strip()
    finally:
        process.terminate()
        process.wait(10.0)
        if process.stdout is not None:
            process.stdout.close()


@contextmanager
def sim_program(*options: str) -> Iterator[Bench]:
    """The simulated board as its own program: ``--serial`` or ``--can slcan``."""
    program = "from snakebot.cli.main import main; main()"
    command = [sys.executable, "-c", program, "board", "sim", *options, "--json"]
    with _program(*command) as (_, line), open_link(json.loads(line)["port"]) as link:
        yield Bench(link, MonotonicClock(), send_bytes=bytes_of(link) if "--serial" in options else None)


@contextmanager
def host_firmware(program: Path, *options: str) -> Iterator[Bench]:
    """The reference firmware as a Linux program."""
    with _program(str(program), *options) as (process, port), open_link(port) as link:
        send_bytes = None if "--slcan" in options else bytes_of(link)
        yield Bench(
            link,
            MonotonicClock(),
            send_bytes=send_bytes,
            reset=lambda: _press(lambda: process.send_signal(signal.SIGUSR1)),
        )


def _press(reset: Callable[[], None]) -> None:
    reset()
    time.sleep(0.1)  # until it is up again


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as door:
        port: int = door.getsockname()[1]
        return port


@contextmanager
def qemu_with_monitor(image: Path) -> Iterator[tuple[str, socket.socket]]:
    """The Cortex-M image on an emulated MPS2 board; the port to use, and the emulator's monitor."""
    need("qemu-system-arm")
    serial, monitor = free_port(), free_port()
    command = [
        "qemu-system-arm", "-M", "mps2-an385", "-display", "none", "-kernel", str(image),
        "-serial", f"tcp:127.0.0.1:{serial},server=on,wait=off,nodelay=on",
        "-monitor", f"tcp:127.0.0.1:{monitor},server=on,wait=off,nodelay=on",
    ]  # fmt: skip
    process = subprocess.Popen(command)
    try:
        connected(serial).close()  # it listens there too
        with connected(monitor) as buttons:
            yield f"serial:socket://127.0.0.1:{serial}", buttons
    finally:
        process.terminate()
        process.wait(10.0)


@contextmanager
def qemu(image: Path) -> Iterator[tuple[str, Callable[[], None]]]:
    """The same; the port to use, and the board's reset button."""
    with qemu_with_monitor(image) as (port, monitor):
        yield port, lambda: _press(lambda: monitor.sendall(b"system_reset\n"))


def connected(port: int) -> socket.socket:
    """A connection to a program that is starting."""
    deadline = time.monotonic() + STARTS_S
    while True:
        try:
            return socket.create_connection(("127.0.0.1", port))
        except OSError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.02)


@contextmanager
def cortex_m(image: Path) -> Iterator[Bench]:
    """The reference firmware on an emulated Cortex-M3."""
    with qemu(image) as (port, reset), open_link(port) as link:
        yield Bench(link, MonotonicClock(), send_bytes=bytes_of(link), reset=reset, tolerance_s=0.03)


def cores_in_process(library: Any) -> list[Callable[[], Any]]:
    """Every bench of the C core in virtual time: the first takes all cases, the others the quick ones."""
    wrap = 1 << 32
    return [
        lambda: core_in_process(library, joints=6),  # the last group of three is full
        lambda: core_in_process(library, can=True, start_us=wrap - 650_000, joints=16, counts_per_rev=4096),
        lambda: core_in_process(library, start_us=wrap - 200_000, joints=1, simulated=False),
    ]


def sims_in_process() -> list[Callable[[], Any]]:
    """Every bench of the simulated board in virtual time."""
    return [
        sim_with_hands,
        sim_in_process,
        lambda: sim_with_hands(16, counts_per_rev=4096),
        lambda: sim_with_hands(1, drift_ppm=_DRIFT_PPM),
        sim_with_hardware,
    ]


def warm_up() -> None:
    """Compile what the simulated board needs of the physics."""
    SoftBoard(load_robot("penn_state"))


# What a wire and a real clock can change: every other promise is one of logic, asked in virtual time of the same code.
_ABOUT_WIRE_AND_TIME = {
    "bad_frames", "beats", "clock", "feeding", "frames", "identity", "latches", "reboot", "setpoints", "watchdog",
}  # fmt: skip


def about_wire_and_time() -> list[Case]:
    """The cases worth their time on every real wire."""
    quick = [case for case in cases() if not case.long]
    return [case for case in quick if case.function.__module__.rpartition(".")[2] in _ABOUT_WIRE_AND_TIME]
