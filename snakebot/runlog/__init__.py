"""Run logs and session folders: write, read, recover, export. See docs/logs.md."""

from __future__ import annotations

from snakebot.runlog.log import RunLog, gait_to_mapping
from snakebot.runlog.naming import new_log_path
from snakebot.runlog.opening import open_run, open_runs, open_session
from snakebot.runlog.reader import LogWarning, read_log
from snakebot.runlog.records import Event, LinkRecord, PoseRecord, RawFrame, Telemetry, Tick
from snakebot.runlog.run import Run, Session
from snakebot.runlog.session import read_session
from snakebot.runlog.session_write import write_session
from snakebot.runlog.writer import RunWriter

__all__ = [
    "Event",
    "LinkRecord",
    "LogWarning",
    "PoseRecord",
    "RawFrame",
    "Run",
    "RunLog",
    "RunWriter",
    "Session",
    "Telemetry",
    "Tick",
    "gait_to_mapping",
    "new_log_path",
    "open_run",
    "open_runs",
    "open_session",
    "read_log",
    "read_session",
    "write_session",
]
