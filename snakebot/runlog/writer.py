"""Writes a run log while the robot moves, without ever making the run loop wait for a disk.

A call encodes its record and puts it on a queue: a few microseconds, no lock, no I/O. One thread gathers the
queue into small MCAP chunks with a checksum and hands them to the system every ``flush_s``; from there they
survive the process (kill -9). A second thread asks for them to reach the disk (fdatasync), so that a slow
disk holds up neither the run loop nor the first thread; from there they survive a power cut.
"""

from __future__ import annotations

import os
import threading
import time
import warnings
from collections import deque
from collections.abc import Callable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

from mcap.opcode import Opcode

from snakebot.errors import LogError
from snakebot.robot import Robot
from snakebot.runlog import channels
from snakebot.runlog.finish import finish
from snakebot.runlog.naming import PART_SUFFIX, final_path, numbered
from snakebot.runlog.part_file import PartFile, beginning, chunk, message, metadata_record
from snakebot.runlog.records import Event, LinkRecord, PoseRecord, RawFrame, SteeringRecord, Telemetry, Tick

FLUSH_S = 0.2  # with the time to sync, well within the half second that a crash may cost
CHUNK_BYTES = 16 << 10  # of a log's chunk; chosen: a crash loses no more
WAKE_BYTES = 1 << 20  # that may wait before the writer is woken early; chosen
# Between two looks at a full queue; a write that takes longer is told. Chosen.
GIVE_WAY_S, DISK_HANGS_S = 1e-3, 0.2
MAX_QUEUE_BYTES = 64 << 20  # a disk that hangs for minutes is reported, not buffered without end


