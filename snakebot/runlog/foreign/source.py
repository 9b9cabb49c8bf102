"""Whatever a lab has recorded, as runs of one robot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

from snakebot.errors import BadInputError
from snakebot.robot import Robot, robot_from_mapping
from snakebot.runlog.foreign import lerobot, ros_bag
from snakebot.runlog.foreign.angles import AngleForm
from snakebot.runlog.foreign.ros_runs import BagOptions, read_bag
from snakebot.runlog.foreign.tables import TableOptions, joints_of, read_table_run
from snakebot.runlog.run import Run
from snakebot.runlog.session import SESSION_FILE

TABLES = (".csv", ".csv.gz", ".parquet", ".tsv", ".txt", ".dat")


@dataclass(frozen=True)
class SourceOptions:
    """What is said of the sources; each kind takes what concerns it."""

    table: TableOptions = field(default_factory=TableOptions)
    measured: str | None = None
    command: str | None = None
    joints: tuple[str, ...] = ()
    episodes: frozenset[int] | None = None


class Imported(NamedTuple):
    robot: Robot
    runs: tuple[Run, ...]
    told: tuple[str, ...]  # how each source was understood


def kind_of(path: Path) -> str:
    """``table``, ``lerobot`` or ``bag``.

    Raises:
        BadInputError: it is not there, is a session already, or is none of them.
    """
    if path.is_dir():
        if (path / SESSION_FILE).exists():
            raise BadInputError(f"{path}: is a session already")
        if lerobot.is_lerobot(path):
            return "lerobot"
        if ros_bag.is_bag(path):
            return "bag"
        raise BadInputError(
            f"{path}: neither a LeRobot dataset (meta/info.json) nor a ROS 2 bag (metadata.yaml); tables are given "
            "file by file"
        )
    if not path.is_file():
        raise BadInputError(f"{path}: no such file")
    if ros_bag.is_bag(path):
        return "bag"
    if path.name.endswith(TABLES):
        return "table"
    raise BadInputError(
        f"{path}: no recording that is read here ({', '.join(TABLES)}, .mcap, .db3, LeRobot folders)"
    )


def read_sources(paths: Sequence[Path], options: SourceOptions, robot: Robot | None = None) -> Imported:
    """All runs of the sources, named apart. Without a robot, it is a bench of as many joints as there are.

    Raises:
        BadInputError: one line that names the source.
    """
    _check_taken(paths, options)
    runs: list[Run] = []
    told: list[str] = []
    angles = options.table.angles
    if angles.counts_per_rev is None and robot is not None:
        angles = replace(angles, counts_per_rev=robot.encoder_counts_per_rev)
    for path in paths:
        kind = kind_of(path)
        if kind == "lerobot":
            data = lerobot.read_info(path)
            found = lerobot.read_dataset(data, options.joints, angles, options.episodes)
            told.append(
                f"{path}: LeRobot {data.version}, {len(found)} episodes at {data.fps:g} Hz, joints "
                f"{', '.join(found[0].metadata['joints'][:8])}; commands are action, measured observation.state"
            )
        elif kind == "bag":
            run, understood = read_bag(
                ros_bag.open_bag(path),
                BagOptions(options.measured, options.command, options.joints, angles),
            )
            found = [run]
            told.append(f"{path}: {understood}")
        else:
            table = replace(options.table, angles=angles)
            nominal = robot or _bench(joints_of(path, table), angles)
            read = read_table_run(path, nominal, table)
            found = [read.run]
            told.append(f"{path}: {read.told}")
        robot = robot or _bench(found[0].joints, angles)
        for run in found:
            if run.joints != robot.joints:
                raise BadInputError(f"{path}: {run.joints} joints, the robot has {robot.joints}")
        runs += found
    assert robot is not None
    return Imported(robot, _named_apart(runs), tuple(told))


def _check_taken(paths: Sequence[Path], options: SourceOptions) -> None:
    """What is said of sources of another kind would change nothing, and nobody would notice."""
    kinds = {kind_of(path) for path in paths}
    of_bags = "is for ROS 2 bags"
    for option, given, takers, what in (
        ("--joints", options.joints, {"lerobot", "bag"}, "is for LeRobot datasets and ROS 2 bags"),
        ("--episodes", options.episodes, {"lerobot"}, "is for LeRobot datasets"),
        ("--measured", options.measured, {"bag"}, of_bags),
        ("--command", options.command, {"bag"}, of_bags),
    ):
        if given and not takers & kinds:
            of_tables = "; of tables, --map says which columns are read" if "table" in kinds else ""
            raise BadInputError(f"{paths[0]}: {option} {what}{of_tables}")


def _bench(joints: int, angles: AngleForm) -> Robot:
    about: dict[str, object] = {"joints": joints}
    if angles.counts_per_rev is not None:
        about["encoder_counts_per_rev"] = angles.counts_per_rev
    return robot_from_mapping(about, "joints of the recording")


def _named_apart(runs: Sequence[Run]) -> tuple[Run, ...]:
    taken: set[str] = set()
    apart = []
    for run in runs:
        name, number = run.name, 1
        while name in taken:
            number += 1
            name = f"{run.name}-{number}"
        taken.add(name)
        apart.append(replace(run, name=name))
    return tuple(apart)
