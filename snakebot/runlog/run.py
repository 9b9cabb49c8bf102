"""A run and a session as numpy arrays: what analysis and diagnosis work on, whatever file they came from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from snakebot.arrays import AnyArray, Floats
from snakebot.errors import BadInputError
from snakebot.in_words import plain
from snakebot.robot import Robot

if TYPE_CHECKING:
    from snakebot.gait import Gait

_LONGEST_END = 400  # characters; an error's line has fewer
FINISHED, CUT_SHORT = "finished", "cut short"


@dataclass(frozen=True, eq=False)
class Run:
    """One motion of the robot: N samples of k joints, SI units.

    Raises:
        BadInputError: the arrays do not have the shapes below.
    """

    name: str
    t_s: Floats  # (N,) rising, need not be uniform
    command_rad: Floats  # (N, k); nan = servo off
    measured_rad: Floats  # (N, k); nan = sample lost
    applied_rad: Floats | None = None  # (N, k) set-point that the board says it executes; nan = not reported
    pose: Floats | None = (
        None  # (N, 3): x_m, y_m of the centre of mass, heading_rad; nan = not known, as all headings may be
    )
    gait: Gait | None = None
    forward_speed_m_s: float | None = None
    repeat_of: str | None = None  # name of the run that this one repeats
    hold_out: bool = False  # never fit on this run
    extra: Mapping[str, AnyArray] = field(default_factory=dict)  # further columns, each (N,)
    metadata: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        shape = self.command_rad.shape
        if len(shape) != 2:
            raise BadInputError(f"run {self.name}: command_rad has shape {shape}, not (samples, joints)")
        wanted: dict[str, tuple[AnyArray | None, tuple[int, ...]]] = {
            "t_s": (self.t_s, shape[:1]),
            "measured_rad": (self.measured_rad, shape),
            "applied_rad": (self.applied_rad, shape),
            "pose": (self.pose, (shape[0], 3)),
            **{name: (column, shape[:1]) for name, column in self.extra.items()},
        }
        for name, (array, expected) in wanted.items():
            if array is not None and array.shape != expected:
                raise BadInputError(f"run {self.name}: {name} has shape {array.shape}, not {expected}")

    @property
    def joints(self) -> int:
        return int(self.command_rad.shape[1])

    @property
    def ended(self) -> str | None:
        """How the run ended, in the log's words on one line; None where that is not known, as of a table."""
        said = self.metadata.get("ended")
        if not isinstance(said, str):
            return None
        return plain(said[:_LONGEST_END])

    @property
    def aborted(self) -> bool:
        """Whether it is known to have ended otherwise than it was meant to: it is no measurement of its gait."""
        return self.ended not in (None, FINISHED)

    @property
    def duration_s(self) -> float:
        return float(self.t_s[-1] - self.t_s[0]) if self.t_s.size else 0.0

    def __len__(self) -> int:
        return int(self.t_s.size)


@dataclass(frozen=True, eq=False)
class Session:
    """Runs of one robot, and the robot as the simulation knows it before any diagnosis."""

    robot: Robot
    runs: tuple[Run, ...]
    path: Path | None = None
    warnings: tuple[str, ...] = ()  # what the reader noticed and went on

    def __getitem__(self, name: str) -> Run:
        for run in self.runs:
            if run.name == name:
                return run
        raise KeyError(name)
