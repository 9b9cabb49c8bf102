"""One motion on one board, attended by a person: open, ask, record, show."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from snakebot.cli.attendance import Attended, tell
from snakebot.cli.live_page import check_view, open_view
from snakebot.cli.ports import patience
from snakebot.errors import BadInputError, SnakebotError

if TYPE_CHECKING:
    from snakebot.cli.run_options import RunOptions
    from snakebot.control import RecordedRun, RunPlan, RunSettings
    from snakebot.robot import Robot
    from snakebot.view.feed import Feed


def check(
    robot: Robot,
    plan: RunPlan,
    settings: RunSettings,
    options: RunOptions,
    *,
    several: bool = False,
    start_pose: tuple[float, float, float] | None = None,
) -> None:
    """What is refused before anything is opened: the same for a run, alone or one of ``several``, and for its
    ``--dry-run``.

    Raises:
        BadInputError: rate, limits, motion, faults, port or effects that the run would refuse; a rate for which the
            line is too slow, even for the board that waits the longest for a set-point.
        LogError: the log's name is taken, or cannot be one.
    """
    from snakebot.control import check_run
    from snakebot.control.copies import Copies
    from snakebot.control.ports import check_port
    from snakebot.lifted import lifted
    from snakebot.links import parse_port
    from snakebot.links.capacity import frames_per_s
    from snakebot.softboard.buildable import MAX_WATCHDOG_MS

    check_run(robot, plan, settings)
    simulated = lifted(robot) if plan.lifted else robot
    check_port(options.port, simulated, options.effects, virtual=options.fast, start_pose=start_pose)
    carried = frames_per_s(parse_port(options.port))
    Copies(1 / settings.rate_hz, robot.joints, carried, 1e-3 * MAX_WATCHDOG_MS, options.port)
    check_view(options, several=several)


def execute(
    robot: Robot,
    plan: RunPlan,
    settings: RunSettings,
    options: RunOptions,
    page: Feed | None = None,
    *,
    start_pose: tuple[float, float, float] | None = None,
) -> RecordedRun:
    """Check, open, connect, ask, record. ``page`` is the one of several runs, where there is such.

    Args:
        start_pose: where the simulated robot lies at first: m, m, rad.

    Raises:
        SnakebotError: see ``check``, ``open_board`` and ``record``.
    """
    from snakebot.control import open_board, record

    check(robot, plan, settings, options, several=page is not None, start_pose=start_pose)
    if settings.pose is not None and options.fast:
        raise BadInputError(f"--pose {settings.pose} comes in real time: leave out --fast")
    if settings.pose is not None and settings.pose.open_to_others:
        tell(f"{settings.pose} is open to other computers: whoever reaches it can steer the robot")
    with _told_what_is_left(options), contextlib.ExitStack() as open_things:
        with patience(options.port):
            board = open_things.enter_context(
                open_board(
                    options.port,
                    robot,
                    effects=options.effects,
                    seed=options.seed,
                    virtual=options.fast,
                    lifted=plan.lifted,
                    rate_hz=settings.rate_hz,
                    servo_watchdog=not options.no_servo_watchdog,
                    start_pose=start_pose,
                    tell=tell,
                )
            )
        assert board.info is not None
        if not (board.info.simulated or options.yes):
            confirm(options.port, robot, plan.title)
        feed = open_view(robot, plan.title, options, page)
        attended = Attended(robot, plan, options, feed)
        try:
            recorded = record(board, robot, plan, settings, attended)
        except BaseException:
            if attended.log_path is not None and attended.log_path.exists():
                with contextlib.suppress(OSError):  # nobody reads: the run's own error is what counts
                    click.echo(f"log up to there: {attended.log_path}", err=True)
            raise
        if told := board.link.told():
            click.echo(told, err=True)
        return recorded


@contextlib.contextmanager
def _told_what_is_left(options: RunOptions) -> Iterator[None]:
    """With ``--verbose``, print the last traffic before an error."""
    try:
        yield
    except SnakebotError as error:
        if options.verbose and error.traffic:
            with contextlib.suppress(OSError):
                click.echo(f"the last {len(error.traffic)} frames on the wire (host clock, s):", err=True)
                for line in error.traffic:
                    click.echo(f"  {line}", err=True)
        raise


def confirm(port: str, robot: Robot, motion: str) -> None:
    """Ask whether a real robot may move.

    Raises:
        BadInputError: there is nobody to ask.
        click.Abort: it may not.
    """
    if not sys.stdin.isatty():
        raise BadInputError(f"{port} is a real robot, and there is nobody to ask: add --yes if it may move")
    click.confirm(
        f"{port}: a real robot ({robot.joints} joints) will move now: {motion}. Is everyone clear of it?",
        abort=True,
    )
