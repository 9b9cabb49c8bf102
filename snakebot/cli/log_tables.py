"""``snakebot log import`` and ``merge-speed``: tables that other programs recorded, through a column map."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from snakebot.cli.log import JSON_OPTION, LOG, existing, tell
from snakebot.cli.map_options import MapOptions, map_options
from snakebot.cli.robot_option import robot_option
from snakebot.cli.run_options import check_speed
from snakebot.cli.typed_options import collected
from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.runlog.number_table import CsvForm

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


_map_options = map_options(
    entries="NAME=[-]COLUMN[:UNIT], as often as needed.",
    map_file="A file with one map entry a line; # begins a comment line.",
    delimiter="Between the CSV's columns; 'tab' for tabs [found out].",
    decimal="Decimal sign of the CSV [found out].",
    skip_rows="Lines before the header [found out].",
)


@click.command("import", short_help="Make a log from any table, by a column map.", epilog=IMPORT_EPILOG)
@click.argument("table", type=LOG)
@click.argument("output", type=LOG)
@_map_options
@robot_option()
@click.option("--alpha", type=float, help="Gait of the run, deg; with --beta and --omega.")
@click.option("--beta", type=float, help="deg")
@click.option("--omega", type=float, help="rad/s")
@click.option("--speed", type=float, help="Measured forward speed, m/s.")
@click.option("--note", help="Anything worth remembering; stored with the log.")
@JSON_OPTION
@collected(MapOptions)
def import_log(
    table: Path,
    output: Path,
    robot_source: str,
    alpha: float | None,
    beta: float | None,
    omega: float | None,
    speed: float | None,
    note: str | None,
    as_json: bool,
    options: MapOptions,
) -> None:
    """Make the log OUTPUT from TABLE (CSV, CSV.gz, Parquet) that another program recorded."""
    from snakebot.robot import load_robot
    from snakebot.runlog import gait_to_mapping
    from snakebot.runlog.column_map import parse_map
    from snakebot.runlog.importing import import_table

    robot = load_robot(robot_source)
    gait = {"alpha_deg": alpha, "beta_deg": beta, "omega_rad_s": omega}
    about: dict[str, Any] = {}
    if any(value is not None for value in gait.values()):
        from snakebot.runlog.log import gait_from_mapping

        given = {key: value for key, value in gait.items() if value is not None}
        parsed = gait_from_mapping(given, "--alpha, --beta, --omega")
        about["gait"] = gait_to_mapping(parsed) if parsed is not None else None
    check_speed(speed)
    if speed is not None:
        about.update(forward_speed_m_s=speed, forward_speed_source="entered by hand")
    if note:
        about["notes"] = note
    mapping = parse_map(options.all_entries(), robot)
    path = import_table(table, output, robot, mapping, about, _dialect(table, options))
    tell({"output": str(path), "robot": robot.name}, as_json, f"{path}: of robot {robot.name}")


MERGE_EPILOG = """\b
Examples:
  snakebot log merge-speed run.mcap --speed 0.131
  snakebot log merge-speed run.mcap --track camera.csv --map t_s=t --map x_m=X:mm --map y_m=Y:mm
  snakebot log merge-speed run.mcap --track camera.csv --offset 3.2 -o tracked.mcap

\b
A track has t_s, x_m, y_m and, if known, heading_rad. Its clock is brought onto the run's by --offset (track time
minus run time, s), by its wall clock (times since 1970), or, without either, by when and how fast the robot moved.
"""


@click.command("merge-speed", short_help="Add a measured speed or a track to a log.", epilog=MERGE_EPILOG)
@click.argument("log", type=LOG)
@click.option("--speed", type=float, help="Measured forward speed, m/s.")
@click.option("--track", type=LOG, help="Table of where the robot was.")
@click.option("--offset", type=float, help="Track time minus run time, s.")
@_map_options
@click.option("-o", "--output", type=LOG, help="Write here [rewrite LOG, in one step].")
@JSON_OPTION
@collected(MapOptions)
def merge(
    log: Path,
    speed: float | None,
    track: Path | None,
    offset: float | None,
    output: Path | None,
    as_json: bool,
    options: MapOptions,
) -> None:
    """Add a measured speed, or a track on a clock of its own, to LOG."""
    from snakebot.runlog.merging import merge_speed

    if (speed is None) == (track is None):
        raise BadInputError("give --speed or --track, one of them")
    if speed is not None:
        check_speed(speed)
        path = merge_speed(existing(log), speed, output=output)
        result: dict[str, Any] = {"output": str(path), "forward_speed_m_s": speed}
        tell(result, as_json, f"{path}: forward speed {speed:g} m/s")
        return
    assert track is not None
    result = _merge_track(existing(log), track, offset, output, options)
    speed_text = result["forward_speed_m_s"]
    known = "not known (no steady motion)" if speed_text is None else f"{speed_text:.4f} m/s"
    how = f"offset {result['offset_s']:.3f} s ({result['aligned_by']})"
    tell(result, as_json, f"{result['output']}: {how}; forward speed {known}")


def _merge_track(
    log: Path, table: Path, offset_s: float | None, output: Path | None, options: MapOptions
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
    track = read_track(table, parse_map(options.all_entries(), contents.robot), _dialect(table, options))
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


def _finite(name: str, value: float) -> float:
    if not math.isfinite(value):
        raise BadInputError(f"{name} {value}: not a finite number")
    return value


def _dialect(table: Path, options: MapOptions) -> CsvForm | None:
    """How the table is written, as the options say; what they leave open is found out."""
    from snakebot.runlog.foreign.csv_form import find_form

    if table.name.endswith(".parquet"):
        return None
    return find_form(table, options.separator(), options.decimal, options.skip_rows).form
