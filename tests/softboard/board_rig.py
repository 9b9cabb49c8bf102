"""A plant without physics, and a host's hands on a board without a link."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from firmware_protocol.assembly import Sample, SampleAssembler, setpoint_messages
from firmware_protocol.catalogue import (
    Acknowledge,
    Applied,
    ClearRequest,
    EmergencyStop,
    Measured,
    Message,
    Mode,
    ModeRequest,
    State,
    decode,
    encode,
)
from snakebot.robot import Robot, robot_from_mapping
from snakebot.softboard import SoftBoard

HOST = 0xA11CE
OTHER = 0xB0B

M = TypeVar("M", bound=Message)


def bench(joints: int = 5, **more: object) -> Robot:
    """A robot without a body."""
    return robot_from_mapping({"joints": joints, **more}, "test")


@dataclass
class StillPlant:
    """Joints that are at their set-point at once, or stay where they are without power."""

    joints: int
    counts_per_rev: int = 8192
    angle_rad: list[float] = field(default_factory=list)
    commands: list[tuple[float, list[float]]] = field(default_factory=list)
    modes: list[str] = field(default_factory=list)
    changes: list[tuple[float, int, str]] = field(default_factory=list)
    lost: set[int] = field(default_factory=set)  # encoders without a reading
    place: tuple[float, float, float, float] | None = None
    now_s: float = -math.inf
    clock_ppm: float = 0.0

    def __post_init__(self) -> None:
        self.angle_rad = self.angle_rad or [0.0] * self.joints
        self.modes = ["active"] * self.joints

    def command(self, t_s: float, setpoint_rad: Sequence[float]) -> None:
        assert t_s == self.now_s, "the plant must stand at the moment of the command"
        self.commands.append((t_s, list(setpoint_rad)))

    def set_joint_mode(self, joint: int, mode: str) -> None:
        self.modes[joint - 1] = mode
        self.changes.append((self.now_s, joint, mode))

    def advance(self, t_s: float) -> None:
        assert t_s >= self.now_s, "time went back"
        if t_s > self.now_s and self.commands:
            for joint, angle_rad in enumerate(self.commands[-1][1]):
                if self.modes[joint] == "active":
                    self.angle_rad[joint] = angle_rad
        self.now_s = t_s

    def encoder_counts(self) -> list[int | None]:
        return [
            None if joint in self.lost else round(angle / (2 * math.pi) * self.counts_per_rev)
            for joint, angle in enumerate(self.angle_rad)
        ]

    def pose(self) -> tuple[float, float, float, float] | None:
        return self.place


class Rig:
    """A board on the bench, with time in the test's hands."""

    def __init__(self, robot: Robot | None = None, **board: object) -> None:
        self.robot = robot or bench()
        self.plant = StillPlant(self.robot.joints, self.robot.encoder_counts_per_rev)
        self.board = SoftBoard(self.robot, plant=self.plant, boot_seed=1, **board)  # type: ignore[arg-type]
        self.now_s = 0.0
        self.sequence = 0
        self.heard: list[Message] = []  # everything since the start
        self.advance(0.0)

    def advance(self, by_s: float) -> list[Message]:
        """Let time pass; what the board said meanwhile."""
        self.now_s += by_s
        said = [decode(frame) for frame in self.board.advance(self.now_s)]
        self.heard += said
        return said

    def mode(self) -> Mode:
        """The board's mode now. (A type checker takes two looks at an attribute for one.)"""
        return self.board.mode

    def say(self, *messages: Message) -> list[Message]:
        """Send messages now; what the board answers now."""
        for message in messages:
            self.board.receive(encode(message), self.now_s)
        return self.advance(0.0)

    def one(self, said: Sequence[Message], kind: type[M]) -> M:
        found = [message for message in said if isinstance(message, kind)]
        assert len(found) == 1, f"{len(found)} {kind.__name__} in {said}"
        return found[0]

    def ask(self, request: Message) -> Acknowledge:
        """A request's acknowledgement."""
        answer = self.one(self.say(request), Acknowledge)
        assert answer.token == request.token  # type: ignore[attr-defined]
        return answer

    def go(self, mode: Mode, host: int = HOST, token: int = 1) -> Acknowledge:
        return self.ask(ModeRequest(token, mode, host))

    def stop(self) -> list[Message]:
        return self.say(EmergencyStop())

    def clear(self, host: int = HOST, number: int | None = None) -> Acknowledge:
        """Leave the latch that the board is in, or the one of this number."""
        if number is None:
            number = self.board._machine.latch
        return self.ask(ClearRequest(1, number, host))

    def tick(self, angles_rad: Sequence[float], interval_s: float = 0.01, step: int = 1) -> list[Message]:
        """One set-point, now."""
        self.sequence += step
        return self.say(*setpoint_messages(self.sequence, angles_rad, interval_s))

    def stream(
        self, seconds: float, angles_rad: Sequence[float] | None = None, interval_s: float = 0.01
    ) -> None:
        """Keep set-points coming."""
        for _ in range(round(seconds / interval_s)):
            self.advance(interval_s)
            self.tick(angles_rad or [0.0] * self.robot.joints, interval_s)

    def enter(self, mode: Mode, host: int = HOST) -> None:
        """Bring a board that is disarmed into any mode."""
        assert self.board.mode is Mode.DISARMED
        if mode is Mode.STOPPED:
            self.stop()
        elif mode is not Mode.DISARMED:
            self.go(Mode.ARMED, host)
            if mode is Mode.HOLDING:
                self.go(Mode.HOLDING, host)
            elif mode is Mode.FAULT:
                self.advance(0.101)
        assert self.board.mode is mode


def samples(said: Sequence[Message], joints: int) -> list[Sample]:
    """The complete samples in what a board said."""
    assembler = SampleAssembler(joints)
    parts = [message for message in said if isinstance(message, State | Measured | Applied)]
    complete = [assembler.add(part) for part in parts]
    assert assembler.dropped == 0
    return [sample for sample in complete if sample is not None]
