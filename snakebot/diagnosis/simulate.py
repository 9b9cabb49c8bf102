"""Predicted readings of every run under a set of effects: the same filters and servo kernel that the simulated board has.

Set-points come into force at their own times and are held; servos start where the joint was first read. Before the
ground no joint disturbs another, so all joints are simulated at once, each with parameters of its own. The torque that a
joint bears is that of the ideal motion (see ``physics.servo``); it is computed once for a set of set-points and kept.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.data import Data, PreparedRun
from snakebot.effects.effect import Track
from snakebot.effects.spec import EffectSpec
from snakebot.effects.stages import Stages, assemble, filled
from snakebot.physics.servo_chain import DrivenChain
from snakebot.physics.servo_layout import FREE_JOINT, LOCK_RAD, LOCKED, RIGID_JOINT, needs_fine_steps

Floats = NDArray[np.float64]

FINE_STEP_S = 2e-3
LOAD_STEP_S = 2e-3
KEPT_LOADS = 600

# Servo effects that shape the motion whose load is taken; the others yield to that load.
_SHAPES_IDEAL = frozenset(
    {"wiring", "command_gain", "servo_offset", "deadband", "second_order", "servo_lag", "rate_limit"}
)


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
        self._loads: dict[tuple[object, ...], Floats] = {}
        self._lock = Lock()

    def stages(self, specs: Iterable[EffectSpec]) -> Stages:
        return assemble(self.robot, specs)

    def predict(self, specs: Iterable[EffectSpec], runs: Sequence[int] | None = None) -> list[Predicted]:
        """Predict the given runs (all, if None)."""
        stages = self.stages(specs)
        return [self._one(stages, i) for i in (range(len(self.data.runs)) if runs is None else runs)]

    def _one(self, stages: Stages, index: int) -> Predicted:
        run = self.data.runs[index]
        track = stages.link(run.t_s, run.command_rad)
        angle = self._servo(stages, index, run, track)
        reading, variance = angle, track.variance_rad2
        if variance is not None:
            variance = _held(run.t_s, track.time_s, variance)
        for sensor in stages.sensor_filters():
            reading = sensor.batch(run.t_s, reading)
            more = sensor.variance_rad2(run.t_s)
            if np.any(more):
                variance = np.zeros_like(reading) + more + (0.0 if variance is None else variance)
        return Predicted(reading, angle, variance)

    def _servo(self, stages: Stages, index: int, run: PreparedRun, track: Track) -> Floats:
        known = stages.true_angle(run.t_s, self.measured[index])
        rows = stages.servo_rows
        swings = rows[:, LOCKED] == FREE_JOINT
        model = stages.model if swings.any() else None  # what a dead joint does, only the whole body tells
        start = known[0].copy()
        start[rows[:, LOCKED] == RIGID_JOINT] = rows[rows[:, LOCKED] == RIGID_JOINT, LOCK_RAD]
        known = np.where(swings, np.nan, known)
        chain = DrivenChain(rows, start, model=model, grid_s=FINE_STEP_S, fine=needs_fine_steps(rows))
        load = self.load(index, stages) if stages.model is not None and stages.feels_load else None
        return chain.run(
            run.t_s,
            track.time_s,
            np.ascontiguousarray(track.setpoint_rad),
            load_t_s=None if load is None else run.t_s,
            load_nm=load,
            known_rad=known,
        ).angle

    def load(self, index: int, stages: Stages) -> Floats:
        """Torque (N, k) that the servos of a run bear in the ideal motion; the robot must have a body.

        It depends on what moves the ideal servo and on the body, not on effects that only yield to the load.
        """
        ideal = tuple(
            spec for spec in stages.specs if spec.effect.stage in ("link", "body") or spec.name in _SHAPES_IDEAL
        )
        key = (index, *sorted(str(_rounded(spec)) for spec in ideal))
        found = self._loads.get(key)
        if found is None:
            run = self.data.runs[index]
            bare = Stages(self.robot, ideal)
            track = bare.link(run.t_s, run.command_rad)
            known = self.measured[index]
            chain = DrivenChain(bare.servo_rows, known[0], load_model=bare.model, grid_s=LOAD_STEP_S)
            found = chain.run(
                run.t_s, track.time_s, np.ascontiguousarray(track.setpoint_rad), known_rad=known
            ).load
            with self._lock:
                if len(self._loads) > KEPT_LOADS:
                    self._loads.clear()
                self._loads[key] = found
        return found


def _rounded(spec: EffectSpec) -> EffectSpec:
    """Values to two figures: a load need not follow every step of a search."""
    return EffectSpec(
        spec.name,
        {k: tuple(_two(x) for x in v) if isinstance(v, tuple) else _two(v) for k, v in spec.values.items()},
        spec.joints,
    )


def _two(value: float) -> float:
    return float(f"{value:.2g}")


def _held(t_s: Floats, time_s: Floats, values: Floats) -> Floats:
    """Values that came into force at ``time_s``, as they stand at ``t_s``."""
    at = np.searchsorted(time_s, t_s, side="right") - 1
    return np.asarray(values[np.maximum(at, 0)])
