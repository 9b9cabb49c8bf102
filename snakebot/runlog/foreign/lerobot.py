"""LeRobot datasets (v2.1: one Parquet an episode; v3.0: several in one) as runs, an episode each.

Commands are ``action``, measurements ``observation.state``, both of the same frame: the action was sent right after the
state was read. Nothing is resampled. https://huggingface.co/docs/lerobot/lerobot-dataset-v3
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.runlog.foreign.angles import AngleForm
from snakebot.runlog.foreign.made_run import chosen, made_run
from snakebot.runlog.number_table import FREE_BYTES, MAX_CELLS, MAX_RATIO
from snakebot.runlog.run import Run
from snakebot.runlog.session import MAX_RUNS

INFO = Path("meta") / "info.json"
VERSIONS = ("v2.0", "v2.1", "v3.0")
MAX_INFO_BYTES = 4 << 20  # of ``INFO``; chosen
MAX_FILES = 10_000  # of one dataset; chosen
MAX_WIDTH = 256  # numbers of an action or a state; chosen
ACTION, STATE = "action", "observation.state"
_BATCH = 1024  # rows


@dataclass(frozen=True)
class Dataset:
    """What ``meta/info.json`` says."""

    folder: Path
    version: str
    fps: float
    action: tuple[str, ...]  # names
    state: tuple[str, ...]


def is_lerobot(folder: Path) -> bool:
    return (folder / INFO).is_file()


def read_info(folder: Path) -> Dataset:
    """
    Raises:
        BadInputError: one line that names the file and the key.
    """
    where = folder / INFO
    try:
        if where.stat().st_size > MAX_INFO_BYTES:
            raise BadInputError(f"{where}: larger than {MAX_INFO_BYTES >> 20} MiB; not read")
        data = json.loads(where.read_bytes())
    except OSError as error:
        raise BadInputError(f"{where}: cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise BadInputError(f"{where}: not JSON: {str(error)[:100]}") from None
    if not isinstance(data, dict):
        raise BadInputError(f"{where}: not a mapping with fps and features")
    version = data.get("codebase_version")
    if version not in VERSIONS:
        raise BadInputError(
            f"{where}: codebase_version is {str(version)[:40]!r}; {', '.join(VERSIONS)} are read here"
        )
    fps = data.get("fps")
    if isinstance(fps, bool) or not isinstance(fps, (int, float)) or not 0 < fps < 1e6:
        raise BadInputError(f"{where}: fps: no rate (found {str(fps)[:40]})")
    features = data.get("features")
    names = [_names(where, features, key) for key in (ACTION, STATE)]
    return Dataset(folder, version, float(fps), *names)


def _names(where: Path, features: Any, key: str) -> tuple[str, ...]:
    feature = features.get(key) if isinstance(features, dict) else None
    if not isinstance(feature, dict):
        raise BadInputError(f"{where}: features has no {key}: commands and measurements are both needed")
    shape = feature.get("shape")
    width = shape[0] if isinstance(shape, list) and len(shape) == 1 else None
    if not isinstance(width, int) or not 0 < width <= MAX_WIDTH:
        raise BadInputError(f"{where}: features: {key}: shape is no single number of 1 to {MAX_WIDTH}")
    names = feature.get("names")
    while isinstance(names, dict) and len(names) == 1:  # {"motors": [...]}
        names = next(iter(names.values()))
    if isinstance(names, list) and len(names) == width and all(isinstance(name, str) for name in names):
        if len(set(names)) == width:
            return tuple(names)
        raise BadInputError(f"{where}: features: {key}: two names are alike")
    return tuple(str(number) for number in range(1, width + 1))


def joints_of(data: Dataset, wanted: tuple[str, ...]) -> tuple[str, ...]:
    """Names of the joints: those asked for, or all, if command and measurement have the same.

    Raises:
        BadInputError: they have others, or one is not there.
    """
    where = str(data.folder / INFO)
    if not wanted and set(data.action) != set(data.state):
        raise BadInputError(
            f"{where}: {ACTION} has {', '.join(data.action[:10])}, {STATE} has {', '.join(data.state[:10])}: "
            "choose what is in both with --joints"
        )
    names = chosen(wanted, data.action, where, ACTION)
    return chosen(names, data.state, where, STATE)


def read_dataset(
    data: Dataset, wanted: tuple[str, ...], angles: AngleForm, episodes: frozenset[int] | None
) -> list[Run]:
    """The episodes as runs.

    Raises:
        BadInputError: one line: the file and what is wrong with it, or the option that is wanted.
    """
    joints = joints_of(data, wanted)
    if angles.unit is None:
        raise BadInputError(
            f"{data.folder / INFO}: does not say the unit of its angles; give --units deg, rad, counts, or percent "
            "with --range"
        )
    angles.line(len(joints))
    columns = [[names.index(joint) for joint in joints] for names in (data.action, data.state)]
    parts: dict[int, list[Floats]] = {}
    cells = 0
    for path in _files(data.folder):
        for episode, rows in _rows(path, data):
            if episodes is None or episode in episodes:
                parts.setdefault(episode, []).append(rows)
                cells += rows.size
        if cells > MAX_CELLS:
            raise BadInputError(f"{data.folder}: more than {MAX_CELLS} numbers; choose some with --episodes")
        if len(parts) > MAX_RUNS:
            raise BadInputError(f"{data.folder}: more than {MAX_RUNS} episodes; choose some with --episodes")
    if not parts or (episodes is not None and not episodes <= parts.keys()):
        missing = sorted((episodes or frozenset()) - parts.keys())
        what = f"no episode {', '.join(map(str, missing[:5]))}" if missing else "no episodes"
        raise BadInputError(f"{data.folder}: {what} in it")
    width = len(data.action)
    runs = []
    for episode in sorted(parts):
        rows = np.concatenate(parts.pop(episode))
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
        command, measured = rows[:, 1 : 1 + width][:, columns[0]], rows[:, 1 + width :][:, columns[1]]
        about = {"imported_from": data.folder.resolve().name, "episode": episode, "joints": list(joints)}
        name = f"episode_{episode:06d}"
        runs.append(
            made_run(data.folder, name, rows[:, 0], angles.to_rad(command), angles.to_rad(measured), about)
        )
    return runs


def _files(folder: Path) -> Sequence[Path]:
    """The tables, in order; none outside the folder, not even through a link."""
    root = folder.resolve()
    found = sorted(islice((folder / "data").glob("*/*.parquet"), MAX_FILES + 1))
    if len(found) > MAX_FILES:
        raise BadInputError(f"{folder}: more than {MAX_FILES} files; not read")
    if not found:
        raise BadInputError(f"{folder}: no data/*/*.parquet in it; is the dataset whole?")
    for path in found:
        if not path.resolve().is_relative_to(root):
            raise BadInputError(f"{path}: leads out of the dataset's folder; not read")
    return found


def _rows(path: Path, data: Dataset) -> Iterator[tuple[int, Floats]]:
    """Episode, and rows of time, action and state (n, 1 + actions + states), batch by batch."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        with pq.ParquetFile(
            path, thrift_string_size_limit=1 << 24, thrift_container_size_limit=1 << 20
        ) as file:
            yield from _batches(path, file, data)
    except (pa.ArrowException, ValueError) as error:
        raise BadInputError(f"{path}: not a Parquet table: {' '.join(str(error).split())[:200]}") from None
    except OSError as error:
        why = error.strerror or " ".join(str(error).split())[:200]
        raise BadInputError(f"{path}: cannot read the table: {why}") from None


