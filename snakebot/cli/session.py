"""``snakebot session``: make session folders, and check those that others made."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from snakebot.runlog import Run

PATH = click.Path(path_type=Path)
JSON_OPTION = click.option("--json", "as_json", is_flag=True, help="Print the result as one JSON object.")

EPILOG = """\b
Examples:
  snakebot session make my_session runs/*.mcap
  snakebot session check my_session
"""


@click.group(name="session", epilog=EPILOG)
def command() -> None:
    """Make session folders from logs, and check them."""


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
@click.option("--robot", "robot_source", help="Nominal model [the description in the first run].")
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
@click.argument("folder", type=PATH)
@JSON_OPTION
def check(folder: Path, as_json: bool) -> None:
    """Read the session FOLDER strictly: what is in it, or what is wrong, by file, row and column.

    What a diagnosis would refuse or doubt (degrees in place of radians, nothing that moves) is told as well.
    """
    import numpy as np

    from snakebot.diagnosis.sanity import check_session
    from snakebot.runlog import read_session

    if not folder.exists():
        raise BadInputError(f"{folder}: no such folder")
    session = read_session(folder)
    try:
        doubts = check_session(session)
    except BadInputError as error:
        doubts = [str(error)]
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
            "session": str(folder),
            "joints": session.robot.joints,
            "body": session.robot.body is not None,
        }
        click.echo(json.dumps(result | {"runs": rows, "warnings": [*session.warnings, *doubts]}))
        return
    body = "with a body" if session.robot.body is not None else "on a bench"
    joints = f"{session.robot.joints} joint{'s' if session.robot.joints > 1 else ''}"
    click.echo(f"{folder}: {joints} {body}, {len(rows)} runs")
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
