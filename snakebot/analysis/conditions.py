"""What a run was made under beside its gait: faults, effects, probe, robot; and how it ended."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from snakebot.analysis.faults import other_effects
from snakebot.in_words import plain, shortened

if TYPE_CHECKING:
    from snakebot.analysis.run_analysis import RunAnalysis

CONDITIONS = ("fault", "effect", "probe", "ended")


@dataclass(frozen=True, order=True)
class Setup:
    """What runs must have in common to be averaged. ``robot`` says where it was simulated; ``effects`` are those of
    the simulated board, without joint faults; ``offset_deg`` is the gait's constant bend."""

    robot: str = ""
    effects: str = ""
    offset_deg: float = 0.0

    def text(self, robot: bool = True) -> str:
        """What is not as usual, with the robot where several are told apart; empty if there is nothing."""
        parts = [self.robot] if robot else []
        parts += [f"offset {self.offset_deg:g}°"] if self.offset_deg else []
        parts += [f"with {shortened(self.effects, 60)}"] if self.effects else []
        return ", ".join(parts)


USUAL = Setup()


def setup_of(run: RunAnalysis) -> Setup:
    offset = run.gait.offset_rad if run.gait is not None else 0.0
    effects = plain(" ".join(other_effects(run.run.metadata)))
    return Setup(robot_text(run), effects, round(math.degrees(offset), 3))


def robot_text(run: RunAnalysis) -> str:
    """As in ``snakebot log list``."""
    return plain(run.robot.name) + (" (simulated)" if run.run.metadata.get("simulated") is True else "")


def condition(run: RunAnalysis, name: str) -> str:
    """One of ``CONDITIONS``, whole; empty where it is as usual."""
    if name == "ended":
        return (run.run.ended or "").partition(":")[0] if run.run.aborted else ""
    value = run.run.metadata.get(name if name == "probe" else f"{name}s")
    return plain(" ".join(map(str, value)) if isinstance(value, list) else str(value or ""))


def conditions_text(run: RunAnalysis) -> str:
    """All of them in a line: ``fault free:3, ended interrupted``."""
    told = [(name, condition(run, name)) for name in CONDITIONS]
    return ", ".join(f"{name} {shortened(text, 60)}" for name, text in told if text)