def _batches(path: Path, file: Any, data: Dataset) -> Iterator[tuple[int, Floats]]:
    there = set(file.schema_arrow.names)
    wide = {ACTION: len(data.action), STATE: len(data.state)}
    for name in (*wide, "episode_index"):
        if name not in there:
            raise BadInputError(f"{path}: column {name} is missing")
    clock = next((name for name in ("timestamp", "frame_index") if name in there), None)
    if clock is None:
        raise BadInputError(f"{path}: neither timestamp nor frame_index is there")
    wanted = [*wide, "episode_index", clock]
    _check_size(path, file, wide)
    for batch in file.iter_batches(batch_size=_BATCH, columns=wanted, use_threads=False):
        columns: Mapping[str, Any] = {name: batch.column(name) for name in wanted}
        time = _numbers(path, columns[clock], clock, 1)
        if clock == "frame_index":
            time = time / data.fps
        rows = np.hstack([time, *(_numbers(path, columns[name], name, wide[name]) for name in wide)])
        of = _numbers(path, columns["episode_index"], "episode_index", 1)[:, 0]
        if not np.isfinite(of).all() or (of < 0).any() or (of != np.floor(of)).any() or (of > 1e9).any():
            raise BadInputError(f"{path}: column episode_index: not the number of an episode")
        for episode in np.unique(of):
            yield int(episode), rows[of == episode]


def _check_size(path: Path, file: Any, wide: Mapping[str, int]) -> None:
    """By the footer; that of a column (``row_group(i).column(j)``) ends the process where it is damaged."""
    about = file.metadata
    rows, width = about.num_rows, 2 + sum(wide.values())
    allowed = FREE_BYTES + MAX_RATIO * path.stat().st_size
    unpacked = sum(about.row_group(index).total_byte_size for index in range(about.num_row_groups))
    if rows * width > MAX_CELLS or 8 * rows * width > allowed or unpacked > allowed:
        raise BadInputError(f"{path}: {rows} rows of {width} numbers are too many for such a file; not read")


def _numbers(path: Path, column: Any, name: str, width: int) -> Floats:
    """A column of numbers, or of lists of ``width`` numbers, as (n, width)."""
    import pyarrow as pa

    kind = column.type
    if pa.types.is_list(kind) or pa.types.is_fixed_size_list(kind) or pa.types.is_large_list(kind):
        flat = column.flatten()
    else:
        flat = column
    if not (pa.types.is_integer(flat.type) or pa.types.is_floating(flat.type)):
        raise BadInputError(f"{path}: column {name}: not numbers but {kind}")
    if len(flat) != len(column) * width or column.null_count:
        raise BadInputError(f"{path}: column {name}: not {width} numbers in every row")
    values = flat.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False)
    return np.asarray(values, dtype=np.float64).reshape(len(column), width)


def parse_episodes(text: str) -> frozenset[int]:
    """``0-9,12`` as numbers.

    Raises:
        BadInputError: not of that form.
    """
    found: set[int] = set()
    for part in text.split(","):
        low, dash, high = (piece.strip() for piece in part.partition("-"))
        if not low.isdecimal() or (dash and not high.isdecimal()) or len(low + high) > 12:
            raise BadInputError(f"--episodes {text[:60]!r}: write numbers and ranges, such as 0-9,12")
        span = range(int(low), int(high or low) + 1)
        if not span or len(span) + len(found) > MAX_RUNS:
            raise BadInputError(
                f"--episodes {text[:60]!r}: {part.strip()} is no range of up to {MAX_RUNS} episodes"
            )
        found.update(span)
    return frozenset(found)
