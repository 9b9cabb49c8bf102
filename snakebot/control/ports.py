"""Opening what ``--port`` names: a board in this process, simulated or in front of bus servos, or a link to one."""

from __future__ import annotations

import contextlib
import math
import warnings
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

from snakebot.clock import RATE_HZ
from snakebot.errors import BadInputError, SnakebotError

if TYPE_CHECKING:
    from snakebot.board import Board
    from snakebot.clock import Clock
    from snakebot.links import Link
    from snakebot.robot import Robot

SIM = "sim:"
# What a standstill may cost on the clock of sim:, whatever it lasted; of a tick's interval so little that the tick is
# not late by it (``snakebot.control.lateness``: half).
_STEP_S, _STEP_SHARE = 0.005, 0.4


def port_clock(port: str, interval_s: float = math.inf) -> Clock:
    """The clock of host and board on ``port`` in real time, for ticks so far apart.

    The board of ``sim:`` is in this process: its clock leaves out what this process could not use. A board elsewhere
    goes on meanwhile, and so do bus servos: there the host's clock does, too.
    """
    from snakebot.clock import MonotonicClock, StandstillClock

    return StandstillClock(min(_STEP_S, _STEP_SHARE * interval_s)) if port == SIM else MonotonicClock()


def open_port(
    port: str,
    clock: Clock,
    robot: Robot,
    effects: Sequence[str] = (),
    seed: int = 0,
    *,
    virtual: bool = False,
    servo_watchdog: bool = True,
    start_pose: tuple[float, float, float] | None = None,
) -> Link:
    """A link to the board that ``port`` names; ``sim:`` is one in this process, made for ``robot``, and so is the one
    in front of bus servos (``feetech:``, ``dynamixel:``).

    Args:
        servo_watchdog: False lets servos be driven that should have a bus watchdog and have none.

    Raises:
        BadInputError: the port is not in the grammar, an effect is unknown, or an option that only the simulated
            board understands was given for another one; or the servos are not as ``robot`` says.
        NoBoardError: the port cannot be opened, or a servo does not answer.
        BoardFaultError: a servo reports an error, or stands beyond its joint's limit.
    """
    if check_port(port, robot, effects, virtual=virtual, start_pose=start_pose):
        from snakebot.effects import parse_effects
        from snakebot.softboard import InProcessLink, SoftBoard

        board = SoftBoard(robot, parse_effects(effects), seed, start_pose=start_pose or (0.0, 0.0, 0.0))
        about = {"effects": list(effects), "seed": seed, "start_pose": start_pose}
        return InProcessLink(
            board, clock, about={key: value for key, value in about.items() if value is not None}
        )
    from snakebot.links import open_link, parse_port
    from snakebot.links.port import ServoPort

    parsed = parse_port(port)
    if isinstance(parsed, ServoPort):
        from snakebot.servobus.opening import ServoLink, open_servos

        return ServoLink(open_servos(parsed, robot, clock, watchdog=servo_watchdog), clock, str(parsed))
    return open_link(parsed)


@contextlib.contextmanager
def open_board(
    port: str,
    robot: Robot,
    *,
    effects: Sequence[str] = (),
    seed: int = 0,
    virtual: bool = False,
    lifted: bool = False,
    rate_hz: float = RATE_HZ,
    servo_watchdog: bool = True,
    start_pose: tuple[float, float, float] | None = None,
    tell: Callable[[str], None] | None = None,
) -> Iterator[Board]:
    """A connected board on ``port``, until the end of the ``with`` block.

    Args:
        port: as after ``--port``: ``sim:``, ``serial:/dev/ttyUSB0``, ``can:socketcan/can0``, ``feetech:/dev/ttyUSB0``.
        robot: what the board drives; what ``sim:`` simulates.
        effects: of ``sim:``, in the grammar of ``--effect``.
        seed: of the randomness of ``sim:``.
        virtual: ``sim:`` only: virtual time, as fast as it computes.
        lifted: ``sim:`` simulates the robot off the ground.
        rate_hz: of the runs that will be made: a standstill of this process is to cost ``sim:`` no tick.
        servo_watchdog: as for ``open_port``.
        start_pose: ``sim:`` only: x, y (m) and heading (rad) that the robot lies with at first.
        tell: is handed each line that should be read before anything moves; None: they become RuntimeWarnings.

    Raises:
        BadInputError: as ``open_port``, or the board is not this robot's.
        NoBoardError: the port cannot be opened, or nobody answers on it.
        BoardFaultError: as ``open_port``.
    """
    from snakebot.board import Board
    from snakebot.clock import VirtualClock
    from snakebot.lifted import lifted as in_the_air

    clock: Clock = VirtualClock() if virtual else port_clock(port, 1.0 / rate_hz)
    simulated = in_the_air(robot) if lifted else robot
    with open_port(
        port,
        clock,
        simulated,
        effects,
        seed,
        virtual=virtual,
        servo_watchdog=servo_watchdog,
        start_pose=start_pose,
    ) as link:
        board = Board(link, clock)
        try:
            board.connect()
        except SnakebotError as error:
            error.traffic = tuple(board.recent_traffic())
            raise
        board.check_robot(robot)
        for line in link.warnings():
            (tell or _warn)(line)
        yield board


def _warn(line: str) -> None:
    warnings.warn(line, RuntimeWarning, stacklevel=4)


def check_port(
    port: str,
    robot: Robot,
    effects: Sequence[str] = (),
    *,
    virtual: bool = False,
    start_pose: tuple[float, float, float] | None = None,
) -> bool:
    """What ``open_port`` refuses before it opens anything. Returns whether the port is the simulated board.

    Raises:
        BadInputError: as ``open_port``; or the robot's own effects do not exist or do not fit it.
    """
    from snakebot.links.port import SimPort, parse_port

    if isinstance(parse_port(port), SimPort):
        from snakebot.effects import parse_effects, robot_effects

        robot_effects(robot)
        parse_effects(effects, robot)
        return True
    if effects:
        raise BadInputError(
            f"--effect changes the simulated board, not the one on {port}: "
            "give it to `snakebot board sim`, or run on --port sim:"
        )
    if start_pose is not None:
        raise BadInputError(f"--start is where the simulated robot lies, not one on {port}")
    if virtual:
        raise BadInputError(f"--fast needs virtual time, which only --port sim: has, not {port}")
    return False
