"""Where the joints are before a motion begins: it starts from there."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from snakebot.board import Board, Reading, Received
from snakebot.clock import Clock
from snakebot.errors import BoardFaultError, LostBoardError

FRESH_READING_S = 10.0  # longest wait: on a bad line few samples of many joints are whole
_POLL_S = 0.05  # for one message; chosen


def read_posture(
    board: Board, clock: Clock, needed: Sequence[bool], take: Callable[[Sequence[Received]], None]
) -> list[float]:
    """Fresh angles (rad) of all joints: the board sends samples by itself while nothing streams.

    A joint that is to get power must have been read: it would go to wherever the board believes it to be.

    Args:
        needed: for each joint whether it must be read; one that need not be and is not counts as straight.
        take: is handed whatever the board says meanwhile.

    Raises:
        LostBoardError: the board sends no angles.
        BoardFaultError: it sends none of a joint that is needed.
    """
    asked_s = clock.now_s()
    latest: Reading | None = None
    angles = [math.nan] * len(needed)

    def missing() -> list[int]:
        return [j for j, angle in enumerate(angles, start=1) if math.isnan(angle) and needed[j - 1]]

    while latest is None or missing():
        take(board.poll(_POLL_S))
        reading = board.last_reading
        if reading is not None and reading.received_s > asked_s and reading is not latest:
            latest = reading
            pairs = zip(angles, reading.measured_rad, strict=True)
            angles = [before if math.isnan(now) else now for before, now in pairs]
        elif clock.now_s() - asked_s > FRESH_READING_S:
            if latest is None:
                raise LostBoardError(
                    f"{board.where}: the board has sent no joint angles for {FRESH_READING_S:g} s"
                )
            raise BoardFaultError(
                f"{board.where}: no angle of joint {', '.join(map(str, missing()))} for {FRESH_READING_S:g} s: "
                "with power it might jump. Check its encoder, or leave it without power: "
                f"--fault free:{'+'.join(map(str, missing()))}"
            )
    return [0.0 if math.isnan(angle) else angle for angle in angles]
