"""The emergency stop from outside a run, until the board says that it has stopped."""

from __future__ import annotations

from firmware_protocol.catalogue import BoardHeartbeat, Fault, FaultEvent, Mode, State, StopReason, decode
from firmware_protocol.frame import Frame, ProtocolError
from snakebot.board.client import Board
from snakebot.clock import Clock
from snakebot.errors import BoardFaultError, NoBoardError
from snakebot.links.base import Link

# A board beats ten times a second: time for a bad line to carry one stop there and one beat back.
STOPPING_S = 2.0
_AGAIN_S = 0.05  # a stop that is not acknowledged is sent again; chosen, half the board's watchdog


def stop_board(link: Link, clock: Clock, reason: StopReason = StopReason.USER) -> None:
    """Send the emergency stop at once, and again until the board reports that it has stopped.

    No handshake comes before it: a board that another host holds, or that has no joint angles, obeys all the same.

    Raises:
        NoBoardError: nobody has said anything; the stop was sent blindly.
        BoardFaultError: a board speaks, but does not say that it has stopped.
        LostBoardError: the link is gone.
    """
    board = Board(link, clock)
    board.emergency_stop(reason)
    link.receive(0.0)  # said before the stop
    deadline_s = clock.now_s() + STOPPING_S
    last: Mode | None = None
    while (left_s := deadline_s - clock.now_s()) > 0:
        for frame in link.receive(min(_AGAIN_S, left_s)):
            mode = _mode(frame)
            if mode is Mode.STOPPED:
                return
            last = last if mode is None else mode
        board.emergency_stop(reason)
    if last is None:
        raise NoBoardError(
            f"{board.where}: no board answered within {STOPPING_S:g} s; the emergency stop was sent all the same: "
            "is the board on, and is this the right port? Cut the supply if anything still moves"
        )
    raise BoardFaultError(
        f"{board.where}: the board has not obeyed the emergency stop within {STOPPING_S:g} s: "
        f"it is {last.name.lower()}: cut its supply"
    )


def _mode(frame: Frame) -> Mode | None:
    """What a frame tells of the board's mode."""
    try:
        message = decode(frame)
    except ProtocolError:
        return None
    match message:
        case BoardHeartbeat() | State():
            return message.mode
        case FaultEvent():
            return Mode.STOPPED if message.code is Fault.EMERGENCY_STOP else Mode.FAULT
    return None
