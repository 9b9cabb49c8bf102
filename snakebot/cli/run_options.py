"""Options of every command that moves a robot: what disturbs it, what is written down, what is asked for first."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from snakebot.cli import names
from snakebot.cli.ports import SIM
from snakebot.cli.typed_options import collected, given
from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.control import RunSettings
    from snakebot.robot import Robot

FASTEST_M_S = 100.0  # a --speed beyond it is a slip; chosen, no snake comes near it


@dataclass(frozen=True)
class RunOptions:
    """What the options of ``run_options`` say, as they are typed; ``faults`` and ``effects`` in their grammars."""

    port: str = SIM
    log_path: Path | None = None
    frames: bool = False
    faults: tuple[str, ...] = ()
    effects: tuple[str, ...] = ()
    speed: float | None = None
    note: str | None = None
    seed: int = 0
    fast: bool = False
    dry_run: bool = False
    keep_stop: bool = False
    no_servo_watchdog: bool = False
    yes: bool = False
    view: bool = False
    view_address: str | None = None
    view_port: int | None = None
    view_stop: bool = False
    verbose: bool = False
    as_json: bool = False

    def settings(self, robot: Robot, rate_hz: float) -> RunSettings:
        """What the run needs of it.

        Raises:
            BadInputError: a number that is not finite, or a fault that is not in the grammar.
        """
        from snakebot.control import RunSettings, parse_fault

        check_finite("speed", self.speed)
        check_speed(self.speed)
        check_finite("rate", rate_hz)
        return RunSettings(
            rate_hz=rate_hz,
            faults=[parse_fault(text, robot.joints) for text in self.faults],
            log_path=self.log_path,
            log_frames=self.frames,
            keep_stop=self.keep_stop,
            forward_speed_m_s=self.speed,
            notes=self.note,
        )


def check_speed(speed_m_s: float | None) -> None:
    """A measured speed that somebody may have mistyped, or given in mm/s."""
    if speed_m_s is not None and math.isfinite(speed_m_s) and abs(speed_m_s) > FASTEST_M_S:
        raise BadInputError(f"--speed {speed_m_s:g}: not a speed in m/s; at most {FASTEST_M_S:g}, either way")


def check_finite(name: str, value: float | None) -> None:
    """Raises: BadInputError: the option is no finite number."""
    if value is not None and not math.isfinite(value):
        raise BadInputError(f"--{name} {value}: must be a finite number")


_VIEW_OPTIONS = (
    click.option("--view", is_flag=True, help="Show the run in a browser, with a stop; prints the address."),
    click.option(
        "--view-address",
        metavar="ADDRESS",
        help="Serve the page there, not on this computer alone; its address then holds a token.",
    ),
    click.option("--view-port", type=click.IntRange(0, 65535), help="Port of the page [8040; 0 a free one]."),
    click.option("--view-stop", is_flag=True, help="Ramp down when the last page is closed."),
)
_OPTIONS = (
    click.option(
        "--port",
        shell_complete=names.ports,
        default=SIM,
        show_default=True,
        help="Where the board is; see `snakebot board list`.",
    ),
    click.option(
        "--log",
        "log_path",
        type=click.Path(path_type=Path),
        help="The run's log [runs/<time>_<motion>.mcap].",
    ),
    click.option("--frames", is_flag=True, help="Also log every frame of the wire."),
    click.option(
        "--fault",
        "faults",
        multiple=True,
        help="Joint fault, e.g. free:3, rigid:4+5, rigid:4@12s, clear@20s.",
    ),
    click.option(
        "--effect",
        "effects",
        shell_complete=names.effects,
        multiple=True,
        help="Unmodelled effect on the simulated board: NAME:param=value.",
    ),
    click.option(
        "--speed", type=float, help="Forward speed that you measured, m/s; stored with the new log."
    ),
    click.option("--note", help="Anything worth remembering; stored with the new log."),
    click.option(
        "--seed",
        type=click.IntRange(min=0),
        default=0,
        show_default=True,
        help="Of the simulated board's randomness.",
    ),
    click.option("--fast", is_flag=True, help="Simulated board only: virtual time, as fast as it computes."),
    click.option(
        "--dry-run", is_flag=True, help="Check the limits and say what would be done; open nothing."
    ),
    click.option(
        "--keep-stop",
        is_flag=True,
        help="Move nothing where the board is found stopped or in a fault (for scripts).",
    ),
    click.option(
        "--no-servo-watchdog",
        is_flag=True,
        help="Drive Dynamixel servos although one has no bus watchdog: a killed host leaves it holding.",
    ),
    click.option("--yes", is_flag=True, help="Do not ask before a real robot moves."),
    *_VIEW_OPTIONS,
    click.option(
        "-v",
        "--verbose",
        is_flag=True,
        help="If the run fails, print the last frames on the wire, decoded (the log has them too).",
    ),
    click.option("--json", "as_json", is_flag=True, help="Print the result as one JSON object."),
)


def run_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command these options, in this order in its help; it is handed them as ``options``."""
    return given(collected(RunOptions)(command), _OPTIONS)


def view_options(command: Callable[..., None]) -> Callable[..., None]:
    """The options of the live page alone; ``run_options`` has them, too."""
    return given(command, _VIEW_OPTIONS)
