"""Writes a run log while the robot moves, without ever making the run loop wait for a disk.

A call encodes its record and puts it on a queue: a few microseconds, no lock, no I/O. One thread gathers the
queue into small MCAP chunks with a checksum and hands them to the system every ``flush_s``; from there they
survive the process (kill -9). A second thread asks for them to reach the disk (fdatasync), so that a slow
disk holds up neither the run loop nor the first thread; from there they survive a power cut.
"""

from __future__ import annotations

import os
import struct
import threading
import time
import zlib
from collections import deque
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Header, Metadata, Schema
from mcap.writer import MCAP0_MAGIC

from snakebot.errors import LogError
from snakebot.robot import Robot
from snakebot.runlog import channels, metadata
from snakebot.runlog.finish import finish, sync_folder
from snakebot.runlog.lock import lock
from snakebot.runlog.naming import PART_SUFFIX, final_path
from snakebot.runlog.records import Event, LinkStatistics, Pose, RawFrame, Telemetry, Tick

FLUSH_S = 0.2  # with the time to sync, well within the half second that a crash may cost
CHUNK_BYTES = 16 << 10
MAX_QUEUE_BYTES = 64 << 20  # a disk that hangs for minutes is reported, not buffered without end

_MESSAGE = struct.Struct("<BQHIQQ")
_CHUNK_HEAD = struct.Struct("<BQQQQI")


