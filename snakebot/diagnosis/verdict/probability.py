"""How sure: from how far an explanation leads and how little it leaves over to a calibrated probability.

The shape of the rule is fixed here, its numbers come from ``calibration.json``, which
``tools/blind/calibrate`` or ``tools/calibrate_diagnosis`` writes from simulated sessions with known causes (the command
and the seeds are in the file).
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TypeVar

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.score import ALIKE
from snakebot.diagnosis.result import Cause, RankingEntry
from snakebot.diagnosis.sizes import HALF, LIKELY, LITTLE, LOWEST, NEXT_TO_NOTHING, NO_PERCENT, SURE

CALIBRATION_FILE = Path(__file__).parents[1] / "calibration.json"
SCHEMA = "snakebot.calibration/1"

# Highest probability of a cause of the body beside a rest over ground. Joint angles are measured there, so no error of
# a servo's model is in it: another law, or another cause, is likelier than not; chosen.
MOST_BESIDE_GROUND_REST = HALF - NEXT_TO_NOTHING
# Highest probability where something is guessed, so that no cause is sure: set-points between the rows of slow logs, or
# what an effect needs and the description lacks, as the arm that a servo on a bench carries; chosen.
MOST_WHERE_GUESSED = SURE - NEXT_TO_NOTHING
FEATURES = (
    "lead", "rest", "closed", "share", "explained", "own", "beside_wear", "together", "together_with_a_rest",
)  # fmt: skip


Told = TypeVar("Told", Cause, RankingEntry)


@dataclass(frozen=True)
class CauseFeatures:
    """What a probability is made of, for one cause.

    Attributes:
        lead: held-out score by which the group leads the best explanation outside it.
        rest: mean square that is left on the blocks it touches, over what noise and tolerance allow.
        closed: share of the gap that is closed there.
        share: of the whole gap, what it carries in the budget; 1 where nothing is shared out.
        motions: different motions in the session; 1 where only one shows the cause, so that nothing can be held out.
        explained: whether all causes together leave too little over to speak of.
        own: whether each of its joints has values of its own, as joints do that are worn, or it is an everyday effect
            beside such a one.
        worn: whether joints have values of their own of this cause or of another.
        together: how many causes there are in all. A robot that has a little of everything is rarely explained to the
            last, so that many beside a rest say more than one.
    """

    lead: float
    rest: float
    closed: float
    share: float
    motions: int
    explained: bool
    own: bool
    worn: bool
    together: int

    def vector(self) -> Floats:
        """(F,) in the order of ``FEATURES``, each of order one; of a gap that is as good as closed, less says nothing
        more: tolerances are no better known. The rest speaks against a cause that is said to be the only one; of
        several, each is less likely to have a part in the gap at all the less of it it carries. Where each joint has
        values of its own the lead says nothing: a lag of the joints' own leads far even where it has hardly a part in
        the gap. Beside such wear, which takes up what it can, a cause of another kind is hardly needed for nothing.
        """
        many = np.log(max(self.together, 1))
        return np.array(
            [
                0.0 if self.own else np.log1p(max(self.lead, 0.0) / ALIKE) / 3,
                np.log1p(max(self.rest, 0.0)) / 2 if self.together < 2 else 0.0,
                -np.log10(np.clip(1 - self.closed, NO_PERCENT, 1.0)) / 2,
                np.log10(np.clip(self.share, NO_PERCENT, 1.0)) / 2 if self.together > 1 else 0.0,
                float(self.explained),
                float(self.own),
                float(self.worn and not self.own),
                many,
                many * (not self.explained),
            ]
        )


@dataclass(frozen=True)
class Calibration:
    """Weights of a logistic rule over ``FEATURES``, and how sure to be of a verdict."""

    intercept: float
    weights: tuple[float, ...]
    command: str
    cases: int
    causes: int
    first_seeds: tuple[int, ...]


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
        int(data["causes"]),
        tuple(int(seed) for seed in data["first_seeds"]),
    )


def probability(features: CauseFeatures) -> float:
    """Probability that the group holds the cause; a guess, no likelier than not, where nothing could be held out."""
    rule = calibration()
    x = rule.intercept + float(np.dot(rule.weights, features.vector()))
    p = float(np.clip(1 / (1 + np.exp(-x)), LOWEST, 1 - LOWEST))
    if LITTLE**2 * features.rest > 1.0:  # what is allowed is little beside what is left
        p = min(p, LIKELY)
    return min(p, HALF) if features.motions < 2 else p


def shared(group: float, scores: Sequence[float]) -> list[float]:
    """Share a group's probability among its members: ``ALIKE`` less held-out score makes one e times less likely."""
    s = np.array(scores, dtype=np.float64)
    weight = np.exp((s - s.max()) / ALIKE)
    return [float(group * w) for w in weight / weight.sum()]


def beside(best: float, score: float, scores: Sequence[float], most: float) -> list[float]:
    """Probabilities of explanations that lost against one of probability ``best`` and held-out ``score``: none above
    it, the less the lower their ``scores``, ``most`` in all.
    """
    s = np.array(scores, dtype=np.float64)
    likely = best * np.exp(np.minimum(s - score, 0.0) / ALIKE)
    return [float(p) for p in likely * min(1.0, most / max(float(likely.sum()), 1e-300))]


def at_most(entry: Told, most: float = MOST_WHERE_GUESSED) -> Told:
    """A cause, or a line of the ranking, with no probability above ``most``."""
    return entry.model_copy(update={"probability": min(entry.probability, most)})
