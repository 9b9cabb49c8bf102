"""``snakebot predict``: what a gait will do, before the robot does it."""

from __future__ import annotations

import contextlib
import json
import shlex
import sys
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import click

from snakebot.cli.robot_option import robot_option
from snakebot.cli.run import gait_given
from snakebot.cli.run_options import check_finite
from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.calibrated.forecast import Banded, Forecast

EPILOG = """\b
Examples:
  snakebot predict --robot calibrated.yaml --alpha 50 --beta 80 --omega 3
  snakebot predict --alpha 66 --beta 80 --omega 2 --effect rate_limit:limit_rad_s=1.6 --json
  snakebot predict --gait penn_state_optimum --draws 200

\b
A band holds 95 %: of robots that the description may mean. What is drawn: the fitted numbers within the intervals that
`snakebot diagnose --apply` leaves in it, the stated ones within their tolerance.
"""


@click.command(name="predict", epilog=EPILOG)
@click.argument("recordings", nargs=-1, metavar="")
@click.option("--alpha", type=float, help="Amplitude of the joint angles, deg.")
@click.option("--beta", type=float, help="Phase from joint to joint, deg.")
@click.option("--omega", type=float, help="Frequency of the wave, rad/s.")
@click.option("--offset", type=float, default=None, help="Constant bend of all joints, deg.")
@click.option(
    "--amplitudes", metavar="SHARES", help="Of each joint, as a share of alpha: 1,0.9,0.8,0.9,1 [1]."
)
@click.option("--gait", "gait_source", help="A gait by name or YAML file; the options above override it.")
@click.option("--duration", type=float, help="Length of the run with its ramps, s [8 cycles].")
@click.option("--ramp", type=float, default=2.0, show_default=True, help="Smooth start and end, each, s.")
@robot_option()
@click.option("--effect", "effects", multiple=True, help="Further effect, exact: NAME:param=value.")
@click.option("--draws", type=int, default=64, show_default=True, help="Robots that are tried.")
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of the draws.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    recordings: tuple[str, ...],
    alpha: float | None,
    beta: float | None,
    omega: float | None,
    offset: float | None,
    amplitudes: str | None,
    gait_source: str | None,
    duration: float | None,
    ramp: float,
    robot_source: str,
    effects: tuple[str, ...],
    draws: int,
    seed: int,
    as_json: bool,
) -> None:
    """Speed, tracking error and power of a gait on a robot, with bands from what is not known of it."""
    from snakebot.calibrated.forecast import forecast
    from snakebot.control import plan_run
    from snakebot.effects import parse_effects
    from snakebot.gait import check_motion
    from snakebot.robot import load_robot

    if recordings:
        named = shlex.join(recordings)
        raise BadInputError(
            f"{named}: a prediction is of a gait on a robot, not of recordings; `snakebot diagnose {named} --apply "
            "robot.yaml` makes the robot of them, for --robot"
        )
    check_finite("ramp", ramp)
    check_finite("duration", duration)
    robot = load_robot(robot_source)
    more = tuple(map(str, parse_effects(effects, robot)))
    robot = robot.model_copy(update={"effects": (*robot.effects, *more)})
    given = {"alpha": alpha, "beta": beta, "omega": omega, "offset": offset}
    wave = gait_given(gait_source, given, amplitudes)
    plan = plan_run(wave, robot.joints, duration_s=duration, cycles=None, ramp_s=ramp, lifted=False)
    motion = plan.from_straight()
    check_motion(motion, robot)
    with _progress() as shown:
        found = forecast(
            robot,
            motion,
            period_s=wave.period_s,
            ramp_s=ramp,
            draws=draws,
            seed=seed,
            progress=shown,
        )
    if as_json:
        click.echo(json.dumps({"robot": robot.name, "gait": str(wave), **found.to_mapping()}))
        return
    click.echo(f"{robot.name}: {wave}, {motion.duration_s:.4g} s")
    for line in _lines(found):
        click.echo(line)


def _lines(found: Forecast) -> Iterator[str]:
    if found.forward_speed_m_s is not None and found.power_w is not None:
        yield f"forward speed   {_shown(found.forward_speed_m_s, 'm/s')}"
        yield f"power           {_shown(found.power_w, 'W')}"
    else:
        yield "no body: nothing is said of speed and power"
    yield f"tracking error  {_shown(found.tracking_error_deg, 'deg rms')}"
    for number, joint in enumerate(found.by_joint, 1):
        yield f"  joint {number}       {_shown(joint, 'deg rms')}"
    if found.draws:
        yield f"bands: 95 % of {found.draws} draws of {', '.join(found.numbers)}"
    else:
        yield "no bands: the description takes every number for exact"


def _shown(value: Banded, unit: str) -> str:
    return f"{value.estimate:.4g} {unit} ({value.low:.4g} to {value.high:.4g})"


@contextlib.contextmanager
def _progress() -> Iterator[Callable[[float], None]]:
    """A bar, on a terminal only."""
    if not sys.stderr.isatty():
        yield lambda share: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("simulating", total=1.0)
        yield lambda share: bar.update(task, completed=share)
