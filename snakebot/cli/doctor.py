"""``snakebot doctor``: what is wrong with a port, and what to do about it."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from typing import TYPE_CHECKING

import click

from snakebot.cli import names
from snakebot.cli.ports import SIM, open_port
from snakebot.cli.robot_option import robot_option
from snakebot.control.ports import port_clock
from snakebot.errors import EXIT_NO_BOARD, EXIT_OK, BadInputError, SnakebotError

if TYPE_CHECKING:
    from snakebot.clock import Clock
    from snakebot.doctor.finding import Finding
    from snakebot.links.port import ServoPort

_MARKS = {
    "ok": ("ok  ", "green"),
    "info": ("    ", None),
    "warn": ("WARN", "yellow"),
    "fail": ("FAIL", "red"),
}


@click.command(
    name="doctor",
    epilog="""\b
Examples:
  snakebot doctor serial:/dev/ttyUSB0
  snakebot doctor can:socketcan/can0 --json
  snakebot doctor feetech:/dev/ttyUSB0           bus servos: bit rate, ids, delays, supply, limits, health
  snakebot doctor                                the simulated board: what this computer can do

\b
Nothing moves. Exit status: 0 all that is needed works (there may be warnings), 2 bad input,
3 the port cannot be opened or no board answers, 4 the board was lost.
""",
)
@click.argument("port", shell_complete=names.ports, default=SIM)
@robot_option("What sim: simulates.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(port: str, robot_source: str, as_json: bool) -> None:
    """Check PORT: rights, adapter, timing, versions on both sides; say what to do about each."""
    from snakebot.clock import MonotonicClock
    from snakebot.doctor.host import check_host
    from snakebot.doctor.port import check_port
    from snakebot.links import parse_port
    from snakebot.links.port import ServoPort

    parsed = parse_port(port)
    findings = [*check_host(MonotonicClock()), *check_port(parsed)]
    if isinstance(parsed, ServoPort):
        board, status = _ask_servos(parsed, robot_source, MonotonicClock())
    else:
        board, status = _ask_board(port, robot_source, port_clock(port))
    findings += board
    if as_json:
        click.echo(
            json.dumps({"port": port, "exit_status": status, "findings": [asdict(each) for each in findings]})
        )
    else:
        for finding in findings:
            _show(finding)
    sys.exit(status)


def _ask_board(port: str, robot_source: str, clock: Clock) -> tuple[list[Finding], int]:
    """What the board says, and the exit status that goes with it."""
    from snakebot.doctor.board import check_board
    from snakebot.doctor.finding import Finding, Status
    from snakebot.robot import load_robot

    robot = load_robot(robot_source)
    try:
        with open_port(port, clock, robot) as link:
            low_latency = getattr(link, "low_latency", None)
            findings = check_board(link, clock)
    except BadInputError:
        raise
    except SnakebotError as error:
        return [Finding("board", Status.FAIL, str(error))], error.exit_status
    if low_latency:
        findings.insert(0, Finding("driver", Status.OK, "hands bytes on at once (low latency mode)"))
    return findings, EXIT_OK


def _ask_servos(port: ServoPort, robot_source: str, clock: Clock) -> tuple[list[Finding], int]:
    """What the servos on a bus say; there is no board to ask."""
    from snakebot.doctor.finding import Finding, Status
    from snakebot.doctor.servos import check_servos
    from snakebot.robot import load_robot

    try:
        findings = check_servos(port, load_robot(robot_source), clock)
    except BadInputError:
        raise
    except SnakebotError as error:
        return [Finding("servos", Status.FAIL, str(error))], error.exit_status
    failed = any(finding.status is Status.FAIL for finding in findings)
    return findings, EXIT_NO_BOARD if failed else EXIT_OK


def _show(finding: Finding) -> None:
    mark, colour = _MARKS[finding.status]
    click.echo(f"{click.style(mark, fg=colour)} {finding.what:15} {finding.found}")
    if finding.advice:
        click.echo(f"{'':20} -> {finding.advice}")
