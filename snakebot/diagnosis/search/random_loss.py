"""Set-points lost at random: their mark is not in the mean but in delays that all joints share and that have no memory.

A set-point that is lost leaves every joint behind by its own rate times the same short time. So the residuals are taken
apart into that common delay and the rest: where the common delay explains most of them, and what it was a third of a
second ago says nothing about now, set-points get lost (or come at random times, which a robot feels no differently).
A log that lacks rows, or was stamped unevenly, shakes alike but delays nothing: so the mean must show the loss as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.angles import AngleEvidence
from snakebot.diagnosis.evidence.blocks import mean_difference
from snakebot.diagnosis.evidence.data import FEWEST_SAMPLES, Data, link_is_clean
from snakebot.diagnosis.evidence.floor import Floor
from snakebot.diagnosis.evidence.gap import gap_of
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.repeats import FORGOTTEN_S
from snakebot.diagnosis.evidence.score import Scoring
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.trial import Trial, run_trial
from snakebot.diagnosis.fit.uncertainty import interval, standard_errors
from snakebot.diagnosis.search.chance import too_random
from snakebot.diagnosis.search.library import Library
from snakebot.diagnosis.search.rounds import MOST_EFFECTS
from snakebot.diagnosis.search.search import SearchResult
from snakebot.diagnosis.sizes import CLEAR, HALF, LITTLE, MUCH
from snakebot.effects.registry import find_effect

START_PROBABILITIES = (LITTLE, MUCH, HALF)  # of losing a set-point, from which a fit starts


def with_random_loss(
    gathered: Evidence, library: Library, found: SearchResult, *, quick: bool
) -> SearchResult:
    """Lost set-points in the place of a delay, where what is left over shows them and they predict clearly better.

    They move the body between the samples, which no replay of samples shows: effects of the body are left out, too;
    and with the delay also where lost set-points may not be named. What nothing tests, as one motion alone shows it,
    gives way as a whole.

    ``gathered``: the evidence as the search found it.
    """
    if link_is_clean(gathered.data):
        return found
    if found.untested:
        tested = SearchResult(
            gathered, found.nominal, found.nominal, found.singles, (), (found.nominal,), (), found.fits
        )
        instead = with_random_loss(gathered, library, tested, quick=quick)
        return found if instead is tested else instead
    evidence = found.evidence
    if not gap_of(evidence.scoring, found.nominal.held_square).significant.any() and not unsteady(
        evidence.floor
    ):
        return found
    if not random_delay(evidence.data, evidence.floor, found.best).evident:
        return found
    effect = next((e for e in library.effects if e.stage == "link" and "scatter" in e.shows_in), None)
    terms = found.best.hypothesis.terms
    stays = [
        i for i, t in enumerate(terms) if "delay" not in find_effect(t.effect).covers and t.stage != "body"
    ]
    if effect is None:
        if stays and len(stays) == len(terms):
            return found
        return _ended(found, stays, _base(evidence, found, stays))
    if len(stays) == MOST_EFFECTS:
        return found
    loss = _with_loss(evidence, found.best, stays, effect.name)
    less = {i: _with_loss(evidence, found.best, [k for k in stays if k != i], effect.name) for i in stays}
    needed = [i for i in stays if predicts_better(evidence.angles, evidence.scoring, loss, less[i])]
    if len(needed) < len(stays):  # what took the place of a loss that had no name yet
        stays = needed
        loss = _with_loss(evidence, found.best, stays, effect.name)
    if too_random(evidence, loss):
        return found
    base = _base(evidence, found, stays)
    error = standard_errors(evidence, loss, tolerances=not quick)[-1]
    ends = interval(loss.hypothesis.parameters[-1], float(loss.theta[-1]), float(error))
    if ends is None or ends[0] <= 0 or not predicts_better(evidence.angles, evidence.scoring, loss, base):
        return found
    rivals = tuple(t for t in found.singles if t.hypothesis.names != (effect.name,))
    singles = found.singles if stays else (loss, *rivals)
    return replace(_ended(found, stays, base, loss), singles=singles)


def _base(evidence: Evidence, found: SearchResult, stays: Sequence[int]) -> Trial:
    """What is found without the terms that give way."""
    return run_trial(evidence, *_kept(found.best, stays)) if stays else found.nominal


def _ended(found: SearchResult, stays: Sequence[int], base: Trial, *loss: Trial) -> SearchResult:
    """The search that ends with ``base``, or with lost set-points beside it. ``stays``: the terms that are still there,
    whose rivals stay as far as any were tried.
    """
    path = (found.nominal, *([base] if stays else []), *loss)
    rivals = [found.rivals[i] for i in stays if i < len(found.rivals)]
    return replace(
        found,
        best=path[-1],
        rivals=(*rivals, *([()] * len(loss))),
        path=path,
        without=(),
        seen_in_scatter=True,
    )


def _kept(best: Trial, stays: Sequence[int]) -> tuple[Hypothesis, list[Floats]]:
    """Some terms of an explanation, and the values from which their fit starts."""
    parts = best.hypothesis.split(best.theta)
    kept = Hypothesis(tuple(best.hypothesis.terms[i] for i in stays))
    return kept, [np.concatenate([np.zeros(0), *(parts[i] for i in stays)])]


def _with_loss(evidence: Evidence, best: Trial, stays: Sequence[int], effect: str) -> Trial:
    """Those terms and lost set-points, fitted together."""
    kept, (theta,) = _kept(best, stays)
    starts = [np.append(theta, p) for p in START_PROBABILITIES]
    return run_trial(evidence, kept.plus(Term(effect, None)), starts)


@dataclass(frozen=True)
class RandomDelay:
    """Share of the residual's mean square that a common delay explains beyond chance, and its memory (correlation)."""

    share: float
    memory: float

    @property
    def evident(self) -> bool:
        return self.share > HALF and abs(self.memory) < MUCH


