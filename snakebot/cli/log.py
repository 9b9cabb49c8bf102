"""``snakebot log``: list, look into, export, import, recover, complete and replay run logs."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.runlog import RunLog
    from snakebot.runlog.listing import LogSummary
    from snakebot.runlog.table import Dialect

LOG = click.Path(path_type=Path)
JSON_OPTION = click.option("--json", "as_json", is_flag=True, help="Print the result as one JSON object.")

EPILOG = """\b
Examples:
  snakebot log list
  snakebot log info runs/20261121T081530Z_a66_b80_w2.mcap
  snakebot log export runs/20261121T081530Z_a66_b80_w2.mcap run.csv
  snakebot log recover runs/20261121T081530Z_a66_b80_w2.mcap.part
"""


class _Group(click.Group):
    """``replay`` needs the run loop: it is imported only when it is called for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return sorted([*super().list_commands(ctx), "replay"])

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name != "replay":
            return super().get_command(ctx, cmd_name)
        from snakebot.cli.replay import command as replay

        return replay


@click.group(name="log", epilog=EPILOG, cls=_Group)
def command() -> None:
    """List, inspect, export, import, replay and recover run logs."""


@command.command("list", epilog="\b\nExamples:\n  snakebot log list\n  snakebot log list other/folder --json")
@click.argument("folder", type=LOG, default="runs")
@JSON_OPTION
def list_logs(folder: Path, as_json: bool) -> None:
    """List the logs in FOLDER [runs], finished and unfinished."""
    from snakebot.runlog.listing import find_logs, summarize

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
    rows = [("log", "state", "ticks", "s", "gait", "m/s", "robot"), *(_row(summary) for summary in summaries)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=True)]
        click.echo("  ".join(cells).rstrip())


def _row(summary: LogSummary) -> tuple[str, ...]:
    about = summary.metadata
    speed = about.get("forward_speed_m_s")
    return (
        _plain(summary.path.name),
        summary.state,
        str(summary.ticks),
        f"{summary.duration_s:.1f}",
        _gait_text(about.get("gait")),
        f"{speed:.4g}" if isinstance(speed, (int, float)) else "-",
        _plain(about.get("robot", "-")) + (" (simulated)" if about.get("simulated") else ""),
    )


@command.command(
    "info", epilog="\b\nExamples:\n  snakebot log info run.mcap\n  snakebot log info run.mcap --json"
)
@click.argument("log", type=LOG)
@JSON_OPTION
def info(log: Path, as_json: bool) -> None:
    """What LOG holds: metadata, channels, attachments, and whether it is whole."""
    from snakebot.runlog import read_log
    from snakebot.runlog.listing import summarize

    contents = read_log(_existing(log))
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
        click.echo(f"  damaged: {_plain(problem)}")
    click.echo(
        f"  {contents.joints} joints; {result['late_ticks']} late ticks; {result['lost_samples']} lost samples"
    )
    click.echo("  channels: " + ", ".join(f"{topic} ({n})" for topic, n in sorted(summary.messages.items())))
    click.echo("  attachments: " + _plain(", ".join(contents.attachments)))
    for key, value in sorted(contents.metadata.items()):
        click.echo(f"  {_plain(key)}: {_plain(value if isinstance(value, str) else json.dumps(value))}")
    for event in contents.events:
        if event.level != "debug":
            click.echo(f"  {event.t_s:9.3f} s  {event.level}: {_plain(event.message)}")


EXPORT_EPILOG = """\b
Examples:
  snakebot log export run.mcap run.csv
  snakebot log export run.mcap run.parquet
  snakebot log export runs/*.mcap my_session            a session folder
  snakebot log export run.mcap robot.yaml               an attachment, by its name
"""


@command.command("export", epilog=EXPORT_EPILOG)
@click.argument("logs", type=LOG, nargs=-1, required=True)
@click.argument("output", type=LOG)
@click.option(
    "--format",
    "form",
    type=click.Choice(["csv", "csv.gz", "parquet", "session", "attachment"]),
    help="What to write [by OUTPUT's ending; a session folder where it has none].",
)
@JSON_OPTION
def export(logs: tuple[Path, ...], output: Path, form: str | None, as_json: bool) -> None:
    """Write LOGS as OUTPUT: a table (CSV, CSV.gz, Parquet) of one log, or a session folder of any number."""
    from snakebot.runlog import open_runs, read_log
    from snakebot.runlog.session_write import write_session, write_table

    form = form or _form(output)
    if output.exists() and (output.is_file() or form != "session"):
        raise BadInputError(f"{output}: exists already")
    if form == "session":
        session = open_runs(logs)
        write_session(output, session.robot, session.runs)
        result: dict[str, Any] = {"output": str(output), "runs": len(session.runs)}
    else:
        if len(logs) > 1:
            raise BadInputError(
                f"{output}: a table holds one run, {len(logs)} were given; give a folder as OUTPUT"
            )
        log = read_log(_existing(logs[0]))
        if form == "attachment":
            if output.name not in log.attachments:
                known = _plain(", ".join(log.attachments))
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
                raise BadInputError(f"{output}: cannot be written: {error.strerror}") from None
            result = {"output": str(output), "rows": int(log.t_s.size), "columns": list(columns)}
    _tell(result, as_json, str(output))


