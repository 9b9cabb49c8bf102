"""``snakebot optimize``: the best gait of a robot with its effects."""

from __future__ import annotations

import contextlib
import shlex
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from snakebot.cli.optimize_show import gait_file, show
from snakebot.cli.study_output import finish
from snakebot.errors import BadInputError
from snakebot.resources import DEFAULT_ROBOT

if TYPE_CHECKING:
    from snakebot.cli.optimize_live import Undertaking
    from snakebot.effects import EffectSpec
    from snakebot.optimise.shape import Amplitudes
    from snakebot.robot import Robot

SHAPES = ("equal", "taper", "each")  # as in optimise.shape
AIMS = ("speed", "power-at-speed", "cost-of-transport")  # as in optimise.goal, which brings numpy in

EPILOG = """\b
Examples:
  snakebot optimize penn_state --for power-at-speed --speed 0.2
  snakebot optimize calibrated.yaml --for speed --robust
  snakebot optimize calibrated.yaml --for speed --within alpha=20..60,omega=1..4
  snakebot optimize penn_state --for cost-of-transport --fault free:3 --json
  snakebot optimize penn_state --for speed --live serial:/dev/ttyUSB0 --logs new_logs

\b
Exit status: 0 a gait was found, and with --live run, whatever came of it; 2 bad input, or no gait does what is asked
for; 1 internal error; 130 interrupted. With --live also those of `snakebot run`, where a run fails.
"""


@click.command(name="optimize", epilog=EPILOG)
@click.argument("robot_source", metavar="ROBOT")
@click.option("--for", "aim", type=click.Choice(AIMS), required=True, help="What the gait is to be best at.")
@click.option("--speed", type=float, help="Of power-at-speed, m/s.")
@click.option(
    "--within", metavar="RANGES", help="alpha and beta in deg, omega in rad/s: alpha=20..60,omega=1..4."
)
@click.option(
    "--within-recorded",
    is_flag=True,
    help="Ask for no more omega, joint speed and torque than the recordings that ROBOT was calibrated on.",
)
@click.option("--fault", "faults", multiple=True, help="Broken joints: free:3, rigid:4+5, rigid:2=30.")
@click.option(
    "--effect",
    "effects",
    multiple=True,
    help="Further effects: NAME:param=value. With --live: on the simulated board, which nobody is told of.",
)
@click.option(
    "--margin", type=float, default=0.1, show_default=True, help="Share of each servo's torque to be left."
)
@click.option("--torque", type=float, help="N m that each servo has, where the description does not say.")
@click.option("--robust", is_flag=True, help="The best worst case over the description's uncertainty.")
@click.option(
    "--draws", type=click.IntRange(0, 1000), default=40, show_default=True, help="Robots behind an interval."
)
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of the draws.")
@click.option(
    "--amplitudes",
    type=click.Choice(SHAPES),
    default="equal",
    show_default=True,
    help="Of the joints: all alpha, falling evenly to one end, or each its own share of alpha.",
)
@click.option(
    "--grid",
    metavar="A,B,W",
    default="10,10,7",
    show_default=True,
    help="Alphas, betas and omegas of the first look; fewer are faster, and may miss the best.",
)
@click.option(
    "--gait", "gait_source", default="penn_state_optimum", show_default=True, help="Gait to compare with."
)
@click.option("--dask", metavar="ADDRESS", help="Hand the simulations to a dask.distributed cluster.")
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="[results/optimize_ROBOT].")
@click.option("--json", "as_json", is_flag=True, help="Print the result as one JSON object.")
@click.option(
    "--live", "port", metavar="PORT", help="Diagnose the robot there, choose, run the choice: does it pay?"
)
@click.option("--logs", type=click.Path(path_type=Path), help="With --live: new folder for the logs.")
@click.option(
    "--budget",
    type=click.IntRange(2, 100),
    default=9,
    show_default=True,
    help="With --live: most runs of the diagnosis.",
)
@click.option(
    "--repeats",
    type=click.IntRange(1, 20),
    default=3,
    show_default=True,
    help="With --live: runs of each choice.",
)
@click.option("--yes", is_flag=True, help="With --live: do not ask before each motion.")
@click.option("--fast", is_flag=True, help="With --live, simulated board: virtual time.")
def command(
    robot_source: str,
    aim: str,
    speed: float | None,
    within: str | None,
    within_recorded: bool,
    faults: tuple[str, ...],
    effects: tuple[str, ...],
    margin: float,
    torque: float | None,
    robust: bool,
    draws: int,
    seed: int,
    amplitudes: Amplitudes,
    grid: str,
    gait_source: str,
    dask: str | None,
    out: Path | None,
    as_json: bool,
    port: str | None,
    logs: Path | None,
    budget: int,
    repeats: int,
    yes: bool,
    fast: bool,
) -> None:
    """The best gait of ROBOT, a description by name or file, with the effects in it.

    The front, what limits each gait, and how sure the promise is. Write the description by `snakebot diagnose --apply`.
    """
    from snakebot.cluster import Workers
    from snakebot.effects import parse_effects
    from snakebot.gait import load_gait
    from snakebot.optimise.figure import optimum_figure
    from snakebot.optimise.goal import AIMS as KNOWN
    from snakebot.optimise.goal import Goal
    from snakebot.optimise.optimum import optimise
    from snakebot.optimise.promise import OptimiseOptions
    from snakebot.optimise.space import parse_grid, parse_within
    from snakebot.robot import load_robot
    from snakebot.studies.figures import save

    goal = Goal(KNOWN[AIMS.index(aim)], speed)
    robot, ranges, beside = load_robot(robot_source), parse_within(within), load_gait(gait_source)
    if robust and not draws:
        raise BadInputError("--robust: needs --draws, the robots that the gait is to suit")
    _check_live(port, logs, faults, dask, within_recorded)
    if effects and port is None:
        further = tuple(str(spec) for spec in parse_effects(effects, robot))
        robot = robot.model_copy(update={"effects": (*robot.effects, *further)})
    options = OptimiseOptions(
        within=ranges, faults=_faults(faults, robot), margin=margin, torque_nm=torque, robust=robust, draws=draws,
        seed=seed, within_recorded=within_recorded, amplitudes=amplitudes, grid=parse_grid(grid),
    )  # fmt: skip
    folder = out or Path("results") / f"optimize_{Path(robot_source).stem}"
    if port is not None and logs is not None:
        from snakebot.cli.optimize_live import Undertaking
        from snakebot.cli.run_options import RunOptions

        which = _which(robot_source, ()) + f" --port {shlex.quote(port)}"
        run_options = RunOptions(port=port, effects=effects, yes=yes, fast=fast)
        asked = Undertaking(logs, goal, options, run_options, budget, repeats)
        _live(robot, asked, folder, as_json, which)
        return
    with _counter(as_json) as progress, Workers(dask) as workers:
        result = optimise(
            robot, goal, options, beside={gait_source: beside}, progress=progress, workers=workers
        )
    files = [*save(optimum_figure(result), folder, "optimum"), gait_file(result, folder, robot_source)]
    which = _which(robot_source, effects)
    finish(result.summary(), as_json, lambda: show(result, robot, which), files)


