"""The C core on the bench: time, wires and joints in the test's hands. It can stand behind a link."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Sequence
from typing import Any

from firmware_protocol.frame import Frame
from firmware_protocol.framing import StreamDecoder, pack_all
from snakebot.clock import VirtualClock
from snakebot.conformance import ViolationError
from snakebot.links.base import Link

_WIRE = 65536
_MOST_TURNS = 50  # at one moment: what is due is done in some


class CoreBench:
    """One C board. The library holds one at a time: a new one replaces it."""

    def __init__(
        self,
        library: Any,
        joints: int = 5,
        *,
        seed: int = 1,
        start_us: int = 0,
        limits: tuple[float, float, float] = (math.radians(95.0), 8.0, 60.0),
        counts_per_rev: int = 8192,
        time_constant_s: float = 0.0,
        simulated: bool = True,
    ) -> None:
        self.library = library
        self.joints = joints
        self._start_us = start_us
        self._time_us = 0
        self._decoder = StreamDecoder()
        self._buffer = (ctypes.c_uint8 * _WIRE)()
        library.simulated_joints_target.restype = ctypes.c_float
        library.bench_new(
            joints, seed, ctypes.c_uint32(start_us), *(ctypes.c_float(limit) for limit in limits),
            counts_per_rev, ctypes.c_float(time_constant_s), simulated,
        )  # fmt: skip

    def step(self, t_s: float) -> None:
        """Bring the board to a time: each timer runs when it is due."""
        until_us = max(round(t_s * 1e6), self._time_us)
        self.library.bench_step()
        turns = 0
        while (idle_us := self.library.bench_idle_us()) <= until_us - self._time_us:
            turns = 0 if idle_us else turns + 1
            if turns > _MOST_TURNS:
                raise ViolationError(f"at {self._time_us} us the board always has something to do")
            self._at(self._time_us + idle_us)
            self.library.bench_step()
        self._at(until_us)

    def _at(self, time_us: int) -> None:
        self._time_us = time_us
        self.library.bench_time(ctypes.c_uint32((self._start_us + time_us) & 0xFFFFFFFF))

    def serial(self, data: bytes) -> None:
        """Bytes arrive."""
        for start in range(0, len(data), 4096):
            part = data[start : start + 4096]
            self.library.bench_serial(part, len(part))
            self.library.bench_step()

    def can(self, frames: Sequence[Frame]) -> None:
        """Frames arrive over CAN."""
        for frame in frames:
            self.library.bench_can(frame.id, frame.data, len(frame.data))
        self.library.bench_step()

    def take(self) -> bytes:
        """What it has said over its serial line."""
        length = self.library.bench_take(self._buffer)
        return bytes(self._buffer[:length])

    def take_can(self) -> list[Frame]:
        """What it has said over CAN."""
        identifier, data, frames = ctypes.c_uint16(), (ctypes.c_uint8 * 8)(), []
        while (length := self.library.bench_take_can(ctypes.byref(identifier), data)) >= 0:
            frames.append(Frame(identifier.value, bytes(data[:length])))
        return frames

    def said(self) -> Sequence[Frame]:
        frames = self._decoder.feed(self.take())
        assert self._decoder.corrupt == 0
        return frames

    def reset(self) -> None:
        self.library.bench_reset()

    def reset_at(self, start_us: int) -> None:
        """Switch it off and on; its clock goes on from there."""
        self._start_us = (start_us - self._time_us) & 0xFFFFFFFF
        self._at(self._time_us)
        self.library.bench_reset()

    def lose_encoder(self, joint: int, lost: bool) -> None:
        """The encoder of a joint (from 1) gives no reading, or gives one again."""
        self.library.simulated_joints_encoder_lost(joint - 1, lost)

    def fail(self, code: int, joint: int, detail: int) -> None:
        """A fault of the hardware from now on; code 0 ends it."""
        self.library.simulated_joints_fault(int(code), joint, ctypes.c_int16(detail))

    def store_trim(self, joint: int, steps: int) -> None:
        """What is stored of a joint's trim (from 1), in steps of the wire: read at the next reset."""
        self.library.bench_store_trim(joint - 1, ctypes.c_int16(steps))

    def draw(self, numbers: Sequence[int]) -> None:
        """What the random source gives next."""
        for number in reversed(numbers):
            self.library.bench_draw(ctypes.c_uint32(number))

    def limit(self, joint: int, limits: Sequence[float]) -> None:
        """Built-in limits of a joint (from 1): angle, speed, acceleration; from the next reset on."""
        self.library.bench_limits(joint - 1, *(ctypes.c_float(limit) for limit in limits))

    def supply(self, measured: tuple[int, int, int] | None) -> None:
        """What the supply's sensors measure (mV, mA, tenths of a degree); None: there are none."""
        volts, amperes, degrees = measured or (0, 0, 0)
        self.library.simulated_joints_supply(
            measured is not None, volts, ctypes.c_int16(amperes), ctypes.c_int16(degrees)
        )

    def place(self, joint: int, angle_rad: float) -> None:
        """Turn a joint (from 1) by hand."""
        self.library.simulated_joints_place(joint - 1, ctypes.c_float(angle_rad))

    def target_rad(self, joint: int) -> float:
        """Where the pulses send a servo (from 1); NaN without power."""
        return float(self.library.simulated_joints_target(joint - 1))


class CoreLink(Link):
    """A host's end of the wire to a C board in this process."""

    def __init__(self, bench: CoreBench, clock: VirtualClock, *, can: bool = False) -> None:
        super().__init__("core:can" if can else "core:serial", math.inf)
        self.bench = bench
        self.clock = clock
        self._can = can
        self._decoder = StreamDecoder()

    def send(self, frames: Sequence[Frame]) -> None:
        self.bench.step(self.clock.now_s())
        if self._can:
            self.bench.can(frames)
        else:
            self.bench.serial(pack_all(frames))
        self.statistics.sent += len(frames)

    def send_bytes(self, data: bytes) -> None:
        """Bytes as they are: tests put noise here."""
        self.bench.step(self.clock.now_s())
        self.bench.serial(data)

    def receive(self, timeout_s: float) -> Sequence[Frame]:
        now_s = self.clock.now_s()
        deadline_s = now_s + timeout_s
        while True:
            self.bench.step(now_s)
            said = self._decoder.feed(self.bench.take())
            frames = self.bench.take_can() if self._can else said
            if frames or now_s >= deadline_s:
                self.statistics.received += len(frames)
                self.statistics.corrupt = self._decoder.corrupt
                return frames
            idle_s = self.bench.library.bench_idle_us() * 1e-6
            self.clock.sleep_until(min(now_s + max(idle_s, 1e-6), deadline_s))
            now_s = self.clock.now_s()

    def close(self) -> None:
        pass
