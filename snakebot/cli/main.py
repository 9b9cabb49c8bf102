"""``snakebot``: the group of all subcommands. A subcommand's module is imported only when it is called."""

from __future__ import annotations

import errno
import importlib
import os
import sys
import warnings
from collections.abc import Sequence
from typing import Any

import click

from snakebot import __version__
from snakebot.errors import EXIT_INTERNAL, EXIT_LOG, SnakebotError

# name -> (module, one line of help): the help page needs no import.
COMMANDS: dict[str, tuple[str, str]] = {
    "run": ("snakebot.cli.run", "Move the robot: stream a gait, read the encoders, log it."),
    "stop": ("snakebot.cli.stop", "Emergency stop from a second terminal."),
    "board": ("snakebot.cli.board", "Find boards, ask them who they are, simulate one, test one."),
    "doctor": ("snakebot.cli.doctor", "Check a port: permissions, timing, versions; say what to do."),
    "log": ("snakebot.cli.log", "List, inspect, export, import, replay and recover run logs."),
    "session": ("snakebot.cli.session", "Make session folders from logs, and check them."),
    "analyze": ("snakebot.cli.analyze", "Tracking error, sines, speed, power and link quality of runs."),
    "compare": ("snakebot.cli.compare", "One run beside its simulation, joint by joint."),
    "diagnose": ("snakebot.cli.diagnose", "Where robot and simulation part, and which effect causes it."),
    "study": ("snakebot.cli.study", "The paper's experiments: Pareto front, faults, friction, speed."),
    "completion": ("snakebot.cli.completion", "Print the script for shell completion."),
}

EPILOG = """\b
Examples:
  snakebot run --alpha 66 --beta 80 --omega 2          on the simulated board
  snakebot run --alpha 66 --beta 80 --omega 2 --port serial:/dev/ttyUSB0
  snakebot board list
  snakebot diagnose runs/

\b
Exit status: 0 done, 1 internal error, 2 bad input (nothing moved), 3 no board, 4 board lost in mid-run,
5 board fault or emergency stop, 6 log or output not written, 7 this computer too late, 130 interrupted.
"""


class _ReaderGoneError(Exception):
    """Whoever read our output has heard enough."""


class LazyGroup(click.Group):
    """Commands by name, imported when asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        command = importlib.import_module(COMMANDS[cmd_name][0]).command
        assert isinstance(command, click.Command)
        return command

    def invoke(self, ctx: click.Context) -> Any:
        """Click would end with status 1 where the reader of our output has gone, as with ``| head``."""
        try:
            result = super().invoke(ctx)
            sys.stdout.flush()
        except BrokenPipeError:
            raise _ReaderGoneError from None
        return result

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in COMMANDS.items()])


@click.group(cls=LazyGroup, epilog=EPILOG, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, "-V", "--version", prog_name="snakebot")
def cli() -> None:
    """Drive a servo snake robot, simulate it, and find out why the two differ."""


_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)


def _write_no_more() -> None:
    """What is still buffered goes nowhere: Python would try to write it at the end, and complain."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _show_warning(message: Warning | str, *_: object, **__: object) -> None:
    click.echo(f"snakebot: warning: {message}", err=True)


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point: every error meant for the user becomes one line and its exit status."""
    warnings.showwarning = _show_warning
    try:
        status = cli.main(args=arguments, prog_name="snakebot", standalone_mode=False)
    except (click.exceptions.Abort, KeyboardInterrupt):
        click.echo("snakebot: aborted", err=True)
        sys.exit(130)
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        usage = f"\nTry: {context.command_path} --help" if context is not None else ""
        click.echo(f"snakebot: {error.format_message()}{usage}", err=True)
        sys.exit(error.exit_code)
    except SnakebotError as error:
        click.echo(f"snakebot: {error}", err=True)
        sys.exit(error.exit_status)
    except (_ReaderGoneError, BrokenPipeError):
        _write_no_more()
        sys.exit(0)
    except Exception as error:
        if isinstance(error, OSError) and error.filename is None and error.errno in _NO_ROOM:
            _write_no_more()
            click.echo(f"snakebot: standard output cannot be written: {error.strerror}", err=True)
            sys.exit(EXIT_LOG)
        if os.environ.get("SNAKEBOT_DEBUG"):
            raise
        click.echo(
            f"snakebot: internal error: {type(error).__name__}: {error} "
            "(a fault of snakebot; SNAKEBOT_DEBUG=1 shows where)",
            err=True,
        )
        sys.exit(EXIT_INTERNAL)
    sys.exit(status if isinstance(status, int) else 0)


if __name__ == "__main__":
    main()
