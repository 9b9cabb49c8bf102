"""``snakebot run``: move the robot."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from snakebot.cli.ports import SIM
from snakebot.cli.run_options import run_options
from snakebot.errors import EXIT_INTERRUPTED, BadInputError

if TYPE_CHECKING:
    from snakebot.gait import Gait, GaitMotion, Probe, ProbeMotion
    from snakebot.robot import Robot

DEFAULT_CYCLES = 8
_TICKS_SHOWN = 200_000  # of a dry run that is longer than twice that: so many at each end
MOST_CYCLES = 10_000  # of a probe
PROBE_CYCLES = {"triangle": 4, "steps": 1, "sine": 4}

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

\b
While it runs: Ctrl-C ramps down, holds and relaxes; a second Ctrl-C holds and relaxes at once;
`snakebot stop` in another terminal cuts the power. In a terminal, keys change the gait without a jump: a/A alpha
down/up, b/B beta, w/W omega, o/O offset; q stops, the space bar is the emergency stop.
"""


@click.command(name="run", epilog=EPILOG)
@click.option("--alpha", type=float, help="Amplitude of the joint angles, deg.")
@click.option("--beta", type=float, help="Phase from joint to joint, deg.")
@click.option("--omega", type=float, help="Frequency of the wave, rad/s.")
@click.option(
    "--offset", type=float, default=None, help="Constant bend of all joints: steers the robot, deg."
)
@click.option("--gait", "gait_source", help="A gait by name or YAML file; the options above override it.")
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
    help=f"Full cycles between the ramps [{DEFAULT_CYCLES} if no --duration; a probe fewer].",
)
@click.option("--rate", type=float, default=100.0, show_default=True, help="Ticks a second, Hz.")
@click.option("--ramp", type=float, default=2.0, show_default=True, help="Smooth start and end, each, s.")
@click.option("--robot", "robot_source", default="penn_state", show_default=True, help="Robot description.")
@click.option("--port", default=SIM, show_default=True, help="Where the board is; see `snakebot board list`.")
@click.option(
    "--log", "log_path", type=click.Path(path_type=Path), help="The run's log [runs/<time>_<gait>.mcap]."
)
@run_options
def command(**options: Any) -> None:
    """Stream a gait to a board, read the encoders back, log everything, stop safely.

    The gait is phi_i = offset + alpha sin(omega t + (i - 1) beta). Without --port the board is simulated.
    A probe measures in place of travelling: triangle:amplitude_deg,rate_deg_s (dead band, play, friction),
    steps:amplitude_deg (delay, rate limit) or sine:amplitude_deg,omega_rad_s=1+4 (delay against lag).
    """
    from snakebot.cli.execution import execute
    from snakebot.control import parse_fault
    from snakebot.gait import check_motion
    from snakebot.robot import load_robot

    robot = load_robot(options["robot_source"])
    probe = _probe(options)
    gait = _gait(options) if probe is None else None
    duration_s = _duration(options, gait, probe)
    faults = [parse_fault(text, robot.joints) for text in options["faults"]]
    for name in ("speed", "rate", "ramp"):
        value = options[name]
        if value is not None and not math.isfinite(value):
            raise BadInputError(f"--{name} {value}: must be a finite number")

    def make_motion(start_rad: Sequence[float]) -> GaitMotion | ProbeMotion:
        from snakebot.gait import GaitMotion, ProbeMotion

        if probe is not None:
            return ProbeMotion(probe, robot.joints, duration_s, options["ramp"], start_rad)
        assert gait is not None
        return GaitMotion(gait, robot.joints, duration_s, options["ramp"], start_rad)

    motion = make_motion([0.0] * robot.joints)
    check_motion(motion, robot)
    if options["dry_run"]:
        _dry_run(motion, robot, options)
        return
    about: dict[str, Any] = {"lifted": True} if options["lifted"] else {}
    title = f"{probe or gait}{', lifted off the ground' if options['lifted'] else ''}"
    if probe is None:
        result = execute(robot, gait, make_motion, faults, options, title=title, about=about)
    else:
        from snakebot.runlog import new_log_path

        options["log_path"] = options["log_path"] or new_log_path(f"probe_{probe}")
        about["probe"] = str(probe)
        result = execute(
            robot, None, make_motion, faults, options, title=title, amplitude_rad=probe.amplitude_rad, about=about
        )  # fmt: skip
    if result == "interrupted":
        sys.exit(EXIT_INTERRUPTED)


def _probe(options: dict[str, Any]) -> Probe | None:
    from snakebot.gait import parse_probe

    if options["probe_text"] is None:
        return None
    gait = {"gait_source": "gait"} | {key: key for key in ("alpha", "beta", "omega", "offset")}
    for key, name in gait.items():
        if options[key] is not None:
            raise BadInputError(f"give --probe or --{name}, not both")
    return parse_probe(options["probe_text"])


