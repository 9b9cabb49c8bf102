"""``snakebot log``: list, look into, export, import, recover, complete and replay run logs."""

from __future__ import annotations

import importlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from snakebot.cli.groups import Group
from snakebot.errors import BadInputError, cannot_write
from snakebot.in_words import plain
from snakebot.text_table import screen_columns, set_in_columns, shortened_apart
from snakebot.whole_files import creating

if TYPE_CHECKING:
    from snakebot.runlog import RunLog
    from snakebot.runlog.listing import LogSummary

LOG = click.Path(path_type=Path)
JSON_OPTION = click.option("--json", "as_json", is_flag=True, help="Print the result as one JSON object.")

EPILOG = """\b
Examples:
  snakebot log list
  snakebot log info runs/20261121T081530Z_a66_b80_w2.mcap
  snakebot log export runs/20261121T081530Z_a66_b80_w2.mcap run.csv
  snakebot log recover runs/20261121T081530Z_a66_b80_w2.mcap.part
"""


_MOST = {"ended": 60}  # characters of a column, where not 44: what a run that failed says

_ELSEWHERE = {  # imported only when called for
    "import": ("snakebot.cli.log_tables", "import_log"),
    "merge-speed": ("snakebot.cli.log_tables", "merge"),
    "replay": ("snakebot.cli.replay", "command"),
}


class _Group(Group):
    def list_commands(self, ctx: click.Context) -> list[str]:
        return sorted([*super().list_commands(ctx), *_ELSEWHERE])

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in _ELSEWHERE:
            return super().get_command(ctx, cmd_name)
        module, name = _ELSEWHERE[cmd_name]
        found = getattr(importlib.import_module(module), name)
        assert isinstance(found, click.Command)
        return found


@click.group(name="log", epilog=EPILOG, cls=_Group)
def command() -> None:
    """List, inspect, export, import, replay and recover run logs."""


@command.command(
    "list",
    short_help="The logs in a folder.",
    epilog="\b\nExamples:\n  snakebot log list\n  snakebot log list other/folder --json",
)
@click.argument("folder", type=LOG, default="runs")
@JSON_OPTION
def list_logs(folder: Path, as_json: bool) -> None:
    """List the logs in FOLDER [runs], finished and unfinished.

    From the index at each log's end: damage inside one shows when it is read (`snakebot log info`).
    """
    from snakebot.runlog.listing import find_logs, summarize

    if folder.is_file():
        raise BadInputError(
            f"{folder}: a file, no folder; `snakebot log info {folder}` says what a log holds"
        )
    if not folder.is_dir():
        raise BadInputError(
            f"{folder}: no such folder; runs are recorded in 'runs' unless --log says otherwise"
        )
    summaries = [summarize(path) for path in find_logs(folder)]
    if as_json:
        click.echo(
            json.dumps({"folder": str(folder), "logs": [_as_mapping(summary) for summary in summaries]})
        )
        return
    if not summaries:
        click.echo(f"{folder}: no logs")
        return
    head = ("log", "file", "ticks", "s", "motion", "m/s", "fault", "effect", "robot", "ended")
    columns = zip(*(_row(summary) for summary in summaries), strict=True)
    body = [shortened_apart(column, _MOST.get(name, 44)) for name, column in zip(head, columns, strict=True)]
    rows = [head, *zip(*body, strict=True)]
    numeric = [name in ("ticks", "s", "m/s") for name in head]
    for line in set_in_columns(rows, numeric, screen=screen_columns()):
        click.echo(line)


def _row(summary: LogSummary) -> tuple[str, ...]:
    about, speed = summary.metadata, summary.speed_m_s
    return (
        plain(summary.path.name),
        summary.state,
        str(summary.ticks),
        f"{summary.duration_s:.1f}",
        _motion_text(about),
        "-" if speed is None else f"{speed:.4g}",
        _list_text(about.get("faults")),
        _list_text(about.get("effects")),
        plain(about.get("robot", "-")) + (" (simulated)" if about.get("simulated") else ""),
        plain(summary.ended or "-"),
    )


