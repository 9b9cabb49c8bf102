"""ROS 2 bags as messages in CDR: a folder with ``metadata.yaml``, or its files (MCAP, SQLite), without ROS."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from snakebot.errors import BadInputError
from snakebot.runlog.container import decompress
from snakebot.runlog.foreign import ros_mcap, ros_sqlite
from snakebot.runlog.foreign.ros_message import MAX_BAG_MESSAGE_BYTES, BagMessage, Topic
from snakebot.safe_yaml import load_yaml

METADATA = "metadata.yaml"
STORAGE = (".mcap", ".db3")
MAX_BAG_FILES = 1000  # of one bag
MAX_MESSAGES = 5_000_000  # of the topics that are read; chosen: a day at 50 Hz


@dataclass
class Bag:
    """A bag: what topics it has, and, when ``messages`` has gone through it, what was wrong with it."""

    path: Path
    files: tuple[Path, ...]
    packed: bool = False  # each message by itself, zstd
    topics: dict[str, Topic] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)

    def messages(self, wanted: Set[str]) -> Iterator[BagMessage]:
        """The messages of some topics, in the order of the files.

        Raises:
            BadInputError: damaged beyond reading, or larger than any recording of joints.
        """
        count = 0
        for file in self.files:
            for message in _storage(file).messages(file, wanted, self.problems):
                count += 1
                if count > MAX_MESSAGES:
                    raise BadInputError(f"{self.path}: more than {MAX_MESSAGES} messages; cut the bag")
                yield message._replace(data=self._unpacked(message.data)) if self.packed else message

    def _unpacked(self, data: bytes) -> bytes:
        try:
            raw = decompress(memoryview(data), "zstd", MAX_BAG_MESSAGE_BYTES)
        except ValueError as error:
            raise BadInputError(f"{self.path}: a compressed message is damaged: {error}") from None
        if len(raw) > MAX_BAG_MESSAGE_BYTES:
            raise BadInputError(
                f"{self.path}: a message is larger than {MAX_BAG_MESSAGE_BYTES >> 10} KiB; not read"
            )
        return raw


def is_bag(path: Path) -> bool:
    """Whether a folder or a file looks like a bag. A run log of snakebot is an ``.mcap``, too."""
    if path.is_dir():
        return (path / METADATA).is_file() or any(_files_in(path))
    return path.suffix in STORAGE


def open_bag(path: Path) -> Bag:
    """Open a bag and read what topics it has.

    Raises:
        BadInputError: one line that names the file and what is wrong.
    """
    files, packed = ((path,), False) if not path.is_dir() else _described(path)
    bag = Bag(path, files, packed)
    for file in files:
        if not file.is_file():
            raise BadInputError(f"{file}: no such file, but {path / METADATA} names it")
        for topic in _storage(file).topics(file, bag.problems):
            known = bag.topics.setdefault(topic.name, topic)
            if known.kind != topic.kind:
                raise BadInputError(f"{file}: topic {topic.name} is {topic.kind} here, {known.kind} before")
    return bag


def _storage(file: Path) -> Any:
    return ros_mcap if file.suffix == ".mcap" else ros_sqlite


def _files_in(folder: Path) -> list[Path]:
    return sorted(path for path in folder.iterdir() if path.suffix in STORAGE and path.is_file())


def _described(folder: Path) -> tuple[tuple[Path, ...], bool]:
    """The files of a bag, and whether messages are packed one by one."""
    where = folder / METADATA
    if not where.is_file():  # the recorder was killed: the files are there all the same
        return tuple(_files_in(folder)), False
    try:
        if where.stat().st_size > 4 << 20:
            raise BadInputError(f"{where}: larger than 4 MiB; not read")
        data = load_yaml(where.read_bytes(), str(where))
    except OSError as error:
        raise BadInputError(f"{where}: cannot be read: {error.strerror}") from None
    about = data.get("rosbag2_bagfile_information") if isinstance(data, Mapping) else None
    names = about.get("relative_file_paths") if isinstance(about, Mapping) else None
    if not isinstance(about, Mapping) or not isinstance(names, list) or not names:
        raise BadInputError(f"{where}: not a bag's: rosbag2_bagfile_information names no files")
    if len(names) > MAX_BAG_FILES:
        raise BadInputError(f"{where}: {len(names)} files; at most {MAX_BAG_FILES} are read")
    mode = str(about.get("compression_mode") or "").lower()
    form = str(about.get("compression_format") or "").lower()
    if mode == "file":
        raise BadInputError(
            f"{where}: the bag's files are compressed as a whole; unpack them first: ros2 bag convert"
        )
    if mode not in ("", "none", "message") or (mode == "message" and form != "zstd"):
        raise BadInputError(f"{where}: compression {mode} {form} is not read")
    files = []
    for name in names:
        plain = str(name).replace("\\", "/").rsplit("/", 1)[-1]  # early versions name the folder as well
        if not plain.endswith(STORAGE) or "\0" in plain:
            raise BadInputError(f"{where}: {plain[:60]!r} is no storage that is read ({', '.join(STORAGE)})")
        file = folder / plain
        if not file.resolve().is_relative_to(folder.resolve()):
            raise BadInputError(f"{file}: leads out of the bag's folder; not read")
        files.append(file)
    return tuple(files), mode == "message"
