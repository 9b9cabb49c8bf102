"""A run in virtual time over a wire that can be broken in every way; shared by the tests and tools/bad_wire.py."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from firmware_protocol.frame import Frame
from firmware_protocol.framing import pack_all
from snakebot.board import Board
from snakebot.clock import VirtualClock
from snakebot.control import RunLoop
from snakebot.gait import Gait, GaitMotion
from snakebot.robot import Robot, load_robot
from snakebot.runlog.records import Event, Tick
from snakebot.softboard import InProcessLink, SoftBoard
from snakebot.softboard.disturbance import BadBus, BadStream, Rates

PENN_STATE = load_robot("penn_state")
GAIT = Gait.from_degrees(66, 80, 2)


class LagJoints:
    """Joints with an exact first-order lag behind their set-point; every command is kept. No body.

    A joint without power stays where it is.
    """

    clock_ppm = 0.0

    def __init__(self, joints: int, time_constant_s: float = 0.03, counts_per_rev: int = 8192) -> None:
        self.angle_rad = [0.0] * joints
        self.commands: list[tuple[float, tuple[float, ...]]] = []
        self.powered = [False] * joints
        self.power_changes: list[tuple[float, int, bool]] = []
        self._tau_s = time_constant_s
        self._step_rad = 2 * math.pi / counts_per_rev
        self._t_s = 0.0

    def command(self, t_s: float, setpoint_rad: Sequence[float]) -> None:
        self.commands.append((t_s, tuple(setpoint_rad)))

    def set_joint_mode(self, joint: int, mode: str, hold_rad: float | None = None) -> None:
        self.powered[joint - 1] = mode != "free"
        self.power_changes.append((self._t_s, joint, mode != "free"))

    def advance(self, t_s: float) -> None:
        share = 1 - math.exp(-max(0.0, t_s - self._t_s) / self._tau_s)
        self._t_s = t_s
        if self.commands:
            for joint, target in enumerate(self.commands[-1][1]):
                if self.powered[joint]:
                    self.angle_rad[joint] += (target - self.angle_rad[joint]) * share

    def encoder_counts(self) -> list[int]:
        return [round(angle / self._step_rad) for angle in self.angle_rad]

    def pose(self) -> None:
        return None


class Memory:
    """A recorder that keeps everything, and calls what it was given at the n-th tick that is sent."""

    def __init__(self) -> None:
        self.ticks: list[Tick] = []
        self.events: list[Event] = []

    def tick(self, tick: Tick) -> None:
        self.ticks.append(tick)

    def event(self, event: Event) -> None:
        self.events.append(event)

    def ignore(self, *_: Any) -> None:
        pass

    pose = link_statistics = telemetry = steering = frame = ignore


class WireLink(InProcessLink):
    """A link whose every send and receive passes a hook first: where tests stall, unplug, reset and stop."""

    before: Callable[[], None] | None = None

    def send(self, frames: Sequence[Frame]) -> None:
        if self.before is not None:
            self.before()
        super().send(frames)

    def receive(self, timeout_s: float) -> Sequence[Frame]:
        if self.before is not None:
            self.before()
        return super().receive(timeout_s)


class BusLink(WireLink):
    """A link of whole frames, as CAN is: both directions are disturbed as frames and packed again."""

    def __init__(self, board: SoftBoard, clock: VirtualClock, out: BadBus, back: BadBus) -> None:
        from firmware_protocol.framing import unpack

        def through(bus: BadBus) -> Callable[[bytes], bytes]:
            return lambda data: pack_all(bus([unpack(packet) for packet in data.split(b"\0") if packet]))

        super().__init__(board, clock, "can:", to_board=through(out), to_host=through(back))


class Bench:
    """Board, wire, host and recorder in virtual time; ``on`` another bench it is a new host on the same board."""

    def __init__(
        self,
        rates: Rates | None = None,
        seed: int = 0,
        *,
        can: bool = False,
        robot: Robot = PENN_STATE,
        gait: Gait = GAIT,
        rate_hz: float = 100.0,
        duration_s: float = 8.0,
        ramp_s: float = 1.0,
        recorder: Any = None,
        board: dict[str, Any] | None = None,
        on: Bench | None = None,
        **options: Any,
    ) -> None:
        self.robot = robot
        if on is None:
            self.clock = VirtualClock()
            self.joints = LagJoints(robot.joints, counts_per_rev=robot.encoder_counts_per_rev)
            self.sim = SoftBoard(robot, plant=self.joints, boot_seed=seed, **(board or {}))
        else:
            self.clock, self.joints, self.sim = on.clock, on.joints, on.sim
        rates = rates or Rates()
        ends = (BadBus if can else BadStream) if rates != Rates() or can else None
        self.disturbances = (
            [] if ends is None else [ends(rates, 2 * seed + i, self.clock.now_s) for i in (0, 1)]
        )
        self.link: WireLink
        if can:
            self.link = BusLink(self.sim, self.clock, *self.disturbances)  # type: ignore[arg-type]
        elif self.disturbances:
            out, back = self.disturbances
            self.link = WireLink(self.sim, self.clock, to_board=out, to_host=back)  # type: ignore[arg-type]
        else:
            self.link = WireLink(self.sim, self.clock)
        self.memory = Memory() if recorder is None else recorder
        self.board = Board(self.link, self.clock, host=seed + 1)
        self.loop = RunLoop(
            self.board,
            robot,
            lambda start: GaitMotion(gait, robot.joints, duration_s, ramp_s, start),
            rate_hz=rate_hz,
            clock=self.clock,
            amplitude_rad=max(gait.alpha_rad, 1e-3),
            settle_s=2 * ramp_s,
            recorder=self.memory,
            **options,
        )

    def run(self) -> Any:
        self.board.connect()
        return self.loop.run()

    def rest_of_life(self, seconds: float) -> None:
        """The board goes on without its host."""
        end_s = self.clock.now_s() + seconds
        while self.sim.next_event_s < end_s:
            self.clock.sleep_until(self.sim.next_event_s)
            self.sim.advance(self.clock.now_s())
        self.clock.sleep_until(end_s)
        self.sim.advance(end_s)

    def tracking_error(self, begin_s: float, end_s: float) -> float:
        """(37) of all joints together over the ticks that have an answer."""
        rows = [
            np.subtract(tick.measured_rad, tick.setpoint_rad)
            for tick in self.memory.ticks
            if tick.measured_rad is not None and begin_s <= tick.t_s <= end_s
        ]
        return float(np.sqrt(np.nanmean(np.square(rows))) / GAIT.alpha_rad)
