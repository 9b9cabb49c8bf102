"""What is in a folder of logs, without decoding a row."""

from __future__ import annotations

import math
import os
import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, McapRecord, Metadata, MetadataIndex, Statistics
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC

from snakebot.errors import LogError
from snakebot.runlog.channels import JOINTS
from snakebot.runlog.container import NOT_AS_WRITTEN, Container
from snakebot.runlog.finish import merge_metadata
from snakebot.runlog.lock import is_being_written
from snakebot.runlog.log import ended
from snakebot.runlog.naming import PART_SUFFIX, SUFFIX

MAX_INDEX_BYTES = 16 << 20  # chosen: the index of a day's run is smaller
_END = struct.Struct("<BQQQI8s")  # footer: opcode, length, summary, summary offsets, crc; closing magic


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

    @property
    def ended(self) -> str | None:
        """How the run ended; None where that is not known, or it goes on."""
        return None if self.state == "writing" else ended(self.metadata, self.state == "finished")

    @property
    def speed_m_s(self) -> float | None:
        """Forward speed that was given with the run, or else that of its pose over the last cycles."""
        for key in ("forward_speed_m_s", "steady_speed_m_s"):
            value = self.metadata.get(key)
            if isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value):
                return value
        return None


def find_logs(folder: str | os.PathLike[str]) -> Iterator[Path]:
    """Finished and unfinished logs in a folder, by name (which is by time)."""
    paths = (path for path in Path(folder).iterdir() if path.is_file())
    yield from sorted(path for path in paths if path.name.endswith((SUFFIX, SUFFIX + PART_SUFFIX)))


def summarize(path: str | os.PathLike[str], thorough: bool = False) -> LogSummary:
    """What a log holds, from the index of a finished one, else by going through it.

    Args:
        thorough: go through it in any case, every checksum compared: only so is damage in mid-file noticed.

    A file that is no log is ``damaged``, not an error.
    """
    path = Path(path)
    if not thorough and path.name.endswith(SUFFIX):
        indexed = _from_index(path)
        if indexed is not None:
            return indexed
    return _from_messages(path)


def _from_messages(path: Path) -> LogSummary:
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
    metadata, damaged = merge_metadata(container.metadata)
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


def _from_index(path: Path) -> LogSummary | None:
    """The summary section at the end of a finished log; None where it is not whole."""
    try:
        with path.open("rb") as file:
            size = path.stat().st_size
            records = list(_summary_records(file, size))
            statistics = next(record for record in records if isinstance(record, Statistics))
            topics = {record.id: record.topic for record in records if isinstance(record, Channel)}
            metadata = [
                _metadata_at(file, size, index) for index in records if isinstance(index, MetadataIndex)
            ]
    except (OSError, StopIteration, *NOT_AS_WRITTEN):
        return None
    merged, damaged = merge_metadata(metadata)
    if damaged:
        return None
    counts = {topics.get(number, ""): count for number, count in statistics.channel_message_counts.items()}
    return LogSummary(
        path=path,
        state="finished",
        ticks=counts.get(JOINTS.topic, 0),
        duration_s=(statistics.message_end_time - statistics.message_start_time) * 1e-9,
        bytes=size,
        messages={topic: count for topic, count in counts.items() if count},
        metadata=merged,
        problems=(),
    )


def _summary_records(file: BinaryIO, size: int) -> Iterator[McapRecord]:
    file.seek(max(0, size - _END.size))
    opcode, length, start, _, crc, magic = _END.unpack(file.read(_END.size))
    end = size - _END.size
    if (opcode, length, magic) != (
        Opcode.FOOTER,
        20,
        MCAP0_MAGIC,
    ) or not 0 < start <= end <= start + MAX_INDEX_BYTES:
        raise ValueError("no summary")
    file.seek(start)
    data = file.read(size - start)
    if zlib.crc32(data[: -len(MCAP0_MAGIC) - 4]) != crc:  # it covers the footer up to itself
        raise ValueError("checksum")
    yield from StreamReader(BytesIO(data), skip_magic=True).records


def _metadata_at(file: BinaryIO, size: int, index: MetadataIndex) -> Metadata:
    if not 9 < index.length <= min(size, MAX_INDEX_BYTES):
        raise ValueError("length")
    file.seek(index.offset + 9)
    record: Metadata = Metadata.read(ReadDataStream(BytesIO(file.read(index.length - 9))))
    return record
