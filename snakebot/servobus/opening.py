"""From a port to a board in this program with bus servos behind it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from firmware_protocol.frame import Frame
from snakebot.board.stopping import STOPPING_S
from snakebot.clock import Clock
from snakebot.errors import BadInputError, BoardFaultError, NoBoardError
from snakebot.links.port import ServoPort
from snakebot.links.serial_link import open_stream
from snakebot.links.stream import Stream
from snakebot.robot import JointServo, Robot
from snakebot.servobus.joints import SCAN_IDS, Joint, dialect_of, roll_call, wanted_servos
from snakebot.servobus.master import BusMaster
from snakebot.servobus.models import MODELS
from snakebot.servobus.packets import BROADCAST
from snakebot.servobus.plant import ServoPlant
from snakebot.servobus.registers import Register
from snakebot.servobus.settings import Settings
from snakebot.servobus.start import Start, prepare
from snakebot.softboard import InProcessLink, SoftBoard

_STOP_TRIES = (
    2  # of a servo that need not be there; chosen: all ids that are asked take less than ``STOPPING_S``
)
_HOLDING = (
    "these servos have no bus watchdog: if this program is killed they go on holding, with {share:.0f} % of their "
    "torque; `snakebot board serve {port} --tcp` keeps a watchdog in a process of its own"
)


def open_master(port: ServoPort, clock: Clock) -> BusMaster:
    """Open the line.

    Raises:
        NoBoardError: no such device, no permission, in use.
    """
    stream, _ = open_stream(port.line, str(port))
    return BusMaster(str(port), stream, dialect_of(port.family), baud=port.baud, now_s=clock.now_s)


def open_servos(
    port: ServoPort, robot: Robot, clock: Clock, *, watchdog: bool = True, lasting: bool = False
) -> ServoBoard:
    """Open the line, find the servos and look at them; a board stands in front of them then. Nothing moves.

    Args:
        watchdog: False lets servos be driven that should have a bus watchdog and have none.
        lasting: the board outlives its line: an adapter that is plugged in again is opened, and the servos relaxed.

    Raises:
        BadInputError, BoardFaultError, NoBoardError: as ``start.prepare`` and ``joints.roll_call``.
    """
    master = open_master(port, clock)
    try:
        reopen = (lambda: open_stream(port.line, str(port))[0]) if lasting else None
        wanted = wanted_servos(robot, port.ids)
        return board_of(master, robot, wanted, clock, watchdog=watchdog, reopen=reopen)
    except BaseException:
        master.close()
        raise


def board_of(
    master: BusMaster,
    robot: Robot,
    wanted: Sequence[JointServo],
    clock: Clock,
    *,
    watchdog: bool = True,
    reopen: Callable[[], Stream] | None = None,
) -> ServoBoard:
    """A board in front of the servos on an open bus."""
    joints = roll_call(master, wanted)
    start = prepare(master, robot, joints, watchdog=watchdog)
    settings = Settings(joints, start.found, watchdog=start.watchdog)
    plant = ServoPlant(robot, joints, master, settings, clock.now_s, reopen=reopen)
    return ServoBoard(plant, start)


def torque_off(master: BusMaster) -> None:
    """Take the torque of every servo on the bus, whoever they are: three times over, nobody acknowledges it.

    Raises:
        LostBoardError: the line is gone.
    """
    off = master.dialect.write(BROADCAST, _torque_enable(master).address, bytes(1))
    for _ in range(3):
        master.say(off)


def stop_servos(master: BusMaster, clock: Clock, ids: Sequence[int] = ()) -> None:
    """Take the torque of every servo on the bus, again until each that answers says that it has none. Asked are ``ids``
    and the usual ones.

    Raises:
        NoBoardError: nobody has answered; the torque was taken blindly.
        BoardFaultError: one still has torque after ``STOPPING_S``.
        LostBoardError: the line is gone.
    """
    register, deadline_s = _torque_enable(master), clock.now_s() + STOPPING_S
    has_torque: dict[int, bool] = {}
    while True:
        torque_off(master)
        for servo in dict.fromkeys((*ids, *SCAN_IDS)):
            if (data := master.read(servo, register.address, register.size, _STOP_TRIES)) is not None:
                has_torque[servo] = any(data)
        if has_torque and not any(has_torque.values()):
            return
        if clock.now_s() >= deadline_s:
            break
    if not has_torque:
        raise NoBoardError(
            f"{master.where}: no servo answered within {STOPPING_S:g} s; all were told to let go all the same: is the "
            "supply on, and are port and bit rate right? Cut the supply if anything still moves"
        )
    held = ", ".join(str(servo) for servo, on in has_torque.items() if on)
    raise BoardFaultError(
        f"{master.where}: after {STOPPING_S:g} s servo {held} still has torque: cut the supply"
    )


def _torque_enable(master: BusMaster) -> Register:
    """Where all servos of a family have their torque switch."""
    return next(m for m in MODELS.values() if m.family == master.dialect.name)["torque_enable"]


class ServoBoard(SoftBoard):
    """The board in software in front of bus servos.

    Attributes:
        joints: who they are.
        start: what was found in them.
        warnings: lines that whoever drives them should read.
    """

    def __init__(self, plant: ServoPlant, start: Start) -> None:
        super().__init__(plant.robot, plant=plant)
        self.servos = plant
        self.start = start

    @property
    def joints(self) -> tuple[Joint, ...]:
        return self.servos.joints

    @property
    def warnings(self) -> list[str]:
        lines = []
        if not self.start.watchdog:
            share = 100 * max(
                1.0 if joint in self._unlimited else joint.torque_limit for joint in self.joints
            )
            lines.append(_HOLDING.format(share=share, port=self.servos.master.where))
        if self._unlimited:
            first = self._unlimited[0]
            lines.append(
                f"{first.what}: a {first.model.name} has no register for torque_limit: {first.torque_limit:g} of the "
                "description is not kept; set max_torque in the servo with the vendor's program"
            )
        counts = self.joints[0].model.counts_per_rev
        if self.robot.encoder_counts_per_rev != round(counts):
            lines.append(
                f"robot {self.robot.name!r} has {self.robot.encoder_counts_per_rev} encoder counts a turn, "
                f"its servos {counts:g}: set encoder_counts_per_rev, or the noise of the angles is judged wrongly"
            )
        return lines

    @property
    def _unlimited(self) -> list[Joint]:
        """Joints whose servos cannot be told the torque limit of the description."""
        return [
            joint
            for joint in self.joints
            if joint.torque_limit < 1.0 and not ("torque_limit" in joint.model or "goal_pwm" in joint.model)
        ]

    def about(self) -> dict[str, Any]:
        """For the log: who the servos are, and what was changed in them."""
        changed = [str(change) for change in self.servos.settings.changes]
        return {**self.start.about(self.joints), "changed": changed}

    def check_rate(self, rate_hz: float) -> None:
        """
        Raises:
            BadInputError: the bus is too slow for so many cycles a second.
        """
        most = self.start.max_rate_hz
        if rate_hz > most:
            model = self.joints[0].model
            how = "" if model.sync_read else ", asked one after the other"
            raise BadInputError(
                f"--rate {rate_hz:g}: {len(self.joints)} servos ({model.name}{how}) on {self.servos.master.where} "
                f"take {1e3 * self.start.cycle_s:.1f} ms a cycle: at most {math.floor(most)} Hz; `snakebot doctor` "
                "says what makes it slow"
            )

    def close(self) -> None:
        """Relax the servos, put their settings back, let go of the line."""
        self.servos.close()


class ServoLink(InProcessLink):
    """A link to the board in this process; it raises once the line to the servos is gone."""

    def __init__(self, board: ServoBoard, clock: Clock, port: str) -> None:
        super().__init__(board, clock, port)
        self.servo_board = board

    def about(self) -> Mapping[str, object]:
        return {"servo_bus": self.servo_board.about()}

    def check_rate(self, rate_hz: float) -> None:
        self.servo_board.check_rate(rate_hz)

    def warnings(self) -> Sequence[str]:
        return self.servo_board.warnings

    def told(self) -> str:
        return f"on the servo bus: {self.servo_board.servos.master.statistics.told}"

    def counters(self) -> Mapping[str, float]:
        bus = self.servo_board.servos.master.statistics
        return {
            "bus_asked": bus.asked,
            "bus_retried": bus.retried,
            "bus_lost": bus.lost,
            "bus_corrupt": bus.corrupt,
        }

    def close(self) -> None:
        if self._plugged:
            self.servo_board.close()
        super().close()

    def _collect(self, now_s: float) -> Sequence[Frame]:
        frames = super()._collect(now_s)
        self._check()  # a line that was lost just now is a lost board, not the fault that the board tells of it
        return frames

    def _check(self) -> None:
        super()._check()
        if self.servo_board.servos.lost is not None:
            raise self.servo_board.servos.lost
