"""``snakebot log replay``: send the set-points of a recorded run again."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from snakebot.cli.robot_option import robot_option
from snakebot.cli.run_options import RunOptions, check_finite, run_options
from snakebot.clock import RATE_HZ
from snakebot.errors import EXIT_INTERRUPTED, BadInputError

EPILOG = """\b
Examples:
  snakebot log replay run.mcap                                   on the simulated board
  snakebot log replay run.mcap --effect rate_limit:limit_rad_s=2.5
  snakebot log replay run.mcap --port serial:/dev/ttyUSB0 --robot my_robot.yaml
  snakebot log replay run.mcap --dry-run                         check the limits only
"""


@click.command("replay", short_help="Send recorded set-points again.", epilog=EPILOG)
@click.argument("log", type=click.Path(path_type=Path))
@robot_option("Robot description with its limits [the one in LOG].", default=None)
@click.option("--rate", type=float, help="Ticks a second, Hz [that of LOG].")
@click.option(
    "--ramp",
    type=float,
    default=2.0,
    show_default=True,
    help="To the first posture and to straight, each, s.",
)
@run_options
def command(
    log: Path, options: RunOptions, robot_source: str | None, rate: float | None, ramp: float
) -> None:
    """Send the set-points recorded in LOG again, to the simulation or to a robot, limits checked before it moves."""
    import json

    from snakebot.cli.execution import check, execute
    from snakebot.cli.log import existing
    from snakebot.cli.summary import report
    from snakebot.control import plan_replay
    from snakebot.robot import load_robot
    from snakebot.runlog import read_log

    existing(log)
    check_finite("rate", rate)
    check_finite("ramp", ramp)
    recorded = read_log(log)
    robot = recorded.robot if robot_source is None else load_robot(robot_source)
    if robot.joints != recorded.joints:
        raise BadInputError(
            f"{log}: {recorded.joints} joints recorded, robot {robot.name!r} has {robot.joints}"
        )
    settings = options.settings(robot, (recorded.number("rate_hz") or RATE_HZ) if rate is None else rate)
    plan = plan_replay(recorded, ramp_s=ramp)
    if options.dry_run:
        check(robot, plan, settings, options)
        duration_s = plan.from_straight().duration_s
        result = {"replays": str(log), "duration_s": duration_s, "joints": robot.joints}
        text = f"{plan.title}: {duration_s:.1f} s with ramps, within all limits of {robot.name}; nothing sent"
        click.echo(json.dumps(result) if options.as_json else text)
        return
    done = execute(robot, plan, settings, options)
    report(done, as_json=options.as_json)
    if done.ended == "interrupted":
        sys.exit(EXIT_INTERRUPTED)
