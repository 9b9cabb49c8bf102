"""``snakebot``: the group of all subcommands. A subcommand's module is imported only when it is called."""

from __future__ import annotations

if __name__ == "__main__":  # before anything slow is imported
    from snakebot.cli.entry import main as begin

    begin()

import contextlib
import importlib
import os
import sys
import warnings
from collections.abc import Sequence
from typing import Any, NoReturn, TextIO

import click

from snakebot import __version__
from snakebot.cli import ctrl_c
from snakebot.cli.groups import Group
from snakebot.errors import EXIT_INTERNAL, EXIT_INTERRUPTED, EXIT_LOG, NO_ROOM, SnakebotError

# name -> (module, one line of help): the help page needs no import.
COMMANDS: dict[str, tuple[str, str]] = {
    "run": ("snakebot.cli.run", "Move the robot: stream a gait, read the encoders, log it."),
    "view": ("snakebot.cli.view", "A recorded run, or a board that others drive, in the browser."),
    "stop": ("snakebot.cli.stop", "Emergency stop from a second terminal."),
    "jog": ("snakebot.cli.jog", "Turn one joint by keys, in small steps."),
    "board": ("snakebot.cli.board", "Find boards, ask them who they are, simulate one, test one."),
    "effect": ("snakebot.cli.effect", "What a nominal simulation leaves out: list the effects, show one."),
    "gait": ("snakebot.cli.gait", "Gaits by name: list, show."),
    "robot": ("snakebot.cli.robot", "Robot descriptions: list, show, calibrate, export to MuJoCo."),
    "doctor": ("snakebot.cli.doctor", "Check a port: permissions, timing, versions; say what to do."),
    "log": ("snakebot.cli.log", "List, inspect, export, import, replay and recover run logs."),
    "session": ("snakebot.cli.session", "Plan recordings, make session folders from logs, check them."),
    "analyze": ("snakebot.cli.analyze", "Tracking error, sines, speed, power and link quality of runs."),
    "compare": ("snakebot.cli.compare", "One run beside its simulation, joint by joint."),
    "diagnose": ("snakebot.cli.diagnose", "Where robot and simulation part, and which effect causes it."),
    "optimize": ("snakebot.cli.optimize", "The best gait of a robot with its effects, and how sure it is."),
    "predict": ("snakebot.cli.predict", "Speed, tracking error and power of a gait, with bands."),
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


class LazyGroup(Group):
    """Commands by name, imported when asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        command = importlib.import_module(COMMANDS[cmd_name][0]).command
        assert isinstance(command, click.Command)
        return command

    def make_context(self, *arguments: Any, **more: Any) -> click.Context:
        """Click would begin a line of its own on Ctrl-C."""
        try:
            return super().make_context(*arguments, **more)
        except KeyboardInterrupt:
            raise click.Abort from None

    def invoke(self, ctx: click.Context) -> Any:
        """Click would end with status 1 where the reader of our output has gone, as with ``| head``, and say more than
        needs saying on Ctrl-C.
        """
        try:
            result = super().invoke(ctx)
            sys.stdout.flush()
        except BrokenPipeError:
            raise _ReaderGoneError from None
        except KeyboardInterrupt:
            raise click.Abort from None
        return result

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in COMMANDS.items()])


@click.group(cls=LazyGroup, epilog=EPILOG, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, "-V", "--version", prog_name="snakebot")
def cli() -> None:
    """Drive a servo snake robot, simulate it, and find out why the two differ."""


def _write_no_more(stream: TextIO) -> None:
    """What is still buffered goes nowhere: Python would try to write it at the end, and complain."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


# click's words for what was typed, in the reader's.
_PLAINER = {
    "is not a valid float.": "is not a number.",
    "is not a valid integer.": "is not a whole number.",
    "is not a valid integer range.": "is not a whole number.",
}


def _say(line: str) -> None:
    try:
        click.echo(f"snakebot: {line}", err=True)
    except OSError:  # a terminal that has been closed
        # Python before 3.11.4 would try to write it at the end, and end with a status of its own
        with contextlib.suppress(OSError, ValueError):
            _write_no_more(sys.stderr)


def _show_warning(message: Warning | str, *_: object, **__: object) -> None:
    _say(f"warning: {message}")


def main(arguments: Sequence[str] | None = None) -> None:
    """Every error meant for the user becomes one line and its exit status. The program begins in ``entry``."""
    warnings.showwarning = _show_warning
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by whoever started us, as ``>&-`` does
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115  # until the program ends
    try:
        status = cli.main(args=arguments, prog_name="snakebot", standalone_mode=False)
    except (click.exceptions.Abort, KeyboardInterrupt):
        _abort()
    except click.exceptions.NoArgsIsHelpError as asked:  # a group alone: its help is the answer
        click.echo(asked.format_message(), err=True)
        sys.exit(asked.exit_code)
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        usage = f"\nTry: {context.command_path} --help" if context is not None else ""
        line = " ".join(error.format_message().split())  # a missing choice comes in several lines
        for theirs, ours in _PLAINER.items():
            line = line.replace(theirs, ours)
        _say(f"{line}{usage}")
        sys.exit(error.exit_code)
    except SnakebotError as error:
        _say(str(error))
        sys.exit(error.exit_status)
    except (_ReaderGoneError, BrokenPipeError):
        _write_no_more(sys.stdout)
        sys.exit(0)
    except Exception as error:
        if isinstance(error, OSError) and error.filename is None and error.errno in NO_ROOM:
            _write_no_more(sys.stdout)
            _say(f"standard output cannot be written: {error.strerror}")
            sys.exit(EXIT_LOG)
        if os.environ.get("SNAKEBOT_DEBUG"):
            raise
        if ctrl_c.pressed:
            _abort()
        _say(
            f"internal error: {type(error).__name__}: {error} "
            "(a fault of snakebot; SNAKEBOT_DEBUG=1 shows where)"
        )
        sys.exit(EXIT_INTERNAL)
    sys.exit(status if isinstance(status, int) else 0)


def _abort() -> NoReturn:
    _say("aborted")
    sys.exit(EXIT_INTERRUPTED)
