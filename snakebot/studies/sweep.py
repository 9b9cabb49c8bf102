"""Many gaits in chunks: resumable, with progress, on this machine's cores or on a cluster.

A sweep is cut into chunks that are computed and stored one by one as Parquet. A sweep that is started again reads the
chunks that are there and computes the others, so that an interrupted one loses a chunk at most. The folder remembers
what was swept; another sweep is refused there.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from snakebot.arrays import Floats
from snakebot.cluster import Workers
from snakebot.errors import BadInputError, cannot_write
from snakebot.robot import Robot

if TYPE_CHECKING:
    import pyarrow as pa

SweepCallback = Callable[[int, int], None]  # gaits done, gaits in all

CHUNK = 256  # gaits: at least a tenth of a second of work, so that handing it over costs nothing
COLUMNS = (
    "alpha_rad",
    "beta_rad",
    "omega_rad_s",
    "offset_rad",
    "speed_m_s",
    "forward_speed_m_s",
    "power_in_w",
    "power_dissipated_w",
    "turn_rad",
    "tracking_error",
)
SPEED, POWER = COLUMNS.index("speed_m_s"), COLUMNS.index("power_in_w")


@dataclass(frozen=True)
class Conditions:
    """Everything but the gaits that a sweep's result depends on. Plain values, so that it can be sent and hashed."""

    robot: Mapping[str, Any]  # as Robot.to_mapping gives it
    free_joints: tuple[int, ...] = ()
    rigid_joints: Mapping[int, float] = field(default_factory=dict)  # joint to angle in rad
    servo_time_constant_s: float = 0.0  # 0: ideal tracking, as in the paper's simulations
    cycles: int = 8
    averaged_cycles: int = 4

    @classmethod
    def of(cls, robot: Robot, **options: Any) -> Conditions:
        return cls(robot.to_mapping(), **options)

    def fingerprint(self, gaits: Floats) -> str:
        """Changes when anything does that the result depends on."""
        text = json.dumps(
            {**vars(self), "robot": dict(self.robot), "rigid_joints": sorted(self.rigid_joints.items())},
            sort_keys=True,
            default=str,
        )
        return hashlib.sha256(text.encode() + gaits.tobytes()).hexdigest()[:16]


def compute(conditions: Conditions, gaits: Floats) -> Floats:
    """One chunk: rows of ``COLUMNS`` for gaits of shape (G, 4). Runs on any machine that has snakebot."""
    from snakebot.physics import ChainModel, simulate_gaits
    from snakebot.robot import robot_from_mapping

    robot = robot_from_mapping(conditions.robot, "sweep")
    if robot.body is None:
        raise BadInputError(f"robot {robot.name!r} has no body: a bench of servos does not move over ground")
    result = simulate_gaits(
        ChainModel.from_body(robot.body),
        gaits,
        free_joints=conditions.free_joints,
        rigid_joints=conditions.rigid_joints,
        servo_time_constant_s=conditions.servo_time_constant_s,
        cycles=conditions.cycles,
        averaged_cycles=conditions.averaged_cycles,
    )
    return np.column_stack([result.gaits, *(getattr(result, name) for name in COLUMNS[4:])])


def sweep(
    conditions: Conditions,
    gaits: npt.ArrayLike,
    folder: str | os.PathLike[str] | None = None,
    *,
    progress: SweepCallback | None = None,
    dask: str | None = None,
) -> Floats:
    """Simulate gaits of shape (G, 3) or (G, 4); returns rows of ``COLUMNS`` in the order of the gaits.

    Args:
        folder: where chunks are kept; None computes everything at once in memory.
        dask: address of a dask.distributed scheduler that does the chunks instead of this machine.

    Raises:
        BadInputError: the folder holds another sweep, or the gaits make no sense.
    """
    table = _four_columns(gaits)
    chunks = [table[first : first + CHUNK] for first in range(0, len(table), CHUNK)]
    results: dict[int, Floats] = {}
    store = _Store(Path(folder), conditions.fingerprint(table)) if folder is not None else None
    if store is not None:
        results = {index: rows for index in range(len(chunks)) if (rows := store.load(index)) is not None}
    done = sum(len(rows) for rows in results.values())
    if progress is not None:
        progress(done, len(table))
    missing = [index for index in range(len(chunks)) if index not in results]
    with Workers(dask) as workers:
        for index, rows in workers.results(compute, {i: (conditions, chunks[i]) for i in missing}):
            results[index] = rows
            if store is not None:
                store.save(index, rows)
            done += len(rows)
            if progress is not None:
                progress(done, len(table))
    return np.concatenate([results[index] for index in range(len(chunks))])


def _four_columns(gaits: npt.ArrayLike) -> Floats:
    table = np.atleast_2d(np.asarray(gaits, dtype=np.float64))
    if table.ndim != 2 or table.shape[1] not in (3, 4) or len(table) == 0:
        raise BadInputError(f"gaits have shape {table.shape}; give (G, 3) or (G, 4) with G of at least 1")
    if table.shape[1] == 3:
        table = np.column_stack([table, np.zeros(len(table))])
    return np.ascontiguousarray(table)


class _Store:
    """Chunks of one sweep in a folder; each file appears whole or not at all."""

    def __init__(self, folder: Path, fingerprint: str) -> None:
        self.folder = folder / "chunks"
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            mark = self.folder / "sweep.txt"
            if mark.exists() and mark.read_text(encoding="utf-8").strip() != fingerprint:
                raise BadInputError(
                    f"{folder}: holds another sweep (other robot, gaits or conditions): give another --out, or "
                    "delete it"
                )
            mark.write_text(fingerprint + "\n", encoding="utf-8")
        except OSError as error:
            raise BadInputError(f"{folder}: cannot keep results there: {error.strerror}") from None

    def load(self, index: int) -> Floats | None:
        import pyarrow as pa
        import pyarrow.parquet as pq

        path = self._path(index)
        if not path.exists():
            return None
        try:
            table = pq.read_table(path)
        except (OSError, pa.ArrowInvalid):
            return None  # damaged: compute it again
        return np.column_stack([table.column(name).to_numpy() for name in COLUMNS])

    def save(self, index: int, rows: Floats) -> None:
        write_parquet(self._path(index), to_table(rows))

    def _path(self, index: int) -> Path:
        return self.folder / f"{index:05d}.parquet"


def to_table(rows: Floats, **more: Sequence[Any]) -> pa.Table:
    """Rows of ``COLUMNS`` as a table, with further columns."""
    import pyarrow as pa

    return pa.table({**{name: rows[:, i] for i, name in enumerate(COLUMNS)}, **more})


def write_parquet(path: Path, table: pa.Table) -> None:
    """Write a table so that it is there whole or not at all.

    Raises:
        BadInputError: the file cannot be written.
    """
    import pyarrow.parquet as pq

    part = path.with_name(path.name + ".part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        pq.write_table(table, part)
        os.replace(part, path)
    except OSError as error:
        raise cannot_write(f"{path}: cannot write the results", error) from None
