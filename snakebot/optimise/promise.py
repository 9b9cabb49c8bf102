"""What a simulation promises of a gait, with an interval, and how it is asked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats
from snakebot.cluster import Workers
from snakebot.effects import EffectSpec
from snakebot.gait import Gait
from snakebot.optimise.outcomes import GaitsCallback, GaitSimulator, Outcomes, TorqueNm
from snakebot.optimise.posterior import draws, interval
from snakebot.optimise.reach import Beyond, Reach, beyond, no_more
from snakebot.optimise.search import GRID
from snakebot.optimise.shape import Amplitudes
from snakebot.optimise.space import Space

if TYPE_CHECKING:
    from snakebot.robot import Robot, Tolerance

DRAWS = 40  # robots behind an interval; chosen


@dataclass(frozen=True)
class OptimiseOptions:
    """How to choose.

    Attributes:
        within: ranges of alpha and beta in deg and omega in rad/s, see ``space.WITHIN``.
        faults: effects of broken joints, part of every simulation.
        margin: share of each servo's torque to be left, where its limit is known.
        torque_nm: that limit, where the description does not say.
        robust: the best worst case instead of the best promise.
        draws: robots behind the intervals; 0: no interval.
        grid: alphas, betas and omegas of the first look.
        within_recorded: ask for no more omega, joint speed and torque than the recordings that the description was
            calibrated on.
        amplitudes: of the joints: all equal, a taper from tail to head, or each its own (``shape``).
    """

    within: Mapping[str, tuple[float, float]] | None = None
    faults: tuple[EffectSpec, ...] = ()
    margin: float = 0.1
    torque_nm: float | None = None
    robust: bool = False
    draws: int = DRAWS
    seed: int = 0
    grid: tuple[int, int, int] = GRID
    within_recorded: bool = False
    amplitudes: Amplitudes = "equal"

    def space(self, robot: Robot) -> Space:
        """Where to look.

        Raises:
            BadInputError: the limits of the robot, or of what was recorded, leave no gait, or nothing was recorded.
        """
        if not self.within_recorded:
            return Space.of(robot, self.within, margin=self.margin, torque_given=self.torque_nm is not None)
        reach = self._reach(robot)
        given = self.torque_nm is not None or reach.torque_nm is not None
        return Space.of(
            robot, reach.within, margin=self.margin, torque_given=given,
            joint_speed_rad_s=reach.joint_speed_rad_s,
        )  # fmt: skip

    def torque(self, robot: Robot) -> TorqueNm:
        """What each servo may be asked for, beside the limits in its description."""
        recorded = self._reach(robot).torque_nm if self.within_recorded else None
        if recorded is None or self.torque_nm is None:
            return recorded or self.torque_nm
        return tuple(min(self.torque_nm, end) for end in recorded)

    def simulator(
        self,
        robot: Robot,
        robots: Sequence[tuple[Robot, tuple[EffectSpec, ...]]] | None = None,
        progress: GaitsCallback | None = None,
        workers: Workers | None = None,
    ) -> GaitSimulator:
        """Of the robot, broken as asked for; or of ``robots`` that it may be."""
        asked = [(robot, self.faults)] if robots is None else robots
        return GaitSimulator(asked, torque_nm=self.torque(robot), progress=progress, workers=workers)

    def _reach(self, robot: Robot) -> Reach:
        return Reach.of(robot, self.within, self.margin)


@dataclass(frozen=True)
class Promise:
    """A gait, and what the simulation says of it. Intervals are of 95 %."""

    what: str
    alpha_deg: float
    beta_deg: float
    omega_rad_s: float
    speed_m_s: float
    power_w: float
    cost_of_transport: float
    torque_nm: float
    turn_deg: float  # a cycle
    binds: tuple[str, ...]
    speed_ci95: tuple[float, float] | None = None
    power_ci95: tuple[float, float] | None = None
    speed_worst_m_s: float | None = None  # of the draws
    power_worst_w: float | None = None
    amplitudes: tuple[float, ...] = ()  # shares of alpha, a joint each; none: equal
    beyond: tuple[Beyond, ...] = ()  # what it asks for more of than the recordings did
    speed_no_more_m_s: float | None = (
        None  # if the servos can do no more than there; None: it asks for no more
    )

    @property
    def gait(self) -> Gait:
        return Gait.from_degrees(self.alpha_deg, self.beta_deg, self.omega_rad_s, shares=self.amplitudes)

    @property
    def row(self) -> Floats:
        """The gait as a simulator takes it."""
        return row_of(self.gait)


def promises(
    robot: Robot,
    gaits: Sequence[tuple[str, Floats]],
    options: OptimiseOptions,
    progress: GaitsCallback | None = None,
    workers: Workers | None = None,
) -> list[Promise]:
    """What the simulation says of gaits, each with what it is called, with intervals.

    A gait is (3,) in rad and rad/s, or (3 + joints,) with each joint's share of alpha.
    """
    if not gaits:
        return []
    if any(len(gait) > 3 for _, gait in gaits):
        ones = np.ones(robot.joints)
        gaits = [(what, gait if len(gait) > 3 else np.append(gait, ones)) for what, gait in gaits]
    space, table = options.space(robot), np.array([gait for _, gait in gaits])
    outcomes = options.simulator(robot, None, progress, workers)(table)
    many = None
    if options.draws:
        many = options.simulator(robot, drawn(robot, options), progress, workers)(table)
    told = [
        promise_of(what, gait, outcomes, i, space, many, robot.tolerance, options.seed)
        for i, (what, gait) in enumerate(gaits)
    ]
    return _against_recordings(robot, told, table, options, workers)


def _against_recordings(
    robot: Robot, told: list[Promise], gaits: Floats, options: OptimiseOptions, workers: Workers | None
) -> list[Promise]:
    """The promises, with what they ask for beyond the recordings, and what is left without."""
    if robot.recorded is None:
        return told
    rows = [beyond(robot.recorded, gait, one.torque_nm) for one, gait in zip(told, gaits, strict=True)]
    limits, far = no_more(robot, options.faults), [i for i, row in enumerate(rows) if row]
    left: dict[int, float] = {}
    if limits and far:
        ended = options.simulator(robot, [(robot, (*options.faults, *limits))], None, workers)(gaits[far])
        left = dict(zip(far, ended.speed_m_s[0].tolist(), strict=True))
    return [replace(one, beyond=rows[i], speed_no_more_m_s=left.get(i)) for i, one in enumerate(told)]


def drawn(robot: Robot, options: OptimiseOptions) -> list[tuple[Robot, tuple[EffectSpec, ...]]]:
    """Robots as the description may mean, broken as asked for."""
    made = draws(robot, options.draws, options.seed)
    return [(one, (*own, *options.faults)) for one, own in made]


def promise_of(
    what: str,
    gait: Floats,
    outcomes: Outcomes,
    at: int,
    space: Space,
    many: Outcomes | None = None,
    tolerance: Tolerance | None = None,
    seed: int = 0,
) -> Promise:
    """The promise of the gait that stands ``at`` a place of ``outcomes``; intervals from those of ``many`` robots, and
    from what a calibration left of the speed (``tolerance``).
    """
    speed, power = float(outcomes.speed_m_s[0, at]), float(outcomes.power_in_w[0, at])
    alpha, beta, omega = (float(v) for v in gait[:3])
    promise = Promise(
        what, degrees(alpha), degrees(beta), omega, speed, power, float(outcomes.transport()[0, at]),
        float(outcomes.torque_nm[0, at]), degrees(outcomes.turn_rad[0, at]),
        tuple(space.binds(gait, float(outcomes.torque_use[0, at]))),
        amplitudes=tuple(round(float(share), 4) for share in gait[3:]) if np.any(gait[3:] != 1) else (),
    )  # fmt: skip
    if many is None:
        return promise
    left_m_s = 0.0 if tolerance is None else tolerance.left_of_speed_m_s(speed)
    return Promise(
        **{
            **vars(promise),
            "speed_ci95": interval(many.speed_m_s[:, at], left_m_s, seed),
            "power_ci95": interval(many.power_in_w[:, at], 0.0),
            "speed_worst_m_s": float(many.speed_m_s[:, at].min()),
            "power_worst_w": float(many.power_in_w[:, at].max()),
        }
    )


def row_of(gait: Gait) -> Floats:
    """A gait as a simulator takes it: (3,) or (3 + joints,)."""
    return np.array([gait.alpha_rad, gait.beta_rad, gait.omega_rad_s, *gait.shares])
