"""The unfinished log on disk: MCAP without an index, in small uncompressed chunks that each carry a checksum."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Header, Metadata, Schema
from mcap.writer import MCAP0_MAGIC

from snakebot.errors import LogError
from snakebot.robot import Robot
from snakebot.runlog import channels, metadata
from snakebot.runlog.finish import sync_folder
from snakebot.runlog.lock import lock

_MESSAGE = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, log time, publish time
_CHUNK_HEAD = struct.Struct("<BQQQQIIQ")  # opcode, length, times, size, crc, no compression, size


class PartFile:
    """A new ``.part``, locked while it is open.

    Raises:
        FileExistsError: the name is taken.
        LogError: it cannot be made.
    """

    def __init__(self, path: Path, start: bytes) -> None:
        self.path = path
        self.good_bytes = 0  # up to here the file is whole
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise LogError(f"{path}: cannot make the log: {error.strerror}") from None
        try:
            self._file = os.open(path, flags, 0o644)
        except OSError as error:
            # Whoever was first may have finished meanwhile: then it is no longer there, but the name is taken.
            if isinstance(error, FileExistsError) or os.path.lexists(path):
                raise FileExistsError(error.errno, "exists already", str(path)) from None
            raise LogError(f"{path}: cannot make the log: {error.strerror}") from None
        lock(self._file)
        try:
            self.write(start)
            sync_folder(path.parent)
        except OSError as error:
            self.close()
            path.unlink(missing_ok=True)
            raise LogError(f"{path}: cannot make the log: {error.strerror}") from None

    def write(self, data: bytes) -> None:
        """Hand whole records to the system; on a failure the file is cut back to the last whole one."""
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[os.write(self._file, rest) :]
        except OSError:
            self._cut_back()
            raise
        self.good_bytes += len(data)

    def _cut_back(self) -> None:
        try:
            os.ftruncate(self._file, self.good_bytes)
            os.lseek(self._file, self.good_bytes, os.SEEK_SET)
        except OSError:
            return  # a reader leaves the torn record out

    def sync(self) -> None:
        """Wait until what was written is on the disk."""
        getattr(os, "fdatasync", os.fsync)(self._file)

    def close(self) -> None:
        os.close(self._file)


def message(channel_id: int, sequence: int, log_ns: int, publish_ns: int, data: bytes) -> bytes:
    """One message record."""
    head = _MESSAGE.pack(
        Opcode.MESSAGE, 22 + len(data), channel_id, sequence & 0xFFFFFFFF, log_ns, publish_ns
    )
    return head + data


def chunk(messages: Sequence[bytes]) -> bytes:
    """A chunk of message records; not compressed, so that nothing is lost in a compressor's buffer."""
    times = [_MESSAGE.unpack_from(record)[4] for record in messages]
    return _chunk(b"".join(messages), min(times), max(times))


def _chunk(data: bytes, first_ns: int, last_ns: int) -> bytes:
    length = 40 + len(data)
    head = (Opcode.CHUNK, length, first_ns, last_ns, len(data), zlib.crc32(data), 0, len(data))
    return _CHUNK_HEAD.pack(*head) + data


def metadata_record(values: Mapping[str, Any]) -> bytes:
    """A metadata record of the run; later ones add to earlier ones."""
    builder = RecordBuilder()
    Metadata(name=metadata.RECORD_NAME, metadata=metadata.to_strings(values)).write(builder)
    return _built(builder)


def beginning(
    robot: Robot, run: Mapping[str, Any], attachments: Mapping[str, bytes], start_time_ns: int
) -> bytes:
    """What precedes the first tick: header, attachments, metadata, schemas and channels."""
    from snakebot import __version__

    builder = RecordBuilder()
    builder.write(MCAP0_MAGIC)
    Header(profile=channels.PROFILE, library=f"snakebot {__version__}").write(builder)
    for name, data in {channels.ROBOT_ATTACHMENT: robot.to_yaml().encode(), **attachments}.items():
        Attachment(start_time_ns, start_time_ns, name, _media_type(name), bytes(data)).write(builder)
    about = {"start_time_ns": start_time_ns, "joints": robot.joints, "robot": robot.name}
    builder.write(metadata_record({**about, **run}))
    declarations = RecordBuilder()
    for channel in channels.CHANNELS:
        number = channel.id
        Schema(number, channel.schema, channels.SCHEMA_ENCODING, channel.schema_name).write(declarations)
        Channel(number, channel.topic, channels.MESSAGE_ENCODING, {}, number).write(declarations)
    builder.write(_chunk(_built(declarations), 0, 0))
    return _built(builder)


def _built(builder: RecordBuilder) -> bytes:
    return bytes(builder.end())


def _media_type(name: str) -> str:
    return {".yaml": "application/yaml", ".json": "application/json"}.get(Path(name).suffix, "text/plain")
