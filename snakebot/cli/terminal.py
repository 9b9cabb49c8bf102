"""A terminal that has been closed: whatever is written to it fails, and must not take the run's end with it."""

from __future__ import annotations

import errno
import os
import termios


def leave_dead_terminal() -> None:
    """What still comes for a terminal that has gone is thrown away. Pipes, files and living terminals stay."""
    for stream in (0, 1, 2):
        try:
            termios.tcgetattr(stream)
        except termios.error as error:
            if error.args[0] == errno.EIO:
                nowhere = os.open(os.devnull, os.O_RDWR)
                os.dup2(nowhere, stream)
                os.close(nowhere)
