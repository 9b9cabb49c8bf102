"""How sure: from how far an explanation leads and how little it leaves over to a calibrated probability.

The shape of the rule is fixed here, its numbers come from ``calibration.json``, which
``tools/blind/calibrate`` or ``tools/calibrate_diagnosis`` writes from simulated sessions with known causes (the command
and the seeds stand in the file).
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

CALIBRATION_FILE = Path(__file__).with_name("calibration.json")
SCHEMA = "snakebot.calibration/1"

HIGHEST, LOWEST = 0.99, 0.01
ONE_MOTION_AT_MOST = 0.5  # nothing could be held out: never more than a guess
NOT_THE_WHOLE_STORY = (
    100.0  # mean square left over the allowed one, above which a cause is never more than likely
)
LIKELY = 0.6
FEATURES = ("lead", "rest", "closed", "rivals", "motions", "explained")


@dataclass(frozen=True)
class Evidence:
    """What a probability is made of, for one cause.

    Attributes:
        lead: held-out score by which the group leads the best explanation outside it.
        rest: mean square that is left on the blocks it touches, over what noise and tolerance allow.
        closed: share of the gap that is closed there.
        rivals: how many effects are in the group beside it.
        motions: different motions in the session; 1 where only one shows the cause.
        explained: whether all causes together leave too little over to speak of.
    """

    lead: float
    rest: float
    closed: float
    rivals: int
    motions: int
    explained: bool

    def features(self) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        """(F,) in the order of ``FEATURES``, each of order one."""
        return np.array(
            [
                np.log1p(max(self.lead, 0.0) / 0.02) / 3,
                np.log1p(max(self.rest, 0.0)) / 2,
                min(max(self.closed, 0.0), 1.0),
                float(min(self.rivals, 3)),
                np.log(max(self.motions, 1)),
                float(self.explained),
            ]
        )


@dataclass(frozen=True)
class Calibration:
    """Weights of a logistic rule over ``FEATURES``, and how sure to be of a verdict."""

    intercept: float
    weights: tuple[float, ...]
    command: str
    cases: int


@cache
def calibration(path: Path = CALIBRATION_FILE) -> Calibration:
    """The calibration that comes with snakebot.

    Raises:
        ValueError: the file is of another schema.
    """
    data = json.loads(path.read_text(encoding="utf-8"))
    if data.get("schema") != SCHEMA or tuple(data["features"]) != FEATURES:
        raise ValueError(f"{path}: not a calibration of this version")
    return Calibration(
        float(data["intercept"]),
        tuple(float(w) for w in data["weights"]),
        str(data["command"]),
        int(data["cases"]),
    )


def probability(evidence: Evidence) -> float:
    """Probability that the group holds the cause."""
    rule = calibration()
    x = rule.intercept + float(np.dot(rule.weights, evidence.features()))
    p = float(np.clip(1 / (1 + np.exp(-x)), LOWEST, HIGHEST))
    if evidence.rest > NOT_THE_WHOLE_STORY:
        p = min(p, LIKELY)
    return min(p, ONE_MOTION_AT_MOST) if evidence.motions < 2 else p


def shared(group: float, scores: Sequence[float]) -> list[float]:
    """Share a group's probability among its members, by how their held-out scores compare."""
    s = np.array(scores, dtype=np.float64)
    weight = np.exp((s - s.max()) / 0.02)
    return [float(group * w) for w in weight / weight.sum()]
