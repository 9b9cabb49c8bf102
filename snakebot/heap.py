"""Python's collector kept from looking through the whole heap while a robot waits for its next set-point."""

from __future__ import annotations

import contextlib
import gc
from collections.abc import Iterator


@contextlib.contextmanager
def settled_heap() -> Iterator[None]:
    """What start-up has made is not looked through again.

    A full collection of a program with its libraries takes tens of milliseconds, and comes when it likes; what a loop
    makes later is little. The first collection happens here: enter before anything moves.
    """
    was_settled = gc.get_freeze_count() > 0
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        if not was_settled:  # whoever settled it first may still be at work: a board served beside a run
            gc.unfreeze()
