"""``snakebot gait``: the gaits that come with snakebot, and what one asks of a robot."""

from __future__ import annotations

import json
from math import degrees, pi
from typing import TYPE_CHECKING, Any

import click

from snakebot.cli.names import gaits
from snakebot.cli.robot_option import robot_option

if TYPE_CHECKING:
    from snakebot.gait import Gait

_RAMP_S = 2.0  # as of `snakebot run`


@click.group(
    name="gait",
    epilog="""\b
Examples:
  snakebot gait list
  snakebot gait show penn_state_optimum
""",
)
def command() -> None:
    """Gaits by name: list them, show one."""


@command.command(
    name="list",
    epilog="""\b
Examples:
  snakebot gait list
  snakebot gait list --json
""",
)
@click.option("--json", "as_json", is_flag=True, help="Print a JSON array.")
def list_(as_json: bool) -> None:
    """The gaits that come with snakebot."""
    from snakebot.gait import load_gait
    from snakebot.resources import configs_root

    found = {path.stem: load_gait(path) for path in sorted((configs_root() / "gaits").glob("*.yaml"))}
    if as_json:
        click.echo(json.dumps([{"name": name, **_told(gait)} for name, gait in found.items()]))
        return
    width = max(len(name) for name in found)
    for name, gait in found.items():
        click.echo(f"{name:{width}}  {_line(gait)}")


@command.command(
    name="show",
    epilog="""\b
Examples:
  snakebot gait show penn_state_optimum
  snakebot gait show my_gait.yaml --robot saito --json
""",
)
@click.argument("gait_source", metavar="GAIT", shell_complete=gaits)
@robot_option("That is to do it.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def show(gait_source: str, robot_source: str, as_json: bool) -> None:
    """A gait, the largest angle and speed of a joint in it, and whether a robot may do it."""
    from snakebot.errors import BadInputError
    from snakebot.gait import GaitMotion, load_gait
    from snakebot.gait.limits import check_motion
    from snakebot.robot import load_robot

    gait, robot = load_gait(gait_source), load_robot(robot_source)
    angle_deg = degrees(abs(gait.alpha_rad) + abs(gait.offset_rad))
    speed_rad_s = abs(gait.alpha_rad) * gait.omega_rad_s
    refused = ""
    try:
        check_motion(
            GaitMotion(gait, robot.joints, 2 * _RAMP_S + 2 * pi / max(gait.omega_rad_s, 0.1), _RAMP_S), robot
        )
    except BadInputError as error:
        refused = str(error)
    if as_json:
        most = {"most_angle_deg": round(angle_deg, 6), "most_speed_rad_s": round(speed_rad_s, 6)}
        click.echo(json.dumps({**_told(gait), **most, "robot": robot.name, "refused": refused or None}))
        return
    click.echo(_line(gait))
    click.echo(f"joints turn up to {angle_deg:.3g} deg, at up to {speed_rad_s:.3g} rad/s")
    click.echo(f"{robot.name} refuses it: {refused}" if refused else f"within the limits of {robot.name}")


def _told(gait: Gait) -> dict[str, Any]:
    return {
        "alpha_deg": round(degrees(gait.alpha_rad), 6),
        "beta_deg": round(degrees(gait.beta_rad), 6),
        "omega_rad_s": gait.omega_rad_s,
        "offset_deg": round(degrees(gait.offset_rad), 6),
        **({"amplitudes": list(gait.shares)} if gait.shares else {}),
    }


def _line(gait: Gait) -> str:
    told = _told(gait)
    offset = f", offset {told['offset_deg']:g} deg" if told["offset_deg"] else ""
    wave = (
        f"alpha {told['alpha_deg']:g} deg, beta {told['beta_deg']:g} deg, omega {told['omega_rad_s']:g} rad/s"
    )
    return wave + offset + (f", amplitudes {gait.shares_text}" if gait.shares else "")
