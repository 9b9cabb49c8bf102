"""Reads the MCAP container: every length is checked before it is used, every checksum is compared.

The same code reads a finished log and a ``.part`` that ends anywhere, as after a power cut. What is damaged
is left out and told in ``problems``; what is returned has passed its checksum. The outer records are few and
are parsed by the ``mcap`` package; messages are many and are cut out of their chunk here.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Header, Metadata
from mcap.writer import MCAP0_MAGIC

from snakebot.errors import NothingLeftError, UnreadableLogError
from snakebot.runlog import channels
from snakebot.runlog.import_hint import import_hint
from snakebot.runlog.number_table import MAX_RATIO, TABLE_SUFFIXES

MAX_CHUNK_BYTES = 8 << 20  # decompressed; ours have about 256 KiB
MAX_RECORD_BYTES = 64 << 20  # as stored
MAX_TOTAL_BYTES = 2 << 30  # decompressed: an hour at 500 Hz and 5 joints is 1.5 GB
MAX_CHANNELS = 1024  # chosen: a log of ours has less than twenty

# What reading a damaged record raises: a length beyond 63 bits is an OverflowError.
NOT_AS_WRITTEN = (McapError, struct.error, ValueError, OverflowError)

_RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, log time, publish time
_MESSAGE_FIXED = 22  # bytes of a message before its data
_CHUNK = struct.Struct("<QQQI")  # first time, last time, decompressed size, crc

LogMessage = tuple[int, int, int, int, bytes]  # channel id, sequence, log time ns, publish time ns, data


@dataclass
class Container:
    """A log file being read: walk through ``chunks`` once, to the end; the other fields fill on the way."""

    path: Path
    problems: list[str] = field(default_factory=list)
    topics: dict[int, str] = field(default_factory=lambda: {c.id: c.topic for c in channels.CHANNELS})
    attachments: dict[str, Attachment] = field(default_factory=dict)
    metadata: list[Metadata] = field(default_factory=list)
    complete: bool = False  # closed properly: data end, footer and closing magic are there
    bytes_read: int = 0  # decompressed

    @cached_property
    def allowed_bytes(self) -> int:
        """Decompressed, in all; 10 kB may unpack to 12 MiB."""
        stored = self.path.stat().st_size if self.path.is_file() else 0
        return min(MAX_TOTAL_BYTES, MAX_CHUNK_BYTES + MAX_RATIO * stored)

    def chunks(self) -> Iterator[list[LogMessage]]:
        """The messages, a list a chunk, in the order of the file.

        Raises:
            UnreadableLogError: not a run log, or one that would need more memory than any log does.
        """
        try:
            with self.path.open("rb") as file:
                begins = file.read(len(MCAP0_MAGIC))
                if not begins.strip(b"\0"):
                    raise NothingLeftError(f"{self.path}: empty, or zeros: nothing of a log is left")
                if begins != MCAP0_MAGIC:
                    hint = ""
                    if self.path.name.endswith(TABLE_SUFFIXES):
                        hint = "; snakebot log import makes one of a table"
                    raise UnreadableLogError(f"{self.path}: not an MCAP log{hint}")
                self._header(file)
                size = self.path.stat().st_size
                for data in self._records(file, size):
                    yield self._cut(data)
        except OSError as error:
            raise UnreadableLogError(f"{self.path}: cannot read the log: {error.strerror or error}") from None

    def _header(self, file: BinaryIO) -> None:
        head = file.read(_RECORD.size)
        opcode, length = _RECORD.unpack(head) if len(head) == _RECORD.size else (0, 0)
        if opcode == Opcode.HEADER and length < 1 << 16:
            try:
                if Header.read(ReadDataStream(BytesIO(file.read(length)))).profile == channels.PROFILE:
                    return
            except NOT_AS_WRITTEN:
                pass  # said below
        raise UnreadableLogError(
            f"{self.path}: an MCAP file, but not a run log of snakebot{import_hint(self.path)}"
        )

    def _records(self, file: BinaryIO, size: int) -> Iterator[bytes]:
        """Go through the outer records; yields the decompressed chunks whose checksum fits."""
        data_ended = False
        while True:
            offset = file.tell()
            head = file.read(_RECORD.size)
            opcode, length = _RECORD.unpack(head) if len(head) == _RECORD.size else (0, 0)
            if not head:
                return  # ends between two records: was not closed
            if length > size - file.tell() or len(head) < _RECORD.size:
                self.problems.append(f"cut short or damaged at byte {offset}: what follows was not read")
            elif opcode == Opcode.FOOTER:
                file.seek(length, 1)
                self.complete = data_ended and length == 20 and file.read(9) == MCAP0_MAGIC
                if not self.complete:
                    self.problems.append(f"damaged at byte {offset}: the log does not end as it should")
            elif not 0 < opcode <= Opcode.DATA_END:
                self.problems.append(f"damaged at byte {offset}: what follows was not read")
            else:
                data_ended = data_ended or opcode == Opcode.DATA_END
                yield from self._record(file, opcode, length, offset)
                continue
            return

    def _record(self, file: BinaryIO, opcode: int, length: int, offset: int) -> Iterator[bytes]:
        if opcode not in (Opcode.CHUNK, Opcode.ATTACHMENT, Opcode.METADATA):
            file.seek(length, 1)  # indexes, schemas, statistics: nothing that the rows need
            return
        if length > MAX_RECORD_BYTES:
            raise UnreadableLogError(
                f"{self.path}: byte {offset}: a record of {length} bytes is no log's; not read"
            )
        body = file.read(length)
        try:
            if opcode == Opcode.CHUNK:
                yield self._chunk(body, offset)
            elif opcode == Opcode.METADATA:
                self._admit(length)
                self.metadata.append(Metadata.read(ReadDataStream(BytesIO(body))))
            else:
                self._admit(length)
                self._attachment(body)
        except NOT_AS_WRITTEN:
            what = "chunk" if opcode == Opcode.CHUNK else Opcode(opcode).name.lower()
            self.problems.append(f"damaged {what} at byte {offset}: left out")

    def _attachment(self, body: bytes) -> None:
        attachment = Attachment.read(ReadDataStream(BytesIO(body)))
        (stored,) = struct.unpack("<I", body[-4:])
        if stored != zlib.crc32(body[:-4]):
            raise ValueError("checksum")
        self.attachments[attachment.name] = attachment

    def _chunk(self, body: bytes, offset: int) -> bytes:
        _, _, size, crc = _CHUNK.unpack_from(body)
        at = _CHUNK.size
        (name_length,) = struct.unpack_from("<I", body, at)
        compression = body[at + 4 : at + 4 + name_length].decode("ascii")
        at += 4 + name_length
        (stored_size,) = struct.unpack_from("<Q", body, at)
        stored = memoryview(body)[at + 8 :]
        if stored_size != len(stored):
            raise ValueError("size")
        if size > MAX_CHUNK_BYTES:
            raise UnreadableLogError(
                f"{self.path}: byte {offset}: a chunk of {size} bytes is no log's; not read"
            )
        self._admit(size)
        data = decompress(stored, compression, size)
        if len(data) != size or zlib.crc32(data) != crc:
            raise ValueError("checksum")
        return data

    def _admit(self, size: int) -> None:
        self.bytes_read += size
        if self.bytes_read > self.allowed_bytes:
            raise UnreadableLogError(
                f"{self.path}: unpacks to more than {self.allowed_bytes >> 20} MiB; not read"
            )

    def _cut(self, data: bytes) -> list[LogMessage]:
        """The messages of a chunk. Written for speed: one struct call and one slice a message."""
        messages: list[LogMessage] = []
        append, unpack, message = messages.append, _MESSAGE.unpack_from, int(Opcode.MESSAGE)
        at, end = 0, len(data)
        try:
            while at < end:
                if data[at] == message:
                    _, length, channel_id, sequence, log_ns, publish_ns = unpack(data, at)
                    stop = at + 9 + length
                    if length < _MESSAGE_FIXED or stop > end:
                        raise ValueError("length")
                    append((channel_id, sequence, log_ns, publish_ns, data[at + 31 : stop]))
                else:
                    opcode, length = _RECORD.unpack_from(data, at)
                    stop = at + 9 + length
                    if stop > end:
                        raise ValueError("length")
                    if opcode == Opcode.CHANNEL:
                        self._channel(data[at + 9 : stop])
                at = stop
        except NOT_AS_WRITTEN:
            raise UnreadableLogError(
                f"{self.path}: a chunk is not made of MCAP records; not a snakebot log"
            ) from None
        return messages

    def _channel(self, body: bytes) -> None:
        channel = Channel.read(ReadDataStream(BytesIO(body)))
        if len(self.topics) >= MAX_CHANNELS:
            raise UnreadableLogError(f"{self.path}: more than {MAX_CHANNELS} channels; no log has so many")
        self.topics[channel.id] = channel.topic


def decompress(stored: memoryview, compression: str, size: int) -> bytes:
    """Never makes more than ``size`` + 1 bytes, whatever the data says of itself."""
    if compression == "":
        return bytes(stored)
    if compression == "zstd":
        import zstandard

        try:
            window = MAX_CHUNK_BYTES
            reader = zstandard.ZstdDecompressor(max_window_size=window).stream_reader(stored)
            return bytes(reader.read(size + 1))
        except zstandard.ZstdError as error:
            raise ValueError(str(error)) from None
    if compression == "lz4":
        import lz4.frame  # type: ignore[import-untyped]

        try:
            return bytes(lz4.frame.LZ4FrameDecompressor().decompress(stored, max_length=size + 1))
        except RuntimeError as error:
            raise ValueError(str(error)) from None
    raise ValueError(f"compression {compression!r}")
