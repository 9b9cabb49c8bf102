"""``snakebot diagnose``: where robot and simulation part, and which effect causes it."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from snakebot.cli import names
from snakebot.cli.pace import shown
from snakebot.cli.robot_option import robot_option
from snakebot.cli.run_options import RunOptions, view_options
from snakebot.cli.typed_options import collected
from snakebot.errors import BadInputError
from snakebot.resources import DEFAULT_ROBOT
from snakebot.whole_files import check_apart, check_output, write_all

if TYPE_CHECKING:
    from snakebot.diagnosis import Diagnosis
    from snakebot.runlog import Session

EPILOG = """\b
Examples:
  snakebot diagnose my_session
  snakebot diagnose runs/*.mcap --json verdict.json --report verdict.html
  snakebot diagnose my_session --apply calibrated.yaml
  snakebot diagnose my_session --absent backlash --known rate_limit.limit_rad_s=1.6
  snakebot diagnose my_session --json - | jq .verdict
  snakebot diagnose sessions/* --table all.parquet --dask tcp://127.0.0.1:8786
  snakebot diagnose --live new_logs --port serial:/dev/ttyUSB0 --view
  snakebot diagnose --live new_logs --fast --yes --effect rate_limit:limit_rad_s=1.5

\b
Exit status: 0 a verdict was reached, whatever it is; 2 bad input (nothing written); 1 internal error. With --table: 2
where a session has no verdict; the table says why. With --live also those of `snakebot run`, where a run fails: its log
stays, and no verdict is written.
"""


@dataclass(frozen=True)
class LiveOptions:
    """Options that mean something with --live only."""

    port: str
    budget: int
    yes: bool
    effects: tuple[str, ...]
    fast: bool
    verbose: bool
    view: bool
    view_address: str | None
    view_port: int | None
    view_stop: bool

    @property
    def of_runs(self) -> RunOptions:
        """Those of every run that is made."""
        return RunOptions(**{f.name: getattr(self, f.name) for f in fields(self) if f.name != "budget"})


@click.command(name="diagnose", epilog=EPILOG)
@click.argument("sources", metavar="SESSION|LOG...", type=click.Path(path_type=Path), nargs=-1)
@click.option(
    "--json", "json_path", metavar="OUT.json", help="Write the verdict as JSON; - for standard output."
)
@click.option(
    "--schema",
    type=click.Choice(["1", "2"]),
    default="2",
    show_default=True,
    help="Of the JSON; 1 knows no `partly`.",
)
@click.option(
    "--report", "report_path", type=click.Path(path_type=Path), help="Write a page to look at (HTML)."
)
@click.option(
    "--apply", "apply_path", type=click.Path(path_type=Path), help="Write the robot with the effect in it."
)
@click.option(
    "--table",
    "table_path",
    type=click.Path(path_type=Path),
    help="Each SESSION for itself, a row of this table each (Parquet).",
)
@click.option(
    "--dask", metavar="ADDRESS", help="With --table: hand the sessions to a dask.distributed cluster."
)
@robot_option("Nominal model [the one in the session].", default=None)
@click.option(
    "--exclude",
    shell_complete=names.effect_names,
    multiple=True,
    metavar="EFFECT",
    help="Never name this effect; may be repeated. It may be there: what leaves the same mark is less sure.",
)
@click.option(
    "--absent",
    shell_complete=names.effect_names,
    multiple=True,
    metavar="EFFECT",
    help="You know that this effect is not there; may be repeated.",
)
@click.option(
    "--only",
    shell_complete=names.effect_names,
    multiple=True,
    metavar="EFFECT",
    help="Try this effect alone; may be repeated.",
)
@click.option("--known", multiple=True, metavar="PARAM=VALUE", help="You have measured it: it is not fitted.")
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of the bootstrap.")
@click.option("--quick", is_flag=True, help="At most two effects, no proposal, rougher intervals.")
@click.option("--quiet", is_flag=True, help="No progress bar.")
@click.option(
    "--live", is_flag=True, help="Run gaits on the robot, diagnose, run what is proposed, and so on."
)
@click.option(
    "--port",
    shell_complete=names.ports,
    default="sim:",
    show_default=True,
    help="With --live: where the board is.",
)
@click.option(
    "--budget", type=click.IntRange(2, 100), default=9, show_default=True, help="With --live: most runs."
)
@click.option("--yes", is_flag=True, help="With --live: do not ask before each motion.")
@click.option(
    "--effect",
    "effects",
    shell_complete=names.effects,
    multiple=True,
    help="With --live: effect on the simulated board.",
)
@click.option("--fast", is_flag=True, help="With --live, simulated board: virtual time.")
@click.option("-v", "--verbose", is_flag=True, help="With --live: print the last frames if a run fails.")
@view_options
@collected(LiveOptions)
def command(
    sources: tuple[Path, ...],
    json_path: str | None,
    schema: str,
    report_path: Path | None,
    apply_path: Path | None,
    table_path: Path | None,
    dask: str | None,
    robot_source: str | None,
    exclude: tuple[str, ...],
    absent: tuple[str, ...],
    only: tuple[str, ...],
    known: tuple[str, ...],
    seed: int,
    quick: bool,
    quiet: bool,
    live: bool,
    options: LiveOptions,
) -> None:
    """Find where the robot parts from its simulation, which effect causes it, and what closes the gap.

    SESSION is a session folder or a folder of logs; or give run logs one by one. With --live it is a new folder for
    the logs of the runs that are then made.
    """
    if not sources:
        raise click.UsageError("Missing argument 'SESSION|LOG...'.")
    how: dict[str, Any] = {
        "exclude": exclude,
        "absent": absent,
        "only": only,
        "known": _known(known),
        "seed": seed,
        "quick": quick,
    }
    to_json = None if json_path in (None, "-") else Path(str(json_path))
    asked = (
        ("--json", to_json, "JSON"),
        ("--report", report_path, "report"),
        ("--apply", apply_path, "robot"),
        ("--table", table_path, "table"),
    )
    for option, path, kind in asked:
        if path is not None:
            check_output(option, path, kind)
    check_apart([(option, path) for option, path, _ in asked if path is not None])
    if not live:
        _refuse_live_options()
    if table_path is not None:
        _refuse_of_one(json_path, report_path, apply_path, live)
        from snakebot.cli.diagnose_many import diagnose_to_table

        diagnose_to_table(sources, table_path, dask, how, lambda one: given_session((one,), robot_source))
        return
    if dask is not None:
        raise BadInputError("--dask: only with --table, which takes many sessions")
    from snakebot.diagnosis import diagnose
    from snakebot.diagnosis.show.words import summary

    def of(session: Session, told: Callable[[str, float], None] = lambda text, share: None) -> Diagnosis:
        with shown(quiet) as bar:

            def progress(text: str, share: float) -> None:
                bar(text, share)
                told(text, share)

            return diagnose(session, **how, progress=progress)

    if live:
        found = _live(sources, robot_source, of, options)
        session = given_session(sources, robot_source)
    else:
        session = given_session(sources, robot_source)
        found = of(session)
    outputs: list[tuple[Path, str]] = []
    text = json.dumps(found.to_mapping(first=schema == "1"), indent=2, allow_nan=False) + "\n"
    if to_json is not None:
        outputs.append((to_json, text))
    if report_path is not None:
        outputs.append((report_path, _page(session, found)))
    refused = None
    if apply_path is not None:
        from snakebot.diagnosis.show.apply import calibrated

        try:
            outputs.append((apply_path, calibrated(session.robot, found, session.runs).to_yaml()))
        except BadInputError as error:
            refused = error  # the verdict stands all the same
    write_all(outputs)
    if json_path == "-":
        click.echo(text, nl=False)
    else:
        for line in summary(found):
            click.echo(line)
        for path, _ in outputs:
            click.echo(f"wrote {path}")
    if refused is not None:
        click.echo(f"snakebot: {refused}; nothing written to {apply_path}", err=True)


def _refuse_of_one(json_path: str | None, report: Path | None, apply: Path | None, live: bool) -> None:
    """
    Raises:
        BadInputError: an option was given that belongs to a single session.
    """
    given = {"--json": json_path, "--report": report, "--apply": apply, "--live": live or None}
    for option, value in given.items():
        if value is not None:
            raise BadInputError(f"{option}: not with --table; it is of one session, and the table has it all")


def _refuse_live_options() -> None:
    """
    Raises:
        BadInputError: an option was given that means something with --live only.
    """
    context = click.get_current_context()
    for name in (field.name for field in fields(LiveOptions)):
        if context.get_parameter_source(name) is ParameterSource.COMMANDLINE:
            option = next(p.opts[0] for p in context.command.params if p.name == name)
            raise BadInputError(f"{option}: only with --live; recorded runs are diagnosed as they are")


def given_session(sources: tuple[Path, ...], robot_source: str | None, *, quiet: bool = True) -> Session:
    """What was named on the command line: a session, logs or a folder of them; of logs repeats are found.

    Raises:
        BadInputError, LogError: it is neither; one line says where, and what makes a session of it.
    """
    import warnings

    from snakebot.runlog import open_runs, open_session
    from snakebot.runlog.repeats import mark_repeats

    with warnings.catch_warnings():
        if quiet:  # the session carries them, and the verdict lists them
            warnings.simplefilter("ignore")
        session = open_session(sources[0]) if len(sources) == 1 else open_runs(sources)
    if len(sources) > 1 or not (sources[0].name == "session.yaml" or (sources[0] / "session.yaml").exists()):
        # Logs do not say what repeats what, as a session does; no robot starts twice from quite the same pose.
        session = replace(session, runs=mark_repeats(session.runs))
    if robot_source is not None:
        from snakebot.robot import load_robot

        session = replace(session, robot=load_robot(robot_source))
    return session


def _live(
    sources: tuple[Path, ...],
    robot_source: str | None,
    of: Callable[[Session, Callable[[str, float], None]], Diagnosis],
    options: LiveOptions,
) -> Diagnosis:
    from snakebot.cli.diagnose_live import Live, check_plan, check_runs, live
    from snakebot.cli.live_story import live_story
    from snakebot.robot import load_robot

    if len(sources) != 1:
        raise BadInputError("--live: give one new folder for the logs")
    plan = Live(sources[0], options.budget, options.of_runs)
    robot = load_robot(robot_source or DEFAULT_ROBOT)
    check_plan(plan, robot)
    check_runs(plan.options, robot)
    with live_story(robot, plan.options) as story:
        return live(
            plan,
            robot,
            lambda folder: of(given_session((folder,), robot_source), story.diagnosing),
            lambda t: click.echo(t, err=True),
            story,
        )


def _known(entries: tuple[str, ...]) -> dict[str, float]:
    values = {}
    for entry in entries:
        name, equals, number = entry.partition("=")
        if name.strip() in values:
            raise BadInputError(f"--known {name.strip()}: given twice")
        try:
            values[name.strip()] = float(number)
        except ValueError:
            equals = ""
        if not equals or not name.strip() or values[name.strip()] != values[name.strip()]:
            raise BadInputError(f"--known {entry!r}: write PARAM=VALUE, as in rate_limit.limit_rad_s=1.6")
    return values


def _page(session: Session, found: Diagnosis) -> str:
    from snakebot.diagnosis.show.page import page

    return page(session, found)
