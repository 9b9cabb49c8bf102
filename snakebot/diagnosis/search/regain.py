"""What comes back: everyday effects that a joint was left without, tried again on top of the whole explanation.

What a joint can do without is judged before the rest of the explanation is known, and by what is clear of chance; of a
few runs that is little. But what is left out without need foretells other motions worse. So in the end an effect comes
back to a joint where it helps on runs left out by more than a standard error: the rule of Breiman et al.,
Classification and Regression Trees, 1984, section 3.4.3, by which less is said only at no more cost than that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Bools, Floats
from snakebot.diagnosis.evidence.gap import gap_of
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.least_squares import FEWEST_STEPS, minimise
from snakebot.diagnosis.fit.trial import Trial, run_trial
from snakebot.diagnosis.search.acceptance import but_the_best, costs_nothing
from snakebot.diagnosis.search.bench import Bench, Wear, as_wide_as, gain_on_joint, laid_out
from snakebot.diagnosis.search.library import Library
from snakebot.diagnosis.sizes import LITTLE


def regained(evidence: Evidence, library: Library, best: Trial) -> Trial:
    """``best`` with the everyday effects that help joints on which it leaves a gap; ``best`` itself where none does."""
    gap = gap_of(evidence.scoring, best.held_square).significant
    with_gap = {int(j) + 1 for j in np.flatnonzero(gap)}
    laid = laid_out(evidence, library, best, with_gap)
    if laid is None or not with_gap:
        return best
    bench = laid.bench
    found = _grown(bench, laid.theta, laid.kept, np.isin(bench.joints, list(with_gap)), best)
    candidate = None if found is None else found.added_to(best.hypothesis, best.theta)
    if candidate is None:
        return best
    trial = run_trial(evidence, candidate.hypothesis, candidate.starts)
    loss = evidence.scoring.gain(best.held_square, trial.held_square)
    return trial if costs_nothing(loss) else best


@dataclass(frozen=True, eq=False)
class _Fitted:
    """Which effects each joint has (U, K), their parameters (U, p), and mean squares of the blocks left out (B,)."""

    kept: Bools
    theta: Floats
    square: Floats

    def with_joint(self, u: int, mine: Bools, other: _Fitted) -> _Fitted:
        """The same with one joint, of the blocks ``mine`` (B,), as in another."""
        row = np.arange(len(self.kept)) == u
        return _Fitted(
            np.where(row[:, None], other.kept, self.kept),
            np.where(row[:, None], other.theta, self.theta),
            np.where(mine, other.square, self.square),
        )


def _grown(bench: Bench, theta: Floats, kept: Bools, may_grow: Bools, best: Trial) -> Wear | None:
    """What all joints have when nothing more helps those that ``may_grow`` (U,); None where nothing did at all."""
    spread = as_wide_as(bench, best.held_square[: bench.size.size])

    def fitted(some: Bools, start: Floats) -> _Fitted:
        at = minimise(bench.problem(some, spread), start, FEWEST_STEPS, covariance=False).theta
        return _Fitted(some, at, bench.held_square(at, some, spread))

    def helps(more: _Fitted, less: _Fitted, u: int) -> bool:
        return _helps(bench, u, spread, more, less)

    begin = now = fitted(kept, theta)
    while may_grow.any():
        wider = []
        for k in range(len(bench.terms)):
            some = now.kept.copy()
            some[may_grow, k] = True
            if (some != now.kept).any():
                wider.append(fitted(some, now.theta))
        before = now
        for u in np.flatnonzero(may_grow).tolist():
            mine = bench.blocks_of(bench.columns[u])
            helpful = [more for more in wider if helps(more, before, u)]
            if helpful:
                now = now.with_joint(u, mine, min(helpful, key=lambda more: bench.over(more.square, mine)))
        may_grow = (now.kept != before.kept).any(axis=1)
    for k in range(len(bench.terms)):  # what came first may be needless beside what came after it
        new = now.kept[:, k] & ~begin.kept[:, k]
        if not new.any():
            continue
        some = now.kept.copy()
        some[new, k] = False
        less, before = fitted(some, now.theta), now
        for u in np.flatnonzero(new).tolist():
            if not helps(before, less, u):
                now = now.with_joint(u, bench.blocks_of(bench.columns[u]), less)
    return None if (now.kept == kept).all() else Wear(bench.terms, bench.joints, now.theta, now.kept)


def _helps(bench: Bench, u: int, spread_square: Floats, more: _Fitted, now: _Fitted) -> bool:
    """Whether ``more`` is more of a joint, gains more than a standard error, and takes a tenth of the mean square away,
    the block in which it takes most not counted: a single moment is no cause.
    """
    if (more.kept[u] == now.kept[u]).all():
        return False
    joint = bench.columns[u]
    rows = but_the_best(more.square, now.square, bench.blocks_of(joint))
    if bench.over(more.square, rows) >= (1 - LITTLE) * bench.over(now.square, rows):
        return False
    return not costs_nothing(gain_on_joint(bench, joint, spread_square, more.square, now.square))
