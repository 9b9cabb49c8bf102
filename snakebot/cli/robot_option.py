"""``--robot`` on the command line: one option, whatever a command does with the description."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

from snakebot.cli import names
from snakebot.resources import DEFAULT_ROBOT

F = TypeVar("F", bound=Callable[..., Any])


def robot_option(help_: str = "Robot description.", default: str | None = DEFAULT_ROBOT) -> Callable[[F], F]:
    """The option, as ``robot_source``. ``default`` None: the command takes the robot from what it is given."""
    return click.option(
        "--robot",
        "robot_source",
        shell_complete=names.robots,
        default=default,
        show_default=default is not None,
        help=help_,
    )
