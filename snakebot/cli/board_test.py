"""The work of ``snakebot board test``: the conformance suite on the board at hand."""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

from snakebot.cli.ports import SIM, open_port
from snakebot.errors import EXIT_BOARD_FAULT, BadInputError
from snakebot.nearest import did_you_mean

if TYPE_CHECKING:
    from snakebot.clock import Clock
    from snakebot.conformance import Case, Outcome
    from snakebot.links import Link

_WIRE_TOLERANCE_S = 0.02  # what a wire and this computer's scheduler may blur
_VIRTUAL_TOLERANCE_S = 0.003  # in virtual time only the steps of the plant and the wire count; chosen


@dataclass(frozen=True, slots=True)
class Options:
    """As on the command line."""

    port: str
    robot_source: str
    names: tuple[str, ...]
    with_long: bool
    yes: bool
    quiet: bool


def chosen_cases(names: tuple[str, ...], with_long: bool) -> list[Case]:
    """The cases to ask: those named, or all (the long ones only when wanted).

    Raises:
        BadInputError: there is no such case.
    """
    from snakebot.conformance import cases

    known = {case.name: case for case in cases()}
    for name in names:
        if name not in known:
            hint = did_you_mean(name, known) or "; `snakebot board test --list` shows them"
            raise BadInputError(f"--case {name}: no such case{hint}")
    if names:
        return [known[name] for name in names]
    return [case for case in known.values() if with_long or not case.long]


def ask_board(options: Options) -> list[dict[str, Any]]:
    """Ask every chosen case, showing each unless quiet; leave with status 5 to the caller's care if one failed.

    Raises:
        BadInputError: a real board, nobody to ask, and no ``--yes``.
        NoBoardError: nobody answers on the port.
        LostBoardError: the link went away.
    """
    from snakebot.board import Board
    from snakebot.clock import MonotonicClock, VirtualClock
    from snakebot.conformance import Bench, run_case
    from snakebot.robot import load_robot

    cases = chosen_cases(options.names, options.with_long)
    clock: Clock = MonotonicClock()
    tolerance_s = _WIRE_TOLERANCE_S
    if options.port == SIM:
        clock, tolerance_s = VirtualClock(), _VIRTUAL_TOLERANCE_S
    with open_port(options.port, clock, load_robot(options.robot_source)) as link:
        info = Board(link, clock).connect()
        bench = Bench(link, clock, send_bytes=_raw(link), tolerance_s=tolerance_s)
        if not (info.simulated or options.yes):
            _confirm(options.port, bench.nudge_rad)
        outcomes = []
        for case in cases:
            outcome = run_case(case, bench)
            outcomes.append(outcome)
            if not options.quiet:
                _show(outcome)
    if not options.quiet:
        count = Counter(outcome.verdict.value for outcome in outcomes)
        click.echo(", ".join(f"{number} {verdict}" for verdict, number in count.items()))
    return [
        {
            "case": outcome.case.name,
            "rule": outcome.case.rule,
            "verdict": outcome.verdict.value,
            "detail": outcome.detail,
            "traffic": list(outcome.traffic),
        }
        for outcome in outcomes
    ]


def leave(outcomes: list[dict[str, Any]]) -> None:
    """End with the exit status that the outcomes deserve."""
    sys.exit(EXIT_BOARD_FAULT if any(each["verdict"] == "failed" for each in outcomes) else 0)


def _raw(link: Link) -> Any:
    """Raw bytes can be put on a serial line; behind an slcan adapter they would be commands to it."""
    from snakebot.links.stream_link import StreamLink

    return link.send_bytes if isinstance(link, StreamLink) and link.port.startswith("serial:") else None


def _confirm(port: str, nudge_rad: float) -> None:
    from math import degrees

    if not sys.stdin.isatty():
        raise BadInputError(f"{port} is a real robot, and there is nobody to ask: add --yes if it may move")
    click.confirm(
        f"{port}: a real robot: its joints will move by up to {degrees(nudge_rad):.0f} deg and lose power "
        "many times. Is it lying flat, and everyone clear of it?",
        abort=True,
    )


def _show(outcome: Outcome) -> None:
    marks = {"passed": ("ok  ", "green"), "failed": ("FAIL", "red"), "skipped": ("skip", "yellow")}
    mark, colour = marks[outcome.verdict.value]
    click.echo(f"{click.style(mark, fg=colour)} {outcome.case.name}")
    if outcome.verdict.value != "passed":
        click.echo(f"     {outcome.case.rule}\n     -> {outcome.detail}")
    for line in outcome.traffic:
        click.echo(f"        {line}")
