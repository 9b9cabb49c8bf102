"""What a robot with its effects makes of gaits: steady speed, power and joint torque of each."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats
from snakebot.cluster import Workers
from snakebot.effects import assemble
from snakebot.effects.prediction import replay_stage
from snakebot.effects.servo_stage import ServoRun, servo_stages
from snakebot.errors import BadInputError
from snakebot.gait.blend import blends
from snakebot.physics import servo_layout as layout
from snakebot.physics import simulate_gaits
from snakebot.physics.model import STANDARD_GRAVITY_M_S2

if TYPE_CHECKING:
    from snakebot.effects import EffectSpec, Stages
    from snakebot.robot import Robot

STEP_S = 0.01  # of the set-points, held in between: 100 Hz, as `snakebot run` sends them
THOROUGH = (8, 4)  # cycles simulated, and the last ones averaged: the paper's
QUICK = (5, 2)  # to choose what is then simulated at length; chosen
# Of a brief look: least steps of the body in a cycle, where the joints do not feel it; but never shorter than those of
# the set-points. Speed and power stay within 1 % of a thorough look's (tests/optimise/test_brief_look.py).
QUICK_STEPS = 160

PIECE, SWEPT_PIECE = 8, 128  # gaits handed to a worker at once: a tenth of a second's work or more; chosen

TorqueNm = float | tuple[float, ...] | None
GaitsCallback = Callable[[int], None]  # gaits simulated since the last call


@dataclass(frozen=True, eq=False)
class Outcomes:
    """Steady state of G gaits on D robots; arrays (D, G).

    Attributes:
        speed_m_s: way of the centre of mass in a cycle over the cycle's length.
        power_in_w: put into the joints, mean; what is given back counts against it.
        torque_nm: largest of all joints.
        torque_use: the same over what the servo of that joint has; 0 where no limit is known.
        turn_rad: change of heading in a cycle.
        weight_n: (D,) of the robots.
    """

    speed_m_s: Floats
    power_in_w: Floats
    torque_nm: Floats
    torque_use: Floats
    turn_rad: Floats
    weight_n: Floats = field(kw_only=True)

    def of(self, gait: int) -> Outcomes:
        """Of one gait alone."""
        tables = (getattr(self, name)[:, gait : gait + 1] for name in _TABLES)
        return Outcomes(*tables, weight_n=self.weight_n)

    def transport(self) -> Floats:
        """Cost of transport (D, G): power over weight and speed, without unit; infinite where it stands."""
        with np.errstate(divide="ignore", invalid="ignore"):
            cost = self.power_in_w / (self.weight_n[:, None] * self.speed_m_s)
        return np.where(self.speed_m_s > 0, cost, np.inf)


_TABLES = ("speed_m_s", "power_in_w", "torque_nm", "torque_use", "turn_rad")


def joined(parts: Sequence[Outcomes]) -> Outcomes:
    """More gaits on the same robots."""
    tables = (np.concatenate([getattr(part, name) for part in parts], axis=1) for name in _TABLES)
    return Outcomes(*tables, weight_n=parts[0].weight_n)


class GaitSimulator:
    """One or several robots, each with its effects, asked what gaits make of them.

    Args:
        robots: each with effects that come to its own; all have as many joints.
        workers: of a cluster, that do it instead of this process; the results are the same.
        torque_nm: what each servo has, where the description does not say, for all joints or one a joint; None: as
            much as is asked for.

    Raises:
        BadInputError: a robot without a body, or an effect that does not fit it.
    """

    def __init__(
        self,
        robots: Sequence[tuple[Robot, Iterable[EffectSpec]]],
        *,
        torque_nm: TorqueNm = None,
        threads: int | None = None,
        progress: GaitsCallback | None = None,
        workers: Workers | None = None,
    ) -> None:
        self._robots = [(robot, tuple(specs)) for robot, specs in robots]
        self._torque_nm, self._workers = torque_nm, workers
        self._stages = []
        for robot, specs in self._robots:
            if robot.body is None:
                raise BadInputError(
                    f"robot {robot.name!r} has no body: a bench of servos does not move over ground"
                )
            self._stages.append(assemble(robot, specs))
        self._allowed = [_torque_limit_nm(stages.servo_rows, torque_nm) for stages in self._stages]
        self._threads = threads or _cores()
        self._sweeps = _only_lags(self._stages[0]) and not np.isfinite(self._allowed[0]).any()
        self._progress = progress or (lambda done: None)
        self.simulated = 0  # gaits so far

    def __call__(self, gaits: Floats, *, thorough: bool = True) -> Outcomes:
        """Simulate gaits (G, 3): alpha and beta in rad, omega in rad/s; or (G, 3 + joints) with each joint's share of
        alpha.

        Where joints follow but for a lag, a brief look is a compiled sweep, which tells no torque.
        """
        if self._workers is not None and self._workers.away and len(gaits):
            return self._handed_out(gaits, thorough, self._workers)
        cycles = THOROUGH if thorough else QUICK
        if not thorough and len(self._stages) == 1 and len(gaits) and self._sweeps and gaits.shape[1] == 3:
            return self._swept(gaits, cycles)
        tasks = [(robot, row) for robot in range(len(self._stages)) for row in gaits]
        found = np.zeros((len(tasks), len(_TABLES)))
        if tasks:
            with ThreadPoolExecutor(min(self._threads, len(tasks))) as pool:
                jobs = [pool.submit(self._one, robot, row, cycles) for robot, row in tasks]
                try:
                    for number, job in enumerate(jobs):
                        found[number] = job.result()
                        self._progress(1)
                except BaseException:
                    pool.shutdown(cancel_futures=True)
                    raise
        self.simulated += len(tasks)
        tables = np.moveaxis(found.reshape(len(self._stages), len(gaits), len(_TABLES)), 2, 0)
        return Outcomes(*tables, weight_n=self._weight_n())

    def _handed_out(self, gaits: Floats, thorough: bool, workers: Workers) -> Outcomes:
        """All robots' gaits in pieces, and these put together."""
        size = SWEPT_PIECE if self._sweeps and not thorough else PIECE
        pieces = {
            (robot, first): (*self._robots[robot], self._torque_nm, gaits[first : first + size], thorough)
            for robot in range(len(self._robots))
            for first in range(0, len(gaits), size)
        }
        found: dict[tuple[int, int], Outcomes] = {}
        for key, part in workers.results(piece, pieces):
            found[key] = part
            self.simulated += part.speed_m_s.size
            self._progress(part.speed_m_s.size)
        rows = [
            joined([found[robot, first] for first in range(0, len(gaits), size)])
            for robot in range(len(self._robots))
        ]
        tables = (np.concatenate([getattr(row, name) for row in rows]) for name in _TABLES)
        return Outcomes(*tables, weight_n=self._weight_n())

    def _weight_n(self) -> Floats:
        return np.array([STANDARD_GRAVITY_M_S2 * s.model.mass.sum() for s in self._stages if s.model])

    def _swept(self, gaits: Floats, cycles: tuple[int, int]) -> Outcomes:
        stages = self._stages[0]
        assert stages.model is not None
        found = simulate_gaits(
            stages.model, gaits, servo_time_constant_s=float(stages.servo_rows[0, layout.TIME_CONSTANT_S]),
            cycles=cycles[0], averaged_cycles=cycles[1], threads=self._threads,
        )  # fmt: skip
        self.simulated += len(gaits)
        self._progress(len(gaits))
        none = np.zeros((1, len(gaits)))
        return Outcomes(
            found.speed_m_s[None], found.power_in_w[None], none, none, found.turn_rad[None],
            weight_n=self._weight_n(),
        )  # fmt: skip

    def _one(self, robot: int, gait: Floats, cycles: tuple[int, int]) -> Floats:
        stages, allowed = self._stages[robot], self._allowed[robot]
        t, command, period_s = commands(gait, stages.robot.joints, cycles[0])
        (servos,) = servo_stages(stages, [ServoRun(t, stages.link(t, command))])
        if servos.base is None:
            angle, step_s = servos.joint_angle_rad, None
            if cycles == QUICK:
                apart = max(1, int(period_s / (QUICK_STEPS * STEP_S)))
                rows = np.append(np.arange(0, len(t) - 1, apart), len(t) - 1)
                t, angle, step_s = t[rows], angle[rows], apart * STEP_S
            moved = replay_stage(stages, t, angle, max_step_s=step_s)
            com, heading, torque, power = (
                moved.com_m, moved.heading_rad, moved.joint_torque_nm, moved.power_in_w,
            )  # fmt: skip
        else:
            assert servos.torque_nm is not None
            assert servos.power_in_w is not None
            com, heading = servos.base[:, :2], servos.base[:, 2]
            torque, power = servos.torque_nm, servos.power_in_w
        begin_s = (cycles[0] - cycles[1]) * period_s
        steady = (t > begin_s) & (t <= cycles[0] * period_s)
        peaks = np.abs(torque[steady]).max(axis=0)
        speed, turn = steady_motion(t, com, heading, period_s, cycles)
        return np.array([speed, power[steady].mean(), peaks.max(), (peaks / allowed).max(), turn])