IMPORT_EPILOG = """\b
Examples:
  snakebot log import lab.csv runs/lab.mcap --map t_s=Time:ms --map 'cmd_*_rad=goal*:deg' --map 'enc_*_rad=pos*:deg'
  snakebot log import lab.csv runs/lab.mcap --map-file columns.txt --delimiter ';' --decimal ,
  snakebot log import run_01.csv runs/one.mcap --robot bench.yaml      (columns named as in a session)

\b
A map entry is NAME=[-]COLUMN[:UNIT]. NAME: t_s, cmd_1_rad, enc_1_rad, applied_1_rad, x_m, y_m, heading_rad,
current_1_a, supply_v, temperature_1_c. UNIT: s ms us ns min, rad deg rev mrad counts, m cm mm, A mA, V mV.
* stands for the joint's number from 1, # in COLUMN for its number from 0.
"""


def _table_options(function: Any) -> Any:
    for option in (
        click.option("--skip-rows", type=click.IntRange(min=0), default=0, help="Lines before the header."),
        click.option(
            "--decimal", type=click.Choice([".", ","]), default=".", help="Decimal sign of the CSV."
        ),
        click.option("--delimiter", default=",", help="Between the CSV's columns; 'tab' for tabs."),
        click.option(
            "--map-file", type=LOG, help="A file with one map entry a line; # begins a comment line."
        ),
        click.option("--map", "entries", multiple=True, help="NAME=[-]COLUMN[:UNIT], as often as needed."),
    ):
        function = option(function)
    return function


@command.command("import", epilog=IMPORT_EPILOG)
@click.argument("table", type=LOG)
@click.argument("output", type=LOG)
@_table_options
@click.option("--robot", "robot_source", default="penn_state", show_default=True, help="Robot description.")
@click.option("--alpha", type=float, help="Gait of the run, deg; with --beta and --omega.")
@click.option("--beta", type=float, help="deg")
@click.option("--omega", type=float, help="rad/s")
@click.option("--speed", type=float, help="Measured forward speed, m/s.")
@click.option("--note", help="Anything worth remembering; stored with the log.")
@JSON_OPTION
def import_log(table: Path, output: Path, robot_source: str, as_json: bool, **options: Any) -> None:
    """Make the log OUTPUT from TABLE (CSV, CSV.gz, Parquet) that another program recorded."""
    from snakebot.robot import load_robot
    from snakebot.runlog import gait_to_mapping
    from snakebot.runlog.column_map import parse_map
    from snakebot.runlog.importing import import_table

    robot = load_robot(robot_source)
    gait = {"alpha_deg": options["alpha"], "beta_deg": options["beta"], "omega_rad_s": options["omega"]}
    about: dict[str, Any] = {}
    if any(value is not None for value in gait.values()):
        from snakebot.runlog.log import gait_from_mapping

        given = {key: value for key, value in gait.items() if value is not None}
        parsed = gait_from_mapping(given, "--alpha, --beta, --omega")
        about["gait"] = gait_to_mapping(parsed) if parsed is not None else None
    if options["speed"] is not None:
        about.update(
            forward_speed_m_s=_finite("--speed", options["speed"]), forward_speed_source="entered by hand"
        )
    if options["note"]:
        about["notes"] = options["note"]
    mapping = parse_map(_entries(options), robot)
    path = import_table(table, output, robot, mapping, about, _dialect(options))
    _tell({"output": str(path)}, as_json, str(path))


