"""The budget of the gap: which part of it each cause carries, and what none does.

Shapley's value: what the mean square of the error falls by when a cause is added, in the mean over the orders in which
the causes may be added. The causes are as they were fitted, each run by parameters that it had no part in; nothing is
fitted anew. A cause that only mends what another overdoes (a lag below the stated one, beside a delay) would make the
gap larger by itself: what the two do is told of the other. With the rest the shares add up to one. Intervals are from
the bootstrap over the blocks of ``closure``, or over the windows of the features over ground.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from snakebot.arrays import Bools, Floats, Ints
from snakebot.diagnosis.evidence.blocks import resample
from snakebot.diagnosis.evidence.data import FEWEST_TO_COMPARE
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.fit_runs import ground_residuals
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.result import BudgetEntry, Cause
from snakebot.diagnosis.search.rounds import MOST_EFFECTS
from snakebot.diagnosis.sizes import LITTLE, NEXT_TO_NOTHING, SOME
from snakebot.diagnosis.verdict.closure import DRAWS, ends_of_95_percent
from snakebot.effects.spec import EffectSpec

Coalition = frozenset[int]
Squares = Callable[[Coalition], Floats]


def angle_budget(evidence: Evidence, nominal: Trial, best: Trial, seed: int) -> list[BudgetEntry]:
    """Shares in the error of the joint angles, on the runs of the closure. ``cause`` of each is the place of a term in
    the hypothesis of ``best``.
    """
    players = _players(best, ("link", "servo", "sensor"))
    if not players:
        return []
    angles, shown = evidence.angles, evidence.split.shown
    blocks = angles.blocks
    rows = np.isin(blocks.run, shown)

    def squares(coalition: Coalition) -> Floats:
        if not coalition:
            return angles.mean_square(nominal.readings)[rows]
        if coalition == frozenset(players):
            return angles.mean_square(best.readings)[rows]
        readings = list(nominal.readings)
        for runs, specs in specs_by_run(best, coalition, shown):
            for index, reading in zip(runs, evidence.predictor.readings(specs, runs), strict=True):
                readings[index] = reading
        return angles.mean_square(readings)[rows]

    floor = evidence.floor
    noise = np.square(floor.rad if floor.known else np.zeros(angles.data.joints))[blocks.joint[rows]]
    shares = _shares(players, squares, noise, blocks.samples[rows], seed)
    draw = resample(blocks.run[rows], np.random.default_rng(seed), DRAWS)
    names = [angles.data.runs[i].name for i in shown]
    return shares.entries(
        "joint_angle",
        draw,
        [blocks.joint[rows] == j for j in range(angles.data.joints)],
        {name: blocks.run[rows] == i for i, name in zip(shown, names, strict=True)},
    )


def ground_budget(evidence: Evidence, best: Trial, seed: int) -> list[BudgetEntry]:
    """Shares in the error of the motion over ground under measured joint angles, each feature against what it is
    allowed. ``cause`` of each is the place of a term in the hypothesis of ``best``.
    """
    players = _players(best, ("body", "sensor"))
    ground, shown = evidence.ground, evidence.split.shown
    if ground is None or not any(best.hypothesis.terms[at].stage == "body" for at in players):
        return []
    features = ground.features
    known = np.isfinite(features.value) & np.isin(features.run, shown)
    if not known.any():
        return []
    windows, of_window = np.unique(features.window[known], return_inverse=True)
    count = np.bincount(of_window).astype(np.float64)
    run = np.array([features.windows[w].run for w in windows], dtype=np.int64)
    lone = np.array([features.windows[w].speed_only for w in windows])
    allowed = ground.allowed_square[known]

    def squares(coalition: Coalition) -> Floats:
        left = np.zeros(known.size)
        for runs, specs in specs_by_run(best, coalition, shown):
            made = ground_residuals(evidence.ground, evidence.predictor, specs, evidence.split.free, runs)
            mine = np.isin(features.run, runs)
            left[mine] = np.nan_to_num(np.square(made[mine]))
        return np.bincount(of_window, weights=left[known] / allowed) / count

    shares = _shares(players, squares, np.ones(count.size), count, seed)
    by_run = {evidence.data.runs[i].name: np.asarray(run == i) for i in shown}
    return shares.entries("ground", window_draws(run, lone, seed), [], by_run)


def window_draws(run: Ints, lone: Bools, seed: int) -> Ints | None:
    """(D, W) draws of the windows of the motion over ground: within each run; runs of one speed alone are
    exchangeable. None where there are too few for an interval.

    Args:
        run: (W,) of each window.
        lone: (W,) whether it gives its run's forward speed alone.
    """
    clusters = np.where(lone, 0, 1 + run)
    sizes = np.bincount(clusters)
    if sizes.max() < FEWEST_TO_COMPARE:
        return None
    return resample(clusters, np.random.default_rng(seed), DRAWS)


def by_share(
    causes: Sequence[Cause], budget: Sequence[BudgetEntry]
) -> tuple[tuple[Cause, ...], tuple[BudgetEntry, ...]]:
    """Causes, first those that carry most of the gap of the joint angles, and the budget with their new places. As they
    are where the motion over ground is shared out, too: shares of two gaps do not compare.
    """
    share = {entry.cause: entry.share for entry in budget}
    if any(entry.of == "ground" for entry in budget):
        return tuple(causes), tuple(budget)
    order = sorted(range(len(causes)), key=lambda i: -round(share.get(i, -math.inf), 2))
    place = {None: None} | {old: new for new, old in enumerate(order)}
    entries = [entry.model_copy(update={"cause": place[entry.cause]}) for entry in budget]
    of_rest = len(causes)  # comes after all of them
    entries.sort(key=lambda entry: of_rest if entry.cause is None else entry.cause)
    return tuple(causes[i] for i in order), tuple(entries)


def of_causes(budget: Sequence[BudgetEntry], terms: Sequence[int | None]) -> list[BudgetEntry]:
    """A budget of the terms of an explanation as one of causes, each of which is one of the ``terms``, or none."""
    place = {None: None} | {term: cause for cause, term in enumerate(terms) if term is not None}
    return [entry.model_copy(update={"cause": place[entry.cause]}) for entry in budget]


def _players(best: Trial, stages: Sequence[str]) -> list[int]:
    """Places of the terms of these stages."""
    return [at for at, term in enumerate(best.hypothesis.terms) if term.stage in stages]


def specs_by_run(
    best: Trial, coalition: Coalition, runs: Sequence[int]
) -> list[tuple[list[int], tuple[EffectSpec, ...]]]:
    """The effects of some terms, at the parameters of each run: runs of the same parameters together."""
    groups: dict[bytes, list[int]] = {}
    for index in runs:
        groups.setdefault(best.run_theta[index].tobytes(), []).append(index)
    out = []
    for group in groups.values():
        parts = best.hypothesis.split(best.run_theta[group[0]])
        specs = [s for at in sorted(coalition) for s in best.hypothesis.terms[at].specs(parts[at].tolist())]
        out.append((group, tuple(specs)))
    return out


@dataclass(frozen=True, eq=False)
class _Shares:
    """What each cause takes off each block (C, B), what is left above the noise (B,), the noise (B,), and how many
    samples each block is of (B,).
    """

    causes: Sequence[int]
    taken: Floats
    rest: Floats
    noise: Floats
    size: Floats

    def of(self, rows: Bools) -> Floats | None:
        """Shares of the causes, then of the rest (C + 1,), in some blocks; None where there is no gap."""
        whole, noise = self._whole(self.taken[:, rows], self.rest[rows], self.size[rows]), self.noise[rows]
        if not rows.any() or whole.sum() <= LITTLE * float(noise @ self.size[rows]):
            return None
        return np.asarray(whole / whole.sum())

    def drawn(self, draw: Ints) -> Floats:
        """(D, C + 1) shares in each draw (D, B) of blocks."""
        taken = (self.taken * self.size)[:, draw].sum(axis=2)
        rest = np.maximum((self.rest * self.size)[draw].sum(axis=1), 0.0)
        whole = np.vstack([taken, rest])
        return np.asarray((whole / np.where(whole.sum(axis=0) > 0, whole.sum(axis=0), np.nan)).T)

    @staticmethod
    def _whole(taken: Floats, rest: Floats, size: Floats) -> Floats:
        return np.append(taken @ size, max(float(rest @ size), 0.0))

    def entries(
        self, of: str, draw: Ints | None, joints: Sequence[Bools], runs: dict[str, Bools]
    ) -> list[BudgetEntry]:
        shares = self.of(np.ones(self.size.size, dtype=bool))
        if shares is None:
            return []
        drawn = None if draw is None else ends_of_95_percent(self.drawn(draw))
        by_joint = [self.of(rows) for rows in joints]
        by_run = {name: self.of(rows) for name, rows in runs.items()}

        def one(found: Floats | None, at: int) -> float | None:
            return None if found is None else round(float(found[at]), 4)

        return [
            BudgetEntry(
                cause=cause,
                of=of,  # type: ignore[arg-type]
                share=round(float(shares[at]), 4),
                ci95=None
                if drawn is None
                else (round(float(drawn[0, at]), 4), round(float(drawn[1, at]), 4)),
                by_joint=tuple(one(found, at) for found in by_joint),
                by_run={name: one(found, at) for name, found in by_run.items()},
            )
            for at, cause in enumerate((*self.causes, None))
        ]


def _shares(terms: Sequence[int], squares: Squares, noise: Floats, size: Floats, seed: int) -> _Shares:
    cache: dict[Coalition, Floats] = {}

    def of(coalition: Coalition) -> Floats:
        if coalition not in cache:
            cache[coalition] = squares(coalition)
        return cache[coalition]

    orders = _orders(len(terms), seed)
    taken = np.zeros((len(terms), size.size))
    for order in orders:
        before: Coalition = frozenset()
        for at in order:
            after = before | {terms[at]}
            taken[at] += (of(before) - of(after)) / len(orders)
            before = after
    rest = of(frozenset(terms)) - noise
    _give_back(terms, taken, lambda *some: float(of(frozenset(some)) @ size), rest, size)
    return _Shares(terms, taken, rest, noise, size)


def _give_back(
    terms: Sequence[int], taken: Floats, left: Callable[..., float], rest: Floats, size: Floats
) -> None:
    """What terms that make the gap larger take off (C, B), all below zero, goes to those they mend: each to the one
    with which it does most beyond what the two do apart. ``left``: of the gap, by some terms.
    """
    open_ = list(range(len(terms)))
    gap = float((taken @ size).sum()) + max(float(rest @ size), 0.0)
    while True:
        share = {at: float(taken[at] @ size) for at in open_}
        at = min(open_, key=share.__getitem__, default=None)
        if at is None or share[at] >= -NEXT_TO_NOTHING * gap:
            return
        open_.remove(at)
        mended = {
            other: left(terms[at]) + left(terms[other]) - left(terms[at], terms[other]) - left()
            for other in open_
        }
        most = max(mended, key=mended.__getitem__, default=None)
        if most is not None and mended[most] > 0:
            taken[most] += taken[at]
            taken[at] = 0.0


def _orders(count: int, seed: int) -> list[tuple[int, ...]]:
    if count <= MOST_EFFECTS:
        return list(permutations(range(count)))
    rng = np.random.default_rng(seed)
    some = [tuple(int(i) for i in rng.permutation(count)) for _ in range(SOME)]
    return [*some, *(order[::-1] for order in some)]