def piece(
    robot: Robot, specs: Iterable[EffectSpec], torque_nm: TorqueNm, gaits: Floats, thorough: bool
) -> Outcomes:
    """Some gaits of one robot, on one core: what a worker of a cluster is asked."""
    return GaitSimulator([(robot, specs)], torque_nm=torque_nm, threads=1)(gaits, thorough=thorough)


def commands(gait: Floats, joints: int, cycles: int) -> tuple[Floats, Floats, float]:
    """Times (T,) and set-points (T, joints) of a gait that swells from rest in its first cycle; its period in s."""
    alpha, beta, omega = gait[:3]
    period_s = 2 * math.pi / omega
    t = STEP_S * np.arange(math.ceil(cycles * period_s / STEP_S) + 1)
    ramp = blends(t[t < period_s] / period_s)
    wave = (
        alpha * (gait[3:] if len(gait) > 3 else 1.0) * np.sin(omega * t[:, None] + beta * np.arange(joints))
    )
    wave[: len(ramp)] *= ramp[:, None]
    return t, wave, period_s


def steady_motion(
    t_s: Floats, com_m: Floats, heading_rad: Floats, period_s: float, cycles: tuple[int, int]
) -> tuple[float, float]:
    """Speed in m/s, the way in a cycle over its length, and change of heading in rad, means of the last cycles."""
    ends = period_s * np.arange(cycles[0] - cycles[1], cycles[0] + 1)
    x, y = (np.interp(ends, t_s, column) for column in com_m.T)
    heading = np.interp(ends, t_s, heading_rad)
    return float(np.hypot(np.diff(x), np.diff(y)).mean() / period_s), float(np.diff(heading).mean())


def _torque_limit_nm(rows: Floats, given_nm: TorqueNm) -> Floats:
    """(joints,) torque of each servo: its limit, or that at which it stalls; infinite where it is not known."""
    limit = rows[:, layout.TORQUE_LIMIT_NM].copy()
    drop = rows[:, layout.RATE_DROP_PER_NM]
    with np.errstate(divide="ignore"):
        limit = np.minimum(limit, np.where(drop > 0, 1 / drop, np.inf))
    return limit if given_nm is None else np.minimum(limit, given_nm)


def _only_lags(stages: Stages) -> bool:
    """Whether every joint follows its set-points but for one and the same lag."""
    rows = stages.servo_rows
    same = layout.nominal_parameters(len(rows), float(rows[0, layout.TIME_CONSTANT_S]))
    filters = [*stages.link_filters(), *stages.servo_filters()]
    return not filters and not stages.late_s.any() and np.array_equal(rows, same)


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
