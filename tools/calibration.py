"""The rule that turns evidence into a probability, fitted to causes of which it is known whether they were right."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np

from snakebot.diagnosis.verdict.probability import CALIBRATION_FILE, FEATURES, SCHEMA, CauseFeatures

PARTS = 10  # of the cases, each left out once to see how well a rule does; chosen
PRIOR_WEIGHT = 0.3  # of the ridge on the rule's weights: few cases must not make it rash
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


def fit(evidence: Sequence[CauseFeatures], right: Sequence[bool]) -> tuple[float, list[float]]:
    """Intercept and weights of a logistic rule, with a weak ridge towards the shape one expects. A weight that is
    expected to be above or below zero is not on the other side: chance must not make a rest speak for a cause.
    """
    from scipy.optimize import minimize

    features = np.reshape([e.vector() for e in evidence], (-1, PRIOR.size - 1))  # of no cause: the prior
    label = np.array(right, dtype=float)
    stacked = np.column_stack([np.ones(label.size), features])

    def loss(w: np.ndarray) -> float:
        z = stacked @ w
        ridge = PRIOR_WEIGHT * np.sum(np.square(w - PRIOR)[1:])
        return float(np.sum(np.logaddexp(0, z) - label * z) + ridge)

    bounds = [(0.0 if w > 0 else None, 0.0 if w < 0 else None) for w in PRIOR]
    found = minimize(loss, PRIOR, method="L-BFGS-B", bounds=bounds).x
    return float(found[0]), [float(v) for v in found[1:]]


def fitted_without_its_own(
    evidence: Sequence[CauseFeatures], right: Sequence[bool], case: Sequence[int]
) -> np.ndarray:
    """(n,) probability of each cause by the rule that is fitted to the other parts of the cases."""
    part = np.array(case) % PARTS
    out = np.zeros(len(evidence))
    for left_out in np.unique(part):
        kept = np.flatnonzero(part != left_out).tolist()
        intercept, weights = fit([evidence[i] for i in kept], [right[i] for i in kept])
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
) -> None:
    """Write ``calibration.json`` into the package."""
    intercept, weights = fit(evidence, right)
    data = {
        "schema": SCHEMA,
        "command": command,
        "first_seeds": list(first_seeds),
        "cases": cases,
        "causes": len(evidence),
        "features": list(FEATURES),
        "intercept": round(intercept, 4),
        "weights": [round(w, 4) for w in weights],
    }
    CALIBRATION_FILE.write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    print(
        f"wrote {CALIBRATION_FILE.name}: {len(evidence)} causes of {cases} cases, {sum(right)} of them right"
    )
