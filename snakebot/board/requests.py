"""Requests that a board acknowledges: sent again with the same token until it does, or until it counts as lost."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from dataclasses import dataclass

from firmware_protocol.catalogue import Acknowledge, Message, Mode, Result, frame_id
from snakebot.errors import BoardFaultError, LostBoardError

# Waits for an acknowledgement before each repetition. The first five tries are within the board's watchdog of 100 ms:
# a host that asks to hold, or has armed, sends no set-points until it is answered.
RETRY_S = (*4 * (0.02,), 0.04, 0.08, *7 * (0.16,))


@dataclass(slots=True)
class _Outstanding:
    """A request that has not been acknowledged yet."""

    message: Message
    what: str
    tries: int
    repeat_s: float


class Requests:
    """The requests that one host has made of one board. Times are the host's clock; nothing is sent from here."""

    def __init__(self, where: str) -> None:
        self._where = where
        self._outstanding: dict[int, _Outstanding] = {}
        self._token = secrets.randbelow(256)
        self.repeated = 0  # that had to be sent again: the line loses frames

    def make(self, make: Callable[[int], Message], what: str, now_s: float) -> tuple[int, Message]:
        """A request with a fresh token. ``what`` completes "the board refused the request ..."."""
        self._token = (self._token + 1) % 256
        message = make(self._token)
        self._outstanding[self._token] = _Outstanding(message, what, 1, now_s + RETRY_S[0])
        return self._token, message

    def waits_for(self, token: int) -> float | None:
        """When this request is sent again; None once it is acknowledged."""
        request = self._outstanding.get(token)
        return None if request is None else request.repeat_s

    def due(self, now_s: float) -> list[Message]:
        """What is to be sent again now.

        Raises:
            LostBoardError: one was repeated often enough.
        """
        again = []
        for token, request in list(self._outstanding.items()):
            if now_s < request.repeat_s:
                continue
            if request.tries >= len(RETRY_S):
                del self._outstanding[token]
                raise LostBoardError(
                    f"{self._where}: the board did not acknowledge the request {request.what} "
                    f"({len(RETRY_S)} tries in {sum(RETRY_S):.1f} s): check the cable and the board's supply"
                )
            request.repeat_s = now_s + RETRY_S[request.tries]
            request.tries += 1
            self.repeated += 1
            again.append(request.message)
        return again

    def answered(self, answer: Acknowledge) -> Mode | None:
        """Take in an acknowledgement. Returns the board's mode if it belongs to a request of ours that was done.

        Raises:
            BoardFaultError: the board refused it.
        """
        request = self._outstanding.get(answer.token)
        if request is None or answer.request != frame_id(type(request.message)):
            return None
        del self._outstanding[answer.token]
        if answer.result is not Result.OK:
            raise BoardFaultError(
                f"{self._where}: the board refused the request {request.what}: {_why(answer)}"
            )
        return Mode(answer.detail) if answer.detail in _MODES else None


_MODES = frozenset(int(mode) for mode in Mode)


def _why(answer: Acknowledge) -> str:
    mode = Mode(answer.detail).name.lower() if answer.detail in _MODES else f"in mode {answer.detail}"
    return {
        Result.OK: "",
        Result.BAD_VALUE: "the value is outside what this board can do",
        Result.BAD_JOINT: f"it has joints 1 to {answer.detail}",
        Result.FORBIDDEN: f"not while it is {mode}",
        Result.HELD: f"host {answer.detail:08x} holds it; `snakebot stop` stops it from here",
        Result.UNSUPPORTED: "it has no such function",
    }[answer.result]
