"""Reads the MCAP container record by record: every length is checked before it is used, every checksum is compared.

The same code reads a finished log and a ``.part`` that ends anywhere, as after a power cut. What is damaged is left
out and told in ``problems``; what is returned has passed its checksum. The outer records are few and are parsed by the
``mcap`` package; messages are many and are cut out of their chunk here (see tools/bench_runlog).
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Header, Metadata
from mcap.writer import MCAP0_MAGIC

from snakebot.errors import LogError

MAX_CHUNK_BYTES = 64 << 20  # decompressed; ours have 1 MiB at most
MAX_ATTACHMENT_BYTES = 64 << 20
MAX_TOTAL_BYTES = 2 << 30  # decompressed: an hour at 500 Hz and 5 joints is 1.2 GB
MAX_RATIO = 400  # decompressed to compressed, beyond the first 64 MiB: a decompression bomb, not a log
MAX_CHANNELS = 1024

_RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, log time, publish time
_MESSAGE_FIXED = 22  # bytes of a message before its data
_CHUNK = struct.Struct("<QQQI")  # first time, last time, decompressed size, crc
_SMALL_RECORD = 16 << 20  # header, metadata: far more than ours need


class Message(NamedTuple):
    channel_id: int
    sequence: int
    log_time_ns: int
    publish_time_ns: int
    data: bytes


@dataclass
class Container:
    """A log file being read. Iterate ``messages`` once, to the end; the other fields are filled on the way."""

    path: Path
    problems: list[str] = field(default_factory=list)
    profile: str = ""
    topics: dict[int, str] = field(default_factory=dict)  # channel id -> topic
    channels: dict[int, Channel] = field(default_factory=dict)
    attachments: dict[str, Attachment] = field(default_factory=dict)
    metadata: list[Metadata] = field(default_factory=list)
    complete: bool = False  # closed properly: data end, footer and closing magic are there
    bytes_read: int = 0  # decompressed

    def messages(self) -> Iterator[Message]:
        """All messages in the order of the file.

        Raises:
            LogError: not an MCAP file, or one that would need more memory than any log.
        """
        for chunk in self.chunks():
            yield from self._in_chunk(chunk)

    def chunks(self) -> Iterator[bytes]:
        """The decompressed chunks whose checksum fits."""
        try:
            with self.path.open("rb") as file:
                size = self.path.stat().st_size
                if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
                    raise LogError(f"{self.path}: not an MCAP log")
                yield from self._outer_records(file, size)
        except OSError as error:
            raise LogError(f"{self.path}: cannot read the log: {error.strerror or error}") from None

    def _outer_records(self, file: BinaryIO, size: int) -> Iterator[bytes]:
        data_ended = False
        while True:
            offset = file.tell()
            head = file.read(_RECORD.size)
            if len(head) < _RECORD.size:
                if head or offset < size:
                    self.problems.append(f"cut short at byte {offset}")
                break
            opcode, length = _RECORD.unpack(head)
            if length > size - file.tell():
                self.problems.append(f"cut short or damaged at byte {offset}")
                break
            if opcode == Opcode.CHUNK:
                chunk = self._chunk(file.read(length), offset, size)
                if chunk is not None:
                    yield chunk
            elif opcode == Opcode.DATA_END:
                data_ended = True
                file.seek(length, 1)
            elif opcode == Opcode.FOOTER:
                file.seek(length, 1)
                self.complete = data_ended and length == 20 and file.read(9) == MCAP0_MAGIC
                if not self.complete:
                    self.problems.append(f"damaged at byte {offset}: what follows was not read")
                break
            elif opcode in (Opcode.ATTACHMENT, Opcode.HEADER, Opcode.METADATA, Opcode.CHANNEL):
                limit = MAX_ATTACHMENT_BYTES if opcode == Opcode.ATTACHMENT else _SMALL_RECORD
                if length > limit:
                    raise LogError(f"{self.path}: a record of {length} bytes at byte {offset} is no log's")
                self._small(opcode, file.read(length), offset)
            elif 0 < opcode <= Opcode.DATA_END:
                file.seek(length, 1)  # indexes and schemas: nothing the rows need
            else:
                self.problems.append(f"damaged at byte {offset}: what follows was not read")
                break

    def _small(self, opcode: int, body: bytes, offset: int) -> None:
        stream = ReadDataStream(BytesIO(body))
        try:
            if opcode == Opcode.HEADER:
                self.profile = Header.read(stream).profile
            elif opcode == Opcode.METADATA:
                self.metadata.append(Metadata.read(stream))
            elif opcode == Opcode.ATTACHMENT:
                self._attachment(Attachment.read(stream), body)
        except (McapError, struct.error, UnicodeDecodeError, ValueError):
            self.problems.append(f"damaged record at byte {offset}: left out")

    def _attachment(self, attachment: Attachment, body: bytes) -> None:
        (stored,) = struct.unpack("<I", body[-4:])
        if stored != zlib.crc32(body[:-4]):
            raise ValueError("checksum")
        self.attachments[attachment.name] = attachment

    def _chunk(self, body: bytes, offset: int, file_size: int) -> bytes | None:
        try:
            _, _, size, crc = _CHUNK.unpack_from(body)
            at = _CHUNK.size
            (name_length,) = struct.unpack_from("<I", body, at)
            compression = body[at + 4 : at + 4 + name_length].decode("ascii")
            at += 4 + name_length
            (packed_size,) = struct.unpack_from("<Q", body, at)
            packed = memoryview(body)[at + 8 :]
            if packed_size != len(packed):
                raise ValueError("size")
            self._admit(size, file_size, offset)
            data = _decompress(packed, compression, size)
            if len(data) != size or zlib.crc32(data) != crc:
                raise ValueError("checksum")
        except (struct.error, UnicodeDecodeError, ValueError):
            self.problems.append(f"damaged chunk at byte {offset}: its rows are left out")
            return None
        return data

    def _admit(self, size: int, file_size: int, offset: int) -> None:
        if size > MAX_CHUNK_BYTES:
            raise LogError(f"{self.path}: a chunk of {size} bytes at byte {offset} is no log's; not read")
        self.bytes_read += size
        if self.bytes_read > min(MAX_TOTAL_BYTES, MAX_CHUNK_BYTES + MAX_RATIO * file_size):
            raise LogError(
                f"{self.path}: {file_size} bytes unpack to more than {self.bytes_read >> 20} MiB; not read"
            )

    def _in_chunk(self, data: bytes) -> Iterator[Message]:
        at, end = 0, len(data)
        unpack, fixed, record_size = _MESSAGE.unpack_from, _MESSAGE.size, _RECORD.size
        try:
            while at < end:
                if data[at] == Opcode.MESSAGE:
                    _, length, channel, sequence, log_time, publish_time = unpack(data, at)
                    stop = at + record_size + length
                    if length < _MESSAGE_FIXED or stop > end:
                        raise ValueError("length")
                    yield Message(channel, sequence, log_time, publish_time, data[at + fixed : stop])
                else:
                    opcode, length = _RECORD.unpack_from(data, at)
                    stop = at + record_size + length
                    if stop > end:
                        raise ValueError("length")
                    if opcode == Opcode.CHANNEL:
                        self._channel(data[at + record_size : stop])
                at = stop
        except (struct.error, UnicodeDecodeError, ValueError, McapError):
            raise LogError(f"{self.path}: a chunk is not made of MCAP records; not a snakebot log") from None

    def _channel(self, body: bytes) -> None:
        channel = Channel.read(ReadDataStream(BytesIO(body)))
        if len(self.channels) >= MAX_CHANNELS:
            raise LogError(f"{self.path}: more than {MAX_CHANNELS} channels is no log's")
        self.channels[channel.id] = channel
        self.topics[channel.id] = channel.topic


def _decompress(packed: memoryview, compression: str, size: int) -> bytes:
    """Never makes more than ``size`` + 1 bytes, whatever the data says of itself."""
    if compression == "":
        return bytes(packed)
    if compression == "zstd":
        import zstandard

        reader = zstandard.ZstdDecompressor(max_window_size=MAX_CHUNK_BYTES).stream_reader(packed)
        try:
            return reader.read(size + 1)
        except zstandard.ZstdError as error:
            raise ValueError(str(error)) from None
    if compression == "lz4":
        import lz4.frame

        try:
            return bytes(lz4.frame.LZ4FrameDecompressor().decompress(packed, max_length=size + 1))
        except RuntimeError as error:
            raise ValueError(str(error)) from None
    raise ValueError(f"compression {compression!r}")
