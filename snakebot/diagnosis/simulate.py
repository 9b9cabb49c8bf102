"""Predicted readings of every run under a set of effects: by the filters and the kernel of the simulated board.

Set-points come into force at their own times and are held (``ticks`` has those between the rows); servos start where
the joint was first read. Where nothing but the servo itself matters no joint disturbs another, so all joints are
simulated at once, each with parameters of its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.data import Data, PreparedRun
from snakebot.diagnosis.smoothing import smoothed
from snakebot.diagnosis.ticks import set_points
from snakebot.effects.effect import Track
from snakebot.effects.prediction import GRID_S, servo_stage, setpoint_at
from snakebot.effects.spec import EffectSpec
from snakebot.effects.stages import Stages, assemble, filled
from snakebot.lifted import lifted
from snakebot.physics.servo_chain import DrivenChain
from snakebot.physics.servo_layout import (
    FREE_JOINT,
    LOCK_RAD,
    LOCKED,
    RIGID_JOINT,
    SOURCE,
    TORQUE_LIMIT_NM,
    loose,
    needs_fine_steps,
)

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Predicted:
    """One run: readings, joint angles, and the spread that chance brings into the readings; (N, k) each."""

    reading_rad: Floats
    angle_rad: Floats
    variance_rad2: Floats | None


class Simulator:
    """Predicts the runs of one session. May be used from several threads."""

    def __init__(self, data: Data) -> None:
        self.data = data
        self.robot = data.robot
        self.measured = tuple(filled(run.measured_rad) for run in data.runs)
        self.smooth = tuple(smoothed(run.t_s, m) for run, m in zip(data.runs, self.measured, strict=True))
        self.set_points = tuple(set_points(run) for run in data.runs)
        self._loads: dict[int, Floats] = {}
        self._lock = Lock()

    def stages(self, specs: Iterable[EffectSpec], *, in_air: bool = False) -> Stages:
        """The robot with its effects; ``in_air``: lifted off the ground, and what the ground does to it is gone."""
        if in_air:
            return assemble(lifted(self.robot), [s for s in specs if s.effect.stage != "body"])
        return assemble(self.robot, specs)

    def dear(self, specs: Iterable[EffectSpec]) -> bool:
        """Whether the whole body must be simulated even for a rough prediction."""
        stages = self.stages(specs)
        rows = stages.servo_rows
        return stages.model is not None and _weak(rows)

    def coupled(self, specs: Iterable[EffectSpec]) -> bool:
        """Whether the whole body must be simulated, unless a rough prediction will do."""
        stages = self.stages(specs)
        return stages.model is not None and (stages.feels_load or _weak(stages.servo_rows))

    def predict(
        self,
        specs: Iterable[EffectSpec],
        runs: Sequence[int] | None = None,
        *,
        rough: bool = False,
        columns: Sequence[int] | None = None,
    ) -> list[Predicted]:
        """Predict the given runs (all, if None).

        Args:
            columns: 0-based joints that are asked for; the others may come out as nan.
            rough: take the torques of the nominal motion for those that the servos bear, where that will do: no body
                needs to be simulated then, and joints stay apart.
        """
        specs = tuple(specs)
        wanted = range(len(self.data.runs)) if runs is None else runs
        in_air = {self.data.runs[i].lifted for i in wanted}
        stages = {air: self.stages(specs, in_air=air) for air in in_air}
        return [self._one(stages[self.data.runs[i].lifted], i, rough, columns) for i in wanted]

    def _one(self, stages: Stages, index: int, rough: bool, columns: Sequence[int] | None) -> Predicted:
        run = self.data.runs[index]
        track = stages.link(*self.set_points[index])
        angle = self.servo(stages, index, run, track, rough, columns)
        reading, variance = angle, None
        if track.variance_rad2 is not None:
            variance = setpoint_at(Track(track.time_s, track.variance_rad2), run.t_s)
        for sensor in stages.sensor_filters():
            reading = sensor.batch(run.t_s, reading)
            more = sensor.variance_rad2(run.t_s)
            if np.any(more):
                variance = np.zeros_like(reading) + more + (0.0 if variance is None else variance)
        return Predicted(reading, angle, variance)

    def servo(
        self,
        stages: Stages,
        index: int,
        run: PreparedRun,
        track: Track,
        rough: bool = False,
        columns: Sequence[int] | None = None,
    ) -> Floats:
        """Joint angles (N, k) that these set-points make."""
        known = (
            stages.true_angle(run.t_s, self.measured[index])
            if stages.sensor_filters()
            else self.measured[index]
        )
        rows = stages.servo_rows
        weak = _weak(rows)
        load = None
        if stages.model is not None and stages.feels_load and rough and not weak:
            load = self.load(index)
        coupled = stages.model is not None and (weak or (stages.feels_load and load is None))
        if coupled or columns is None or len(columns) == rows.shape[0]:
            return servo_stage(
                stages, track, run.t_s, initial_rad=known[0], known_rad=known, load_nm=load
            ).joint_angle_rad
        return _some_joints(stages, run, track, known, load, np.asarray(columns, dtype=np.int64))

    def between_samples(self, index: int, parts: int) -> tuple[Floats, Floats]:
        """Times (M,) and nominal joint angles (M, k) of a run, each sample's interval cut into ``parts``."""
        run = self.data.runs[index]
        stages = self.stages((), in_air=run.lifted)
        steps = np.arange(run.t_s.size * parts - parts + 1) / parts
        t_s = np.interp(steps, np.arange(run.t_s.size), run.t_s)
        known = np.stack([np.interp(t_s, run.t_s, column) for column in self.measured[index].T], axis=1)
        track = stages.link(*self.set_points[index])
        made = servo_stage(stages, track, t_s, initial_rad=known[0], known_rad=known)
        return t_s, made.joint_angle_rad

    def load(self, index: int) -> Floats | None:
        """Torques (N, k) of the nominal motion; None on a bench without an arm."""
        if index not in self._loads:
            run = self.data.runs[index]
            stages = self.stages((), in_air=run.lifted)
            track = stages.link(*self.set_points[index])
            torque = stages.torque_of(run.t_s, self.servo(stages, index, run, track))
            if torque is None:
                return None
            with self._lock:
                self._loads[index] = torque
        return self._loads[index]


