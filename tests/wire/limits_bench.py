"""Who listens at both ends of the wire and holds every set-point against the limits."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from unittest.mock import patch

import numpy as np
from limit_windows import nearest_to_limits
from wire_bench import Bench

from firmware_protocol.catalogue import Latch, Setpoint, decode
from firmware_protocol.frame import Frame, ProtocolError
from snakebot.robot import Robot
from snakebot.softboard.register import AssembledTick, SetpointRegister

STEP_RAD = 1e-4  # the wire's resolution
EARLY_S = 0.020  # by how much a set-point may come early, in all
MIN_INTERVAL_S = 0.0005
MAX_GAP = 4
_ROUNDING = 1e-6


@dataclass
class Margins:
    """What was seen: steps, and the nearest to each limit (1 is the limit itself)."""

    steps: int = 0
    worst: dict[str, float] = field(
        default_factory=lambda: dict.fromkeys(("angle", "speed", "acceleration"), 0.0)
    )

    def hold(self, what: str, value: float, allowed: float, where: str) -> None:
        assert value <= allowed + _ROUNDING, f"{what} of {where}: {value} beyond {allowed}"
        self.worst[what] = max(self.worst[what], value / allowed)


class StepCheck:
    """Holds one stream of set-points against the limits of its joints: each step as it is made, all windows at the end.

    Args:
        robot: whose limits.
        name: whose set-points.
        slack: how many steps of the wire a set-point may lie beside a path that keeps the limits.
    """

    def __init__(self, robot: Robot, name: str, slack: float) -> None:
        self.margins = Margins()
        self._limits = list(
            zip(
                robot.angle_limit_rad,
                robot.speed_limit_rad_s,
                robot.acceleration_limit_rad_s2,
                strict=True,
            )
        )
        self._name = name
        self._slack_rad = slack * STEP_RAD
        self._t_s = 0.0
        self._rows: list[list[tuple[float, float]]] = [[] for _ in self._limits]
        self.stand()

    def stand(self, joint: int | None = None) -> None:
        """A joint (all without a number) begins again at rest."""
        for number in range(len(self._limits)) if joint is None else (joint,):
            self._look(number)
            self._rows[number].clear()
        if joint is None:
            self._dt_s = 0.0

    def look(self) -> None:
        """Check the windows of what has come together."""
        for number in range(len(self._limits)):
            self._look(number)

    def _look(self, joint: int) -> None:
        rows = self._rows[joint]
        if len(rows) < 3:
            return
        _, speed, acceleration = self._limits[joint]
        times, angles = zip(*rows, strict=True)
        where = f"of joint {joint + 1} {self._name}"
        shares = nearest_to_limits(times, angles, speed, acceleration, self._slack_rad, where)
        for what, share in zip(("speed", "acceleration"), shares, strict=True):
            self.margins.worst[what] = max(self.margins.worst[what], share)

    def step(self, before: Sequence[float], after: Sequence[float], dt_s: float) -> None:
        """One set-point, and the time that it had."""
        margins = self.margins
        margins.steps += 1
        self._t_s += dt_s
        for joint, (angle, speed, acceleration) in enumerate(self._limits):
            where = f"joint {joint + 1} {self._name}, step {margins.steps}"
            outside = max(angle, abs(before[joint]))  # from outside it only goes inwards
            margins.hold("angle", abs(after[joint]), outside + STEP_RAD / 2, where)
            v = (after[joint] - before[joint]) / dt_s
            margins.hold("speed", abs(v), speed + 2 * self._slack_rad / dt_s, where)
            rows = self._rows[joint]
            if not rows:
                rows.append((self._t_s - dt_s, before[joint]))
                allowed = acceleration * max(self._dt_s + dt_s, 2 * dt_s) / 2 + 2 * self._slack_rad / dt_s
                margins.hold("acceleration", abs(v), allowed, f"{where}, from rest")
            rows.append((self._t_s, after[joint]))
        self._dt_s = dt_s


class HostEar:
    """Takes the set-points off the wire as they leave the host, and checks them at the host's own intervals."""

    def __init__(self, bench: Bench) -> None:
        self.check = StepCheck(bench.robot, "sent", 0.51)  # rounded to the wire, and no more
        self._joints = bench.robot.joints
        self._parts: dict[int, dict[int, Setpoint]] = {}
        self._last: tuple[float, ...] | None = None
        self._heard: set[int] = set()

    @property
    def ticks(self) -> int:
        return len(self._heard)

    def hear(self, frames: Sequence[Frame]) -> None:
        for frame in frames:
            try:
                message = decode(frame)
            except ProtocolError as error:
                raise AssertionError(f"the host sent no message: {error}") from None
            if isinstance(message, Setpoint):
                self._parts.setdefault(message.sequence, {})[message.group] = message
            elif isinstance(message, Latch) and message.sequence not in self._heard:
                self._heard.add(message.sequence)
                groups = self._parts[message.sequence & 0xFFF]
                angles = [
                    a
                    for g in sorted(groups)
                    for a in (groups[g].first_rad, groups[g].second_rad, groups[g].third_rad)
                ]
                now = tuple(angles[: self._joints])
                before, self._last = self._last, now
                if before is not None:
                    self.check.step(before, now, message.interval_s)