def _which(source: str, effects: tuple[str, ...]) -> str:
    """Options of `snakebot run` for this robot; it takes ``DEFAULT_ROBOT`` without any."""
    words = [] if source == DEFAULT_ROBOT else ["--robot", source]
    words += [word for effect in effects for word in ("--effect", effect)]
    return "".join(f" {shlex.quote(word)}" for word in words)


_LIVE_OPTIONS = ("logs", "budget", "repeats", "yes", "fast")


def _check_live(
    port: str | None, logs: Path | None, faults: tuple[str, ...], dask: str | None, within_recorded: bool
) -> None:
    """
    Raises:
        BadInputError: an option that means something with --live only, or that it lacks or cannot have.
    """
    context = click.get_current_context()
    if port is None:
        for name in _LIVE_OPTIONS:
            if context.get_parameter_source(name) is ParameterSource.COMMANDLINE:
                raise BadInputError(f"--{name}: only with --live; nothing moves otherwise")
    elif logs is None:
        raise BadInputError("--live: say where the logs go, as in --logs new_logs")
    elif dask is not None:
        raise BadInputError("--dask: not with --live, which runs on this computer")
    elif within_recorded:
        raise BadInputError(
            "--within-recorded: not with --live, which runs the choice and tells what came of it"
        )
    elif faults:
        raise BadInputError("--fault: not with --live; the diagnosis finds a broken joint itself")


def _live(robot: Robot, asked: Undertaking, folder: Path, as_json: bool, which: str) -> None:
    from snakebot.cli.diagnose_live import check_runs
    from snakebot.cli.optimize_live import lines, optimize_live
    from snakebot.optimise.figure import optimum_figure
    from snakebot.studies.figures import save

    # Where somebody said no to the first run, there are folders and nothing in them.
    logs = asked.folder
    if logs.exists() and (not logs.is_dir() or any(not path.is_dir() for path in logs.rglob("*"))):
        raise BadInputError(f"{logs}: holds something already; give a new folder for the logs")
    check_runs(asked.run_options, robot)
    result, proof = optimize_live(asked, robot, lambda text: click.echo(text, err=True))
    files = [*save(optimum_figure(result), folder, "optimum"), gait_file(result, folder, robot.name)]

    def show_both() -> None:
        show(result, robot, which)
        for line in lines(asked.goal, proof):
            click.echo(line)

    finish({**result.summary(), "proof": proof.summary()}, as_json, show_both, files)


def _faults(texts: tuple[str, ...], robot: Robot) -> tuple[EffectSpec, ...]:
    """
    Raises:
        BadInputError: not in the grammar, no such joint, or a fault that comes or goes in mid-run.
    """
    from firmware_protocol.catalogue import JointMode
    from snakebot.control.faults import check_faults, parse_fault
    from snakebot.effects import fault_spec

    found = [parse_fault(text, robot.joints) for text in texts]
    check_faults(found, robot)
    broken: set[int] = set()
    for fault in found:
        if fault.at_s > 0 or fault.mode is JointMode.ACTIVE:
            raise BadInputError(
                f"--fault {fault}: a joint is broken all the time, or not: free:3, rigid:4=20"
            )
        twice = broken & set(fault.joints)
        if twice:
            raise BadInputError(f"--fault {fault}: joint {min(twice)} has a fault already")
        broken |= set(fault.joints)
    if len(broken) == robot.joints:
        raise BadInputError("--fault: no joint is left to move the robot")
    kinds = {JointMode.FREE: "free", JointMode.RIGID: "rigid"}
    return tuple(fault_spec(kinds[fault.mode], fault.joints, fault.angle_rad) for fault in found)


@contextlib.contextmanager
def _counter(as_json: bool) -> Iterator[Callable[[int], None]]:
    """How many gaits have been simulated, on a terminal only."""
    if as_json or not sys.stderr.isatty():
        yield lambda done: None
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.completed} gaits simulated"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=None)
        yield lambda done: bar.advance(task, done)
