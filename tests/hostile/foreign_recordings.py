"""Foreign recordings as parsers of bytes, and sound input for each: a part of ``parsers.py`` and ``seeds.py``."""

from __future__ import annotations

import io
import json
import sqlite3
from collections.abc import Callable
from pathlib import Path

import numpy as np

INFO = (
    b'{"codebase_version":"v3.0","fps":30,"features":{"action":{"shape":[2],"names":["a","b"]},'
    b'"observation.state":{"shape":[2],"names":{"motors":["b","a"]}}}}'
)
FOREIGN = b"Logger;3\nZeit [ms];Soll1 [deg];Ist1 [deg]\n0;1,5;1,4\n10;1,6;1,5\n20;-3;1,6\n"


def _imported(path: Path) -> None:
    from snakebot.runlog.foreign.angles import AngleForm
    from snakebot.runlog.foreign.source import SourceOptions, read_sources
    from snakebot.runlog.foreign.tables import TableOptions

    found = read_sources([path], SourceOptions(TableOptions(angles=AngleForm("deg"))))
    for run in found.runs:
        assert np.isfinite(run.t_s).all()
        assert (np.diff(run.t_s) > 0).all()
        assert not np.isinf(run.command_rad).any()
        assert not np.isinf(run.measured_rad).any()


def foreign_table(folder: Path, data: bytes) -> None:
    (folder / "foreign.txt").write_bytes(data)
    _imported(folder / "foreign.txt")


def _dataset(folder: Path, info: bytes, table: bytes) -> None:
    made = folder / "dataset"
    (made / "meta").mkdir(parents=True, exist_ok=True)
    (made / "data" / "chunk-000").mkdir(parents=True, exist_ok=True)
    (made / "meta" / "info.json").write_bytes(info)
    (made / "data" / "chunk-000" / "file-000.parquet").write_bytes(table)
    _imported(made)


def lerobot_info(folder: Path, data: bytes) -> None:
    _dataset(folder, data, episodes())


def lerobot_data(folder: Path, data: bytes) -> None:
    _dataset(folder, INFO, data)


def bag_mcap(folder: Path, data: bytes) -> None:
    (folder / "bag.mcap").write_bytes(data)
    _imported(folder / "bag.mcap")


def bag_sqlite(folder: Path, data: bytes) -> None:
    (folder / "bag.db3").write_bytes(data)
    _imported(folder / "bag.db3")


def ros_definition(folder: Path, data: bytes) -> None:
    """A definition, and a message of zeros by it."""
    from snakebot.errors import BadInputError
    from snakebot.runlog.foreign.ros_types import DefinitionError, definition

    try:
        definition("trajectory_msgs/msg/A", data.decode("utf-8", "replace")).decode(b"\0\1\0\0" + bytes(4000))
    except DefinitionError as error:
        raise BadInputError(str(error)) from None


def episodes() -> bytes:
    import pyarrow as pa
    import pyarrow.parquet as pq

    two = pa.list_(pa.float32(), 2)
    table = pa.table(
        {
            "action": pa.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]], two),
            "observation.state": pa.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]], two),
            "timestamp": np.arange(3, dtype=np.float32) / 30,
            "episode_index": np.zeros(3, dtype=np.int64),
        }
    )
    file = io.BytesIO()
    pq.write_table(table, file, compression="none", use_dictionary=False, store_schema=False)
    return file.getvalue()


def _states() -> list[tuple[str, int, bytes]]:
    from snakebot.runlog.foreign.ros_export import joint_state

    names = ["a", "b"]
    return [
        (topic, ns, joint_state(ns, names, np.array([0.1, 0.2])))
        for ns in (10**18, 10**18 + 10**7)
        for topic in ("/joint_states", "/cmd")
    ]


def mcap_bag() -> bytes:
    from mcap.writer import CompressionType, Writer

    from snakebot.runlog.foreign.ros_types import JOINT_STATE, KNOWN

    file = io.BytesIO()
    writer = Writer(file, compression=CompressionType.NONE)
    writer.start(profile="ros2", library="")
    schema = writer.register_schema(JOINT_STATE, "ros2msg", KNOWN[JOINT_STATE].encode())
    channels = {topic: writer.register_channel(topic, "cdr", schema) for topic in ("/joint_states", "/cmd")}
    for topic, ns, data in _states():
        writer.add_message(channels[topic], ns, data, ns)
    writer.finish()
    return file.getvalue()


def sqlite_bag() -> bytes:
    from snakebot.runlog.foreign.ros_types import JOINT_STATE

    database = sqlite3.connect(":memory:")
    database.executescript(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);"
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)"
    )
    for number, topic in enumerate(("/joint_states", "/cmd")):
        database.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr')", (number, topic, JOINT_STATE))
    for topic, ns, data in _states():
        row = (0 if topic == "/joint_states" else 1, ns, data)
        database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", row)
    database.commit()
    return database.serialize()


def _definitions() -> list[bytes]:
    from snakebot.runlog.foreign.ros_types import JOINT_STATE, KNOWN, TRAJECTORY

    return [KNOWN[kind].encode() for kind in (JOINT_STATE, TRAJECTORY)]


RECORDINGS: dict[str, Callable[[Path, bytes], None]] = {
    parser.__name__: parser
    for parser in (foreign_table, lerobot_info, lerobot_data, bag_mcap, bag_sqlite, ros_definition)
}
SOUND: dict[str, Callable[[], list[bytes]]] = {
    "foreign_table": lambda: [FOREIGN, b"t goal pos\n0 1 2\n1 2 3\n"],
    "lerobot_info": lambda: [INFO, json.dumps(json.loads(INFO) | {"codebase_version": "v2.1"}).encode()],
    "lerobot_data": lambda: [episodes()],
    "bag_mcap": lambda: [mcap_bag()],
    "bag_sqlite": lambda: [sqlite_bag()],
    "ros_definition": _definitions,
}
