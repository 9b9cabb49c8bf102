"""Emulated servos at the end of a pty, served by a thread, or in memory on a virtual clock."""

from __future__ import annotations

import contextlib
import sys
import threading
from collections.abc import Iterator, Sequence
from typing import Any

from snakebot.clock import Clock, MonotonicClock, VirtualClock
from snakebot.conformance import Bench
from snakebot.effects import Plant
from snakebot.errors import NoBoardError
from snakebot.robot import JointServo, Robot, robot_from_mapping
from snakebot.servobus.emulated import EmulatedBus, EmulatedServo, ServoChain
from snakebot.servobus.emulated.end import ServoBusEnd, serve_servos
from snakebot.servobus.joints import wanted_servos
from snakebot.servobus.master import BusMaster
from snakebot.servobus.models import model_named
from snakebot.servobus.opening import ServoLink, board_of
from snakebot.servobus.plant import ServoPlant

MODELS = {"feetech": "sts3215", "dynamixel": "xl330"}


def bench(joints: int = 5, **more: Any) -> Robot:
    """Servos without a body: their dynamics cost next to nothing."""
    return robot_from_mapping({"joints": joints, "encoder_counts_per_rev": 4096, **more}, "test")


def emulated(
    model: str,
    joints: int = 5,
    *,
    robot: Robot | None = None,
    effects: Sequence[str] = (),
    start_rad: Sequence[float] | float = 0.0,
    zero_counts: Sequence[float] | None = None,
    direction: Sequence[int] | None = None,
    ids: Sequence[int] | None = None,
    plant: Any = None,
    **wires: Any,
) -> EmulatedBus:
    """Servos of one model with ids from 1, and joints behind them."""
    robot = bench(joints) if robot is None else robot
    plant = Plant(robot, effects, initial_rad=start_rad) if plant is None else plant
    numbers = list(ids) if ids is not None else list(range(1, robot.joints + 1))
    servos = [EmulatedServo(model_named(model), number) for number in numbers]
    return EmulatedBus(servos, ServoChain(robot, plant, servos, zero_counts, direction), **wires)


@contextlib.contextmanager
def on_a_pty(bus: EmulatedBus, clock: Clock | None = None) -> Iterator[ServoBusEnd]:
    """Serve them in a thread."""
    bus.advance(0.0)  # whatever is compiled is compiled now
    bus.advance(0.002)
    end = ServoBusEnd(bus, MonotonicClock() if clock is None else clock)
    end._start_s -= 0.002
    stop = threading.Event()
    thread = threading.Thread(target=serve_servos, args=(end, stop), daemon=True)
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-4)  # the SDKs spin while they wait for an answer
    thread.start()

    def unplug() -> None:
        stop.set()
        thread.join(5.0)
        end.close()

    end.unplug = unplug  # type: ignore[attr-defined]
    try:
        yield end
    finally:
        sys.setswitchinterval(before)
        stop.set()
        thread.join(5.0)
        end.close()


class MemoryLine:
    """A line to emulated servos without a wire: a question is answered before the write returns."""

    def __init__(self, bus: EmulatedBus, clock: VirtualClock, baud: int | None = None) -> None:
        self.bus = bus
        self.clock = clock
        self.baud = baud
        self.cut = False
        self.written: list[bytes] = []
        self._start_s = clock.now_s()
        self._waiting = b""

    def write(self, data: bytes) -> None:
        if self.cut:
            raise OSError(5, "Input/output error")
        self.written.append(data)
        self.bus.pause()  # the clock stands while the host waits for answers that do not come
        self._waiting += self.bus.feed(data, self.clock.now_s() - self._start_s, self.baud)

    def read(self, timeout_s: float) -> bytes:
        if self.cut:
            raise OSError(5, "Input/output error")
        said, self._waiting = self._waiting, b""
        return said

    def close(self) -> None:
        pass


def master_of(line: MemoryLine, where: str = "feetech:memory") -> BusMaster:
    """The host's end of a line in memory."""
    return BusMaster(where, line, line.bus.dialect, baud=1_000_000, now_s=line.clock.now_s)


class Rig:
    """A board in front of emulated servos, in virtual time; ``bench`` talks to the board."""

    line_baud: int | None = None  # at which the host writes; None: at whatever the servos listen to

    def __init__(
        self,
        bus: EmulatedBus,
        robot: Robot,
        *,
        servos: Sequence[JointServo] | None = None,
        watchdog: bool = True,
        reopen: bool = False,
    ) -> None:
        self.clock = VirtualClock()
        self.bus = bus
        self.line = MemoryLine(bus, self.clock, self.line_baud)
        self.master = master_of(self.line, f"{bus.dialect.name}:memory")
        wanted = servos if servos is not None else wanted_servos(robot, ())
        again = self._opened_again if reopen else None
        self.board = board_of(self.master, robot, wanted, self.clock, watchdog=watchdog, reopen=again)
        self.link = ServoLink(self.board, self.clock, self.master.where)
        self.bench = Bench(self.link, self.clock, tolerance_s=0.003)
        self.servos = bus.servos

    def _opened_again(self) -> MemoryLine:
        if self.line.cut:
            raise NoBoardError("still unplugged")
        return self.line

    @property
    def plant(self) -> ServoPlant:
        return self.board.servos

    def stream(self, seconds: float, angles_rad: Sequence[float], interval_s: float = 0.01) -> None:
        """Stream one posture."""
        self.bench.stream(seconds, lambda t: angles_rad, interval_s)
