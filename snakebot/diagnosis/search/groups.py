"""Which effects this data cannot tell apart: the winner is simulated at its fit, and the rivals are fitted to that.

If a rival then comes as close as the noise allows, no search over this data could have preferred one to the
other on good grounds, whichever happened to win. The same holds where both leave nothing beyond noise and tolerance,
and one leads by little. Nothing is wired in: the ties of one session are not those of another.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from snakebot.diagnosis.evidence.gap import gap_of
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.score import ALIKE, Scoring
from snakebot.diagnosis.fit.hypothesis import Box
from snakebot.diagnosis.fit.parallel import in_parallel
from snakebot.diagnosis.fit.step import A_THOUSANDTH, to_scale
from snakebot.diagnosis.fit.trial import Trial, run_trial
from snakebot.diagnosis.search.acceptance import lead, touched
from snakebot.diagnosis.sizes import CLEAR, HALF, LITTLE

# Lead in score beyond which a rival is not refitted to simulated data: e times the mean square, of which a score is
# half of the logarithm.
TOO_FAR = HALF


def indistinguishable(evidence: Evidence, best: Trial, rivals: Sequence[Trial], seed: int = 0) -> list[Trial]:
    """Those of ``rivals`` that this data cannot tell from ``best``; ``seed``: of the noise that is drawn."""
    scoring = evidence.scoring
    near = [r for r in rivals if lead(scoring, best, r).mean < TOO_FAR and not degenerate(best, r)]
    if not near:
        return []
    ahead = _behind_either_way(evidence, best, [r for r in near if _leads(scoring, best, r)])
    clear: set[Trial] = set()
    if ahead:
        ideal = _as_if(evidence, best, seed)
        truth, *refits = in_parallel(
            lambda t: run_trial(ideal, t.hypothesis, [t.theta], cross=False), [best, *ahead]
        )
        clear = {
            r for r, refit in zip(ahead, refits, strict=True) if _apart(ideal.scoring, truth, refit) >= ALIKE
        }
    return [r for r in near if r not in clear]


def _leads(scoring: Scoring, best: Trial, rival: Trial) -> bool:
    """Whether ``best`` is clearly ahead on the data itself."""
    seen = lead(scoring, best, rival)
    # sound robots differ by more than what is ``ALIKE`` elsewhere
    enough = LITTLE if not gap_of(scoring, rival.held_square).any else ALIKE
    return seen.z >= CLEAR and seen.mean >= enough


def _behind_either_way(evidence: Evidence, best: Trial, rivals: Sequence[Trial]) -> list[Trial]:
    """Those of ``rivals`` that fall behind under the torques of the measured motion, too, where these will do: on which
    side of its play a joint of the simulated body comes to rest may be chance.
    """
    simulator = evidence.predictor.simulator

    def without_body(trial: Trial) -> Trial:
        return run_trial(evidence, trial.hypothesis, [trial.theta], rough=True, cross=False)

    if not rivals or not simulator.needs_body(best.specs) or simulator.rough_needs_body(best.specs):
        return list(rivals)
    apart = [r for r in rivals if not simulator.rough_needs_body(r.specs)]
    roughly, *others = in_parallel(without_body, [best, *apart])
    near = {r for r, o in zip(apart, others, strict=True) if not _leads(evidence.scoring, roughly, o)}
    return [r for r in rivals if r not in near]


def _apart(scoring: Scoring, truth: Trial, refit: Trial) -> float:
    """The lead of the truth over a rival fitted to what it made."""
    rows = touched(scoring, truth, refit)
    return scoring.gain(truth.fitted_square, refit.fitted_square, rows).mean if rows.any() else 0.0


def degenerate(best: Trial, rival: Trial) -> bool:
    """Whether a rival with more parameters has shrunk to the simpler ``best``: one of them is at its bound."""
    if rival.theta.size <= best.theta.size:
        return False
    box = Box.of(rival.hypothesis.parameters)
    lower, value, upper = to_scale(np.stack([box.lower, rival.theta, box.upper]), box)
    near = A_THOUSANDTH * (upper - lower)
    return bool(((value - lower < near) | (box.logarithmic & (upper - value < near))).any())


def _as_if(evidence: Evidence, best: Trial, seed: int) -> Evidence:
    """The evidence in which ``best`` is the truth: its readings and a draw of the noise, on the same samples.

    What the best explanation leaves over is noise as well: two effects that differ by less than the rest are
    not told apart.
    """
    rng = np.random.default_rng(seed)
    predicted = evidence.predictor.simulator.predict(best.specs)
    blocks = evidence.angles.blocks
    left = np.sqrt(
        [
            float(np.median(best.held_square[: blocks.count][blocks.joint == joint]))
            if np.any(blocks.joint == joint)
            else 0.0
            for joint in range(evidence.data.joints)
        ]
    )
    readings = []
    for run, made in zip(evidence.data.runs, predicted, strict=True):
        noise = rng.normal(size=run.measured_rad.shape) * left
        readings.append(np.where(np.isfinite(run.measured_rad), made.reading_rad + noise, np.nan))
    value = None
    if evidence.ground is not None:
        features = evidence.predictor.ground_features(best.specs)
        measured, allowed = evidence.ground.features, evidence.ground.allowed_square
        spread = np.sqrt(np.minimum(measured.floor_square, allowed))
        value = (
            np.where(np.isfinite(features), features, measured.value) + rng.normal(size=spread.size) * spread
        )
    return evidence.of_readings(readings, value)