@command.command(
    "recover",
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
        click.echo(f"snakebot: {log}: {_plain(problem)}", err=True)
    _tell({"output": str(path), "ticks": ticks, "left_out": problems}, as_json, f"{path}: {ticks} ticks")


MERGE_EPILOG = """\b
Examples:
  snakebot log merge-speed run.mcap --speed 0.131
  snakebot log merge-speed run.mcap --track camera.csv --map t_s=t --map x_m=X:mm --map y_m=Y:mm
  snakebot log merge-speed run.mcap --track camera.csv --offset 3.2 -o tracked.mcap

\b
A track has t_s, x_m, y_m and, if known, heading_rad. Its clock is brought onto the run's by --offset (track time
minus run time, s), by its wall clock (times since 1970), or, without either, by when and how fast the robot moved.
"""


@command.command("merge-speed", epilog=MERGE_EPILOG)
@click.argument("log", type=LOG)
@click.option("--speed", type=float, help="Measured forward speed, m/s.")
@click.option("--track", type=LOG, help="Table of where the robot was.")
@click.option("--offset", type=float, help="Track time minus run time, s.")
@_table_options
@click.option("-o", "--output", type=LOG, help="Write here [rewrite LOG, in one step].")
@JSON_OPTION
def merge(
    log: Path,
    speed: float | None,
    track: Path | None,
    offset: float | None,
    output: Path | None,
    as_json: bool,
    **options: Any,
) -> None:
    """Add a measured speed, or a track on a clock of its own, to LOG."""
    from snakebot.runlog.merging import merge_speed

    if (speed is None) == (track is None):
        raise BadInputError("give --speed or --track, one of them")
    if speed is not None:
        path = merge_speed(_existing(log), _finite("--speed", speed), output=output)
        result: dict[str, Any] = {"output": str(path), "forward_speed_m_s": speed}
        _tell(result, as_json, f"{path}: forward speed {speed:g} m/s")
        return
    assert track is not None
    result = _merge_track(_existing(log), track, offset, output, options)
    speed_text = result["forward_speed_m_s"]
    known = "not known (no steady motion)" if speed_text is None else f"{speed_text:.4f} m/s"
    how = f"offset {result['offset_s']:.3f} s ({result['aligned_by']})"
    _tell(result, as_json, f"{result['output']}: {how}; forward speed {known}")


def _merge_track(
    log: Path, table: Path, offset_s: float | None, output: Path | None, options: dict[str, Any]
) -> dict[str, Any]:
    from snakebot.analysis.speed import forward_speed
    from snakebot.analysis.steady import find_steady_state
    from snakebot.runlog import read_log
    from snakebot.runlog.column_map import parse_map
    from snakebot.runlog.merging import merge_track, place_track, read_track, with_heading

    contents = read_log(log)
    run = contents.to_run()
    gait = contents.gait
    period_s = gait.period_s if gait is not None and math.isfinite(gait.period_s) else 1.0
    track = read_track(table, parse_map(_entries(options), contents.robot), _dialect(options))
    track = with_heading(track, period_s)
    offset, aligned_by = place_track(
        contents, track, None if offset_s is None else _finite("--offset", offset_s)
    )
    omega = None if gait is None else gait.omega_rad_s
    steady = find_steady_state(run.t_s, run.command_rad, run.measured_rad, omega)
    found = forward_speed(
        track.t_s - offset.offset_s,
        track.pose,
        steady.start_s,
        steady.end_s,
        period_s if gait is not None else None,
    )
    speed = None if found is None else found.forward_m_s
    path = merge_track(log, track, offset, speed, table.name, output)
    return {
        "output": str(path),
        "offset_s": offset.offset_s,
        "aligned_by": aligned_by,
        "correlation": None if math.isnan(offset.correlation) else offset.correlation,
        "forward_speed_m_s": speed,
    }


def _existing(log: Path) -> Path:
    if not log.is_file():
        raise BadInputError(f"{log}: no such log")
    return log


def _finite(name: str, value: float) -> float:
    if not math.isfinite(value):
        raise BadInputError(f"{name} {value}: not a finite number")
    return value


def _form(output: Path) -> str:
    for ending in ("csv", "csv.gz", "parquet"):
        if output.name.endswith(f".{ending}"):
            return ending
    return "attachment" if output.suffix else "session"


def _write(path: Path, data: bytes) -> None:
    try:
        path.write_bytes(data)
    except OSError as error:
        raise BadInputError(f"{path}: cannot be written: {error.strerror}") from None


def _entries(options: dict[str, Any]) -> list[str]:
    entries = list(options["entries"])
    if options["map_file"] is not None:
        try:
            lines = options["map_file"].read_text(encoding="utf-8").splitlines()
        except (OSError, UnicodeDecodeError) as error:
            raise BadInputError(f"{options['map_file']}: cannot read the column map: {error}") from None
        entries += [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
    return entries


def _dialect(options: dict[str, Any]) -> Dialect:
    from snakebot.runlog.table import Dialect

    delimiter = "\t" if options["delimiter"] == "tab" else options["delimiter"]
    if len(delimiter) != 1:
        raise BadInputError(f"--delimiter {delimiter!r}: give one character, or 'tab'")
    return Dialect(delimiter, options["decimal"], options["skip_rows"])


def _tell(result: dict[str, Any], as_json: bool, text: str) -> None:
    click.echo(json.dumps(result) if as_json else text)


def _plain(text: object) -> str:
    """Text from a file as one line that cannot steer the terminal."""
    return "".join(char if char.isprintable() else "?" for char in str(text))


def _gait_text(gait: Any) -> str:
    if not isinstance(gait, dict):
        return "-"
    values = [gait.get(key) for key in ("alpha_deg", "beta_deg", "omega_rad_s")]
    return " ".join(f"{value:g}" if isinstance(value, (int, float)) else "?" for value in values)


def _lost(log: RunLog) -> int:
    import numpy as np

    return int(np.isnan(log.measured_rad).sum())


def _as_mapping(summary: LogSummary) -> dict[str, Any]:
    return {
        "log": str(summary.path),
        "state": summary.state,
        "ticks": summary.ticks,
        "duration_s": summary.duration_s,
        "bytes": summary.bytes,
        "messages": dict(summary.messages),
        "metadata": dict(summary.metadata),
        "problems": list(summary.problems),
    }
