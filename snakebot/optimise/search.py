"""The best gait of a space: a grid first, then from its best places uphill with ever shorter steps.

Speed rises up to a limit or a range as often as not. So a step that breaks a limit is not refused: its omega is
lowered until it is kept, and the search goes along the limit. For the least power at a speed, omega is whatever brings
that speed, and the search goes over alpha and beta alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from snakebot.arrays import Floats
from snakebot.optimise.goal import REACHED, Goal
from snakebot.optimise.outcomes import Outcomes, joined
from snakebot.optimise.space import Space
from snakebot.studies.pareto import front_of

Simulate = Callable[..., Outcomes]  # of gaits (G, 3); thorough=

GRID = (10, 10, 7)  # alphas, betas, omegas
STARTS = 3  # places of the grid from which it goes uphill
SHORTEST = 1 / 16  # of the grid's spacing: the last step, about a degree and a hundredth of omega
MOST_STEPS = 16  # of one way uphill; chosen
BRIEF_TORQUE = 0.97  # of the torque that a gait may take; chosen
SEEN = 12  # of the gaits seen on the way, which are looked at closely; chosen
OMEGA_TRIES = 6  # to bring a speed about


@dataclass(eq=False)
class Search:
    """Keeps all that it has seen."""

    simulate: Simulate
    space: Space
    goal: Goal
    gaits: list[Floats] = field(default_factory=list)
    outcomes: list[Outcomes] = field(default_factory=list)
    _known: dict[tuple[float, ...], tuple[int, int]] = field(default_factory=dict)  # part and column

    def look(self, gaits: Floats, *, thorough: bool = True) -> Outcomes:
        """Outcomes of gaits; those that were looked at before, as closely, are not simulated again."""
        keys = [(thorough, *row) for row in np.round(gaits, 9).tolist()]
        new = {key: row for key, row in zip(keys, gaits, strict=True) if key not in self._known}
        if new:
            self.gaits.append(np.array(list(new.values())))
            self.outcomes.append(self.simulate(self.gaits[-1], thorough=thorough))
            part = len(self.outcomes) - 1
            self._known.update({key: (part, column) for column, key in enumerate(new)})
        places = [self._known[key] for key in keys]
        return joined([self.outcomes[part].of(column) for part, column in places])

    def scores(self, outcomes: Outcomes, *, thorough: bool = True) -> Floats:
        """Of a brief look with a little torque to spare: at length a gait on the limit may take a little more."""
        most = self.space.torque_most * (1.0 if thorough else BRIEF_TORQUE)
        return self.goal.worst(outcomes, most)

    def all_seen(self) -> tuple[Floats, Outcomes]:
        return np.concatenate(self.gaits), joined(self.outcomes)

    def over_grid(self, size: tuple[int, int, int] = GRID) -> Floats:
        """(S, 3) the places of the grid from which to go uphill, the best one first; none where none will do."""
        gaits = self.space.grid(*size)
        outcomes = self.look(gaits, thorough=False)
        if self.goal.speed_m_s is not None:
            gaits, scores = self._at_speed(gaits, outcomes, self.goal.speed_m_s)
        else:
            scores = self.scores(outcomes)
        return self.apart(gaits, scores, STARTS, self._spacing(size))

    def _at_speed(self, gaits: Floats, outcomes: Outcomes, speed: float) -> tuple[Floats, Floats]:
        """Each alpha and beta of a grid with the omega that brings the speed, and less the power it takes."""
        slowest, most = outcomes.speed_m_s.min(axis=0), outcomes.power_in_w.max(axis=0)
        fits = (outcomes.torque_use <= self.space.torque_most).all(axis=0)
        rows, scores = [], []
        for key in np.unique(gaits[:, :2], axis=0):
            column = np.flatnonzero((gaits[:, :2] == key).all(axis=1) & fits)
            reach = column[slowest[column] >= 0.97 * speed]  # the grid is looked at roughly
            if reach.size:
                at = reach[np.argmin(most[reach])]
                omega = gaits[at, 2] * min(1.0, speed / slowest[at])
                rows.append((*key, max(omega, self.space.omega_rad_s[0])))
                scores.append(-most[at] * min(1.0, speed / slowest[at]) ** 2)  # viscous: as the square
        return np.array(rows).reshape(-1, 3), np.array(scores)

    def apart(self, gaits: Floats, scores: Floats, count: int, spacing: Floats) -> Floats:
        """The best gaits of which no two are neighbours."""
        chosen: list[Floats] = []
        for at in np.argsort(-scores, kind="stable"):
            if len(chosen) == count or not np.isfinite(scores[at]):
                break
            place = _coordinates(gaits[at])
            if all(np.abs((place - _coordinates(other)) / spacing).max() > 1.01 for other in chosen):
                chosen.append(gaits[at])
        return np.array(chosen).reshape(-1, 3)

    def uphill(
        self,
        start: Floats,
        size: tuple[int, int, int] = GRID,
        *,
        first: float = 0.5,
        shortest: float = SHORTEST,
        thorough: bool = False,
    ) -> tuple[Floats, float]:
        """The best gait found from a start (3,), or (3 + joints,) with shares that stay, and its score.

        Args:
            thorough: look at each step at length, and not at the last one alone.
        """
        spacing = self._spacing(size)
        best, score = (found[0] for found in self.tried(start[None, :], thorough=thorough))
        step = first
        for _ in range(MOST_STEPS):
            if step < shortest:
                break
            places = _coordinates(best) + step * spacing * _stencil(2 if self.goal.speed_m_s else 3)
            gaits = self.space.nearest(_gaits(places, best[3:]))
            gaits = gaits[np.abs(gaits - best).max(axis=1) > 1e-9]
            tried, scores = self.tried(np.unique(gaits, axis=0), thorough=thorough)
            if len(scores) and scores.max() > score:
                best, score = tried[np.argmax(scores)], scores.max()
            else:
                step /= 2
        at_length, scores = self.tried(best[None, :])
        return at_length[0], float(scores[0])

    def no_worse_than_seen(self, best: Floats, size: tuple[int, int, int] = GRID) -> Floats:
        """``best``, or a gait that beats it at length: uphill from the best ones that were seen on the way, and, where
        there is a limit of torque, nearer to it than brief looks dare to go.
        """
        gaits, outcomes = self.all_seen()
        order = np.argsort(-self.scores(outcomes), kind="stable")[:SEEN]
        tried, scores = self.tried(np.unique(np.concatenate([best[None, :], gaits[order]]), axis=0))
        seen = tried[np.argmax(scores)]
        limited = bool(np.isfinite(self.space.torque_most) and self.look(seen[None, :]).torque_use.max() > 0)
        if not limited and np.array_equal(seen, best):
            return best
        return self.uphill(seen, size, first=0.25, thorough=True)[0]

    def sharpen_front(self, size: tuple[int, int, int] = GRID, rounds: int = 2) -> None:
        """Look at the neighbours in alpha and beta of the gaits on the front, nearer each round."""
        steps = _stencil(2)[:4] * self._spacing(size)
        for level in range(1, rounds + 1):
            gaits, outcomes = self.all_seen()
            fits = np.flatnonzero((outcomes.torque_use <= self.space.torque_most).all(axis=0))
            on = gaits[fits[front_of(outcomes.speed_m_s[0][fits], outcomes.power_in_w[0][fits])]]
            around = [_coordinates(gait) + step / 2**level for gait in on for step in steps]
            if around:
                near = self.space.nearest(_gaits(np.array(around)))
                self.look(np.unique(np.round(near, 6), axis=0), thorough=False)

    def tried(self, gaits: Floats, *, thorough: bool = True) -> tuple[Floats, Floats]:
        """Gaits and scores; for power at a speed, with the omega that brings it."""
        speed = self.goal.speed_m_s
        if not len(gaits):
            return gaits, np.zeros(0)
        if speed is None:
            return gaits, self.scores(self.look(gaits, thorough=thorough), thorough=thorough)
        gaits = self.space.nearest(gaits)
        scores = np.full(len(gaits), -np.inf)
        best = gaits.copy()
        slope = np.ones(len(gaits))  # of log speed over log omega
        last_omega, last_speed = np.full(len(gaits), np.nan), np.full(len(gaits), np.nan)
        open_ = np.arange(len(gaits))
        for _ in range(OMEGA_TRIES):
            outcomes = self.look(gaits[open_], thorough=thorough)
            v = np.maximum(outcomes.speed_m_s.min(axis=0), 1e-9)
            now = self.scores(outcomes, thorough=thorough)
            better = now > scores[open_]
            scores[open_[better]], best[open_[better]] = now[better], gaits[open_[better]]
            omega = gaits[open_, 2]
            with np.errstate(divide="ignore", invalid="ignore"):
                found = np.log(v / last_speed[open_]) / np.log(omega / last_omega[open_])
            slope[open_] = np.where(np.isfinite(found) & (found > 0.2), np.minimum(found, 3.0), 1.0)
            last_omega[open_], last_speed[open_] = omega, v
            # a little above the speed: it has to be reached
            factor = np.clip((speed * (1 + REACHED / 4) / v) ** (1 / slope[open_]), 0.6, 1.6)
            gaits[open_, 2] = omega * factor
            gaits[open_] = self.space.nearest(gaits[open_])
            done = (np.abs(v / speed - 1) <= REACHED) | (np.abs(gaits[open_, 2] - omega) < 1e-9)
            open_ = open_[~done]
            if not open_.size:
                break
        return best, scores

    def _spacing(self, size: tuple[int, int, int]) -> Floats:
        """Of a grid, in coordinates."""
        space = self.space
        low = _coordinates(np.array([space.alpha_rad[0], space.beta_rad[0], space.omega_rad_s[0]]))
        high = _coordinates(np.array([space.alpha_most_rad, space.beta_rad[1], space.omega_rad_s[1]]))
        return np.asarray(np.maximum((high - low) / np.maximum(np.array(size) - 1, 1), 1e-9))


def _coordinates(gait: Floats) -> Floats:
    return np.array([np.log(gait[0]), gait[1], np.log(gait[2])])


def _gaits(places: Floats, shares: Floats | None = None) -> Floats:
    """Gaits at places; with the same shares of alpha in each."""
    table = np.column_stack([np.exp(places[:, 0]), places[:, 1], np.exp(places[:, 2])])
    return table if shares is None else np.column_stack([table, np.tile(shares, (len(table), 1))])


def _stencil(dimensions: int) -> Floats:
    """Steps along each axis, and along two at once; (S, 3)."""
    rows: list[Floats] = []
    for axis in range(dimensions):
        rows += [np.eye(3)[axis], -np.eye(3)[axis]]
    for a, b in combinations(range(dimensions), 2):
        for sign in (1, -1):
            rows += [np.eye(3)[a] + sign * np.eye(3)[b], -np.eye(3)[a] - sign * np.eye(3)[b]]
    return np.array(rows)
