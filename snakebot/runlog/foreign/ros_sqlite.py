"""The SQLite storage of a ROS 2 bag (``.db3``), opened for reading only."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Set
from contextlib import closing
from pathlib import Path

from snakebot.errors import BadInputError
from snakebot.runlog.container import MAX_CHANNELS
from snakebot.runlog.foreign.ros_message import MAX_BAG_MESSAGE_BYTES, BagMessage, Topic


def topics(path: Path, problems: list[str]) -> list[Topic]:
    """What topics a file has.

    Raises:
        BadInputError: not SQLite, or not a bag of ROS 2.
    """
    try:
        with closing(_open(path)) as database:
            definitions = {}
            if "message_definitions" in _tables(path, database, ()):
                rows = database.execute(
                    "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions LIMIT ?",
                    (MAX_CHANNELS,),
                )
                definitions = {kind: text for kind, encoding, text in rows if encoding == "ros2msg"}
            found = database.execute(
                "SELECT name, type, serialization_format FROM topics LIMIT ?", (MAX_CHANNELS + 1,)
            ).fetchall()
    except (sqlite3.Error, OverflowError, ValueError) as error:
        raise BadInputError(f"{path}: cannot be read as a bag: {error}") from None
    if len(found) > MAX_CHANNELS:
        raise BadInputError(f"{path}: more than {MAX_CHANNELS} topics; not read")
    made = []
    for name, kind, encoding in found:
        text = definitions.get(kind)
        made.append(Topic(str(name), str(kind), text if isinstance(text, str) else None, str(encoding)))
    return made


def messages(path: Path, wanted: Set[str], problems: list[str]) -> Iterator[BagMessage]:
    """The messages of some topics."""
    names = sorted(wanted)
    query = (
        "SELECT topics.name, messages.timestamp, messages.data FROM messages JOIN topics "
        f"ON messages.topic_id = topics.id WHERE topics.name IN ({','.join('?' * len(names))})"
    )
    try:
        with closing(_open(path)) as database:
            for name, time_ns, data in database.execute(query, names):
                if not isinstance(time_ns, int) or not isinstance(data, bytes):
                    raise BadInputError(f"{path}: a message without a time or without data")
                yield BagMessage(name, time_ns, data)
    except (sqlite3.Error, OverflowError, ValueError) as error:
        raise BadInputError(f"{path}: cannot be read as a bag: {error}") from None


def _open(path: Path) -> sqlite3.Connection:
    """Without a lock, a journal or anything else written; what the file defines to run by itself is not trusted."""
    if not path.is_file():
        raise BadInputError(f"{path}: no such file")
    database = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro&immutable=1", uri=True)
    database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_BAG_MESSAGE_BYTES)
    database.execute("PRAGMA trusted_schema=OFF")
    database.execute("PRAGMA cell_size_check=ON")
    _tables(path, database, ("topics", "messages"))
    return database


def _tables(path: Path, database: sqlite3.Connection, needed: tuple[str, ...]) -> set[str]:
    """Names of the plain tables; a view of that name could compute without an end."""
    rows = database.execute("SELECT name, sql FROM sqlite_master WHERE type = 'table' LIMIT 1000").fetchall()
    plain = {
        str(name)
        for name, sql in rows
        if str(sql).upper().startswith("CREATE TABLE") and " AS " not in str(sql).upper()
    }
    for name in needed:
        if name not in plain:
            raise BadInputError(f"{path}: no bag of ROS 2: it has no table {name}")
    return plain
