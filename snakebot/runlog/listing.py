"""What is in a folder of logs, without decoding a row."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from snakebot.errors import LogError
from snakebot.runlog.channels import JOINTS
from snakebot.runlog.container import Container
from snakebot.runlog.finish import merge_metadata
from snakebot.runlog.lock import is_being_written
from snakebot.runlog.naming import PART_SUFFIX, SUFFIX


@dataclass(frozen=True)
class LogSummary:
    """One line of ``snakebot log list``."""

    path: Path
    state: str  # finished, unfinished, writing, damaged
    ticks: int
    duration_s: float
    bytes: int
    messages: Mapping[str, int]  # topic -> number
    metadata: Mapping[str, Any]
    problems: tuple[str, ...]


def find_logs(folder: str | os.PathLike[str]) -> Iterator[Path]:
    """Finished and unfinished logs in a folder, by name (which is by time)."""
    paths = (path for path in Path(folder).iterdir() if path.is_file())
    yield from sorted(path for path in paths if path.name.endswith((SUFFIX, SUFFIX + PART_SUFFIX)))


def summarize(path: str | os.PathLike[str]) -> LogSummary:
    """Go through a log, every checksum compared; a file that is no log is ``damaged``, not an error."""
    path = Path(path)
    container = Container(path)
    counts: dict[str, int] = {}
    first, last = None, 0
    problems: list[str] = []
    try:
        for messages in container.chunks():
            for channel_id, _, log_ns, _, _ in messages:
                topic = container.topics.get(channel_id, "")
                counts[topic] = counts.get(topic, 0) + 1
                if topic == JOINTS.topic:
                    first = log_ns if first is None else min(first, log_ns)
                    last = max(last, log_ns)
    except LogError as error:
        problems.append(str(error))
    metadata, damaged = merge_metadata(container)
    problems += container.problems + damaged
    if is_being_written(path):
        state = "writing"
    elif container.complete:
        state = "damaged" if problems else "finished"
    else:
        state = "unfinished" if path.name.endswith(PART_SUFFIX) else "damaged"
    return LogSummary(
        path=path,
        state=state,
        ticks=counts.get(JOINTS.topic, 0),
        duration_s=(last - first) * 1e-9 if first is not None else 0.0,
        bytes=path.stat().st_size if path.exists() else 0,
        messages=counts,
        metadata=metadata,
        problems=tuple(problems),
    )
