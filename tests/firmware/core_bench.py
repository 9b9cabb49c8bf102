"""The C core on the bench: time, wires and joints in the test's hands. It can stand behind a link."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Sequence
from typing import Any

from firmware_protocol.frame import Frame
from firmware_protocol.framing import StreamDecoder, pack_all
from snakebot.clock import VirtualClock
from snakebot.links.base import Link

_WIRE = 65536


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
            counts_per_rev, ctypes.c_float(time_constant_s),
        )  # fmt: skip

    def step(self, t_s: float) -> None:
        """Bring the board to a time: each timer runs when it is due."""
        until_us = max(round(t_s * 1e6), self._time_us)
        self.library.bench_step()
        while (idle_us := self.library.bench_idle_us()) <= until_us - self._time_us:
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

    def said(self) -> list[Frame]:
        frames = self._decoder.feed(self.take())
        assert self._decoder.corrupt == 0
        return frames

    def reset(self) -> None:
        self.library.bench_reset()

    def place(self, joint: int, angle_rad: float) -> None:
        """Turn a joint (from 1) by hand."""
        self.library.simulated_joints_place(joint - 1, ctypes.c_float(angle_rad))

    def target_rad(self, joint: int) -> float:
        """Where the pulses send a servo (from 1); NaN without power."""
        return float(self.library.simulated_joints_target(joint - 1))


class CoreLink(Link):
    """A host's end of the wire to a C board in this process."""

    def __init__(self, bench: CoreBench, clock: VirtualClock, *, can: bool = False) -> None:
        super().__init__("core:can" if can else "core:serial")
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

    def receive(self, timeout_s: float) -> list[Frame]:
        now_s = self.clock.now_s()
        deadline_s = now_s + timeout_s
        while True:
            self.bench.step(now_s)
            frames = self._decoder.feed(self.bench.take())
            if frames or now_s >= deadline_s:
                self.statistics.received += len(frames)
                self.statistics.corrupt = self._decoder.corrupt
                return frames
            idle_s = self.bench.library.bench_idle_us() * 1e-6
            self.clock.sleep_until(min(now_s + max(idle_s, 1e-6), deadline_s))
            now_s = self.clock.now_s()

    def close(self) -> None:
        pass
