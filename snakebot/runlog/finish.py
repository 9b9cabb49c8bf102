"""Turns a ``.part`` into a finished log: compressed, indexed, under its final name in one step."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer

from snakebot.errors import LogError
from snakebot.runlog import channels, metadata
from snakebot.runlog.container import Container

CHUNK_BYTES = 1 << 20
TEMPORARY_SUFFIX = ".tmp"


def finish(source: Path, target: Path, extra_metadata: Mapping[str, Any] | None = None) -> list[str]:
    """Rewrite ``source`` (unfinished, damaged or whole) as the finished log ``target``.

    The new file is complete on disk before it takes the name ``target``; ``source`` goes only then.

    Returns:
        What was damaged in ``source`` and left out, a line each.

    Raises:
        LogError: ``source`` is not a log, or ``target`` cannot be written; ``source`` is left as it was.
    """
    temporary = target.with_name(target.name + TEMPORARY_SUFFIX)
    try:
        with temporary.open("wb") as file:
            problems = _rewrite(source, file, extra_metadata or {})
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, target)
        if source != target:
            source.unlink()
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise LogError(
            f"{target}: cannot finish the log: {error.strerror or error}; all of it is in {source}"
        ) from None
    except LogError:
        temporary.unlink(missing_ok=True)
        raise
    sync_folder(target.parent)
    return problems


def _rewrite(source: Path, file: Any, extra_metadata: Mapping[str, Any]) -> list[str]:
    container = Container(source)
    writer = Writer(file, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD)
    started = False
    ids: dict[int, int] = {}
    by_topic = {channel.topic: channel for channel in channels.CHANNELS}
    for message in container.messages():
        if not started:
            _start(writer, container)
            started = True
        channel_id = ids.get(message.channel_id)
        if channel_id is None:
            channel = by_topic.get(container.topics.get(message.channel_id, ""))
            if channel is None:
                continue  # no channel of ours: its declaration was damaged
            schema_id = writer.register_schema(channel.schema_name, channels.SCHEMA_ENCODING, channel.schema)
            channel_id = writer.register_channel(channel.topic, channels.MESSAGE_ENCODING, schema_id)
            ids[message.channel_id] = channel_id
        writer.add_message(
            channel_id, message.log_time_ns, message.data, message.publish_time_ns, message.sequence
        )
    if not started:
        _start(writer, container)
    merged, damaged = merge_metadata(container)
    merged.update(extra_metadata)
    writer.add_metadata(metadata.RECORD_NAME, metadata.to_strings(merged))
    writer.finish()
    return container.problems + damaged


def _start(writer: Writer, container: Container) -> None:
    if container.profile != channels.PROFILE:
        raise LogError(f"{container.path}: an MCAP file, but not a run log of snakebot")
    from snakebot import __version__

    writer.start(profile=channels.PROFILE, library=f"snakebot {__version__}")
    for name, item in container.attachments.items():
        writer.add_attachment(item.create_time, item.log_time, name, item.media_type, item.data)


def merge_metadata(container: Container) -> tuple[dict[str, Any], list[str]]:
    """All metadata records of the run in their order, later values over earlier ones, and what was damaged."""
    merged: dict[str, Any] = {}
    damaged = []
    for record in container.metadata:
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
