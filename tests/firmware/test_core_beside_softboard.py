"""Two boards that share no code, side by side: the C core and the simulated board, fed the same frames at one time.

What they say must be the same, frame by frame: an angle may differ by one step of the wire (single precision in C).
"""

from __future__ import annotations

import ctypes
import itertools
import math
import random
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest
from core_bench import CoreBench
from test_vectors import VECTORS

from firmware_protocol.assembly import setpoint_messages
from firmware_protocol.catalogue import (
    Applied,
    BoardHeartbeat,
    ClearRequest,
    EmergencyStop,
    Fault,
    FaultEvent,
    HostHeartbeat,
    InfoFirmware,
    InfoRequest,
    JointMode,
    JointModeRequest,
    LimitKind,
    LimitRequest,
    Message,
    Mode,
    ModeRequest,
    Ping,
    Pong,
    State,
    StopReason,
    TrimRequest,
    ZeroRequest,
    decode,
    encode,
)
from firmware_protocol.frame import Frame
from firmware_protocol.framing import pack_all
from snakebot.robot import robot_from_mapping
from snakebot.softboard import SoftBoard
from snakebot.softboard.hardware import HardwareFault

HOSTS = (0, 11, 11, 11, 11, 22)
CORE_SERIAL_NUMBER = 0xFEDCBA9876543210  # port/bench


class PromptJoints:
    """Servos that are at their pulse as soon as time goes on, as the bench's are without a time constant."""

    clock_ppm = 0.0

    def __init__(self, joints: int, counts_per_rev: int) -> None:
        self._counts_per_rev = counts_per_rev
        self.angle_rad = [0.0] * joints
        self._wanted = [0.0] * joints
        self._free = [True] * joints
        self._t_s = 0.0

    def command(self, t_s: float, setpoint_rad: Sequence[float]) -> None:
        self._wanted = list(setpoint_rad)

    def set_joint_mode(self, joint: int, mode: str, /) -> None:
        self._free[joint - 1] = mode == "free"
        self._wanted[joint - 1] = self.angle_rad[joint - 1]

    def advance(self, t_s: float) -> None:
        if t_s > self._t_s + 1e-9:
            self.angle_rad = [
                angle if free else wanted
                for angle, wanted, free in zip(self.angle_rad, self._wanted, self._free, strict=True)
            ]
            self._t_s = t_s

    def encoder_counts(self) -> list[int]:
        return [round(angle / (2 * math.pi) * self._counts_per_rev) for angle in self.angle_rad]

    def pose(self) -> None:
        return None