class RunWriter:
    """One run on its way to disk: ``<path>.part`` while it runs, ``<path>`` once closed.

    Args:
        path: final name; ``.mcap`` is added where it is missing. Neither it nor its ``.part`` may exist.
        or_numbered: where the name is taken, take the next free number.
        robot: attached as ``robot.yaml``.
        metadata: what describes the run (gait, faults, port, versions, ...): anything JSON can carry.
        attachments: further files to carry, by name (the DBC, an effects file).
        start_time_ns: wall clock at t_s = 0. Log times are this plus ``t_s``, so that setting the wall clock
            in mid-run does not disorder the log; the wall clock of each tick is kept as its publish time.
        flush_s: longest time that a record waits in this process.
        sync_s: longest time between two requests to reach the disk.
        tap: is handed each record, too (channel's number, log time in ns, JSON); it must neither wait nor raise.

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
        or_numbered: bool = False,
        attachments: Mapping[str, bytes] | None = None,
        start_time_ns: int | None = None,
        flush_s: float = FLUSH_S,
        sync_s: float = FLUSH_S,
        tap: Callable[[int, int, bytes], None] | None = None,
    ) -> None:
        self.joints = robot.joints
        self.start_time_ns = time.time_ns() if start_time_ns is None else start_time_ns
        self._flush_s, self._sync_s = flush_s, sync_s
        self._tap = tap
        self._queue: deque[bytes] = deque()
        self._queued_bytes = self._written_bytes = 0
        self._sequence = dict.fromkeys((channel.id for channel in channels.CHANNELS), 0)
        self._writing_since_s: float | None = None
        self._error: str | None = None
        self._reported = self._closed = False
        start = beginning(robot, metadata or {}, attachments or {}, self.start_time_ns)
        self.path, self._file = _claimed(path, start, or_numbered)
        self.part_path = self._file.path
        self._wake, self._last_sync = threading.Event(), threading.Event()
        self._flusher = threading.Thread(target=self._flush_loop, name="runlog-flush", daemon=True)
        self._syncer = threading.Thread(target=self._sync_loop, name="runlog-sync", daemon=True)
        self._flusher.start()
        self._syncer.start()

    @property
    def waiting_bytes(self) -> int:
        """What was recorded and is not yet on its way to the disk."""
        return self._queued_bytes - self._written_bytes

    # --- called from the run loop

    def tick(self, tick: Tick) -> None:
        """Record one tick. Its arrays are copied: the caller may use them again."""
        for values in (tick.setpoint_rad, tick.sent_rad, tick.applied_rad, tick.measured_rad):
            if values is not None and len(values) != self.joints:
                found = f"{len(values)} values for {self.joints} joints"
                raise LogError(f"{self.path}: tick {tick.sequence} has {found}")
        data = channels.encode_tick(tick)
        self._put(channels.JOINTS.id, tick.t_s, data, tick.sequence, tick.host_time_ns)

    def pose(self, pose: PoseRecord) -> None:
        """Record where the robot is."""
        self._put(channels.POSE.id, pose.t_s, channels.encode_pose(pose, self.start_time_ns))

    def event(self, event: Event) -> None:
        """Record that something happened."""
        self._put(channels.EVENTS.id, event.t_s, channels.encode_event(event, self.start_time_ns))

    def link_statistics(self, statistics: LinkRecord) -> None:
        """Record the link's counters."""
        self._put(channels.LINK.id, statistics.t_s, channels.encode_link(statistics))

    def telemetry(self, telemetry: Telemetry) -> None:
        """Record further readings: supply, currents, temperatures."""
        self._put(channels.TELEMETRY.id, telemetry.t_s, channels.encode_telemetry(telemetry))

    def steering(self, steering: SteeringRecord) -> None:
        """Record a decision of a run that holds a course."""
        self._put(channels.STEERING.id, steering.t_s, channels.encode_steering(steering))

    def frame(self, frame: RawFrame) -> None:
        """Record one frame of the wire."""
        self._put(channels.FRAMES.id, frame.t_s, channels.encode_frame(frame))

    def add_metadata(self, more: Mapping[str, Any]) -> None:
        """Add to the run's metadata, or replace values of it: how the run ended, a speed measured later."""
        self._append(metadata_record(more))

    def _put(
        self,
        channel_id: int,
        t_s: float,
        data: bytes,
        sequence: int | None = None,
        wall_ns: int | None = None,
    ) -> None:
        if sequence is None:
            sequence = self._sequence[channel_id]
            self._sequence[channel_id] = sequence + 1
        log_ns = max(0, self.start_time_ns + round(t_s * 1e9))
        self._append(message(channel_id, sequence, log_ns, max(0, wall_ns or log_ns), data))
        if self._tap is not None:
            self._tap(channel_id, log_ns, data)

    def _append(self, record: bytes) -> None:
        if self.waiting_bytes > MAX_QUEUE_BYTES:
            self._fail("the disk does not keep up")
        if self._error is not None:
            self._reported = True
            raise LogError(self._error)
        if self._closed:
            raise LogError(f"{self.path}: the log is closed")
        self._queue.append(record)
        self._queued_bytes += len(record)
        if self.waiting_bytes > WAKE_BYTES:
            self._give_way()

    def _give_way(self) -> None:
        """Far more is waiting than any robot sends: an import, or a simulation in virtual time. Such a caller never
        waits, and the interpreter's lock would hardly ever be the flusher's. Where the disk hangs, giving way would
        not help, and the caller may be a loop that has a robot to drive."""
        self._wake.set()
        if self._writing_since_s is None or time.monotonic() - self._writing_since_s < DISK_HANGS_S:
            time.sleep(GIVE_WAY_S)

    def flush(self) -> None:
        """Wait until all that was recorded can be read from the ``.part``, or cannot be written: ``close`` tells."""
        while self.waiting_bytes and self._error is None:
            self._wake.set()
            time.sleep(GIVE_WAY_S)

    # --- closing

    def close(self) -> Path:
        """Write what is left, compress, add the index and give the log its final name. Returns that name: the next
        free number where another file has taken the name meanwhile.

        Raises:
            LogError: it could not be written whole; what was written stays in the ``.part``. An error that
                a call before has raised already is not raised again: then the ``.part``'s name is returned.
        """
        if self._closed:
            return self.part_path if self._error is not None else self.path
        self._end_threads()
        if self._error is None:
            wanted = self.path
            self.path = finish(self.part_path, wanted, or_numbered=True).path
            if self.path != wanted:
                warnings.warn(
                    f"{wanted}: appeared while the run went on, and stays; the run is in {self.path}",
                    stacklevel=2,
                )
            return self.path
        if not self._reported:
            raise LogError(self._error)
        return self.part_path

    def discard(self) -> None:
        """End without a log: of a run that was refused, nothing is kept."""
        if not self._closed:
            self._end_threads()
            self.part_path.unlink(missing_ok=True)

    def _end_threads(self) -> None:
        self._closed = True
        self._wake.set()
        self._flusher.join()
        self._last_sync.set()
        self._syncer.join()
        self._file.close()

    def __enter__(self) -> RunWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            self.close()
        except LogError as second:
            if error is None:
                raise
            error.add_note(str(second))

    # --- the two threads

    def _flush_loop(self) -> None:
        last = False
        while not last and self._error is None:
            self._wake.wait(self._flush_s)
            self._wake.clear()
            last = self._closed
            try:
                self._drain()
            except Exception as error:  # this thread may not die in silence: the run loop must hear of it
                self._fail(getattr(error, "strerror", None) or f"{type(error).__name__}: {error}")

    def _sync_loop(self) -> None:
        synced, last = -1, False
        while not last:
            last = self._last_sync.wait(self._sync_s)
            if self._file.good_bytes != synced:
                synced = self._file.good_bytes
                try:
                    self._file.sync()
                except OSError as error:
                    self._fail(error.strerror or str(error))

    def _drain(self) -> None:
        """Write what is on the queue now, in chunks; metadata records stand between chunks."""
        batch: list[bytes] = []
        size, opcode = 0, int(Opcode.MESSAGE)
        for _ in range(len(self._queue)):
            record = self._queue.popleft()
            is_message = record[0] == opcode
            if is_message:
                batch.append(record)
                size += len(record)
            if size >= CHUNK_BYTES or not is_message:
                self._write_chunk(batch)
                batch, size = [], 0
            if not is_message:
                self._file.write(record)
                self._written_bytes += len(record)
        self._write_chunk(batch)

    def _write_chunk(self, batch: list[bytes]) -> None:
        if batch:
            data = chunk(batch)
            self._writing_since_s = time.monotonic()
            self._file.write(data)
            self._writing_since_s = None
            self._written_bytes += sum(map(len, batch))

    def _fail(self, why: str) -> None:
        if self._error is None:
            self._error = (
                f"{self.part_path}: the log cannot be written any further: {why}; what was written until "
                "then can be read as it is, or finished with 'snakebot log recover'"
            )


def _claimed(path: str | os.PathLike[str], start: bytes, or_numbered: bool) -> tuple[Path, PartFile]:
    """A final name that is free, and its ``.part``, which nobody else has."""
    final = final_path(path)
    if Path(path).is_dir():
        raise LogError(f"{path}: is a folder; give the name of a log in it")
    for name in numbered(final) if or_numbered else (final,):
        if not os.path.lexists(name):
            try:
                return name, PartFile(name.with_name(name.name + PART_SUFFIX), start)
            except FileExistsError:
                continue
    raise LogError(f"{final}: exists already; a log is never overwritten")