def _gait(options: dict[str, Any]) -> Gait:
    from snakebot.gait import Gait, load_gait

    given = {key: options[key] for key in ("alpha", "beta", "omega", "offset")}
    if options["gait_source"] is not None:
        base = load_gait(options["gait_source"])
        defaults = {
            "alpha": math.degrees(base.alpha_rad),
            "beta": math.degrees(base.beta_rad),
            "omega": base.omega_rad_s,
            "offset": math.degrees(base.offset_rad),
        }
        given = {key: defaults[key] if value is None else value for key, value in given.items()}
    missing = [f"--{key}" for key in ("alpha", "beta", "omega") if given[key] is None]
    if missing:
        raise BadInputError(
            f"{' and '.join(missing)} missing: give --alpha, --beta and --omega, or --gait "
            "(for example --alpha 66 --beta 80 --omega 2)"
        )
    return Gait.from_degrees(given["alpha"], given["beta"], given["omega"], given["offset"] or 0.0)


def _duration(options: dict[str, Any], gait: Gait | None, probe: Probe | None) -> float:
    duration, cycles, ramp = options["duration"], options["cycles"], options["ramp"]
    if duration is not None and cycles is not None:
        raise BadInputError("give --duration or --cycles, not both")
    if duration is not None:
        if not (math.isfinite(duration) and duration > 0):
            raise BadInputError(f"--duration {duration:g}: must be a positive number of seconds")
        return float(duration)
    if cycles is None:
        cycles = DEFAULT_CYCLES if probe is None else PROBE_CYCLES[probe.kind]
    if not (math.isfinite(cycles) and cycles > 0):
        raise BadInputError(f"--cycles {cycles:g}: must be a positive number")
    if probe is not None:
        from snakebot.gait import probe_span_s

        if cycles < 1 or cycles > MOST_CYCLES or (probe.kind != "sine" and cycles != int(cycles)):
            raise BadInputError(f"--cycles {cycles:g}: a probe makes whole cycles, 1 to {MOST_CYCLES}")
        return probe_span_s(probe, cycles) + 2 * float(ramp)
    assert gait is not None
    if not math.isfinite(gait.period_s):
        raise BadInputError("--omega 0 has no cycles: give --duration")
    return float(cycles * gait.period_s + 2 * ramp)


def _dry_run(motion: GaitMotion | ProbeMotion, robot: Robot, options: dict[str, Any]) -> None:
    """What would be sent, without opening anything."""
    import numpy as np

    from firmware_protocol.assembly import setpoint_messages
    from firmware_protocol.catalogue import encode
    from firmware_protocol.framing import pack_all
    from snakebot.gait import GaitMotion

    gait = str(motion.gait) if isinstance(motion, GaitMotion) else None
    probe = None if isinstance(motion, GaitMotion) else str(motion.probe)
    interval = 1.0 / options["rate"]
    ticks = math.floor(motion.duration_s / interval + 0.5) + 1
    parts = [(0, ticks)] if ticks <= 2 * _TICKS_SHOWN else [(0, _TICKS_SHOWN), (ticks - _TICKS_SHOWN, ticks)]
    pieces = [motion.sampled(interval * np.arange(*part)) for part in parts]
    speeds = [np.gradient(piece, interval, axis=0) for piece in pieces]
    angles, speed = np.concatenate(pieces), np.concatenate(speeds)
    acceleration = np.concatenate([np.gradient(piece, interval, axis=0) for piece in speeds])
    frames = [encode(message) for message in setpoint_messages(0, list(angles[0]), interval)]
    summary = {
        "gait": gait,
        "probe": probe,
        "duration_s": round(motion.duration_s, 6),
        "ticks": ticks,
        "frames_per_tick": len(frames),
        "serial_bytes_per_s": round(len(pack_all(frames)) * options["rate"]),
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
    if options["as_json"]:
        click.echo(json.dumps(summary))
        return
    from rich.console import Console
    from rich.table import Table

    table = Table(title=f"{gait or probe}: nothing sent", caption="largest value, and what the robot allows")
    for name in ("joint", "angle deg", "allowed", "speed rad/s", "allowed", "acceleration rad/s2", "allowed"):
        table.add_column(name, justify="right")
    for row in summary["joints"]:
        table.add_row(*(f"{value:g}" for value in row.values()))
    console = Console()
    console.print(table)
    console.print(
        f"{summary['ticks']} ticks in {motion.duration_s:.1f} s, {len(frames)} frames a tick, "
        f"{summary['serial_bytes_per_s']} bytes/s on a serial line; within all limits of {robot.name}"
    )
