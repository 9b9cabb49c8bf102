"""The best gait of a robot with its effects: chosen, promised with an interval, and set beside others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import degrees
from typing import TYPE_CHECKING, Any

import numpy as np

from snakebot.arrays import Floats
from snakebot.cluster import Workers
from snakebot.effects import robot_effects
from snakebot.errors import BadInputError
from snakebot.gait import Gait
from snakebot.optimise.goal import Goal
from snakebot.optimise.outcomes import GaitsCallback, GaitSimulator
from snakebot.optimise.promise import OptimiseOptions, Promise, drawn, promise_of, promises, row_of
from snakebot.optimise.search import Search
from snakebot.optimise.shape import shaped
from snakebot.studies.pareto import front_of

if TYPE_CHECKING:
    from snakebot.robot import Robot

ROBUST_DRAWS = 12  # of these, those whose worst case a robust choice looks at; chosen
CANDIDATES = 16  # gaits that a robust choice begins with; chosen
FRONT = 9  # gaits of the front that are told; chosen
SLOWEST = 0.05  # of the fastest speed: the front is told from there on; chosen


@dataclass(frozen=True)
class Optimum:
    """What was found.

    Attributes:
        found: the choice.
        others: on the same robot, the gait that the choice would be without the robot's effects, and given ones.
        front: gaits that no other beats in speed and power, from slow to fast.
        seen: (G, 2) speed and power of all gaits looked at, for a picture.
    """

    robot: str
    goal: Goal
    robust: bool
    found: Promise
    others: tuple[Promise, ...]
    front: tuple[Promise, ...]
    draws: int
    simulated: int
    effects: tuple[str, ...]
    seen: Floats

    def summary(self) -> dict[str, Any]:
        """Plain values for ``--json``."""
        return {
            "schema": "snakebot.optimum/1",
            "robot": self.robot,
            "effects": list(self.effects),
            "for": self.goal.aim,
            "speed_m_s": self.goal.speed_m_s,
            "robust": self.robust,
            "draws": self.draws,
            "simulated": self.simulated,
            "found": asdict(self.found),
            "others": [asdict(other) for other in self.others],
            "front": [asdict(gait) for gait in self.front],
        }


def optimise(
    robot: Robot,
    goal: Goal,
    options: OptimiseOptions | None = None,
    *,
    beside: Mapping[str, Gait] | None = None,
    progress: GaitsCallback | None = None,
    workers: Workers | None = None,
) -> Optimum:
    """The best gait for a goal.

    Args:
        robot: with its effects, e.g. as ``snakebot diagnose --apply`` writes it.
        beside: gaits to be set beside the choice, by what they are called.
        progress: is told how many gaits have been simulated since it was told before.
        workers: of a cluster, that simulate.

    Raises:
        BadInputError: the robot has no body, its limits leave no gait, or none reaches the goal.
    """
    options = options or OptimiseOptions()
    if options.torque_nm is not None and not options.torque_nm > 0:
        raise BadInputError(f"--torque {options.torque_nm:g}: a torque is above zero")
    space, simulator = options.space(robot), options.simulator(robot, None, progress, workers)
    search = Search(simulator, space, goal)
    best = _best(search, robot, options.grid)
    search.sharpen_front(options.grid)
    best = search.no_worse_than_seen(best, options.grid)
    others = 0  # gaits simulated elsewhere
    judge = simulator
    if options.robust and options.draws:
        judge = options.simulator(robot, drawn(robot, options)[:ROBUST_DRAWS], progress, workers)
        best = _robust(search, judge, best)
    gaits = [("found", best)]
    if options.amplitudes != "equal":
        found = shaped(Search(judge, space, goal), best, robot.joints, options.amplitudes, options.grid)
        gaits = [("found", found), ("equal amplitudes", best)]
    others += judge.simulated if judge is not simulator else 0
    effects = robot_effects(robot)
    if effects:
        nominal, cost = _nominal(robot, goal, options, progress, workers)
        others += cost
        if nominal is not None:
            gaits.append(("without the effects", nominal))
    for label, gait in (beside or {}).items():
        gaits.append((label, row_of(gait)))
    told = promises(robot, gaits, options, progress, workers)
    others += len(gaits) * (1 + options.draws)
    front = _front(search, simulator)
    seen = search.all_seen()[1]
    return Optimum(
        robot.name, goal, options.robust, told[0], tuple(told[1:]), front, options.draws,
        others + simulator.simulated, tuple(str(spec) for spec in (*effects, *options.faults)),
        np.column_stack([seen.speed_m_s[0], seen.power_in_w[0]]),
    )  # fmt: skip


def _best(search: Search, robot: Robot, grid: tuple[int, int, int]) -> Floats:
    """
    Raises:
        BadInputError: nothing reaches the goal.
    """
    found = [search.uphill(start, grid) for start in search.over_grid(grid)]
    found = [(gait, score) for gait, score in found if np.isfinite(score)]
    if not found:
        raise BadInputError(_nothing(search, robot))
    return max(found, key=lambda pair: pair[1])[0]


def _nothing(search: Search, robot: Robot) -> str:
    gaits, outcomes = search.all_seen()
    kept = outcomes.torque_use[0] <= search.space.torque_most
    if not kept.any():
        return (
            f"robot {robot.name!r}: every gait here takes more than {100 * search.space.torque_most:g} % of a servo's "
            "torque: lower --margin or widen --within"
        )
    at = np.flatnonzero(kept)[np.argmax(outcomes.speed_m_s[0][kept])]
    alpha, beta, omega = gaits[at]
    limited = search.space.margin and outcomes.torque_use[0].any()  # all 0 where no servo's torque is known
    left = f" with {100 * search.space.margin:g} % of the torque left" if limited else ""
    return (
        f"robot {robot.name!r}: no gait here reaches {search.goal.speed_m_s:g} m/s{left}; the fastest makes "
        f"{outcomes.speed_m_s[0, at]:.4g} m/s (alpha {degrees(alpha):.0f} deg, beta {degrees(beta):.0f} deg, "
        f"omega {omega:.2f} rad/s)"
    )


def _robust(search: Search, some: GaitSimulator, best: Floats) -> Floats:
    """The gait with the best worst case over some robots: from the best ones of the point estimate on."""
    gaits, outcomes = search.all_seen()
    scores = search.scores(outcomes)
    apart = np.array([0.05, 0.05, 0.05])  # in log alpha, beta in rad, log omega
    candidates = search.apart(gaits, scores, CANDIDATES, apart)
    candidates = np.unique(np.concatenate([best[None, :], candidates]), axis=0)
    over = Search(some, search.space, search.goal)
    tried, worst = over.tried(candidates)
    if not np.isfinite(worst).any():
        return best  # one of the draws reaches the goal with none of them
    return over.uphill(tried[np.argmax(worst)], first=0.25, shortest=1 / 8)[0]


def _nominal(
    robot: Robot,
    goal: Goal,
    options: OptimiseOptions,
    progress: GaitsCallback | None,
    workers: Workers | None,
) -> tuple[Floats | None, int]:
    """What the choice would be if the robot had no effects but broken joints; None where nothing would do."""
    plain = robot.model_copy(update={"effects": ()})
    space, simulator = options.space(plain), options.simulator(plain, None, progress, workers)
    try:
        return _best(Search(simulator, space, goal), plain, options.grid), simulator.simulated
    except BadInputError:
        return None, simulator.simulated


def _front(search: Search, simulator: GaitSimulator) -> tuple[Promise, ...]:
    """A few gaits of the front of all that was seen, even in speed, simulated at length."""
    gaits, outcomes = search.all_seen()
    fits = np.flatnonzero(outcomes.torque_use[0] <= search.space.torque_most)
    speed, power = outcomes.speed_m_s[0][fits], outcomes.power_in_w[0][fits]
    on = fits[front_of(speed, power)]
    v = outcomes.speed_m_s[0][on]
    on, v = on[v >= SLOWEST * v[-1]], v[v >= SLOWEST * v[-1]]
    wanted = np.linspace(v[0], v[-1], FRONT)
    on = on[np.unique([int(np.argmin(np.abs(v - w))) for w in wanted])]
    again = simulator(gaits[on])
    rows = [promise_of("front", gaits[at], again, i, search.space) for i, at in enumerate(on)]
    return tuple(rows[i] for i in front_of([r.speed_m_s for r in rows], [r.power_w for r in rows]))
