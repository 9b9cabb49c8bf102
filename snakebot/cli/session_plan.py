"""``snakebot session plan``: what to record, and what that will tell, before anybody records."""

from __future__ import annotations

import contextlib
import json
import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.diagnosis.plan import EffectPair, Plan
    from snakebot.gait import Gait

EPILOG = """\b
Examples:
  snakebot session plan penn_state
  snakebot session plan my_snake.yaml --port serial:/dev/ttyUSB0 --pose
  snakebot session plan penn_state --gait 50,80,2 --gait 20,80,5 --json

\b
Every effect is taken at the size of its example (`docs/effects`), on all joints, and read with the encoders' own noise:
on a real robot, whose sound joints differ a little, less is told apart.
"""


@click.command(name="plan", epilog=EPILOG)
@click.argument("robot_source", metavar="ROBOT")
@click.option(
    "--gait",
    "gaits",
    multiple=True,
    metavar="ALPHA,BETA,OMEGA[,OFFSET]",
    help="In deg and rad/s, in place of the default ones; may be repeated.",
)
@click.option("--pose", is_flag=True, help="You will measure x_m, y_m and heading_rad (a camera).")
@click.option("--port", default="sim:", show_default=True, help="Where the board is, for the commands.")
@click.option("--folder", default="my_runs", show_default=True, help="For the logs, in the commands.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    robot_source: str, gaits: tuple[str, ...], pose: bool, port: str, folder: str, as_json: bool
) -> None:
    """What to record on ROBOT: which effects these gaits would tell apart, which not, and which runs to add."""
    from snakebot.diagnosis.plan import plan
    from snakebot.links import parse_port
    from snakebot.robot import load_robot

    robot = load_robot(robot_source)
    parse_port(port)
    chosen = [_gait(text) for text in gaits]
    if len(set(chosen)) < len(chosen):
        raise BadInputError("--gait: one is given twice; the first is repeated at the end by itself")
    with _progress() as shown:
        found = plan(robot, chosen, pose=pose, progress=shown)
    commands = _commands(found, robot_source, port, Path(folder))
    if as_json:
        click.echo(json.dumps(_mapping(found, commands)))
        return
    for line in _lines(found, commands, folder):
        click.echo(line)


def _gait(text: str) -> Gait:
    from snakebot.gait import Gait

    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (3, 4):
        raise BadInputError(f"--gait {text}: write ALPHA,BETA,OMEGA in deg, deg and rad/s, as in 50,80,2")
    return Gait.from_degrees(*numbers[:3], *(numbers[3:] or [0.0]))


def _commands(found: Plan, robot: str, port: str, folder: Path) -> list[str]:
    """One a run, ready to be pasted; the runs to add after those of the plan."""
    runs = [run.command for run in found.experiments] + [run.option.command for run in found.added]
    end = f" --robot {shlex.quote(robot)} --port {shlex.quote(port)} --log "
    return [
        command + end + shlex.quote(str(folder / f"run_{number:02d}.mcap"))
        for number, command in enumerate(runs, 1)
    ]


def _mapping(found: Plan, commands: Sequence[str]) -> dict[str, Any]:
    count = len(found.experiments)
    return {
        "schema": "snakebot.plan/1",
        "commands": list(commands[:count]),
        "duration_s": found.duration_s,
        "shown": list(found.shown),
        "hidden": list(found.hidden),
        "parted": [list(pair) for pair in found.parted],
        "tied": [list(pair) for pair in found.tied],
        "added": [
            {"command": command, "parts": [list(pair) for pair in run.parts]}
            for command, run in zip(commands[count:], found.added, strict=True)
        ],
        "left": [list(pair) for pair in found.left],
        "channel": found.channel,
    }


def _lines(found: Plan, commands: Sequence[str], folder: str) -> Iterator[str]:
    count = len(found.experiments)
    quoted = shlex.quote(folder)
    yield f"# {len(commands)} runs, about {found.duration_s / 60:.0f} min with putting the robot back"
    yield f"mkdir -p {quoted}"
    yield from commands[:count]
    for command, run in zip(commands[count:], found.added, strict=True):
        yield f"# {run.option}: parts {_pairs(run.parts)}"
        yield command
    yield f"snakebot diagnose {quoted}"
    yield ""
    yield f"# would show: {', '.join(found.shown) or 'nothing'}"
    if found.hidden:
        yield f"# would not, at the size of its example: {', '.join(found.hidden)}"
    pairs = len(found.parted) + len(found.tied)
    yield f"# {len(found.parted)} of {pairs} pairs are told apart by the first {count} runs"
    if found.tied:
        yield f"# not: {_pairs(found.tied)}"
    if found.left:
        yield f"# nor by the runs to add: {_pairs(found.left)}"
    if found.channel is not None:
        yield f"# {found.channel}"


def _pairs(pairs: Sequence[EffectPair]) -> str:
    return ", ".join(f"{a} or {b}" for a, b in pairs)


@contextlib.contextmanager
def _progress() -> Iterator[Callable[[str, float], None]]:
    """A bar, on a terminal only."""
    if not sys.stderr.isatty():
        yield lambda text, share: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=1.0)
        yield lambda text, share: bar.update(task, completed=share, description=text)
