"""``snakebot run``: move the robot."""

from __future__ import annotations

import json
import math
import sys
from typing import TYPE_CHECKING, Any

import click

from snakebot.cli import names
from snakebot.cli.course_options import parse_start, steered
from snakebot.cli.robot_option import robot_option
from snakebot.cli.run_options import RunOptions, check_finite, run_options
from snakebot.clock import RATE_HZ
from snakebot.errors import EXIT_INTERRUPTED, BadInputError

if TYPE_CHECKING:
    from snakebot.control import RunPlan
    from snakebot.gait import Gait, Probe
    from snakebot.robot import Robot

_TICKS_SHOWN = 200_000  # of a dry run that is longer than twice that: so many at each end

EPILOG = """\b
Examples:
  snakebot run --alpha 66 --beta 80 --omega 2
  snakebot run --gait penn_state_optimum --cycles 4 --fast
  snakebot run --alpha 66 --beta 80 --omega 2 --port serial:/dev/ttyUSB0?baud=1000000
  snakebot run --alpha 40 --beta 80 --omega 3 --fault rigid:4@12s --fault clear@20s
  snakebot run --alpha 66 --beta 80 --omega 4 --effect rate_limit:limit_rad_s=2.5,joints=3
  snakebot run --alpha 66 --beta 80 --omega 2 --dry-run
  snakebot run --probe triangle:amplitude_deg=5,rate_deg_s=10,joints=3
  snakebot run --probe steps:amplitude_deg=20 --lifted
  snakebot run --probe sine:amplitude_deg=10,omega_rad_s=1+4+8 --duration 20
  snakebot run --alpha 37 --beta 80 --omega 2 --line y=0 --start 0,0,20 --fast
  snakebot run --alpha 37 --beta 80 --omega 2 --heading 30 --pose udp://127.0.0.1:9000 --port serial:/dev/ttyUSB0

\b
While it runs: Ctrl-C ramps down, holds and relaxes; a second Ctrl-C holds and relaxes at once; a closed terminal ramps
down; `snakebot stop` in another terminal cuts the power. In a terminal, keys change the gait without a jump: a/A
alpha down/up, b/B beta, w/W omega, o/O offset; q stops, the space bar is the emergency stop.
"""


@click.command(name="run", epilog=EPILOG)
@click.option("--alpha", type=float, help="Amplitude of the joint angles, deg.")
@click.option("--beta", type=float, help="Phase from joint to joint, deg.")
@click.option("--omega", type=float, help="Frequency of the wave, rad/s.")
@click.option(
    "--offset", type=float, default=None, help="Constant bend of all joints: steers the robot, deg."
)
@click.option(
    "--amplitudes",
    metavar="SHARES",
    help="Of each joint, from the tail on, as a share of alpha: 1,0.9,0.8,0.9,1 [1].",
)
@click.option(
    "--gait",
    "gait_source",
    shell_complete=names.gaits,
    help="A gait by name or YAML file; the options above override it.",
)
@click.option(
    "--probe",
    "probe_text",
    metavar="KIND:...",
    help="A test motion in place of a gait: triangle, steps or sine, of all joints or of some.",
)
@click.option("--lifted", is_flag=True, help="The robot is off the ground: no load; stored with the log.")
@click.option("--duration", type=float, help="Length of the run with its ramps, s.")
@click.option(
    "--cycles",
    type=float,
    help="Full cycles between the ramps [8 if no --duration; a probe fewer].",
)
@click.option("--rate", type=float, default=RATE_HZ, show_default=True, help="Ticks a second, Hz.")
@click.option("--ramp", type=float, default=2.0, show_default=True, help="Smooth start and end, each, s.")
@click.option("--heading", type=float, help="Steer for this heading of the body, deg from the x axis.")
@click.option(
    "--line",
    "line_text",
    metavar="LINE",
    help="Steer along a line: y=0, x=1.5, y=0@180 (the other way) or X,Y@DEG (a point, a direction).",
)
@click.option(
    "--pose",
    "pose_text",
    metavar="udp://127.0.0.1:PORT",
    help="Where a tracker sends the robot's pose, a JSON line each: t (s), x, y (m), heading (rad).",
)
@click.option(
    "--start",
    "start_text",
    metavar="X,Y,DEG",
    help="Simulated board only: where the robot lies at first, m and deg.",
)
@robot_option()
@run_options
def command(
    options: RunOptions,
    alpha: float | None,
    beta: float | None,
    omega: float | None,
    offset: float | None,
    amplitudes: str | None,
    gait_source: str | None,
    probe_text: str | None,
    lifted: bool,
    duration: float | None,
    cycles: float | None,
    rate: float,
    ramp: float,
    heading: float | None,
    line_text: str | None,
    pose_text: str | None,
    start_text: str | None,
    robot_source: str,
) -> None:
    """Stream a gait to a board, read the encoders back, log everything, stop safely.

    The gait is phi_i = offset + alpha sin(omega t + (i - 1) beta). Without --port the board is simulated.
    With --heading or --line it is steered by that offset, once a cycle, as poses tell.
    A probe measures in place of travelling: triangle:amplitude_deg,rate_deg_s (dead band, play, friction),
    steps:amplitude_deg (delay, rate limit) or sine:amplitude_deg,omega_rad_s=1+4 (delay against lag).
    """
    from snakebot.cli.execution import check, execute
    from snakebot.cli.summary import report
    from snakebot.control import plan_run
    from snakebot.robot import load_robot

    robot = load_robot(robot_source)
    settings = steered(options.settings(robot, rate), heading, line_text, pose_text)
    start_pose = parse_start(start_text)
    check_finite("ramp", ramp)
    wave = {"alpha": alpha, "beta": beta, "omega": omega, "offset": offset}
    if probe_text is None:
        what: Gait | Probe = gait_given(gait_source, wave, amplitudes)
    elif amplitudes is not None:
        raise BadInputError("give --probe or --amplitudes, not both")
    else:
        what = _probe(probe_text, gait_source, wave)
    plan = plan_run(what, robot.joints, duration_s=duration, cycles=cycles, ramp_s=ramp, lifted=lifted)
    if options.dry_run:
        check(robot, plan, settings, options, start_pose=start_pose)
        _dry_run(plan, robot, rate, as_json=options.as_json)
        return
    recorded = execute(robot, plan, settings, options, start_pose=start_pose)
    report(recorded, as_json=options.as_json)
    if recorded.ended == "interrupted":
        sys.exit(EXIT_INTERRUPTED)


