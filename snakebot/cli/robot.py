"""``snakebot robot``: descriptions of robots: which there are, what is in one, and one for your own servos."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from snakebot.cli import names
from snakebot.cli.robot_option import robot_option
from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.robot import Robot
    from snakebot.servobus.joints import Joint
    from snakebot.servobus.master import BusMaster

MOST_TURNS_ASKED = 5  # tries to turn one joint; a servo that is in no joint, or in another one, never turns


@click.group(
    name="robot",
    epilog="""\b
Examples:
  snakebot robot list
  snakebot robot show sts3215_snake
  snakebot robot calibrate feetech:/dev/ttyUSB0 --robot sts3215_snake --out my_snake.yaml
  snakebot robot export calibrated.yaml --mujoco snake.xml --ranges ranges.yaml
""",
)
def command() -> None:
    """Robot descriptions: list, show, export; store the zeros of your own servos in one."""


@command.command(
    name="list",
    epilog="""\b
Examples:
  snakebot robot list
  snakebot robot list --json
""",
)
@click.option("--json", "as_json", is_flag=True, help="Print a JSON array.")
def list_(as_json: bool) -> None:
    """The descriptions that come with snakebot."""
    from snakebot.resources import configs_root
    from snakebot.robot import load_robot

    found = [load_robot(path) for path in sorted((configs_root() / "robots").glob("*.yaml"))]
    if as_json:
        click.echo(json.dumps([_brief(robot) for robot in found]))
        return
    width = max(len(robot.name) for robot in found)
    for robot in found:
        about = _brief(robot)
        servos = f", servos: {', '.join(about['servos'])}" if about["servos"] else ""
        click.echo(f"{robot.name:{width}}  {about['joints']} joints, {about['body']}{servos}")


def _brief(robot: Robot) -> dict[str, Any]:
    models = sorted({servo.model or "any model" for servo in robot.servos or ()})
    body = "a bench without a body" if robot.body is None else f"{robot.body.links} links"
    return {"name": robot.name, "joints": robot.joints, "body": body, "servos": models}


@command.command(
    name="show",
    epilog="""\b
Examples:
  snakebot robot show penn_state
  snakebot robot show my_snake.yaml --json
""",
)
@click.argument("robot_source", metavar="ROBOT", shell_complete=names.robots)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def show(robot_source: str, as_json: bool) -> None:
    """A description as it is understood, and what its servos do by themselves."""
    from snakebot.effects import robot_effects
    from snakebot.robot import load_robot
    from snakebot.servobus.models import model_named

    robot = load_robot(robot_source)
    robot_effects(robot)  # one that does not fit is told
    models = {s.model: model_named(s.model) for s in robot.servos or () if s.model is not None}
    if as_json:
        by_itself = {name: list(model.by_itself) for name, model in models.items()}
        click.echo(json.dumps({**robot.to_mapping(), "by_itself": by_itself}))
        return
    click.echo(robot.to_yaml().rstrip())
    for name, model in models.items():
        click.echo(f"\n# what a {name} does by itself")
        for line in model.by_itself:
            click.echo(f"#   {line}")


@command.command(
    name="export",
    epilog="""\b
Examples:
  snakebot robot export calibrated.yaml --mujoco snake.xml
  snakebot robot export penn_state --mujoco snake.xml --ranges ranges.yaml
  snakebot robot export calibrated.yaml --ranges ranges.yaml --json
""",
)
@click.argument("robot_source", metavar="ROBOT")
@click.option(
    "--mujoco",
    "xml_path",
    type=click.Path(path_type=Path),
    help="Write the model as MJCF, and its callbacks beside it (.py).",
)
@click.option(
    "--ranges",
    "ranges_path",
    type=click.Path(path_type=Path),
    help="Write what is not known of its numbers, to randomise (YAML).",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def export(robot_source: str, xml_path: Path | None, ranges_path: Path | None, as_json: bool) -> None:
    """The robot with its effects for another simulator, and ranges for domain randomisation."""
    from snakebot.calibrated.mujoco_model import callbacks_name, mujoco_model
    from snakebot.calibrated.ranges import ranges_yaml
    from snakebot.robot import load_robot
    from snakebot.whole_files import check_apart, check_output, write_all

    if xml_path is None and ranges_path is None:
        raise BadInputError("give --mujoco OUT.xml, --ranges OUT.yaml, or both")
    outputs: list[tuple[str, Path, str]] = []
    if xml_path is not None:
        if xml_path.suffix != ".xml":
            raise BadInputError(f"--mujoco {xml_path}: give a name that ends in .xml")
        outputs += [("--mujoco", xml_path, "MJCF"), ("--mujoco", callbacks_name(xml_path), "callbacks")]
    if ranges_path is not None:
        outputs.append(("--ranges", ranges_path, "ranges"))
    for option, path, kind in outputs:
        check_output(option, path, kind)
    check_apart([(option, path) for option, path, _ in outputs])
    robot = load_robot(robot_source)
    texts = [] if ranges_path is None else [ranges_yaml(robot)]
    left_out: tuple[str, ...] = ()
    if xml_path is not None:
        made = mujoco_model(robot, xml_path)
        texts, left_out = [made.xml, made.callbacks, *texts], made.not_expressed
    paths = [path for _, path, _ in outputs]
    write_all(list(zip(paths, texts, strict=True)))
    if as_json:
        click.echo(json.dumps({"written": [str(path) for path in paths], "not_expressed": list(left_out)}))
        return
    for path in paths:
        click.echo(f"wrote {path}")
    if xml_path is not None:
        click.echo("not expressed, or otherwise than snakebot does it:")
        for sentence in left_out:
            click.echo(f"  {sentence}")


@command.command(
    name="calibrate",
    epilog="""\b