@command.command(
    "info",
    short_help="What a log holds, and whether it is whole.",
    epilog="\b\nExamples:\n  snakebot log info run.mcap\n  snakebot log info run.mcap --json",
)
@click.argument("log", type=LOG)
@JSON_OPTION
def info(log: Path, as_json: bool) -> None:
    """What LOG holds: metadata, channels, attachments, and whether it is whole."""
    from snakebot.runlog import read_log
    from snakebot.runlog.listing import summarize

    contents = read_log(existing(log))
    summary = summarize(log, thorough=True)
    result = _as_mapping(summary) | {
        "joints": contents.joints,
        "attachments": {name: len(data) for name, data in contents.attachments.items()},
        "late_ticks": int(contents.late.sum()),
        "lost_samples": _lost(contents),
        "events": [
            {"t_s": e.t_s, "kind": e.kind, "level": e.level, "message": e.message, "data": dict(e.data)}
            for e in contents.events
        ],
    }
    if as_json:
        click.echo(json.dumps(result))
        return
    size = f"{summary.bytes / 1e6:.2f} MB"
    click.echo(f"{log}: {summary.state}, {summary.ticks} ticks in {summary.duration_s:.2f} s, {size}")
    for problem in summary.problems:
        click.echo(f"  damaged: {plain(problem)}")
    click.echo(
        f"  {contents.joints} joints; {result['late_ticks']} late ticks; {result['lost_samples']} lost samples"
    )
    click.echo("  channels: " + ", ".join(f"{topic} ({n})" for topic, n in sorted(summary.messages.items())))
    click.echo("  attachments: " + plain(", ".join(contents.attachments)))
    for key, value in sorted(contents.metadata.items()):
        click.echo(f"  {plain(key)}: {plain(value if isinstance(value, str) else json.dumps(value))}")
    for event in contents.events:
        if event.level != "debug":
            click.echo(f"  {event.t_s:9.3f} s  {event.level}: {plain(event.message)}")


EXPORT_EPILOG = """\b
Examples:
  snakebot log export run.mcap run.csv
  snakebot log export run.mcap run.parquet
  snakebot log export runs/*.mcap my_session            a session folder
  snakebot log export run.mcap --ros2 my_bag            a ROS 2 bag: JointState of commands and encoders
  snakebot log export run.mcap robot.yaml               an attachment, by its name
"""


@command.command(
    "export", short_help="Write logs as a table, a session folder, a ROS 2 bag.", epilog=EXPORT_EPILOG
)
@click.argument("paths", type=LOG, nargs=-1, required=True, metavar="LOGS... OUTPUT")
@click.option(
    "--ros2", type=LOG, metavar="FOLDER", help="Write one log as a ROS 2 bag (MCAP, CDR), without OUTPUT."
)
@click.option(
    "--format",
    "form",
    type=click.Choice(["csv", "csv.gz", "parquet", "session", "attachment"]),
    help="What to write [by OUTPUT's ending; a session folder where it has none].",
)
@JSON_OPTION
def export(paths: tuple[Path, ...], ros2: Path | None, form: str | None, as_json: bool) -> None:
    """Write LOGS as OUTPUT: a table (CSV, CSV.gz, Parquet) of one log, or a session folder of any number."""
    from snakebot.runlog import open_runs, read_log
    from snakebot.runlog.session_write import write_session, write_table

    if ros2 is not None:
        from snakebot.runlog.foreign.ros_export import write_bag

        if len(paths) > 1 or form is not None:
            raise BadInputError(
                f"--ros2 {ros2}: a bag holds one log, and takes the place of OUTPUT and --format"
            )
        counts = write_bag(read_log(existing(paths[0])), ros2)
        tell({"output": str(ros2), "messages": counts}, as_json, str(ros2))
        return
    if len(paths) < 2:
        raise BadInputError(f"{paths[0]}: give the log, then what to write: LOGS... OUTPUT")
    *logs, output = paths
    form = form or _form(output)
    if os.path.lexists(output) and not (output.is_dir() and form == "session"):
        raise BadInputError(f"{output}: exists already; give another name")
    if form == "session":
        session = open_runs(logs)
        write_session(output, session.robot, session.runs)
        result: dict[str, Any] = {"output": str(output), "runs": len(session.runs)}
    else:
        if len(logs) > 1:
            raise BadInputError(
                f"{output}: a table holds one run, {len(logs)} were given; give a folder as OUTPUT"
            )
        log = read_log(existing(logs[0]))
        if form == "attachment":
            if output.name not in log.attachments:
                known = plain(", ".join(log.attachments))
                raise BadInputError(
                    f"{output}: neither a table (.csv, .csv.gz, .parquet) nor an attachment ({known})"
                )
            _write(output, log.attachments[output.name])
            result = {"output": str(output), "bytes": len(log.attachments[output.name])}
        else:
            columns = log.columns()
            try:
                write_table(output, columns)
            except OSError as error:
                raise cannot_write(f"{output}: cannot be written", error) from None
            result = {"output": str(output), "rows": int(log.t_s.size), "columns": list(columns)}
    tell(result, as_json, str(output))


