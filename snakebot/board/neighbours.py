"""Who else speaks on a board's line: a second board is an error, another host is a warning."""

from __future__ import annotations

from enum import Enum, auto


class Beat(Enum):
    """Whose heartbeat it was."""

    OURS = auto()
    STRANGE = auto()  # a reset of our board or a second board: the next beat tells
    REBOOTED = auto()
    SECOND_BOARD = auto()


class Neighbours:
    """Boot ids and hosts that were heard on one line. Nothing is sent from here.

    A boot id that changes is a board that was reset, or a second board: with two of them the first one is heard again.
    """

    def __init__(self, host: int) -> None:
        self.hosts: set[int] = set()  # other ones
        self.stranger: int | None = None  # the boot id that is not our board's
        self._host = host
        self._told = False

    def board(self, boot_id: int, ours: int) -> Beat:
        """A board has said its boot id. A second board is told once."""
        if boot_id == ours:
            if self.stranger is None or self._told:
                return Beat.OURS
            self._told = True
            return Beat.SECOND_BOARD
        if self._told or boot_id != self.stranger:
            self.stranger = boot_id
            return Beat.STRANGE
        return Beat.REBOOTED

    def host(self, host: int) -> bool:
        """A host's heartbeat: True where it is another one, heard for the first time."""
        new = host != self._host and host not in self.hosts
        if new:
            self.hosts.add(host)
        return new