class RunWriter:
    """One run on its way to disk: ``<path>.part`` while it runs, ``<path>`` once closed.

    Args:
        path: final name; ``.mcap`` is added where it is missing. Neither it nor its ``.part`` may exist.
        robot: attached as ``robot.yaml``.
        metadata: what describes the run (gait, faults, port, versions, ...): anything JSON can carry.
        attachments: further files to carry, by name (the DBC, an effects file).
        start_time_ns: wall clock at t_s = 0. Log times are this plus ``t_s``, so that setting the wall clock
            in mid-run does not disorder the log; the wall clock of each tick is kept as its publish time.
        flush_s: longest time that a record waits in this process.
        sync_s: longest time between two requests to reach the disk.

    Raises:
        LogError: the log cannot be made. Every later call raises it too, in one clear line, as soon as a
            record could not be written; what was written until then stays readable.

    Calls may come from any thread; ``close`` waits for the disk, so call it when the robot is safe.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        robot: Robot,
        metadata: Mapping[str, Any] | None = None,
        *,
        attachments: Mapping[str, bytes] | None = None,
        start_time_ns: int | None = None,
        flush_s: float = FLUSH_S,
        sync_s: float = FLUSH_S,
    ) -> None:
        self.path = final_path(path)
        self.part_path = self.path.with_name(self.path.name + PART_SUFFIX)
        self.joints = robot.joints
        self.start_time_ns = time.time_ns() if start_time_ns is None else start_time_ns
        self._queue: deque[bytes] = deque()
        self._queued_bytes = 0
        self._written_bytes = 0
        self._sequence = dict.fromkeys((channel.id for channel in channels.CHANNELS), 0)
        self._error: str | None = None
        self._reported = False
        self._closed = False
        self._flush_s, self._sync_s = flush_s, sync_s
        self._wake = threading.Event()
        self._file = self._create()
        self._good_bytes = 0
        try:
            self._write(self._preamble(robot, metadata or {}, attachments or {}))
            sync_folder(self.path.parent)
        except OSError as error:
            os.close(self._file)
            self.part_path.unlink(missing_ok=True)
            raise LogError(f"{self.part_path}: cannot write the log: {error.strerror}") from None
        self._thread = threading.Thread(target=self._write_loop, name="runlog-writer", daemon=True)
        self._syncer = threading.Thread(target=self._sync_loop, name="runlog-sync", daemon=True)
        self._stop_sync = threading.Event()
        self._thread.start()
        self._syncer.start()

    # --- called from the run loop

    def tick(self, tick: Tick) -> None:
        """Record one tick. Its arrays are copied: the caller may use them again."""
        joints = self.joints
        for values in (tick.setpoint_rad, tick.sent_rad, tick.applied_rad, tick.measured_rad):
            if values is not None and len(values) != joints:
                raise LogError(
                    f"{self.path}: tick {tick.sequence} has {len(values)} values for {joints} joints"
                )
        self._put(
            channels.JOINTS.id, tick.t_s, channels.encode_tick(tick), tick.sequence, max(0, tick.host_time_ns)
        )

    def pose(self, pose: Pose) -> None:
        """Record where the robot is."""
        self._put(channels.POSE.id, pose.t_s, channels.encode_pose(pose, self.start_time_ns))

    def event(self, event: Event) -> None:
        """Record that something happened."""
        self._put(channels.EVENTS.id, event.t_s, channels.encode_event(event, self.start_time_ns))

    def link_statistics(self, statistics: LinkStatistics) -> None:
        """Record the link's counters."""
        self._put(channels.LINK.id, statistics.t_s, channels.encode_link(statistics))

    def telemetry(self, telemetry: Telemetry) -> None:
        """Record further readings: supply, currents, temperatures."""
        self._put(channels.TELEMETRY.id, telemetry.t_s, channels.encode_telemetry(telemetry))

    def frame(self, frame: RawFrame) -> None:
        """Record one frame of the wire."""
        self._put(channels.FRAMES.id, frame.t_s, channels.encode_frame(frame))

    def add_metadata(self, more: Mapping[str, Any]) -> None:
        """Add to the run's metadata, or replace values of it: how the run ended, a speed measured later."""
        self._check()
        self._append(_metadata_record(more))

    def _put(
        self,
        channel_id: int,
        t_s: float,
        data: bytes,
        sequence: int | None = None,
        publish_ns: int | None = None,
    ) -> None:
        self._check()
        if sequence is None:
            sequence = self._sequence[channel_id]
            self._sequence[channel_id] = sequence + 1
        log_ns = max(0, self.start_time_ns + round(t_s * 1e9))
        head = _MESSAGE.pack(
            Opcode.MESSAGE,
            22 + len(data),
            channel_id,
            sequence & 0xFFFFFFFF,
            log_ns,
            log_ns if publish_ns is None else publish_ns,
        )
        self._append(head + data)

    def _append(self, record: bytes) -> None:
        self._queue.append(record)
        self._queued_bytes += len(record)
        if self._queued_bytes - self._written_bytes > MAX_QUEUE_BYTES:
            self._fail("the disk does not keep up")
            self._check()

    def _check(self) -> None:
        if self._error is not None:
            self._reported = True
            raise LogError(self._error)
        if self._closed:
            raise LogError(f"{self.path}: the log is closed")

    # --- closing

    def close(self) -> Path:
        """Write what is left, compress, add the index and give the log its final name. Returns that name.

        Raises:
            LogError: it could not be written whole; what was written stays in the ``.part``.
        """
        if self._closed:
            return self.path
        self._closed = True
        self._wake.set()
        self._thread.join()
        self._stop_sync.set()
        self._syncer.join()
        try:
            os.fsync(self._file)
        except OSError as error:
            self._fail(error.strerror or str(error))
        finally:
            os.close(self._file)
        if self._error is not None:
            if self._reported:
                return self.part_path
            raise LogError(self._error)
        finish(self.part_path, self.path)
        return self.path

    def __enter__(self) -> RunWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None:
            self.close()
            return
        try:
            self.close()
        except LogError as second:
            error.add_note(str(second))

    # --- the two threads

    def _write_loop(self) -> None:
        while True:
            last = self._wake.wait(self._flush_s)
            try:
                self._drain()
            except OSError as error:
                self._undo_torn_chunk()
                self._fail(error.strerror or str(error))
            if last or self._error is not None:
                return

    def _sync_loop(self) -> None:
        synced = -1
        while not self._stop_sync.wait(self._sync_s):
            if self._good_bytes != synced:
                synced = self._good_bytes
                try:
                    os.fdatasync(self._file) if hasattr(os, "fdatasync") else os.fsync(self._file)
                except OSError as error:
                    self._fail(error.strerror or str(error))

    def _drain(self) -> None:
        batch: list[bytes] = []
        size = 0
        for _ in range(len(self._queue)):
            record = self._queue.popleft()
            if record[0] != Opcode.MESSAGE:
                self._write_chunk(batch)
                batch, size = [], 0
                self._write(record)
                self._written_bytes += len(record)
                continue
            batch.append(record)
            size += len(record)
            if size >= CHUNK_BYTES:
                self._write_chunk(batch)
                batch, size = [], 0
        self._write_chunk(batch)

    def _write_chunk(self, batch: list[bytes]) -> None:
        if batch:
            data = b"".join(batch)
            times = [_MESSAGE.unpack_from(record)[4] for record in batch]
            self._write(_chunk(data, min(times), max(times)))
            self._written_bytes += len(data)

    def _write(self, data: bytes) -> None:
        rest = memoryview(data)
        while rest:
            rest = rest[os.write(self._file, rest) :]
        self._good_bytes += len(data)

    def _undo_torn_chunk(self) -> None:
        """After a failed write, end the file where the last whole chunk ended."""
        try:
            os.ftruncate(self._file, self._good_bytes)
        except OSError:
            return  # a reader leaves the torn chunk out

    def _fail(self, why: str) -> None:
        if self._error is None:
            self._error = (
                f"{self.part_path}: the log cannot be written any further: {why}; what was written until "
                "then can be read as it is, or finished with 'snakebot log recover'"
            )

    # --- the start of the file

    def _create(self) -> int:
        if self.path.exists():
            raise LogError(f"{self.path}: exists already; a log is never overwritten")
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            file = os.open(self.part_path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644)
        except FileExistsError:
            raise LogError(f"{self.part_path}: exists already; a log is never overwritten") from None
        except OSError as error:
            raise LogError(f"{self.part_path}: cannot make the log: {error.strerror}") from None
        lock(file)
        return file

    def _preamble(self, robot: Robot, run: Mapping[str, Any], attachments: Mapping[str, bytes]) -> bytes:
        from snakebot import __version__

        now_ns = self.start_time_ns
        builder = RecordBuilder()
        builder.write(MCAP0_MAGIC)
        Header(profile=channels.PROFILE, library=f"snakebot {__version__}").write(builder)
        files = {channels.ROBOT_ATTACHMENT: robot.to_yaml().encode(), **attachments}
        for name, data in files.items():
            Attachment(now_ns, now_ns, name, _media_type(name), bytes(data)).write(builder)
        builder.write(
            _metadata_record({"start_time_ns": now_ns, "joints": robot.joints, "robot": robot.name, **run})
        )
        declarations = RecordBuilder()
        for channel in channels.CHANNELS:
            number = channel.id
            Schema(number, channel.schema, channels.SCHEMA_ENCODING, channel.schema_name).write(declarations)
            Channel(number, channel.topic, channels.MESSAGE_ENCODING, {}, number).write(declarations)
        builder.write(_chunk(_built(declarations), 0, 0))
        return _built(builder)


def _chunk(data: bytes, first_ns: int, last_ns: int) -> bytes:
    """An uncompressed chunk record: small enough that compressing it would cost more than it saves."""
    length = 8 + 8 + 8 + 4 + 4 + 8 + len(data)
    head = _CHUNK_HEAD.pack(Opcode.CHUNK, length, first_ns, last_ns, len(data), zlib.crc32(data))
    return head + struct.pack("<IQ", 0, len(data)) + data


def _built(builder: RecordBuilder) -> bytes:
    return bytes(builder.end())  # type: ignore[no-untyped-call]


def _metadata_record(values: Mapping[str, Any]) -> bytes:
    builder = RecordBuilder()
    Metadata(name=metadata.RECORD_NAME, metadata=metadata.to_strings(values)).write(builder)
    return _built(builder)


def _media_type(name: str) -> str:
    return {".yaml": "application/yaml", ".json": "application/json"}.get(Path(name).suffix, "text/plain")
