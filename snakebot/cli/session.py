"""``snakebot session``: plan recordings, make session folders, and check those that others made."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from snakebot.cli.groups import Group
from snakebot.cli.robot_option import robot_option
from snakebot.cli.session_plan import command as plan_command
from snakebot.errors import BadInputError
from snakebot.in_words import plain

if TYPE_CHECKING:
    from collections.abc import Sequence

    from snakebot.runlog import Run

PATH = click.Path(path_type=Path)
JSON_OPTION = click.option("--json", "as_json", is_flag=True, help="Print the result as one JSON object.")

EPILOG = """\b
Examples:
  snakebot session plan penn_state --port serial:/dev/ttyUSB0
  snakebot session make my_session runs/*.mcap
  snakebot session import monday.csv -o lab --units deg
  snakebot session check my_session
"""


class _Group(Group):
    """Imports ``import`` only when it is called for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return sorted([*super().list_commands(ctx), "import"])

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name != "import":
            return super().get_command(ctx, cmd_name)
        from snakebot.cli.session_import import import_session

        return import_session


@click.group(name="session", epilog=EPILOG, cls=_Group)
def command() -> None:
    """Plan recordings, make session folders from logs and from any robot's recordings, and check them."""


command.add_command(plan_command)


MAKE_EPILOG = """\b
Examples:
  snakebot session make my_session runs/*.mcap
  snakebot session make my_session runs/*.mcap --hold-out 20261121T081530Z_a66_b80_w4 --format parquet
  snakebot session make both session_a session_b --robot configs/robots/penn_state.yaml

\b
A run is named as its log without .mcap, or as its file in the session that it comes from.
"""


@command.command("make", epilog=MAKE_EPILOG)
@click.argument("output", type=PATH)
@click.argument("runs", type=PATH, nargs=-1, required=True)
@robot_option("Nominal model [the description in the first run].", default=None)
@click.option("--hold-out", multiple=True, metavar="RUN", help="Never fit on this run.")
@click.option("--repeat", multiple=True, metavar="RUN=FIRST", help="RUN repeats the motion of FIRST.")
@click.option("--find-repeats/--no-find-repeats", default=True, show_default=True, help="Find equal motions.")
@click.option(
    "--format", "form", type=click.Choice(["csv", "csv.gz", "parquet"]), default="csv", show_default=True
)
@JSON_OPTION
def make(
    output: Path,
    runs: tuple[Path, ...],
    robot_source: str | None,
    hold_out: tuple[str, ...],
    repeat: tuple[str, ...],
    find_repeats: bool,
    form: Any,
    as_json: bool,
) -> None:
    """Write the session folder OUTPUT from RUNS: logs, folders of logs, other sessions."""
    from snakebot.robot import load_robot
    from snakebot.runlog import open_runs, write_session
    from snakebot.runlog.repeats import mark_repeats

    session = open_runs(runs)
    robot = load_robot(robot_source) if robot_source is not None else session.robot
    chosen = _marked(session.runs, hold_out, repeat)
    if find_repeats:
        chosen = mark_repeats(chosen)
    write_session(output, robot, chosen, form)
    result = {
        "output": str(output),
        "runs": len(chosen),
        "samples": sum(map(len, chosen)),
        "repeats": {run.name: run.repeat_of for run in chosen if run.repeat_of is not None},
        "held_out": [run.name for run in chosen if run.hold_out],
    }
    if as_json:
        click.echo(json.dumps(result))
        return
    click.echo(f"{output}: {len(chosen)} runs, {result['samples']} samples")
    for run in chosen:
        about = [f"repeats {run.repeat_of}"] if run.repeat_of else []
        about += ["held out"] if run.hold_out else []
        if about:
            click.echo(f"  {run.name}: {', '.join(about)}")


def _marked(runs: Sequence[Run], hold_out: Sequence[str], repeat: Sequence[str]) -> tuple[Run, ...]:
    from dataclasses import replace

    names = {run.name for run in runs}
    repeats = {}
    for entry in repeat:
        name, equals, first = entry.partition("=")
        if not equals:
            raise BadInputError(f"--repeat {entry!r}: write RUN=FIRST")
        repeats[name] = first
    for name, first in repeats.items():
        if first in repeats:
            what = "itself" if first == name else f"{first}, which repeats {repeats[first]}"
            raise BadInputError(
                f"--repeat {name}={first}: {name} would repeat {what}; name the first of them"
            )
    for name in (*hold_out, *repeats, *repeats.values()):
        if name not in names:
            known = ", ".join(sorted(names)[:8])
            raise BadInputError(f"{name}: no such run; there are {known}")
    return tuple(
        replace(
            run, hold_out=run.hold_out or run.name in hold_out, repeat_of=repeats.get(run.name, run.repeat_of)
        )
        for run in runs
    )


@command.command(
    "check", epilog="\b\nExamples:\n  snakebot session check my_session\n  snakebot session check lab --json"
)
@click.argument("folder", metavar="SESSION|LOG...", type=PATH, nargs=-1, required=True)
@robot_option("In the commands that are told [the session's, by its name].", default=None)
@click.option("--port", help="In the commands that are told [sim:; PORT where the robot is none of ours].")
@JSON_OPTION
def check(folder: tuple[Path, ...], robot_source: str | None, port: str | None, as_json: bool) -> None:
    """Read SESSION strictly: what is in it, or what is wrong, by file, row and column. Logs and folders of logs, too.

    What a diagnosis would refuse or doubt (degrees in place of radians, nothing that moves) is told as well; and what
    is missing for a confident verdict, each with the command that mends it.
    """
    import numpy as np

    from snakebot.cli.diagnose import given_session
    from snakebot.diagnosis.evidence.sanity import check_session
    from snakebot.diagnosis.evidence.turns import run_on
    from snakebot.diagnosis.missing import missing
    from snakebot.effects import robot_effects
    from snakebot.robot import ITS_FILE, load_robot, shipped_name

    session = given_session(folder, None, quiet=False)
    robot = session.robot if robot_source is None else load_robot(robot_source)
    if (theirs := robot.joints) != session.robot.joints:
        raise BadInputError(
            f"--robot {robot_source}: a robot of {theirs} joint{'s' if theirs > 1 else ''}, "
            f"the recordings have {session.robot.joints}"
        )
    robot_effects(robot)  # one that does not fit is told
    named = " ".join(map(str, folder))
    try:
        doubts = [*check_session(session), *run_on(session)[1]]
    except BadInputError as error:
        doubts = [str(error)]
    known = shipped_name(robot)
    where = port or ("PORT" if known is None else "sim:")
    lacks = missing(session, robot=_shown(robot_source or known or ITS_FILE), port=_shown(where))
    rows = [
        {
            "run": run.name,
            "samples": len(run),
            "duration_s": run.duration_s,
            "rate_hz": (len(run) - 1) / run.duration_s if run.duration_s > 0 else None,
            "lost_samples": int(np.isnan(run.measured_rad).sum()),
            "servo_off_samples": int(np.isnan(run.command_rad).sum()),
            "pose": run.pose is not None,
            "forward_speed_m_s": run.forward_speed_m_s,
            "repeat_of": run.repeat_of,
            "hold_out": run.hold_out,
        }
        for run in session.runs
    ]
    if as_json:
        result = {
            "session": named,
            "joints": session.robot.joints,
            "body": session.robot.body is not None,
        }
        told = {"warnings": [*session.warnings, *doubts], "missing": [vars(lack) for lack in lacks]}
        click.echo(json.dumps(result | {"runs": rows} | told))
        return
    body = "with a body" if session.robot.body is not None else "on a bench"
    joints = f"{session.robot.joints} joint{'s' if session.robot.joints > 1 else ''}"
    click.echo(f"{named}: {joints} {body}, {len(rows)} run{'s' if len(rows) > 1 else ''}")
    width = max(len(str(row["run"])) for row in rows)
    for row in rows:
        about = [f"{row['samples']} samples", f"{row['duration_s']:.2f} s"]
        if row["rate_hz"] is not None:
            about.append(f"{row['rate_hz']:.1f} Hz")
        about += [f"{row['lost_samples']} lost"] if row["lost_samples"] else []
        about += [f"{row['servo_off_samples']} servo off"] if row["servo_off_samples"] else []
        about += [f"{row['forward_speed_m_s']:g} m/s"] if row["forward_speed_m_s"] is not None else []
        about += [f"repeats {row['repeat_of']}"] if row["repeat_of"] else []
        about += ["held out"] if row["hold_out"] else []
        click.echo(f"  {row['run']:<{width}}  {', '.join(about)}")
    for doubt in doubts:
        click.echo(f"for a diagnosis: {doubt}")
    for lack in lacks:
        click.echo(f"missing: {lack.text}\n  {lack.command}")


def _shown(word: str) -> str:
    """A word as a shell takes it, whoever wrote it."""
    return shlex.quote(plain(word))
