"""Requests that a board acknowledges: sent again with the same token until it does, or until it counts as lost."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from dataclasses import dataclass

from firmware_protocol.catalogue import Acknowledge, ClearRequest, Fault, Message, Result, frame_id
from snakebot.board.faults import fault_line
from snakebot.errors import BoardFaultError, LostBoardError

# Waits for an acknowledgement before each repetition. The first five tries are within the watchdog's time that
# PROTOCOL.md asks of a board, 100 ms: a host that asks to hold, or has armed, sends no set-points until it is answered.
RETRY_S = (*4 * (0.02,), 0.04, 0.08, *7 * (0.16,))


@dataclass(slots=True)
class Outstanding:
    """A request that has not been acknowledged yet. ``what`` completes "the board refused the request ..."."""

    message: Message
    what: str
    tries: int
    repeat_s: float


class Requests:
    """The requests that one host has made of one board. Times are the host's clock; nothing is sent from here."""

    def __init__(self, where: str) -> None:
        self._where = where
        self._outstanding: dict[int, Outstanding] = {}
        self._token = secrets.randbelow(256)
        self.repeated = 0  # that had to be sent again: the line loses frames

    def make(self, make: Callable[[int], Message], what: str, now_s: float) -> tuple[int, Message]:
        """A request with a fresh token. An older one for the same thing is not sent again: this one is what holds."""
        self._token = (self._token + 1) % 256
        message = make(self._token)
        for token, older in list(self._outstanding.items()):
            if _subject(older.message) == _subject(message):
                del self._outstanding[token]
        self._outstanding[self._token] = Outstanding(message, what, 1, now_s + RETRY_S[0])
        return self._token, message

    def forget(self) -> None:
        """Send none again."""
        self._outstanding.clear()

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

    def answered(self, answer: Acknowledge) -> Outstanding | None:
        """The request that this answers, which is not waited for any more; None: it is not one of ours."""
        request = self._outstanding.get(answer.token)
        if request is None or answer.request != frame_id(type(request.message)):
            return None
        if answer.host != getattr(request.message, "host"):  # noqa: B009 - every request has one
            return None
        return self._outstanding.pop(answer.token)

    def refusal(
        self, request: Outstanding, answer: Acknowledge, holder: int, watchdog_ms: int | None = None
    ) -> BoardFaultError:
        """What to raise when a request was not granted.

        Args:
            holder: as far as heartbeats have said, or 0.
            watchdog_ms: of the board, as far as it has said.
        """
        why = {
            Result.OK: "",
            Result.BAD_VALUE: "the value is outside what this board can do",
            Result.BAD_JOINT: f"it has joints 1 to {answer.detail}",
            Result.FORBIDDEN: f"not while it is {answer.mode.name.lower()}",
            Result.HELD: (f"host {holder:08x}" if holder else "another host")
            + " holds it; `snakebot stop` stops it from here",
            Result.UNSUPPORTED: "it has no such function",
            Result.FAULTY: fault_line(Fault(answer.detail), watchdog_ms=watchdog_ms)
            if answer.detail in _FAULTS
            else "a fault lasts",
        }[answer.result]
        if isinstance(request.message, ClearRequest) and answer.result is Result.FORBIDDEN:
            why = "it was stopped again meanwhile"
        return BoardFaultError(f"{self._where}: the board refused the request {request.what}: {why}")


def _subject(message: Message) -> tuple[object, ...]:
    """What a request sets: a newer one for the same takes its place."""
    return type(message), getattr(message, "joint", None), getattr(message, "kind", None)


_FAULTS = frozenset(int(fault) for fault in Fault)
