"""What a fit knows of the data before it begins: figures that put each effect's start into its active range."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np

from snakebot.arrays import Floats
from snakebot.effects.stages import assemble, filled
from snakebot.robust import MAD_TO_STD
from snakebot.smoothing import smoothed

if TYPE_CHECKING:
    from snakebot.robot import Robot


_RATE_WINDOW_S = 0.03  # chosen: shorter differences see the encoder's counts, not the motion
_REST_S, _STILL_RAD = 0.2, 0.02  # a joint is at rest that moved no more, in rad, for so long; chosen


class RunLike(Protocol):
    """Any run of the log or of a session folder."""

    @property
    def t_s(self) -> Floats: ...
    @property
    def command_rad(self) -> Floats: ...
    @property
    def measured_rad(self) -> Floats: ...


class Observed:
    """Figures over all runs, an array of (joints,) each unless said otherwise. NaN where the data say nothing."""

    def __init__(self, robot: Robot, runs: Sequence[RunLike]) -> None:
        self.robot = robot
        self.runs = tuple(runs)

    @cached_property
    def duration_s(self) -> float:
        """Of the longest run."""
        return max(float(run.t_s[-1] - run.t_s[0]) for run in self.runs)

    @cached_property
    def sample_s(self) -> float:
        """Median time between samples."""
        return float(np.median(np.concatenate([np.diff(run.t_s) for run in self.runs])))

    @cached_property
    def peak_rate_rad_s(self) -> Floats:
        """Nearly the fastest that each joint was seen to move."""
        return _pooled(self._rates(), lambda rate: np.nanquantile(np.abs(rate), 0.98))

    @cached_property
    def top_rate_rad_s(self) -> Floats:
        """As ``peak_rate_rad_s``, but of the fastest few samples: a limit that is reached in one run of many."""
        return _pooled(self._rates(), lambda rate: np.nanquantile(np.abs(rate), 0.998))

    @cached_property
    def furthest_error_rad(self) -> Floats:
        """Nearly the largest difference of command and measured angle."""
        return _pooled(
            [np.abs(r.command_rad - r.measured_rad) for r in self.runs], lambda e: np.nanquantile(e, 0.99)
        )

    @cached_property
    def amplitude_rad(self) -> Floats:
        """Half the range of motion, but for a per cent at each end."""
        return _pooled(
            [r.measured_rad for r in self.runs],
            lambda a: (np.nanquantile(a, 0.99) - np.nanquantile(a, 0.01)) / 2,
        )

    @cached_property
    def median_rad(self) -> Floats:
        """Median of the measured angles."""
        return _pooled([r.measured_rad for r in self.runs], np.nanmedian)

    @cached_property
    def lag_s(self) -> Floats:
        """Delay that best turns the command into the measured angle: first-order estimate, per joint."""
        return self._line[:, 2]

    @cached_property
    def gain(self) -> Floats:
        """Slope of measured angle against command, the lag taken out."""
        return self._line[:, 0]

    @cached_property
    def offset_rad(self) -> Floats:
        """Measured angle at command 0, the lag taken out."""
        return self._line[:, 1]

    @cached_property
    def residual_rms_rad(self) -> Floats:
        """What gain, offset and lag leave of the error."""
        return self._line[:, 3]

    @cached_property
    def scatter_rad(self) -> Floats:
        """Standard deviation of what changes from sample to sample and back: noise, not motion."""
        return _pooled(
            [np.diff(r.measured_rad, n=3, axis=0) / np.sqrt(20.0) for r in self.runs],
            lambda d: MAD_TO_STD * np.nanmedian(np.abs(d)),
        )

    @cached_property
    def correlation(self) -> Floats:
        """(joints, joints): of measured angle i with command j."""
        joints = self.robot.joints
        table = np.zeros((joints, joints))
        for i in range(joints):
            for j in range(joints):
                pairs = [_paired(r.command_rad[:, j], r.measured_rad[:, i]) for r in self.runs]
                c, m = np.concatenate([p[0] for p in pairs]), np.concatenate([p[1] for p in pairs])
                if c.size > 2 and c.std() > 0 and m.std() > 0:
                    table[i, j] = np.corrcoef(c, m)[0, 1]
        return table

    @cached_property
    def hangs_at_rad(self) -> Floats:
        """Where each joint came to rest while its servo was off: on a bench, straight down."""
        rests: list[list[float]] = [[] for _ in range(self.robot.joints)]
        for run in self.runs:
            for j, found in enumerate(rests):
                off = np.isnan(run.command_rad[:, j])
                for part in np.split(np.arange(off.size), np.flatnonzero(np.diff(off)) + 1):
                    last = run.measured_rad[part[run.t_s[part] > run.t_s[part[-1]] - _REST_S], j]
                    long = run.t_s[part[-1]] - run.t_s[part[0]] > 3 * _REST_S
                    if off[part[0]] and long and np.isfinite(last).any() and np.ptp(last) < _STILL_RAD:
                        found.append(float(np.nanmedian(last)))
        return np.array([np.median(found) if found else np.nan for found in rests])

    @cached_property
    def peak_load_nm(self) -> Floats:
        """Nearly the largest torque that each joint bore, from the model, as its motion was without the noise of the
        readings; NaN without a body or an arm.
        """
        return self._load_at(0.98)

    @cached_property
    def top_load_nm(self) -> Floats:
        """As ``peak_load_nm``, but of the fewest samples: a servo whose torque is limited never bore more than that."""
        return self._load_at(0.995)

    def _load_at(self, share: float) -> Floats:
        if not self._loads:
            return np.full(self.robot.joints, np.nan)
        return _pooled(self._loads, lambda load: np.nanquantile(np.abs(load), share))

    @cached_property
    def _loads(self) -> list[Floats]:
        """Torques of each run; none without a body or an arm."""
        stages = assemble(self.robot, ())
        loads = [stages.torque_of(run.t_s, smoothed(run.t_s, filled(run.measured_rad))) for run in self.runs]
        return [load for load in loads if load is not None]

    def _rates(self) -> list[Floats]:
        rates = []
        for run in self.runs:
            reach = max(1, round(_RATE_WINDOW_S / max(float(np.median(np.diff(run.t_s))), 1e-6) / 2))
            dt = run.t_s[2 * reach :] - run.t_s[: -2 * reach]
            rates.append((run.measured_rad[2 * reach :] - run.measured_rad[: -2 * reach]) / dt[:, None])
        return rates

    @cached_property
    def _line(self) -> Floats:
        """Least squares of measured = gain * command + offset - lag * rate of command, and the rms of the rest."""
        joints = self.robot.joints
        table = np.full((joints, 4), np.nan)
        for j in range(joints):
            rows, right = [], []
            for run in self.runs:
                command = run.command_rad[:, j]
                if run.t_s.size < 3:
                    continue
                rate = np.gradient(command, run.t_s)
                good = np.isfinite(command) & np.isfinite(run.measured_rad[:, j]) & np.isfinite(rate)
                rows.append(np.stack([command[good], np.ones(good.sum()), -rate[good]], axis=1))
                right.append(run.measured_rad[good, j])
            a, b = np.concatenate([np.zeros((0, 3)), *rows]), np.concatenate([np.zeros(0), *right])
            if b.size < 4:
                continue
            found = np.linalg.lstsq(a, b, rcond=None)[0]
            rest = float(np.sqrt(np.mean((a @ found - b) ** 2)))
            table[j] = (*found, rest)
        return table

    def over(self, figure: Floats, joints: tuple[int, ...], otherwise: float) -> float:
        """Median of a figure over some joints; ``otherwise`` where the data say nothing."""
        values = figure[list(joints)]
        values = values[np.isfinite(values)]
        return float(np.median(values)) if values.size else otherwise

    def most(self, figure: Floats, joints: tuple[int, ...], otherwise: float) -> float:
        """Largest of a figure over some joints; ``otherwise`` where the data say nothing."""
        values = figure[list(joints)]
        return float(np.nanmax(values)) if np.isfinite(values).any() else otherwise


def _paired(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    good = np.isfinite(a) & np.isfinite(b)
    return a[good], b[good]


def _pooled(tables: list[Floats], figure: object) -> Floats:
    """``figure`` of all samples of each joint; NaN for a joint without one."""
    both = np.concatenate(tables)
    return np.array(
        [figure(both[:, j]) if np.isfinite(both[:, j]).any() else np.nan for j in range(both.shape[1])]  # type: ignore[operator]
    )