def unsteady(floor: Floor) -> bool:
    """Whether repeats of a motion differ by more than the noise of their readings."""
    return floor.known and bool(np.nanmax(floor.repeat_rad / floor.white_rad) > CLEAR)


def predicts_better(angles: AngleEvidence, scoring: Scoring, loss: Trial, base: Trial) -> bool:
    """Whether lost set-points predict held-out angles clearly better than ``base``, without them or with less beside
    them, does.

    Neither is helped by a shift in time here: what comes at random is no wire that is a little slower. And a gap need
    not be above the floor, which repeats that differ by chance have raised. How much they gain does not count:
    most of what they do is scatter.
    """
    blocks = angles.blocks
    with_loss, without = (angles.mean_square(t.readings) for t in (loss, base))
    allowed, free = angles.allowed_square, scoring.decides[: blocks.count]
    rows = free & (np.abs(with_loss - without) > LITTLE * allowed)
    if not rows.any():
        return False
    gain = 0.5 * (np.log1p(without / allowed) - np.log1p(with_loss / allowed))
    return mean_difference(gain[rows], blocks.run[rows]).z > CLEAR


def random_delay(data: Data, floor: Floor, trial: Trial) -> RandomDelay:
    """Look for a common random delay in what ``trial`` leaves over: joints must agree on it. A joint that goes astray
    by itself agrees with itself, which is chance.
    """
    if data.joints < 2:
        return RandomDelay(0.0, 1.0)
    explained = by_chance = total = weight = 0.0
    lagged, power = 0.0, 0.0
    for run, reading, left in zip(data.runs, trial.readings, trial.left, strict=True):
        use = np.asarray(run.use.all(axis=1))
        if use.sum() < FEWEST_SAMPLES:
            continue
        rate: Floats = np.asarray(np.gradient(reading, run.t_s, axis=0))
        residual = np.where(use[:, None], left, 0.0)
        noise = float(np.square(floor.white_rad).sum())
        speed: Floats = np.asarray(np.square(rate).sum(axis=1))
        moving = use & (speed > LITTLE * np.quantile(speed[use], 0.9))  # else no delay can be told
        product, some_speed = residual * rate, np.maximum(speed, 1e-12)
        delay = np.where(moving, -product.sum(axis=1) / some_speed, 0.0)
        explained += float((np.square(delay) * speed)[moving].sum())
        by_chance += float((np.square(product).sum(axis=1) / some_speed)[moving].sum())
        total += float(np.square(residual)[moving].sum())
        weight += float(moving.sum()) * noise
        delay = np.where(moving, delay - delay[moving].mean(), 0.0)
        step = max(1, round(FORGOTTEN_S / run.period_s))
        if delay.size > 2 * step:
            lagged += float((delay[step:] * delay[:-step]).sum())
            power += float(np.square(delay[step:]).sum())
    # nothing but the readings' own noise, or one joint is all that moves
    if total <= max(2 * weight, by_chance) or power <= 0:
        return RandomDelay(0.0, 1.0)
    return RandomDelay((explained - by_chance) / (total - by_chance), lagged / power)
