"""``snakebot session import``: recordings of any robot as a session folder."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from snakebot.cli.map_options import MapOptions, map_options
from snakebot.cli.robot_option import robot_option
from snakebot.cli.typed_options import collected
from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.runlog import Run
    from snakebot.runlog.foreign.angles import AngleForm
    from snakebot.runlog.foreign.source import SourceOptions
    from snakebot.runlog.session_write import TableFormat

PATH = click.Path(path_type=Path)

EPILOG = """\b
Examples:
  snakebot session import monday.csv tuesday.csv -o lab --units deg
  snakebot session import log.csv -o lab --map t_s=Time:ms --map 'cmd_*_rad=goal*:deg' --map 'enc_*_rad=pos*:deg'
  snakebot session import log.txt -o lab --units counts --counts-per-rev 4096 --centre 2048 --direction 1,-1,1
  snakebot session import my_dataset -o lab --units percent --range -100:100 --episodes 0-9   (LeRobot)
  snakebot session import my_bag -o lab --command /position_controller/commands --joints a,b   (ROS 2)

\b
What is not said is found out from names and numbers and told in a line; on a terminal it is shown and asked about
first, unless --yes is given. docs/your-recordings.md says what is read and how.
A map entry is NAME=[-]COLUMN[:UNIT], as of snakebot log import.
"""


@dataclass(frozen=True)
class ImportOptions(MapOptions):
    """What the options say of the recordings, as they are typed."""

    units: str | None
    counts_per_rev: int | None
    centre: str | None
    direction: str | None
    ranges: str | None
    time_unit: str | None
    rate: float | None
    joints: str | None
    episodes: str | None
    measured: str | None
    command_topic: str | None

    def source(self) -> SourceOptions:
        """What the reading of recordings needs of it.

        Raises:
            BadInputError: a text that is not in its grammar, or a rate out of range.
        """
        from snakebot.runlog.foreign.lerobot import parse_episodes
        from snakebot.runlog.foreign.source import SourceOptions
        from snakebot.runlog.foreign.tables import TableOptions

        if self.rate is not None and not 0 < self.rate < 1e6:
            raise BadInputError(f"--rate {self.rate:g}: rows a second, more than 0 and less than a million")
        names = self.joints or ""
        joints = tuple(name.strip() for name in names.split(",") if name.strip())
        if len(set(joints)) != len(joints):
            raise BadInputError(f"--joints {names[:60]}: a joint stands twice")
        table = TableOptions(
            entries=tuple(self.all_entries()),
            delimiter=self.separator(),
            decimal=self.decimal,
            skip_rows=self.skip_rows,
            time_unit=self.time_unit,
            rate_hz=self.rate,
            angles=self._angles(),
        )
        return SourceOptions(
            table=table,
            measured=self.measured,
            command=self.command_topic,
            joints=joints,
            episodes=None if self.episodes is None else parse_episodes(self.episodes),
        )

    def _angles(self) -> AngleForm:
        from snakebot.runlog.foreign.angles import AngleForm

        form = AngleForm(self.units, counts_per_rev=self.counts_per_rev)
        if self.centre is not None:
            form = replace(form, centre=_numbers("--centre", self.centre))
        if self.direction is not None:
            direction = _numbers("--direction", self.direction)
            if any(sign not in (1.0, -1.0) for sign in direction):
                raise BadInputError(f"--direction {self.direction[:60]}: 1 or -1, one or one a joint")
            form = replace(form, direction=direction)
        if self.ranges is not None:
            spans = [_numbers("--range", part, ":") for part in self.ranges.split(",")]
            if any(len(span) != 2 or not span[0] < span[1] for span in spans):
                raise BadInputError(f"--range {self.ranges[:60]}: write LOW:HIGH in degrees, LOW below HIGH")
            form = replace(form, range_deg=tuple((span[0], span[1]) for span in spans))
        return form


@click.command("import", short_help="Make a session of any robot's recordings.", epilog=EPILOG)
@click.argument("sources", type=PATH, nargs=-1, required=True)
@click.option("-o", "--output", type=PATH, required=True, help="The session folder to write.")
@robot_option("Nominal model [a bench of as many joints as are recorded].", default=None)
@click.option(
    "--units",
    type=click.Choice(["rad", "deg", "counts", "percent"]),
    help="Of angles [said by columns' names].",
)
@click.option("--counts-per-rev", type=click.IntRange(16, 1 << 20), help="Encoder counts of a turn.")
@click.option("--centre", help="What is recorded where joints are straight: one number, or one a joint.")
@click.option("--direction", help="1 or -1 (turns the axis round): one, or one a joint.")
@click.option(
    "--range", "ranges", help="Angles at -100 and 100 percent, LOW:HIGH in deg: one, or one a joint."
)
@map_options(
    entries="Tables: NAME=[-]COLUMN[:UNIT], as often as needed.",
    map_file="Tables: a file with one map entry a line.",
    delimiter="Tables: between columns; 'tab' for tabs [found out].",
    decimal="Tables: decimal sign [found out].",
    skip_rows="Tables: lines before the header [found out].",
)
@click.option("--time-unit", type=click.Choice(["s", "ms", "us", "ns", "min"]), help="Tables [found out].")
@click.option("--rate", type=float, help="Tables without a time: rows a second, Hz.")
@click.option("--joints", help="LeRobot, ROS 2: which joints, in which order, with commas between [all].")
@click.option("--episodes", help="LeRobot: such as 0-9,12 [all].")
@click.option("--measured", help="ROS 2: topic of the measured joint states [found out].")
@click.option("--command", "command_topic", help="ROS 2: topic of the commands [found out].")
@click.option("--find-repeats/--no-find-repeats", default=True, show_default=True, help="Find equal motions.")
@click.option(
    "--format", "form", type=click.Choice(["csv", "csv.gz", "parquet"]), default="csv", show_default=True
)
@click.option("--yes", is_flag=True, help="Ask nothing.")
@click.option("--json", "as_json", is_flag=True, help="Print the result as one JSON object; ask nothing.")
@collected(ImportOptions)
def import_session(
    sources: tuple[Path, ...],
    output: Path,
    robot_source: str | None,
    find_repeats: bool,
    form: TableFormat,
    yes: bool,
    as_json: bool,
    options: ImportOptions,
) -> None:
    """Write the session folder OUTPUT from SOURCES of any robot: tables, LeRobot datasets, ROS 2 bags."""
    from snakebot.robot import load_robot
    from snakebot.runlog import write_session
    from snakebot.runlog.foreign.source import read_sources
    from snakebot.runlog.repeats import mark_repeats

    _check_output(output)
    robot = load_robot(robot_source) if robot_source is not None else None
    said = options.source()
    asking = not (as_json or yes) and asks()
    if asking:
        from snakebot.cli.import_questions import ask

        said = ask(sources, said)
    found = read_sources(sources, said, robot)
    if not as_json:
        for line in _grouped(found.told):
            click.echo(line)
    if asking:
        _preview(found.runs[0])
        if not click.confirm(f"Write {output}?", default=True):
            raise BadInputError("nothing was written")
    runs = mark_repeats(found.runs) if find_repeats else found.runs
    write_session(output, found.robot, runs, form)
    result = {
        "output": str(output),
        "runs": len(runs),
        "joints": found.robot.joints,
        "samples": sum(map(len, runs)),
        "repeats": {run.name: run.repeat_of for run in runs if run.repeat_of is not None},
        "told": list(found.told),
    }
    if as_json:
        click.echo(json.dumps(result))
        return
    joints = f"{found.robot.joints} joint{'s' if found.robot.joints > 1 else ''}"
    click.echo(
        f"{output}: {len(runs)} run{'s' if len(runs) > 1 else ''}, {joints}, {result['samples']} samples"
    )
    if robot is None:
        lag_s, where = found.robot.servo.time_constant_s, output / "session.yaml"
        click.echo(
            f"  the nominal robot is a bench of servos with a lag of {lag_s:g} s; describe yours in {where}, or with "
            "--robot"
        )
    click.echo(f"next: snakebot session check {output}; snakebot diagnose {output}")


def _grouped(lines: Sequence[str]) -> list[str]:
    """``name: what was found``, files of which the same was found in one line."""
    names: dict[str, list[str]] = {}
    for line in lines:
        name, _, text = line.partition(": ")
        names.setdefault(text, []).append(name)
    return [
        f"{first}{f' and {len(more)} more' if more else ''}{f': {text}' if text else ''}"
        for text, (first, *more) in names.items()
    ]


def asks() -> bool:
    """Whether somebody sits there who can answer."""
    return sys.stdin.isatty() and sys.stdout.isatty()


def _check_output(output: Path) -> None:
    """Before anything is read: minutes of work must not end in a name that is taken."""
    if output.exists() and (not output.is_dir() or any(output.iterdir())):
        raise BadInputError(f"{output}: exists already; a session is never written over another")


def _numbers(option: str, text: str, between: str = ",") -> tuple[float, ...]:
    try:
        found = tuple(float(part) for part in text.split(between))
    except ValueError:
        found = (math.nan,)
    if not all(map(math.isfinite, found)):
        raise BadInputError(f"{option} {text[:60]}: not numbers with {between!r} between")
    return found


def _preview(run: Run) -> None:
    """The first samples of a run as they would be written, in degrees for the eye."""
    import numpy as np

    shown = min(run.joints, 4)
    heads = [f"{kind} {joint + 1}" for kind in ("cmd", "enc") for joint in range(shown)]
    click.echo(f"{run.name}: {len(run)} samples over {run.duration_s:.2f} s; the first, in degrees:")
    click.echo("  " + "".join(f"{head:>10}" for head in ["t, s", *heads]))
    for row in range(min(5, len(run))):
        angles = np.degrees(np.concatenate([run.command_rad[row, :shown], run.measured_rad[row, :shown]]))
        click.echo("  " + "".join(f"{value:10.3f}" for value in [run.t_s[row], *angles]))
