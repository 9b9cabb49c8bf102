"""The work of ``snakebot board serve``, and of ``snakebot board sim --feetech | --dynamixel``: servos on a bus."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import click

from snakebot.cli.board_sim import announce, check_wires, named, open_end, until_told
from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.cli.board_options import BoardOptions, SimOptions
    from snakebot.robot import Robot
    from snakebot.servobus.emulated import EmulatedBus
    from snakebot.servobus.opening import ServoBoard
    from snakebot.softboard.disturbance import Rates

_USUAL_MODEL = {"feetech": "sts3215", "dynamixel": "xl330"}


# -- board serve ------------------------------------------------------------------------------------------------------


def serve_servos(port_text: str, options: BoardOptions, *, watchdog: bool) -> None:
    """Put a board in front of the servos on a bus, on the wire that was asked for, until Ctrl-C or SIGTERM."""
    from snakebot.clock import MonotonicClock
    from snakebot.control import registry
    from snakebot.links import parse_port
    from snakebot.links.port import ServoPort
    from snakebot.robot import load_robot
    from snakebot.servobus.opening import open_servos
    from snakebot.softboard import serve

    check_wires(options, f"snakebot board serve {port_text} --tcp")
    port = parse_port(port_text)
    if not isinstance(port, ServoPort):
        raise BadInputError(
            f"{port_text}: only servo buses need a board: feetech:/dev/ttyUSB0?ids=1-5 or dynamixel:..."
        )
    robot = load_robot(options.robot_source)
    clock = MonotonicClock()
    stop = until_told()
    with contextlib.ExitStack() as stack:
        board = stack.enter_context(
            contextlib.closing(open_servos(port, robot, clock, watchdog=watchdog, lasting=True))
        )
        end = stack.enter_context(contextlib.closing(open_end(options)))
        shown = stack.enter_context(named(end, options.symlink))
        stack.enter_context(registry.registered(shown, registry.BOARDS))
        announce(shown, robot, options, f"board in front of {port}", servo_bus=board.about())
        _tell(board)
        stack.enter_context(_telling_faults(board, stop))
        serve(board, end, clock, stop)
        click.echo(f"on the bus: {board.servos.master.statistics.told}", err=True)


def _tell(board: ServoBoard) -> None:
    about = board.about()
    for servo in about["servos"]:
        gains = " ".join(f"{name[9]}={servo[name]}" for name in servo if name.endswith("_gain"))
        click.echo(
            f"joint {servo['joint']}: servo {servo['id']}, {servo['model']}, firmware {servo['firmware']}, "
            f"gains {gains}",
            err=True,
        )
    for line in about["changed"]:
        click.echo(f"while armed: {line}", err=True)
    if not board.start.watchdog:
        click.echo("these servos have no bus watchdog: kill -9 of this process leaves them holding", err=True)


@contextlib.contextmanager
def _telling_faults(board: ServoBoard, stop: threading.Event) -> Iterator[None]:
    """Say each fault of a servo once, in words."""
    from snakebot.servobus.troubles import words

    def watch() -> None:
        told = None
        while not stop.wait(0.1):
            fault = board.servos.fault()
            if fault is not None and fault != told:
                click.echo(words(fault), err=True)
            told = fault

    thread = threading.Thread(target=watch, name="faults", daemon=True)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join(1.0)


# -- board sim --feetech ----------------------------------------------------------------------------------------------


def emulate_servos(options: SimOptions) -> None:
    """Servos that are not there, on a pseudo-terminal, until Ctrl-C or SIGTERM."""
    if options.feetech and options.dynamixel:
        raise BadInputError("--feetech and --dynamixel: choose one")
    family = "feetech" if options.feetech else "dynamixel"
    from snakebot.clock import MonotonicClock, urgent
    from snakebot.control import registry
    from snakebot.servobus.emulated.end import ServoBusEnd, serve_servos

    if options.as_serial or options.tcp or options.can:
        raise BadInputError(
            f"--{family}: servos are on a pseudo-terminal; "
            f"`snakebot board serve {family}:... --tcp` puts a board in front of them"
        )
    if options.watchdog_ms is not None:
        raise BadInputError(f"--watchdog-ms is of a simulated board; with --{family} there is none")
    if options.faults:
        raise BadInputError(
            f"--fault breaks joints of a simulated board; with --{family} use --effect, or --damage for the wire"
        )
    clock = MonotonicClock()
    bus, robot = make_bus(family, options, clock.now_s)
    stop = until_told()
    with contextlib.ExitStack() as stack:
        end = stack.enter_context(contextlib.closing(ServoBusEnd(bus, clock)))
        port = stack.enter_context(named(end, options.symlink))
        stack.enter_context(registry.registered(port, registry.BOARDS))
        announce(port, robot, options, f"emulated {family} servos")
        with urgent():
            serve_servos(end, stop)


def make_bus(family: str, options: SimOptions, now_s: Callable[[], float]) -> tuple[EmulatedBus, Robot]:
    """The servos of a robot's description, or ``--model`` with ids from 1; and the robot that they move."""
    from snakebot.effects import Plant, parse_effects
    from snakebot.robot import load_robot
    from snakebot.servobus.emulated import EmulatedBus, EmulatedServo, ServoChain
    from snakebot.servobus.joints import wanted_servos
    from snakebot.servobus.models import model_named
    from snakebot.softboard.disturbance import BadPackets

    robot = load_robot(options.robot_source)
    model = options.model or _USUAL_MODEL[family]
    servos, zeros = [], []
    for wanted in wanted_servos(robot, ()):
        chosen = model_named(options.model or wanted.model or model)
        if chosen.family != family:
            raise BadInputError(f"--{family}: {chosen.name} is a {chosen.family} servo")
        servos.append(EmulatedServo(chosen, wanted.id))
        middle = (chosen.lowest + chosen.highest + 1) // 2
        zeros.append(float(middle if wanted.zero_counts is None else wanted.zero_counts))
    directions = [servo.direction for servo in wanted_servos(robot, ())]
    plant = Plant(robot, parse_effects(options.effects, robot), options.seed)
    chain = ServoChain(robot, plant, servos, zeros, directions)
    wires: dict[str, Any] = {}
    if options.damage:
        rates = parse_damage(options.damage)
        for offset, name in enumerate(("to_servos", "to_host")):
            wires[name] = BadPackets(rates, options.seed + offset, now_s)
    bus = EmulatedBus(servos, chain, **wires)
    bus.advance(0.002)  # what is compiled is compiled now
    return bus, robot


def parse_damage(text: str) -> Rates:
    """``flip=0.01,drop=0.05``.

    Raises:
        BadInputError: not that.
    """
    from snakebot.softboard.disturbance import Rates

    given: dict[str, float] = {}
    for part in text.split(","):
        name, _, value = part.partition("=")
        try:
            number = float(value)
        except ValueError:
            number = -1.0
        if not 0.0 <= number <= 1.0 or name not in ("flip", "drop", "duplicate", "truncate") or name in given:
            raise BadInputError(
                f"--damage {text!r}: give flip, drop, duplicate or truncate with a probability (0 to 1), "
                "for example --damage flip=0.01,drop=0.05"
            )
        given[name] = number
    return Rates(**given)
