"""The rule that turns evidence into a probability, fitted to causes of which it is known whether they were right."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np

from snakebot.diagnosis.verdict.probability import (
    CALIBRATION_FILE,
    FEATURES,
    SCHEMA,
    Calibration,
    CauseFeatures,
)

PARTS = 10  # of the cases, each left out once to see how well a rule does; chosen
PRIOR_WEIGHT = 0.3  # of the ridge on the rule's weights: few cases must not make it rash
# Of the ridge towards the present rule where that is carried on: it rests on more causes than come to it; chosen, of 1,
# 3, 10 and 30, by how well opened sets of faults and of worn robots are told with it.
PRESENT_WEIGHT = 10.0
LEAST_SHARE = 0.1  # of what one expects a weight to be, that it has in any case; chosen
# Intercept and weights that one expects: a lead, a closed gap and a large share in it speak for a cause, a rest
# against it.
PRIOR = np.array([0.0, 1.0, -1.0, 2.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0])


def evidence_of(cause: dict[str, object]) -> CauseFeatures | None:
    """The evidence that stands beside a cause; None where its probability comes from elsewhere."""
    found = cause["evidence"]
    if not isinstance(found, dict) or "lead" not in found:
        return None
    return CauseFeatures(
        lead=found["lead"],
        rest=found["rest"],
        closed=found["closed"],
        share=found["share"],
        motions=int(found["motions"]),
        explained=bool(found["explained"]),
        own=bool(found["own"]),
        worn=bool(found["worn"]),
        together=int(found["together"]),
    )


def fit(
    evidence: Sequence[CauseFeatures], right: Sequence[bool], present: Calibration | None = None
) -> tuple[float, list[float]]:
    """Intercept and weights of a logistic rule, with a weak ridge towards the shape one expects. A weight that is
    expected to be above or below zero is so by a tenth of that at least: chance must not make a rest speak for a cause,
    nor for nothing.

    ``present``: the rule that is carried on; a weight of zero, where that is expected, is of a feature that it did not
    know.
    """
    from scipy.optimize import minimize

    features = np.reshape([e.vector() for e in evidence], (-1, PRIOR.size - 1))  # of no cause: the prior
    label = np.array(right, dtype=float)
    stacked = np.column_stack([np.ones(label.size), features])
    expected, strength = PRIOR, np.where(np.arange(PRIOR.size) > 0, PRIOR_WEIGHT, 0.0)
    if present is not None:
        expected = np.array([present.intercept, *present.weights])
        strength = np.where((expected == 0.0) & (PRIOR == 0.0), PRIOR_WEIGHT, PRESENT_WEIGHT)

    def loss(w: np.ndarray) -> float:
        z = stacked @ w
        ridge = np.sum(strength * np.square(w - expected))
        return float(np.sum(np.logaddexp(0, z) - label * z) + ridge)

    bounds = [(LEAST_SHARE * w if w > 0 else None, LEAST_SHARE * w if w < 0 else None) for w in PRIOR]
    found = minimize(loss, expected, method="L-BFGS-B", bounds=bounds).x
    return float(found[0]), [float(v) for v in found[1:]]


def fitted_without_its_own(
    evidence: Sequence[CauseFeatures],
    right: Sequence[bool],
    case: Sequence[int],
    present: Calibration | None = None,
) -> np.ndarray:
    """(n,) probability of each cause by the rule that is fitted to the other parts of the cases."""
    part = np.array(case) % PARTS
    out = np.zeros(len(evidence))
    for left_out in np.unique(part):
        kept = np.flatnonzero(part != left_out).tolist()
        intercept, weights = fit([evidence[i] for i in kept], [right[i] for i in kept], present)
        rows = np.flatnonzero(part == left_out).tolist()
        table = np.array([evidence[i].vector() for i in rows])
        out[rows] = 1 / (1 + np.exp(-(intercept + table @ np.array(weights))))
    return out


def write(
    command: str,
    first_seeds: Sequence[int],
    cases: int,
    evidence: Sequence[CauseFeatures],
    right: Sequence[bool],
    present: Calibration | None = None,
) -> None:
    """Write ``calibration.json`` into the package; ``present``: the rule that is carried on, named in it."""
    intercept, weights = fit(evidence, right, present)
    if present is not None:
        command, cases = f"{present.command}; then {command} --carry-on", present.cases + cases
        first_seeds = [*present.first_seeds, *first_seeds]
    data = {
        "schema": SCHEMA,
        "command": command,
        "first_seeds": list(first_seeds),
        "cases": cases,
        "causes": len(evidence) + (0 if present is None else present.causes),
        "features": list(FEATURES),
        "intercept": round(intercept, 4),
        "weights": [round(w, 4) for w in weights],
    }
    CALIBRATION_FILE.write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    print(
        f"wrote {CALIBRATION_FILE.name}: {len(evidence)} causes of {cases} cases, {sum(right)} of them right"
    )
