"""Turns a ``.part`` into a finished log: compressed, indexed, under its final name in one step."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from mcap.records import Metadata
from mcap.writer import CompressionType, Writer

from snakebot.errors import LogError, UnreadableLogError
from snakebot.runlog import channels, metadata
from snakebot.runlog.container import Container
from snakebot.runlog.naming import numbered
from snakebot.whole_files import take_name

FINISHED_CHUNK_BYTES = 256 << 10  # what one flipped bit can cost: a few seconds
TEMPORARY_SUFFIX = ".tmp"


@dataclass(frozen=True)
class Changes:
    """What is different in the rewritten log."""

    metadata: Mapping[str, Any] = field(default_factory=dict)  # added, or in place of older values
    drop_topics: frozenset[str] = frozenset()
    messages: Sequence[tuple[str, int, bytes]] = ()  # topic, log time ns, data; added at the end


class Finished(NamedTuple):
    path: Path
    problems: list[str]  # what was damaged and left out, a line each


def finish(
    source: Path,
    target: Path,
    changes: Changes | None = None,
    *,
    keep_source: bool = False,
    or_numbered: bool = False,
) -> Finished:
    """Rewrite ``source`` (unfinished, damaged or whole) as the finished log ``target``.

    The new file is complete on disk before it takes the name ``target``; ``source`` goes only then. Nothing but
    ``source`` itself is replaced.

    Args:
        or_numbered: where the name is taken, take the next free number.

    Raises:
        LogError: ``source`` is not a log, or ``target`` exists or cannot be written; ``source`` is left as it was.
    """
    temporary = target.with_name(target.name + TEMPORARY_SUFFIX)
    try:
        temporary.unlink(missing_ok=True)  # left by a crash; or a link, laid there to be written through
        with temporary.open("xb") as file:
            problems = _rewrite(source, file, changes or Changes())
            file.flush()
            os.fsync(file.fileno())
        if source == target:
            os.replace(temporary, target)
        else:
            target = _named(temporary, target, or_numbered)
            if not keep_source:
                source.unlink()
        sync_folder(target.parent)
    except FileExistsError:
        temporary.unlink(missing_ok=True)
        raise LogError(
            f"{target}: exists already; a log is never overwritten; all of it is in {source}"
        ) from None
    except UnreadableLogError:
        temporary.unlink(missing_ok=True)
        if source.exists():
            raise
        raise LogError(f"{target}: cannot finish the log: somebody has removed {source}") from None
    except OSError as error:
        temporary.unlink(missing_ok=True)
        why = error.strerror or error
        raise LogError(f"{target}: cannot finish the log: {why}; all of it is in {source}") from None
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    return Finished(target, problems)


def _named(temporary: Path, target: Path, or_numbered: bool) -> Path:
    """The first of the names that was free."""
    for path in numbered(target) if or_numbered else (target,):
        try:
            take_name(temporary, path)
        except FileExistsError:
            continue
        return path
    raise FileExistsError(target)


def _rewrite(source: Path, file: BinaryIO, changes: Changes) -> list[str]:
    from snakebot import __version__

    container = Container(source)
    writer = Writer(file, chunk_size=FINISHED_CHUNK_BYTES, compression=CompressionType.ZSTD)
    writer.start(profile=channels.PROFILE, library=f"snakebot {__version__}")
    numbers = {}
    for channel in channels.CHANNELS:  # in the order of their ids, so that the ids stay the same
        schema_id = writer.register_schema(channel.schema_name, channels.SCHEMA_ENCODING, channel.schema)
        numbers[channel.topic] = writer.register_channel(channel.topic, channels.MESSAGE_ENCODING, schema_id)
    for messages in container.chunks():
        for channel_id, sequence, log_ns, publish_ns, data in messages:
            topic = container.topics.get(channel_id, "")
            number = numbers.get(topic)
            if number is not None and topic not in changes.drop_topics:
                writer.add_message(number, log_ns, data, publish_ns, sequence)
    for sequence, (topic, log_ns, data) in enumerate(changes.messages):
        writer.add_message(numbers[topic], log_ns, data, log_ns, sequence)
    for name, item in container.attachments.items():
        writer.add_attachment(item.create_time, item.log_time, name, item.media_type, item.data)
    merged, damaged = merge_metadata(container.metadata)
    merged.update(changes.metadata)
    writer.add_metadata(metadata.RECORD_NAME, metadata.to_strings(merged))
    writer.finish()
    return container.problems + damaged


def merge_metadata(records: Iterable[Metadata]) -> tuple[dict[str, Any], list[str]]:
    """All metadata of the run, later records over earlier ones; and what was damaged."""
    merged: dict[str, Any] = {}
    damaged = []
    for record in records:
        if record.name == metadata.RECORD_NAME:
            values = metadata.from_strings(record.metadata)
            if values is None:
                damaged.append("damaged metadata: left out")
            else:
                merged.update(values)
    return merged, damaged


def sync_folder(folder: Path) -> None:
    """Make a new name in a folder survive a power cut, where the system can."""
    if not hasattr(os, "O_DIRECTORY"):
        return
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