def _probe(text: str, gait_source: str | None, wave: dict[str, float | None]) -> Probe:
    from snakebot.gait import parse_probe

    for name, value in {"gait": gait_source, **wave}.items():
        if value is not None:
            raise BadInputError(f"give --probe or --{name}, not both")
    return parse_probe(text)


def gait_given(source: str | None, wave: dict[str, float | None], amplitudes: str | None = None) -> Gait:
    from snakebot.gait import Gait, load_gait
    from snakebot.gait.wave import parse_shares

    given = dict(wave)
    shares = parse_shares(amplitudes) if amplitudes is not None else ()
    if source is not None:
        base = load_gait(source)
        shares = shares if amplitudes is not None else base.shares
        defaults = {
            "alpha": math.degrees(base.alpha_rad),
            "beta": math.degrees(base.beta_rad),
            "omega": base.omega_rad_s,
            "offset": math.degrees(base.offset_rad),
        }
        given = {key: defaults[key] if value is None else value for key, value in given.items()}
    alpha, beta, omega = (given[key] for key in ("alpha", "beta", "omega"))
    if alpha is None or beta is None or omega is None:
        missing = [f"--{key}" for key in ("alpha", "beta", "omega") if given[key] is None]
        raise BadInputError(
            f"{' and '.join(missing)} missing: give --alpha, --beta and --omega, or --gait "
            "(for example --alpha 66 --beta 80 --omega 2)"
        )
    return Gait.from_degrees(alpha, beta, omega, given["offset"] or 0.0, shares=shares)


def _dry_run(plan: RunPlan, robot: Robot, rate_hz: float, *, as_json: bool) -> None:
    """What would be sent, without opening anything."""
    import numpy as np

    from firmware_protocol.assembly import setpoint_messages
    from firmware_protocol.catalogue import encode
    from firmware_protocol.framing import pack_all

    motion = plan.from_straight()
    gait = str(plan.gait) if plan.gait is not None else None
    probe = plan.about.get("probe")
    interval = 1.0 / rate_hz
    ticks = math.floor(motion.duration_s / interval + 0.5) + 1
    parts = [(0, ticks)] if ticks <= 2 * _TICKS_SHOWN else [(0, _TICKS_SHOWN), (ticks - _TICKS_SHOWN, ticks)]
    # A tick more at each end, where the motion stands still: differences there are part of what is asked for.
    pieces = [
        motion.sampled(interval * np.arange(first - 1, end + 1, dtype=np.float64)) for first, end in parts
    ]
    speeds = [np.diff(piece, axis=0) / interval for piece in pieces]
    angles, speed = np.concatenate(pieces), np.concatenate(speeds)
    acceleration = np.concatenate([np.diff(piece, axis=0) / interval for piece in speeds])
    frames = [encode(message) for message in setpoint_messages(0, list(angles[0]), interval)]
    summary: dict[str, Any] = {
        "gait": gait,
        "probe": probe,
        "duration_s": round(motion.duration_s, 6),
        "ticks": ticks,
        "frames_per_tick": len(frames),
        "serial_bytes_per_s": round(len(pack_all(frames)) * rate_hz),
        "joints": [
            {
                "joint": joint + 1,
                "angle_deg": round(float(np.degrees(np.abs(angles[:, joint]).max())), 3),
                "angle_limit_deg": round(math.degrees(robot.angle_limit_rad[joint]), 3),
                "speed_rad_s": round(float(np.abs(speed[:, joint]).max()), 4),
                "speed_limit_rad_s": robot.speed_limit_rad_s[joint],
                "acceleration_rad_s2": round(float(np.abs(acceleration[:, joint]).max()), 4),
                "acceleration_limit_rad_s2": robot.acceleration_limit_rad_s2[joint],
            }
            for joint in range(robot.joints)
        ],
    }
    if as_json:
        click.echo(json.dumps(summary))
        return
    from rich.table import Table

    from snakebot.cli.console import StandardOutput

    table = Table(title=f"{gait or probe}: nothing sent", caption="largest value, and what the robot allows")
    for name in ("joint", "angle deg", "allowed", "speed rad/s", "allowed", "acceleration rad/s2", "allowed"):
        table.add_column(name, justify="right")
    for row in summary["joints"]:
        table.add_row(*(f"{value:g}" for value in row.values()))
    console = StandardOutput()
    console.print(table)
    console.print(
        f"{summary['ticks']} ticks in {motion.duration_s:.1f} s, {len(frames)} frames a tick, "
        f"{summary['serial_bytes_per_s']} bytes/s on a serial line; within all limits of {robot.name}"
    )
