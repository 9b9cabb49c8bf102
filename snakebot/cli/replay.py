"""``snakebot log replay``: send the set-points of a recorded run again."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from snakebot.cli.ports import SIM
from snakebot.cli.run_options import run_options
from snakebot.errors import EXIT_INTERRUPTED, BadInputError

if TYPE_CHECKING:
    from snakebot.gait import SampledMotion

EPILOG = """\b
Examples:
  snakebot log replay run.mcap                                   on the simulated board
  snakebot log replay run.mcap --effect rate_limit:limit_rad_s=2.5
  snakebot log replay run.mcap --port serial:/dev/ttyUSB0 --robot my_robot.yaml
  snakebot log replay run.mcap --dry-run                         check the limits only
"""


@click.command("replay", short_help="Send recorded set-points again.", epilog=EPILOG)
@click.argument("log", type=click.Path(path_type=Path))
@click.option("--port", default=SIM, show_default=True, help="Where the board is; see `snakebot board list`.")
@click.option("--robot", "robot_source", help="Robot description with its limits [the one in LOG].")
@click.option("--rate", type=float, help="Ticks a second, Hz [that of LOG].")
@click.option(
    "--ramp",
    type=float,
    default=2.0,
    show_default=True,
    help="To the first posture and to straight, each, s.",
)
@click.option(
    "--log", "log_path", type=click.Path(path_type=Path), help="The new run's log [runs/<time>_replay.mcap]."
)
@run_options
def command(log: Path, **options: Any) -> None:
    """Send the set-points recorded in LOG again, to the simulation or to a robot, limits checked before it moves."""
    import json
    import math

    import numpy as np

    from snakebot.cli.execution import execute
    from snakebot.control import parse_fault
    from snakebot.control.loop import check_rate
    from snakebot.gait import SampledMotion, check_motion
    from snakebot.robot import load_robot
    from snakebot.runlog import new_log_path, read_log
    from snakebot.runlog.naming import gait_label
    from snakebot.runlog.replaying import recorded_setpoints

    if not log.is_file():
        raise BadInputError(f"{log}: no such log")
    for name in ("ramp", "rate", "speed"):
        if options[name] is not None and not math.isfinite(options[name]):
            raise BadInputError(f"--{name} {options[name]}: not a finite number")
    if options["ramp"] <= 0:
        raise BadInputError(f"--ramp {options['ramp']:g}: must be a positive number of seconds")
    recorded = read_log(log)
    rate_hz = (recorded.number("rate_hz") or 100.0) if options["rate"] is None else options["rate"]
    check_rate(rate_hz)
    robot = recorded.robot if options["robot_source"] is None else load_robot(options["robot_source"])
    if robot.joints != recorded.joints:
        raise BadInputError(
            f"{log}: {recorded.joints} joints recorded, robot {robot.name!r} has {robot.joints}"
        )
    t_s, angles_rad = recorded_setpoints(recorded)

    def make_motion(start_rad: Sequence[float]) -> SampledMotion:
        return SampledMotion(t_s, angles_rad, options["ramp"], start_rad)

    motion = make_motion([0.0] * robot.joints)
    check_motion(motion, robot)
    faults = [parse_fault(text, robot.joints) for text in options["faults"]]
    title = f"the recorded set-points of {recorded.name}"
    if options["dry_run"]:
        result = {"replays": str(log), "duration_s": motion.duration_s, "joints": robot.joints}
        text = (
            f"{title}: {motion.duration_s:.1f} s with ramps, within all limits of {robot.name}; nothing sent"
        )
        click.echo(json.dumps(result) if options["as_json"] else text)
        return
    label = f"{gait_label(recorded.gait)}_replay" if recorded.gait is not None else "replay"
    settle_s = options["ramp"] + (recorded.number("ramp_s") or 0.0)  # the recorded ramp comes after ours
    ended = execute(
        robot,
        recorded.gait,
        make_motion,
        faults,
        {
            **options,
            "ramp": settle_s,
            "rate": rate_hz,
            "log_path": options["log_path"] or new_log_path(label),
        },
        title=title,
        amplitude_rad=float(np.ptp(angles_rad, axis=0).max() / 2),
        about={"replay_of": recorded.name},
    )
    if ended == "interrupted":
        sys.exit(EXIT_INTERRUPTED)