def _weak(rows: Floats) -> bool:
    """Whether some joint goes where the rest of the body takes it."""
    limited = np.isfinite(rows[:, TORQUE_LIMIT_NM]) | (rows[:, LOCKED] == FREE_JOINT) | loose(rows)
    return bool(limited.any())


def _some_joints(
    stages: Stages,
    run: PreparedRun,
    track: Track,
    known: Floats,
    load: Floats | None,
    columns: NDArray[np.int64],
) -> Floats:
    """``servo_stage`` for some of the joints, where none feels the others; nan for the rest."""
    rows = stages.servo_rows[columns].copy()
    source = rows[:, SOURCE].astype(np.int64)
    rows[:, SOURCE] = np.arange(columns.size)
    setpoint = np.ascontiguousarray(track.setpoint_rad[:, source])
    start = np.where(rows[:, LOCKED] == RIGID_JOINT, rows[:, LOCK_RAD], known[0, columns])
    powered = np.isfinite(setpoint_at(Track(track.time_s, setpoint), run.t_s))
    chain = DrivenChain(rows, start, grid_s=GRID_S, fine=needs_fine_steps(rows))
    made = chain.run(
        run.t_s,
        track.time_s,
        setpoint,
        load_t_s=None if load is None else run.t_s,
        load_nm=None if load is None else np.ascontiguousarray(load[:, columns]),
        known_rad=np.where(powered, np.nan, known[:, columns]),
    )
    out = np.full(known.shape, np.nan)
    out[:, columns] = made.angle
    return out
