"""``snakebot board``: find boards, ask who they are, simulate, test, configure one, put one in front of bus servos."""

from __future__ import annotations

import json

import click

from snakebot.cli import names
from snakebot.cli.board_options import BoardOptions, SimOptions, symlink_option, wire_options
from snakebot.cli.board_settings import trim, zero
from snakebot.cli.groups import Group
from snakebot.cli.ports import SIM
from snakebot.cli.robot_option import robot_option
from snakebot.cli.typed_options import collected


@click.group(
    cls=Group,
    name="board",
    epilog="""\b
Examples:
  snakebot board list --probe
  snakebot board info serial:/dev/ttyUSB0
  snakebot board sim --serial
  snakebot board sim --can slcan --effect backlash:width_deg=2
  snakebot board test serial:/dev/ttyUSB0
  snakebot board serve feetech:/dev/ttyUSB0?ids=1-5 --tcp
""",
)
def command() -> None:
    """Find boards, ask who they are, simulate, test, configure one, put one in front of bus servos."""


command.add_command(trim)
command.add_command(zero)


@command.command(
    name="sim",
    epilog="""\b
Examples:
  snakebot board sim --serial                          a pseudo-terminal
  snakebot board sim --serial --symlink ./snake        ... under a name that stays
  snakebot board sim --tcp 127.0.0.1:5555
  snakebot board sim --can udp_multicast/239.74.163.2
  snakebot board sim --can slcan                       a pseudo-terminal that is a USB-CAN adapter
  snakebot board sim --serial --fault free:3@10s --effect servo_lag:time_constant_s=0.08
  snakebot board sim --feetech                         bus servos without a board, on a pseudo-terminal
  snakebot board sim --dynamixel --model xl430 --damage flip=0.01,drop=0.05

\b
It prints the --port to use, and answers until Ctrl-C.
""",
)
@wire_options
@click.option(
    "--feetech", is_flag=True, help="Emulate Feetech bus servos; a board is put in front by the host."
)
@click.option("--dynamixel", is_flag=True, help="Emulate Dynamixel bus servos.")
@click.option("--model", help="Servos of this model [as the robot's description says, or sts3215, xl330].")
@click.option("--damage", help="Of the servos' wire: flip=0.01,drop=0.05 (a byte, a packet).")
@symlink_option
@robot_option()
@click.option(
    "--effect",
    "effects",
    shell_complete=names.effects,
    multiple=True,
    help="Unmodelled effect: NAME:param=value[,joints=3+4].",
)
@click.option(
    "--fault",
    "faults",
    multiple=True,
    help="A joint that breaks by itself, whatever the host says: free:3, rigid:4+5, rigid:4@12s, clear@20s.",
)
@click.option(
    "--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of everything random."
)
@click.option(
    "--watchdog-ms",
    type=int,
    metavar="N",
    help="The board waits N ms for a set-point, 20 to 255, for a computer that stands still now and then [100].",
)
@click.option("--json", "as_json", is_flag=True, help="Print the port as one JSON object.")
@collected(SimOptions)
def sim(options: SimOptions) -> None:
    """A simulated board in a process of its own: what a host sees is a real board on a real wire."""
    if options.feetech or options.dynamixel:
        from snakebot.cli.board_servos import emulate_servos

        emulate_servos(options)
    else:
        from snakebot.cli.board_sim import serve_board

        serve_board(options)


@command.command(
    name="serve",
    epilog="""\b
Examples:
  snakebot board serve feetech:/dev/ttyUSB0?ids=1-5 --tcp 127.0.0.1:5555
  snakebot board serve dynamixel:/dev/ttyUSB0?baud=57600 --serial --symlink ./snake

\b
It prints the --port to use, and answers until Ctrl-C; then the servos relax. Its watchdog outlives the host: the
servos relax when the host dies. Only if this process dies too do Feetech servos go on holding.
""",
)
@click.argument("port", shell_complete=names.ports)
@wire_options
@symlink_option
@robot_option()
@click.option(
    "--no-servo-watchdog", is_flag=True, help="Drive Dynamixel servos although one has no bus watchdog."
)
@click.option(
    "--json",
    "as_json",
    is_flag=True,
    help="Print the port, and what is known of the servos, as one JSON object.",
)
@collected(BoardOptions)
def serve(port: str, no_servo_watchdog: bool, options: BoardOptions) -> None:
    """A board in a process of its own in front of the bus servos on PORT (feetech:..., dynamixel:...)."""
    from snakebot.cli.board_servos import serve_servos

    serve_servos(port, options, watchdog=not no_servo_watchdog)


@command.command(
    name="list",
    epilog="""\b
Examples:
  snakebot board list
  snakebot board list --probe       also ask each port whether a board answers
""",
)
@click.option(
    "--probe", is_flag=True, help="Open each port and ask for a board. Other devices get to see a few bytes."
)
@click.option("--json", "as_json", is_flag=True, help="Print a JSON array.")
def list_(probe: bool, as_json: bool) -> None:
    """Serial ports, CAN interfaces and simulated boards of this computer."""
    from snakebot.cli.board_list import find, show

    found = find(probe)
    if as_json:
        click.echo(json.dumps(found))
    else:
        show(found, probe)


@command.command(
    name="info",
    epilog="""\b
Examples:
  snakebot board info serial:/dev/ttyUSB0?baud=1000000
  snakebot board info can:socketcan/can0 --json
""",
)
@click.argument("port", shell_complete=names.ports, default=SIM)
@robot_option("What sim: simulates.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def info(port: str, robot_source: str, as_json: bool) -> None:
    """Who the board on PORT is, and how it is."""
    from snakebot.cli.board_info import ask, show

    found = ask(port, robot_source)
    if as_json:
        click.echo(json.dumps(found))
    else:
        show(found)


@command.command(
    name="test",
    epilog="""\b
Examples:
  snakebot board test serial:/dev/ttyUSB0
  snakebot board test can:socketcan/can0 --long --yes --json
  snakebot board test --case stops_from_any_mode
  snakebot board test --list

\b
Exit status: 0 no promise was broken, 3 no board, 4 the board was lost, 5 a promise was broken.
""",
)
@click.argument("port", shell_complete=names.ports, default=SIM)
@click.option("--case", "names", multiple=True, help="Only this case; may be repeated.")
@click.option("--long", "with_long", is_flag=True, help="Also the cases that take more than a few seconds.")
@click.option(
    "--list", "list_only", is_flag=True, help="Show the cases and what each asks for; open nothing."
)
@robot_option("What sim: simulates.")
@click.option("--yes", is_flag=True, help="Do not ask before a real robot moves.")
@click.option("--json", "as_json", is_flag=True, help="Print a JSON array.")
def test(
    port: str,
    names: tuple[str, ...],
    with_long: bool,
    list_only: bool,
    robot_source: str,
    yes: bool,
    as_json: bool,
) -> None:
    """Ask the board on PORT for every promise of the protocol. Joints move by a few degrees."""
    from snakebot.cli.board_test import Options, ask_board, chosen_cases, leave

    if list_only:
        for case in chosen_cases(names, with_long=True):
            click.echo(f"{case.name}{' (long)' if case.long else ''}\n    {case.rule}")
        return
    outcomes = ask_board(Options(port, robot_source, names, with_long, yes, quiet=as_json))
    if as_json:
        click.echo(json.dumps(outcomes))
    leave(outcomes)
