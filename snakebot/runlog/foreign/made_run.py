"""Arrays that came from a foreign recording as a run, under the same checks as a table of a session."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.runlog.merging import EPOCH_S
from snakebot.runlog.number_table import NumberTable
from snakebot.runlog.run import Run
from snakebot.runlog.session import run_from_table


def made_run(
    path: Path, name: str, t_s: Floats, command_rad: Floats, measured_rad: Floats, about: Mapping[str, Any]
) -> Run:
    """A run of times (N,) and angles (N, k); times of a wall clock begin at zero.

    Raises:
        BadInputError: infinite numbers, times that do not rise, angles that no robot reaches.
    """
    metadata = dict(about)
    if t_s.size and t_s[0] > EPOCH_S:
        metadata["started_unix_s"] = float(t_s[0])
        t_s = t_s - t_s[0]
    columns = {"t_s": t_s}
    for kind, angles in (("cmd", command_rad), ("enc", measured_rad)):
        if np.isinf(angles).any() or np.isinf(t_s).any():
            raise BadInputError(f"{path}: {name}: an infinite number among the {kind} angles or times")
        columns |= {f"{kind}_{joint + 1}_rad": angles[:, joint] for joint in range(angles.shape[1])}
    table = NumberTable(columns, (), 1)
    where = path / name if path.is_dir() else path
    return run_from_table(where, table, command_rad.shape[1], set(), name=name, metadata=metadata)


def chosen(wanted: tuple[str, ...], there: tuple[str, ...], where: str, what: str) -> tuple[str, ...]:
    """The joints that were asked for, or all.

    Raises:
        BadInputError: one is not there; the line names those that are.
    """
    for name in wanted:
        if name not in there:
            raise BadInputError(
                f"{where}: {what} has no joint {name}; it has {', '.join(there[:20]) or 'none'}"
            )
    return wanted or there
