"""Fits that do not need each other, on both cores: the compiled loops that they spend their time in hold no lock."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

# Fits at a time; chosen: the cores of the computer that the documentation's times are measured on.
THREADS = 2

T = TypeVar("T")
R = TypeVar("R")


def in_parallel(
    function: Callable[[T], R], items: Iterable[T], done: Callable[[int], None] | None = None
) -> list[R]:
    """What ``function`` makes of each item, in their order; ``done`` is called with how many are ready."""
    out = []
    with ThreadPoolExecutor(THREADS) as pool:
        for result in pool.map(function, items):
            out.append(result)
            if done is not None:
                done(len(out))
    return out