class Pair:
    """Both boards, on one clock of whole microseconds."""

    def __init__(self, library: Any, joints: int, tolerance_rad: float) -> None:
        robot = robot_from_mapping({"joints": joints}, "test")
        self.tolerance_rad = tolerance_rad
        plant = PromptJoints(joints, robot.encoder_counts_per_rev)
        self.sim = SoftBoard(robot, plant=plant, boot_seed=1, serial_number=CORE_SERIAL_NUMBER)
        self.core = CoreBench(library, joints)
        self.time_us = 0
        self.sim.receive(encode(Ping(0)), 0.0)
        self.core.serial(pack_all([encode(Ping(0))]))
        self.go(0)

    def go(self, by_us: int) -> None:
        self.time_us += by_us
        self.sim_said = self.sim.advance(self._sim_s())
        self.core.step(self.time_us * 1e-6)
        self.core_said = self.core.said()
        self.compare()

    def _sim_s(self) -> float:
        return (self.time_us + 0.2) * 1e-6  # its clock cuts off, and a float may lie below its microsecond

    def fail(self, fault: Fault) -> None:
        """The hardware breaks, or is whole again."""
        self.sim.fail(HardwareFault(fault), self._sim_s())
        self.core.library.simulated_joints_fault(int(fault), 0, 0)
        self.go(0)

    def send(self, frames: Sequence[Frame]) -> None:
        for frame in frames:
            self.sim.receive(frame, self._sim_s())
        self.core.serial(pack_all(frames))
        self.go(0)

    def compare(self) -> None:
        # What falls due at the same microsecond may be said in any order.
        sim = [self._shown(decode(frame)) for frame in sorted(self.sim_said, key=lambda frame: frame.id)]
        core = [self._shown(decode(frame)) for frame in sorted(self.core_said, key=lambda frame: frame.id)]
        assert len(core) == len(sim), f"at {self.time_us} us: core {core}, simulated {sim}"
        for ours, theirs in zip(core, sim, strict=True):
            if isinstance(ours, Applied) and isinstance(theirs, Applied):
                assert (ours.sample, ours.group) == (theirs.sample, theirs.group)
                for one, other in ((ours.first_rad, theirs.first_rad), (ours.second_rad, theirs.second_rad),
                                   (ours.third_rad, theirs.third_rad)):  # fmt: skip
                    assert abs(one - other) < self.tolerance_rad, f"at {self.time_us} us: {ours}, {theirs}"
            elif type(ours).__name__ == "Measured":
                for name in ("first_counts", "second_counts", "third_counts"):
                    assert abs(getattr(ours, name) - getattr(theirs, name)) <= 1, (ours, theirs)
            else:
                if isinstance(ours, State | FaultEvent | Pong) and isinstance(
                    theirs, State | FaultEvent | Pong
                ):
                    assert abs(ours.board_time_us - theirs.board_time_us) <= 1, (ours, theirs)
                    theirs = replace(theirs, board_time_us=ours.board_time_us)
                assert ours == theirs, f"at {self.time_us} us: core {core}, simulated {sim}"

    @staticmethod
    def _shown(message: Message) -> Message:
        """Without what may differ: boot id and firmware version."""
        if isinstance(message, BoardHeartbeat):
            return BoardHeartbeat(0, message.mode, message.powered, 1, message.fault, message.holder)
        if isinstance(message, InfoFirmware):
            return InfoFirmware(0, 0, 0, message.watchdog_ms, message.counts_per_rev, 0)
        return message


def anything(draw: random.Random, joints: int) -> Message:
    host = draw.choice(HOSTS)
    joint = draw.randint(1, min(joints + 1, 16))
    match draw.randrange(10):
        case 0 | 1:
            return ModeRequest(draw.randrange(256), draw.choice(list(Mode)), host)
        case 9:
            return ClearRequest(draw.randrange(256), draw.randrange(8), host)
        case 2:
            angle = round(draw.uniform(-2.0, 2.0), 4)
            return JointModeRequest(draw.randrange(256), joint, draw.choice(list(JointMode)), angle, host)
        case 3:
            value = (
                round(draw.choice((0.0, 0.1, 1.0, 8.0, 60.0, 100.0)) * draw.uniform(0.5, 1.1) / 0.002) * 0.002
            )
            return LimitRequest(draw.randrange(256), joint, draw.choice(list(LimitKind)), value, host)
        case 4:
            return TrimRequest(draw.randrange(256), joint, round(draw.uniform(-0.4, 0.4), 4), host)
        case 5:
            return ZeroRequest(draw.randrange(256), joint, draw.randint(-500, 500), host)
        case 6:
            return draw.choice([Ping(draw.getrandbits(32)), InfoRequest(host)])
        case 7:
            return HostHeartbeat(host, draw.randrange(65536))
        case _:
            return EmergencyStop(StopReason.USER, host) if draw.random() < 0.2 else Ping(1)


def session(library: Any, seed: int, turns: int, tolerance_rad: float = 1.5e-4) -> Pair:
    """A host that behaves badly: a stream with losses, duplicates, swaps and stalls, and requests of every kind."""
    draw = random.Random(seed)
    joints = draw.choice((1, 2, 3, 4, 5, 7, 16))
    pair = Pair(library, joints, tolerance_rad)
    sequence = draw.randrange(65536)
    for turn in range(turns):
        pair.go(draw.choice((0, 301, 2001, 5003, 10007, 10007, 10007, 20011, 60013, 105019)))
        if draw.random() < 0.15:
            pair.send([encode(anything(draw, joints))])
        if draw.random() < 0.05:
            frame = Frame(draw.randrange(2048), draw.randbytes(draw.randrange(9)))
            pair.send([frame] if frame.id != 1 else [])
        if draw.random() < 0.1:
            pair.send([encode(ClearRequest(turn % 256, pair.sim._machine.latch, 11))])
            pair.send([encode(ModeRequest(turn % 256, draw.choice((Mode.DISARMED, Mode.ARMED)), 11))])
        if draw.random() < 0.03:
            pair.fail(draw.choice((Fault.NONE, Fault.NONE, Fault.SERVO)))
        sequence = (sequence + draw.choice((1, 1, 1, 1, 2, 5, 0, 65535))) % 65536
        targets = [round(draw.choice((0.2, 2.0)) * math.sin(turn / 9 + j), 4) for j in range(joints)]
        frames = [
            encode(m) for m in setpoint_messages(sequence, targets, draw.choice((0.005, 0.01, 0.01, 0.02)))
        ]
        fate = draw.random()
        if fate < 0.05:
            frames.pop(draw.randrange(len(frames)))
        elif fate < 0.1:
            draw.shuffle(frames)
        elif fate < 0.15:
            frames.append(draw.choice(frames))
        pair.send(frames)
    return pair


