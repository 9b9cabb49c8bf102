"""A board client whose wire the tests hold: messages changed, lost, or added; several boards on one line."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from firmware_protocol.catalogue import Message, decode, encode
from firmware_protocol.frame import Frame
from snakebot.board import Board
from snakebot.clock import VirtualClock
from snakebot.links.base import Link
from snakebot.robot import load_robot
from snakebot.softboard import InProcessLink, SoftBoard

ROBOT = load_robot("penn_state")
HOST, OTHER = 0xC0FFEE, 0xBEEF


class SharedLine(Link):
    """Simulated boards on one line in virtual time, as on a CAN bus.

    Attributes:
        change: what becomes of a message of a board on its way to the host; None: it is lost.
        change_frame: the same for the frame that carries it.
        on_send: hears what the host says; what it returns is heard by the boards.
        extra: frames that somebody else puts on the line, heard by the host.
    """

    def __init__(self, clock: VirtualClock, *boards: SoftBoard) -> None:
        super().__init__("can:test", math.inf)
        self.clock = clock
        self.boards = list(boards)
        self.change: Callable[[Message], Message | None] = lambda message: message
        self.change_frame: Callable[[Frame], Frame] = lambda frame: frame
        self.on_send: Callable[[Message], Message | None] = lambda message: message
        self.extra: list[Frame] = []
        self._links = [InProcessLink(board, clock) for board in boards]

    def send(self, frames: Sequence[Frame]) -> None:
        kept = [message for frame in frames if (message := self.on_send(decode(frame))) is not None]
        for link in self._links:
            link.send([encode(message) for message in kept])

    def receive(self, timeout_s: float) -> list[Frame]:
        deadline_s = self.clock.now_s() + timeout_s
        while True:
            heard, self.extra = self.extra, []
            for link in self._links:
                for frame in link._collect(self.clock.now_s()):
                    message = self.change(decode(frame))
                    if message is not None:
                        heard.append(self.change_frame(encode(message)))
            if heard or self.clock.now_s() >= deadline_s:
                return heard
            self.clock.sleep_until(min([deadline_s, *(board.next_event_s for board in self.boards)]))

    def close(self) -> None:
        pass


class Hands:
    """One host on a line with as many boards as there are ``serial_numbers``."""

    def __init__(self, *serial_numbers: int, phase_s: float = 0.037) -> None:
        self.clock = VirtualClock()
        self.boards = [
            SoftBoard(ROBOT, serial_number=number, boot_seed=seed)
            for seed, number in enumerate(serial_numbers or (1,))
        ]
        self.sim = self.boards[0]
        for number, board in enumerate(self.boards):
            self.clock.sleep_until(number * phase_s)  # they were not switched on together
            board.advance(self.clock.now_s())
        self.line = SharedLine(self.clock, *self.boards)
        self.board = Board(self.line, self.clock, host=HOST)

    def say(self, *messages: Message) -> None:
        """Somebody else says something that boards and host hear."""
        for message in messages:
            for board in self.boards:
                board.receive(encode(message), self.clock.now_s())
            self.line.extra.append(encode(message))
