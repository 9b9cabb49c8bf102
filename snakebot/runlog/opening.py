"""Opens whatever holds runs: logs, unfinished logs, session folders, one run of a session."""

from __future__ import annotations

import itertools
import os
import warnings
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from snakebot.errors import BadInputError, NothingLeftError
from snakebot.runlog.import_hint import import_hint
from snakebot.runlog.listing import find_logs
from snakebot.runlog.log import NoTicksError
from snakebot.runlog.naming import PART_SUFFIX, SUFFIX, no_such_log
from snakebot.runlog.number_table import TABLE_SUFFIXES, stem_and_suffix
from snakebot.runlog.reader import LogWarning, read_log
from snakebot.runlog.run import Run, Session
from snakebot.runlog.session import SESSION_FILE, read_session

PathLike = str | os.PathLike[str]


def open_session(path: PathLike) -> Session:
    """A session folder, a folder of logs, or one log (``.mcap``, ``.mcap.part``) as a session of one run.

    Raises:
        BadInputError, LogError: it is neither, or holds an error; one line says where.
    """
    given = Path(path)
    if given.is_dir() and not (given / SESSION_FILE).exists():
        logs = list(find_logs(given))
        if not logs:
            hint = import_hint(given)
            raise BadInputError(f"{given}: holds neither {SESSION_FILE} nor run logs ({SUFFIX}){hint}")
        return open_runs(logs)
    if given.is_dir() or given.name == SESSION_FILE:
        return read_session(given)
    if given.name.endswith((SUFFIX, SUFFIX + PART_SUFFIX)):
        if not given.is_file():
            raise no_such_log(given)
        log = read_log(given)
        return Session(robot=log.robot, runs=(log.to_run(),), path=given, warnings=log.problems)
    if not given.is_file():
        raise BadInputError(f"{given}: no such file or folder")
    if given.name.endswith(TABLE_SUFFIXES) and (given.parent / SESSION_FILE).exists():
        session = read_session(given.parent)
        for run in session.runs:
            if run.name == given.name:
                return Session(session.robot, (run,), session.path, session.warnings)
        raise BadInputError(f"{given}: {given.parent / SESSION_FILE} names no such run{import_hint(given)}")
    raise BadInputError(
        f"{given}: neither a run log (.mcap, .mcap.part) nor a run of a session{import_hint(given)}"
    )


def open_run(path: PathLike) -> Run:
    """One run: a log, a session folder with one run, or ``folder/run_01.csv``.

    Raises:
        BadInputError, LogError: as ``open_session``; or there are several runs to choose from.
    """
    session = open_session(path)
    if len(session.runs) > 1:
        names = ", ".join(run.name for run in session.runs[:5])
        raise BadInputError(f"{path}: holds {len(session.runs)} runs; name one of them ({names}, ...)")
    return session.runs[0]


def open_each(paths: Iterable[PathLike]) -> tuple[list[tuple[Path, Session]], list[str]]:
    """Each log or session on its own, and what was left out: logs without ticks, or so damaged that none is left.

    A ``LogWarning`` tells each of these.

    Raises:
        NoTicksError: nothing is left.
        BadInputError, LogError: as ``open_session``.
    """
    given = [Path(path) for path in paths]
    opened, left_out = [], []
    for path in given:
        try:
            opened.append((path, open_session(path)))
        except (NoTicksError, NothingLeftError) as error:
            if len(given) == 1:
                raise
            left_out.append(f"{error}: left out")
            warnings.warn(left_out[-1], LogWarning, stacklevel=3)
    if not opened and given:
        raise NoTicksError(f"{given[0]} and {len(given) - 1} more: none of these logs holds a tick")
    return opened, left_out


def open_runs(paths: Iterable[PathLike]) -> Session:
    """Logs and sessions of one robot together, in the order given. The robot is the first one's.

    Of runs that have the same name the later ones get a number; logs without ticks are left out.

    Raises:
        BadInputError, LogError: as ``open_each``; or a joint count differs.
    """
    opened, left_out = open_each(paths)
    sessions = [session for _, session in opened]
    if not sessions:
        raise BadInputError("no run was given")
    first = sessions[0]
    for session in sessions[1:]:
        if session.robot.joints != first.robot.joints:
            raise BadInputError(
                f"{session.path}: the robot has {session.robot.joints} joints, "
                f"but in {first.path} {first.robot.joints}"
            )
    return Session(
        robot=first.robot,
        runs=_named_apart(sessions),
        path=first.path if len(sessions) == 1 else None,
        warnings=(*left_out, *(note for session in sessions for note in session.warnings)),
    )


def _named_apart(sessions: Iterable[Session]) -> tuple[Run, ...]:
    taken: set[str] = set()
    apart: list[Run] = []
    for session in sessions:
        names = {run.name: _free_name(run.name, taken) for run in session.runs}
        taken.update(names.values())
        for run in session.runs:
            repeat_of = None if run.repeat_of is None else names.get(run.repeat_of, run.repeat_of)
            apart.append(replace(run, name=names[run.name], repeat_of=repeat_of))
    return tuple(apart)


def _free_name(name: str, taken: set[str]) -> str:
    stem, suffix = stem_and_suffix(name)
    numbered = (f"{stem}-{count}{suffix}" for count in itertools.count(2))
    return name if name not in taken else next(free for free in numbered if free not in taken)