@pytest.mark.parametrize("seed", range(12))
def test_both_boards_say_the_same(bench_library: Any, seed: int) -> None:
    session(bench_library, seed, 150)


@pytest.mark.slow
def test_both_boards_say_the_same_for_longer(bench_library: Any) -> None:
    count_rad = 2 * math.pi / 8192  # an angle on the edge between two counts may be read as either
    for seed in range(1000, 1060):
        session(bench_library, seed, 600, count_rad + 1.5e-4)


def test_the_sessions_go_everywhere(bench_library: Any) -> None:
    """What is compared must be more than refusals."""
    modes: set[Mode] = set()
    executed = 0
    for seed in range(12):
        draw = session(bench_library, seed, 60)
        modes.add(draw.sim.mode)
        executed += draw.sim._register.clamped
    assert executed > 20
    assert len(modes) >= 3


def test_limits_that_are_tightened_in_mid_motion_are_kept_by_both(bench_library: Any) -> None:
    """The angle of joint 1 to less than where it is, the speed of joint 2 to less than what it has."""
    pair = Pair(bench_library, 2, 1.5e-4)
    pair.go(1000)
    pair.send([encode(ModeRequest(1, Mode.ARMED, 11))])
    angles: list[tuple[float, ...]] = []
    for tick in range(1, 80):
        pair.go(10007)
        if tick == 8:
            pair.send([encode(LimitRequest(2, 1, LimitKind.ANGLE, 0.1, 11))])
            pair.send([encode(LimitRequest(3, 2, LimitKind.SPEED, 0.5, 11))])
        pair.send([encode(message) for message in setpoint_messages(tick, [1.5, 1.5], 0.01)])
        angles.append(pair.sim._register.applied_rad)
    there = angles[6][0]
    assert there > 0.12, "the limit was not tightened on a joint beyond it"
    assert max(first for first, _ in angles) == pytest.approx(there, abs=2e-4), "further out than it was"
    assert angles[-1][0] == pytest.approx(0.1)
    for (_, before), (_, now) in itertools.pairwise(angles[7:]):
        assert now - before <= 0.5 * 0.0101 + 2e-4


@pytest.mark.parametrize("trace", VECTORS["limiter"], ids=lambda v: f"{v['style']}-{v['angle_rad']}")
def test_limiter_in_c_meets_the_vectors(bench_library: Any, trace: dict[str, Any]) -> None:
    ticks = trace["ticks"]
    count = len(ticks)
    applied = (ctypes.c_float * count)()
    bench_library.bench_limiter(
        (ctypes.c_float * 3)(trace["angle_rad"], trace["speed_rad_s"], trace["acceleration_rad_s2"]),
        ctypes.c_float(trace["start_rad"]),
        count,
        (ctypes.c_float * count)(*(tick["target_rad"] for tick in ticks)),
        (ctypes.c_uint32 * count)(*(round(tick["interval_s"] * 1e6) * min(tick["gap"], 4) for tick in ticks)),
        (ctypes.c_uint32 * count)(*(round(tick["elapsed_s"] * 1e6) for tick in ticks)),
        applied,
    )
    for tick, value in zip(ticks, applied, strict=True):
        if tick["applied_rad"] is None:
            assert math.isnan(value)
        else:
            assert value == pytest.approx(tick["applied_rad"], abs=2e-5)