class ClockCheck:
    """Holds what a board executes against the clock: over any ticks, no further than speed and credit allow."""

    def __init__(self, robot: Robot) -> None:
        self._speed_rad_s = np.array(robot.speed_limit_rad_s)
        self._followed: set[int] = set()
        self._rows: list[tuple[float, tuple[float, ...]]] = []

    def start(self, t_s: float, applied_rad: Sequence[float]) -> None:
        """The board is armed."""
        self.look()
        self._rows = [(t_s, tuple(applied_rad))]
        self._followed = set()

    def follow(self, joint: int) -> None:
        """A joint without power: its angle at the tick before says nothing about the next."""
        self._followed.add(joint)

    def execute(self, t_s: float, applied_rad: Sequence[float]) -> None:
        row = tuple(math.nan if joint in self._followed else angle for joint, angle in enumerate(applied_rad))
        self._rows.append((t_s, row))
        self._followed = set()

    def look(self) -> None:
        """Check what has come together."""
        if len(self._rows) < 2:
            return
        times = np.array([t for t, _ in self._rows])
        rows = np.array([row for _, row in self._rows])
        unknown = np.cumsum(np.isnan(rows), axis=0)
        for width in (1, 3, 10):
            passed_s = (times[width:] - times[:-width])[:, None] + EARLY_S
            allowed = self._speed_rad_s * passed_s + 2.04 * STEP_RAD
            moved = np.abs(rows[width:] - rows[:-width])
            known = (unknown[width:] == unknown[:-width]) & ~np.isnan(moved)
            assert (moved <= allowed)[known].all(), f"faster than its limit over {width} ticks"


@contextlib.contextmanager
def board_ear(robot: Robot) -> Iterator[StepCheck]:
    """Looks into the register of every board meanwhile, and checks what it executes at the board's own ticks.

    The time that a step has is counted again here, by the rule of PROTOCOL.md.
    """
    check, clock = StepCheck(robot, "executed", 1.02), ClockCheck(robot)
    credit_s, executed_s = EARLY_S, 0.0
    heard: SetpointRegister | None = None
    start, follow, execute = SetpointRegister.start, SetpointRegister.follow, SetpointRegister.execute

    def hear_start(register: SetpointRegister, t_s: float) -> None:
        nonlocal credit_s, executed_s, heard
        if register is not heard:  # the board was reset
            heard, credit_s, executed_s = register, EARLY_S, 0.0
        credit_s, executed_s = min(credit_s + (t_s - executed_s), EARLY_S), t_s
        check.stand()
        start(register, t_s)
        clock.start(t_s, register.servo_rad)

    def hear_follow(register: SetpointRegister, joint: int, measured_rad: float) -> None:
        check.stand(joint)
        clock.follow(joint)
        follow(register, joint, measured_rad)

    def hear_execute(register: SetpointRegister, tick: AssembledTick, t_s: float) -> bool:
        nonlocal credit_s, executed_s
        declared_s = tick.interval_s * min(max(tick.step, 1), MAX_GAP)
        available_s = min(credit_s + (t_s - executed_s), declared_s + EARLY_S)
        dt_s = min(declared_s, available_s)
        before = register.servo_rad
        done = execute(register, tick, t_s)
        if abs(dt_s - MIN_INTERVAL_S) > 1e-9:
            assert done == (dt_s > MIN_INTERVAL_S)
        if done:
            credit_s, executed_s = available_s - dt_s, t_s
            check.step(before, register.servo_rad, dt_s)
            clock.execute(t_s, register.servo_rad)
        return done

    with (
        patch.object(SetpointRegister, "start", hear_start),
        patch.object(SetpointRegister, "follow", hear_follow),
        patch.object(SetpointRegister, "execute", hear_execute),
    ):
        yield check
        check.look()
        clock.look()
