"""The errors a user can meet, and the exit status that belongs to each.

Every error carries one line that says what is wrong, where, and what to do. The command line prints that line and
leaves with ``exit_status``; nothing else in the program decides on an exit status.

====== ==================================================================
status meaning
====== ==================================================================
0      done
1      internal error: a fault of snakebot itself
2      bad input: nothing was opened, nothing moved
3      the link or the board could not be opened, the handshake failed, or nobody answered a stop
4      the link or the board was lost in mid-run; the robot was left to its watchdog
5      the board reported a fault, refused a request or was stopped by an emergency stop; `snakebot stop`: not
       everything has stopped
6      the log or an output could not be written; a robot that moved was stopped safely
7      this computer was so late, again and again, that the board's watchdog was near; held and relaxed
130    interrupted by the user; the robot was stopped safely
====== ==================================================================
"""

from __future__ import annotations

import errno
import re

# Exit statuses of the command line, as the help of its commands tells them.
EXIT_OK = 0
EXIT_INTERNAL = 1
EXIT_BAD_INPUT = 2
EXIT_NO_BOARD = 3
EXIT_LOST = 4
EXIT_BOARD_FAULT = 5
EXIT_LOG = 6
EXIT_HOST_LATE = 7
EXIT_INTERRUPTED = 130  # the shell's: 128 and the number of SIGINT

MAX_LINE = 2000  # characters of an error

# Control characters (a terminal obeys them), marks that turn the direction of writing, halves of characters.
_UNPRINTABLE = re.compile(r"[\x00-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")


class SnakebotError(Exception):
    """Base of every error that is meant for the user: one clear line and an exit status."""

    exit_status = EXIT_INTERNAL
    traffic: tuple[str, ...] = ()  # the last frames before it, decoded, where a board was spoken with

    def __str__(self) -> str:
        """One line that a terminal may be given, whatever a file or an option that is quoted in it held."""
        text = super().__str__()
        if len(text) > MAX_LINE:  # a file's own words may be quoted in it
            text = f"{text[: MAX_LINE * 3 // 4]} ... {text[-MAX_LINE // 4 :]}"
        line = " ".join(text.splitlines())
        return _UNPRINTABLE.sub(lambda sign: sign[0].encode("unicode_escape").decode(), line)


class BadInputError(SnakebotError):
    """What the user gave cannot be used: an option, a file, a gait outside the limits."""

    exit_status = EXIT_BAD_INPUT


class OutputError(BadInputError):
    """A disk that is full or fails: what was asked for is right, but cannot be written."""

    exit_status = EXIT_LOG


# Of a full disk, a quota, a file system's largest file, a disk that fails.
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)


def cannot_write(what: str, error: OSError) -> BadInputError:
    """The error of an output: the disk's, or that of a name that nothing can be written to."""
    kind = OutputError if error.errno in NO_ROOM else BadInputError
    return kind(f"{what}: {error.strerror or error}")


class NoBoardError(SnakebotError):
    """The port cannot be opened, nobody answers, or the two ends do not speak the same catalogue."""

    exit_status = EXIT_NO_BOARD


class LostBoardError(SnakebotError):
    """The link or the board went away while it was in use."""

    exit_status = EXIT_LOST


class BoardFaultError(SnakebotError):
    """The board is in a fault, refused a request, or was stopped by an emergency stop."""

    exit_status = EXIT_BOARD_FAULT


class HostLateError(SnakebotError):
    """This computer is so slow or so busy that the board's watchdog would soon stop the robot."""

    exit_status = EXIT_HOST_LATE


class LogError(SnakebotError):
    """A run log cannot be written or is not one."""

    exit_status = EXIT_LOG


class UnreadableLogError(LogError):
    """A file that was to be read is no run log, or holds what no run log holds."""

    exit_status = EXIT_BAD_INPUT


class NothingLeftError(UnreadableLogError):
    """A log so damaged that nothing of a run is left."""
