"""The MCAP storage of a ROS 2 bag. Lengths are checked before they are used; a file that was cut short is read as far
as it goes."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator, Set
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Header, Schema
from mcap.records import Message as McapMessage
from mcap.writer import MCAP0_MAGIC

from snakebot.errors import BadInputError
from snakebot.runlog.container import MAX_CHANNELS, MAX_TOTAL_BYTES, NOT_AS_WRITTEN, decompress
from snakebot.runlog.foreign.ros_message import MAX_BAG_MESSAGE_BYTES, BagMessage, Topic
from snakebot.runlog.number_table import MAX_RATIO

MAX_BAG_CHUNK_BYTES = 32 << 20  # decompressed; rosbag2's presets have up to 4 MiB
MAX_STORED_BYTES = 64 << 20  # of one record

_READ: dict[int, Any] = {
    Opcode.HEADER: Header,
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.CHUNK: Chunk,
    Opcode.MESSAGE: McapMessage,
}
_RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time


def topics(path: Path, problems: list[str]) -> list[Topic]:
    """What topics a file has.

    Raises:
        BadInputError: not MCAP, or not a bag of ROS 2.
    """
    walk = _Walk(path, problems)
    for _ in walk.messages(frozenset()):
        pass
    return [
        Topic(channel.topic, schema.name if schema else "", _text(schema), channel.message_encoding)
        for channel in walk.channels.values()
        for schema in [walk.schemas.get(channel.schema_id)]
    ]


def messages(path: Path, wanted: Set[str], problems: list[str]) -> Iterator[BagMessage]:
    """The messages of some topics."""
    seen = len(problems)
    yield from _Walk(path, problems).messages(wanted)
    del problems[seen:]  # told when the topics were read


def _text(schema: Schema | None) -> str | None:
    if schema is None or schema.encoding != "ros2msg":
        return None
    return schema.data.decode("utf-8", "replace")


def _outer(file: BinaryIO, size: int) -> Iterator[Any]:
    """The records of a file, chunks unopened; nothing of a record is read beyond its end.

    Raises:
        NOT_AS_WRITTEN: a record is damaged, or the file ends before its end.
    """
    while True:
        opcode, length = _RECORD.unpack(file.read(_RECORD.size))
        if length > min(MAX_STORED_BYTES, size - file.tell()):
            raise ValueError("a record longer than its file")
        if opcode == Opcode.FOOTER:
            file.seek(length, 1)
            if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
                raise ValueError("does not end as it should")
            return
        body = file.read(length)
        if opcode in _READ:
            stream = ReadDataStream(BytesIO(body))
            yield McapMessage.read(stream, length) if opcode == Opcode.MESSAGE else _READ[opcode].read(stream)


class _Walk:
    """Once through a file: schemas and channels fill on the way."""

    def __init__(self, path: Path, problems: list[str]) -> None:
        self.path, self.problems = path, problems
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self._read_bytes = 0

    def messages(self, wanted: Set[str]) -> Iterator[BagMessage]:
        try:
            with self.path.open("rb") as file:
                self._allowed = min(
                    MAX_TOTAL_BYTES, MAX_BAG_CHUNK_BYTES + MAX_RATIO * self.path.stat().st_size
                )
                if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
                    raise BadInputError(f"{self.path}: not an MCAP file")
                yield from self._records(_outer(file, self.path.stat().st_size), wanted)
        except NOT_AS_WRITTEN as error:
            if not self.channels:
                said = str(error)[:80] or "cut short or damaged"
                raise BadInputError(f"{self.path}: not a whole MCAP file: {said}") from None
            self.problems.append(f"{self.path}: cut short or damaged; read as far as it goes")
        except OSError as error:
            raise BadInputError(f"{self.path}: cannot be read: {error.strerror or error}") from None

    def _records(self, records: Any, wanted: Set[str]) -> Iterator[BagMessage]:
        for record in records:
            if isinstance(record, Header) and record.profile == "snakebot":
                raise BadInputError(
                    f"{self.path}: a run log of snakebot: snakebot session make takes it as it is"
                )
            if isinstance(record, Chunk):
                yield from self._chunk(record, wanted)
            elif isinstance(record, McapMessage):
                yield from self._message(record.channel_id, record.log_time, record.data, wanted)
            else:
                self._declare(record)

    def _chunk(self, chunk: Chunk, wanted: Set[str]) -> Iterator[BagMessage]:
        size = chunk.uncompressed_size
        self._read_bytes += size
        if size > MAX_BAG_CHUNK_BYTES or self._read_bytes > self._allowed:
            raise BadInputError(f"{self.path}: unpacks to more than {self._allowed >> 20} MiB; not read")
        try:
            data = decompress(memoryview(chunk.data), chunk.compression, size)
            if len(data) != size or (chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc):
                raise ValueError("checksum")
        except ValueError:
            self.problems.append(f"{self.path}: a damaged chunk is left out")
            return
        at = 0
        while at + _RECORD.size <= size:
            opcode, length = _RECORD.unpack_from(data, at)
            at += _RECORD.size
            if length > size - at:
                raise ValueError("a record longer than its chunk")
            if opcode == 0x05 and length >= _MESSAGE.size:
                channel, _, log_ns, _ = _MESSAGE.unpack_from(data, at)
                yield from self._message(channel, log_ns, data[at + _MESSAGE.size : at + length], wanted)
            elif opcode == 0x03:
                self._declare(Schema.read(ReadDataStream(BytesIO(data[at : at + length]))))
            elif opcode == 0x04:
                self._declare(Channel.read(ReadDataStream(BytesIO(data[at : at + length]))))
            at += length

    def _declare(self, record: Any) -> None:
        if isinstance(record, Schema):
            self.schemas[record.id] = record
        elif isinstance(record, Channel):
            self.channels[record.id] = record
        if len(self.schemas) + len(self.channels) > 2 * MAX_CHANNELS:
            raise BadInputError(f"{self.path}: more than {MAX_CHANNELS} channels; not read")

    def _message(self, channel_id: int, log_ns: int, data: bytes, wanted: Set[str]) -> Iterator[BagMessage]:
        channel = self.channels.get(channel_id)
        if channel is None or channel.topic not in wanted:
            return
        if len(data) > MAX_BAG_MESSAGE_BYTES:
            raise BadInputError(
                f"{self.path}: a message of {channel.topic} is larger than {MAX_BAG_MESSAGE_BYTES >> 10} KiB; not read"
            )
        yield BagMessage(channel.topic, log_ns, data)