Examples:
  snakebot robot calibrate feetech:/dev/ttyUSB0?ids=1-5
  snakebot robot calibrate dynamixel:/dev/ttyUSB0?baud=57600 --robot my_snake.yaml --out my_snake.yaml --zeros-only

\b
All servos lose their torque. Hold the snake straight and press enter; then turn each joint to larger angles (the part
with the higher numbers counter-clockwise, seen from above) and press enter. Nothing is written into a servo.
""",
)
@click.argument("port", shell_complete=names.ports)
@robot_option("Description to copy.")
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Where the copy goes [ROBOT_calibrated.yaml].",
)
@click.option("--zeros-only", is_flag=True, help="Keep the directions of the description.")
def calibrate(port: str, robot_source: str, out: Path | None, zeros_only: bool) -> None:
    """Store where your servos stand when the snake is straight, in a copy of a robot's description."""
    from snakebot.clock import MonotonicClock
    from snakebot.links import parse_port
    from snakebot.links.port import ServoPort
    from snakebot.robot import load_robot
    from snakebot.servobus.calibration import calibrated, check_limp, positions
    from snakebot.servobus.joints import roll_call, wanted_servos
    from snakebot.servobus.opening import open_master, torque_off
    from snakebot.whole_files import check_output, write_all

    parsed = parse_port(port)
    if not isinstance(parsed, ServoPort):
        raise BadInputError(
            f"{port}: zeros are those of bus servos: feetech:/dev/ttyUSB0?ids=1-5 or dynamixel:..."
        )
    robot = load_robot(robot_source)
    path = out or Path(f"{robot.name}_calibrated.yaml")
    check_output("--out", path, "robot")
    master = open_master(parsed, MonotonicClock())
    try:
        joints = roll_call(master, wanted_servos(robot, parsed.ids))
        torque_off(master)
        check_limp(master, joints)
        click.echo(", ".join(f"joint {j.number}: servo {j.id} ({j.model.name})" for j in joints))
        _enter("No servo has torque now. Hold the snake straight")
        zeros = positions(master, joints)
        directions = [joint.direction for joint in joints]
        if not zeros_only:
            directions = [_direction(master, joint, zero) for joint, zero in zip(joints, zeros, strict=True)]
    finally:
        master.close()
    write_all([(path, calibrated(robot, joints, zeros, directions).to_yaml())])
    for joint, zero, sign in zip(joints, zeros, directions, strict=True):
        click.echo(f"joint {joint.number}: zero {zero} counts, direction {sign:+d}")
    click.echo(f"wrote {path}: use it with --robot {path}")


def _enter(what: str) -> None:
    click.prompt(f"{what}, then press enter", default="", show_default=False, prompt_suffix=" ")


def _direction(master: BusMaster, joint: Joint, zero: int) -> int:
    """
    Raises:
        BadInputError: the joint has not turned, however often it was asked for.
    """
    from snakebot.servobus.calibration import MOVED_RAD, direction, positions

    for _ in range(MOST_TURNS_ASKED):
        _enter(
            f"Turn joint {joint.number} by {math.degrees(MOVED_RAD):.0f} deg or more to larger angles, hold it"
        )
        sign = direction(joint, zero, positions(master, [joint])[0])
        if sign is not None:
            return sign
        click.echo(f"joint {joint.number} has hardly turned")
    raise BadInputError(
        f"joint {joint.number} (servo {joint.id}) did not turn in {MOST_TURNS_ASKED} tries: is that servo in this "
        "joint? Nothing was written; --zeros-only keeps the directions of the description"
    )
