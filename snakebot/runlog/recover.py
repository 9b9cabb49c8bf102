"""Finishes a log that was cut short: kill -9, a full disk, a power cut."""

from __future__ import annotations

import os
from pathlib import Path

from snakebot.errors import BadInputError, LogError
from snakebot.runlog.channels import JOINTS
from snakebot.runlog.container import Container
from snakebot.runlog.finish import Changes, finish
from snakebot.runlog.lock import is_being_written
from snakebot.runlog.naming import PART_SUFFIX, SUFFIX, final_path, no_such_log


def recover(
    path: str | os.PathLike[str], output: str | os.PathLike[str] | None = None
) -> tuple[Path, list[str]]:
    """Rewrite an unfinished or damaged log as a finished one, with all that its checksums vouch for.

    Args:
        path: a ``.mcap.part``, or a damaged ``.mcap``.
        output: the finished log; by default the ``.part`` takes its final name and goes. With an output the
            original stays.

    Returns:
        The finished log, and what was damaged and left out, a line each.

    Raises:
        BadInputError: no such file, a ``.mcap`` without an output, or not one tick in it is whole.
        LogError: a run is still writing it, it is no log, or the output exists or cannot be written.
    """
    source = Path(path)
    if not source.is_file():
        raise no_such_log(source)
    if output is None and not source.name.endswith(SUFFIX + PART_SUFFIX):
        raise BadInputError(
            f"{source}: not an unfinished log ({SUFFIX}{PART_SUFFIX}); to rewrite it give --output"
        )
    target = final_path(source if output is None else output)
    if os.path.lexists(target):
        raise LogError(f"{target}: exists already; a log is never overwritten; give another --output")
    if is_being_written(source):
        raise LogError(f"{source}: a run is still writing this log; recover it when that has ended")
    if not _has_ticks(source):
        raise BadInputError(f"{source}: not one tick in it is whole: nothing to recover; it stays as it is")
    return finish(source, target, Changes(metadata={"recovered": True}), keep_source=output is not None)


def _has_ticks(log: Path) -> bool:
    container = Container(log)
    return any(
        container.topics.get(channel_id) == JOINTS.topic
        for messages in container.chunks()
        for channel_id, *_ in messages
    )
