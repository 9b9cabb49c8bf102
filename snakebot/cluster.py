"""Independent pieces of work: done here, one after the other, or handed to a dask.distributed cluster.

Whoever splits work up (sweeps, the choice of a gait, many sessions) gives a function and the arguments of each piece,
by a key, and takes results as they come, each key once. A piece whose worker dies is done again by another one.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Hashable, Iterator, Mapping
from concurrent.futures import CancelledError
from types import TracebackType
from typing import Any, Self, TypeVar

from snakebot.errors import BadInputError, SnakebotError

K = TypeVar("K", bound=Hashable)
R = TypeVar("R")

_SCHEDULER_ANSWERS = "5s"  # a dask scheduler on a local network answers well within a second
_LOGGERS = ("distributed", "distributed.client", "tornado.application")  # each has a level of its own
_WORKER_COMES_S = 10.0  # one that was just started; chosen
_RETRIES = 3  # of a piece that fails on a worker, before it counts as failed
_CANCELLED = (CancelledError, asyncio.CancelledError)


class Workers:
    """Who does the pieces, until the end of the ``with`` block.

    Args:
        dask: address of a dask.distributed scheduler; None: this process.

    Raises:
        BadInputError: on entering: the extra is missing, no scheduler answers there, or it has no worker.
    """

    def __init__(self, dask: str | None = None) -> None:
        self.dask = dask
        self._client: Any = None
        self._levels: list[tuple[logging.Logger, int]] = []

    def __enter__(self) -> Self:
        if self.dask is None:
            return self
        try:
            import distributed
        except ImportError:
            raise BadInputError("--dask needs the extra: pip install 'snakebot[dask]'") from None
        connect: Any = distributed.Client
        # What goes wrong is raised, in one line; dask would write tracebacks of its own threads beside it.
        self._levels = [(logger, logger.level) for logger in map(logging.getLogger, _LOGGERS)]
        for logger, _ in self._levels:
            logger.setLevel(logging.CRITICAL + 1)
        try:
            self._client = connect(self.dask, timeout=_SCHEDULER_ANSWERS)
        except (OSError, ValueError) as error:
            self._say_again()
            raise BadInputError(f"--dask {self.dask}: no scheduler answers there: {error}") from None
        try:
            self._client.wait_for_workers(1, timeout=_WORKER_COMES_S)
        except (TimeoutError, OSError):
            self.__exit__(None, None, None)
            raise BadInputError(
                f"--dask {self.dask}: the scheduler has no worker: start one, as by `dask worker {self.dask}`"
            ) from None
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None
        self._say_again()

    def _say_again(self) -> None:
        for logger, level in self._levels:
            logger.setLevel(level)
        self._levels = []

    @property
    def away(self) -> bool:
        """Whether pieces leave this process."""
        return self._client is not None

    def results(
        self, function: Callable[..., R], pieces: Mapping[K, tuple[Any, ...]]
    ) -> Iterator[tuple[K, R]]:
        """Key and result of each piece, as they are done; here in their order.

        Args:
            function: of a module that the workers have, without side effects: a piece may be done twice.
            pieces: its arguments; they are sent, pickled.

        Raises:
            SnakebotError: the workers that had a piece died, one after the other, or the scheduler is gone.
        """
        if self._client is None:
            for key, arguments in pieces.items():
                yield key, function(*arguments)
            return
        import distributed

        done: Any = distributed.as_completed
        gone = SnakebotError(f"--dask {self.dask}: the scheduler is gone; start it again, and the command")
        try:
            futures = {
                self._client.submit(function, *arguments, pure=False, retries=_RETRIES): key
                for key, arguments in pieces.items()
            }
            for future, result in done(futures, with_results=True):
                if isinstance(result, _CANCELLED):  # dask hands it over in the place of a result
                    raise gone
                yield futures[future], result
        except distributed.scheduler.KilledWorker as error:
            raise SnakebotError(f"--dask {self.dask}: workers die of a piece of this work: {error}") from None
        except (*_CANCELLED, distributed.client.ClosedClientError, distributed.comm.core.CommClosedError):
            raise gone from None