@command.command(
    "recover",
    short_help="Finish a log that was cut short or damaged.",
    epilog="\b\nExamples:\n  snakebot log recover run.mcap.part\n  snakebot log recover bad.mcap -o good.mcap",
)
@click.argument("log", type=LOG)
@click.option("-o", "--output", type=LOG, help="Write here and keep LOG [LOG takes its final name].")
@JSON_OPTION
def recover_log(log: Path, output: Path | None, as_json: bool) -> None:
    """Finish LOG, which was cut short or damaged: compressed, with an index, all that its checksums vouch for."""
    from snakebot.runlog.listing import summarize
    from snakebot.runlog.recover import recover

    path, problems = recover(log, output)
    ticks = summarize(path).ticks
    for problem in problems:
        click.echo(f"snakebot: {log}: {plain(problem)}", err=True)
    tell({"output": str(path), "ticks": ticks, "left_out": problems}, as_json, f"{path}: {ticks} ticks")


def existing(log: Path) -> Path:
    """The log, if there is such a file."""
    from snakebot.runlog.naming import no_such_log

    if log.is_dir():
        raise BadInputError(f"{log}: a folder; give a log in it (`snakebot log list {log}`)")
    if not log.is_file():
        raise no_such_log(log)
    return log


def _form(output: Path) -> str:
    for ending in ("csv", "csv.gz", "parquet"):
        if output.name.endswith(f".{ending}"):
            return ending
    return "attachment" if output.suffix else "session"


def _write(path: Path, data: bytes) -> None:
    try:
        with creating(path) as whole:
            whole.write_bytes(data)
    except OSError as error:
        raise cannot_write(f"{path}: cannot be written", error) from None


def tell(result: dict[str, Any], as_json: bool, text: str) -> None:
    """Print a result, for people or for programs."""
    click.echo(json.dumps(result) if as_json else text)


def _motion_text(about: Mapping[str, Any]) -> str:
    """The gait (alpha, beta, omega), or the probe, of a run."""
    gait = about.get("gait")
    if not isinstance(gait, dict):
        return plain(about.get("probe", "-"))
    values = [gait.get(key) for key in ("alpha_deg", "beta_deg", "omega_rad_s")]
    numbers = [f"{value:g}" if isinstance(value, (int, float)) else "?" for value in values]
    return "{}° {}° {} rad/s".format(*numbers)


def _list_text(values: object) -> str:
    """What was given to ``--fault`` or ``--effect``, as often as it was."""
    return plain(" ".join(map(str, values))) if isinstance(values, list) and values else "-"


def _lost(log: RunLog) -> int:
    import numpy as np

    return int(np.isnan(log.measured_rad).sum())


def _as_mapping(summary: LogSummary) -> dict[str, Any]:
    return {
        "log": str(summary.path),
        "state": summary.state,
        "ticks": summary.ticks,
        "duration_s": summary.duration_s,
        "ended": summary.ended,
        "forward_speed_m_s": summary.speed_m_s,
        "bytes": summary.bytes,
        "messages": dict(summary.messages),
        "metadata": dict(summary.metadata),
        "problems": list(summary.problems),
    }
