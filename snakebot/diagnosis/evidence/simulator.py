"""Predicted readings of every run under a set of effects: by the filters and the kernel of the simulated board.

Set-points come into force at their own times and are held (``ticks`` has those between the rows); servos start where
the joint was first read. Where nothing but the servo itself matters no joint disturbs another, so all joints are
simulated at once, each with parameters of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from copy import copy
from dataclasses import replace
from threading import Lock

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.data import Data
from snakebot.diagnosis.evidence.recent import RecentRuns
from snakebot.diagnosis.evidence.ticks import set_points
from snakebot.effects.effect import Track
from snakebot.effects.prediction import JointRun, joint_run, joint_runs
from snakebot.effects.servo_stage import ServoRun
from snakebot.effects.spec import EffectSpec
from snakebot.effects.stages import Stages, assemble, filled
from snakebot.lifted import lifted
from snakebot.physics.servo_layout import (
    FREE_JOINT,
    LOCKED,
    RATE_DROP_PER_NM,
    SOURCE,
    TORQUE_LIMIT_NM,
    loose,
)
from snakebot.smoothing import smoothed


class Simulator:
    """Predicts the runs of one session. May be used from several threads."""

    def __init__(self, data: Data) -> None:
        self.data = data
        self.robot = data.robot
        self.measured = tuple(filled(run.measured_rad) for run in data.runs)
        self.smooth = tuple(smoothed(run.t_s, m) for run, m in zip(data.runs, self.measured, strict=True))
        self.set_points = tuple(set_points(run) for run in data.runs)
        self._loads: dict[int, Floats] = {}
        self._measured_loads: dict[int, Floats] = {}
        self._recent = RecentRuns()
        self._beside: tuple[EffectSpec, ...] = ()
        self._frozen: tuple[EffectSpec, ...] = ()  # of these; see ``beside``
        self._marks: dict[int, Floats] = {}  # (N, k) what they change in the readings of a run
        self._lock = Lock()

    def stages(self, specs: Iterable[EffectSpec], *, in_air: bool = False) -> Stages:
        """The robot with its effects; ``in_air``: lifted off the ground, and what the ground does to it is gone."""
        if in_air:
            return assemble(lifted(self.robot), [s for s in specs if s.effect.stage != "body"])
        return assemble(self.robot, specs)

    def always_needs_body(self, specs: Iterable[EffectSpec]) -> bool:
        """Whether what the joints do is another matter without the body: with torques given, slopes are wrong."""
        stages = self.stages(specs)
        rows = stages.servo_rows
        return stages.model is not None and (_goes_along(rows) or _slowed(rows))

    def beside(self, specs: Iterable[EffectSpec]) -> Simulator:
        """The same robot, for rough predictions of these effects with others beside them: what takes a body even so
        stays as it shows with these alone. So does play that the load takes up: under torques that are given it is
        off by more than most effects change.
        """
        out = copy(self)
        out._beside = tuple(specs)
        out._frozen = tuple(
            spec for spec in out._beside if self.rough_needs_body([spec]) or self._swings([spec])
        )
        out._marks = {}
        return out

    @property
    def has_frozen(self) -> bool:
        """Whether rough predictions leave some effects as they show with those that they are beside."""
        return bool(self._frozen)

    def rough_needs_body(self, specs: Iterable[EffectSpec]) -> bool:
        """Whether the whole body must be simulated even for a rough prediction."""
        return _meets(self.stages(self._not_frozen(specs)), rough=True)

    def _swings(self, specs: Iterable[EffectSpec]) -> bool:
        """Whether a joint of the body has play that the load takes up."""
        stages = self.stages(specs)
        return stages.model is not None and bool(loose(stages.servo_rows).any())

    def needs_body(self, specs: Iterable[EffectSpec]) -> bool:
        """Whether the whole body must be simulated, unless a rough prediction will do."""
        return _meets(self.stages(specs), rough=False)

    def joints_meet(self, specs: Iterable[EffectSpec], *, rough: bool) -> bool:
        """Whether what changes one joint can change another: through the body, or because cables are swapped."""
        coupled = self.rough_needs_body(specs) if rough else self.needs_body(specs)
        return coupled or self._swapped(self.stages(specs))

    def others_drive(self, specs: Iterable[EffectSpec]) -> bool:
        """Whether a joint is free, or has the set-points of another."""
        stages = self.stages(specs)
        return stages.broken[0] or self._swapped(stages)

    def _swapped(self, stages: Stages) -> bool:
        return bool((stages.servo_rows[:, SOURCE] != np.arange(self.data.joints)).any())

    def predict(
        self,
        specs: Iterable[EffectSpec],
        runs: Sequence[int] | None = None,
        *,
        rough: bool = False,
        columns: Sequence[int] | None = None,
        loads_nm: Sequence[Floats] | None = None,
    ) -> list[JointRun]:
        """Predict the given runs (all, if None).

        Args:
            loads_nm: torques (N, k) that the servos bear in each of the given runs, where they are known: joints stay
                apart.
            columns: 0-based joints that are asked for; the others may come out as nan.
            rough: take the torques of the measured motion for those that the servos bear, where that will do: no body
                needs to be simulated then, and joints stay apart.
        """
        specs = tuple(specs)
        wanted = range(len(self.data.runs)) if runs is None else runs
        given = dict.fromkeys(wanted) if loads_nm is None else dict(zip(wanted, loads_nm, strict=True))
        if rough and loads_nm is None and self._frozen and not self.rough_needs_body(specs):
            return self._with_frozen(specs, wanted, columns)
        stages = self.stages(specs)
        if loads_nm is not None or not _meets(stages, rough):
            made = self._predicted(specs, stages, given, columns, rough)
        else:  # a body takes long to simulate: twenty times as long as servos that stay apart
            made = {i: run for i in wanted if (run := self._recent.get((i, specs))) is not None}
            missing = {i: None for i in wanted if i not in made}
            for index, run in self._predicted(specs, stages, missing).items():
                self._recent.keep((index, specs), run)
                made[index] = run
        return [made[i] for i in wanted]

    def _not_frozen(self, specs: Iterable[EffectSpec]) -> tuple[EffectSpec, ...]:
        return tuple(spec for spec in specs if spec not in self._frozen)

    def _with_frozen(
        self, specs: Iterable[EffectSpec], runs: Sequence[int], columns: Sequence[int] | None
    ) -> list[JointRun]:
        """A rough prediction without those that are frozen, and what these change with those beside them alone."""
        thawed = self.beside(())
        missing = [i for i in runs if i not in self._marks]
        if missing:
            with_them = thawed.predict(self._beside, missing)
            without = thawed.predict(self._not_frozen(self._beside), missing, rough=True)
            for index, one, other in zip(missing, with_them, without, strict=True):
                self._marks[index] = one.reading_rad - other.reading_rad
        made = thawed.predict(self._not_frozen(specs), runs, rough=True, columns=columns)
        return [
            replace(run, reading_rad=run.reading_rad + self._marks[index])
            for index, run in zip(runs, made, strict=True)
        ]

    def _predicted(
        self,
        specs: tuple[EffectSpec, ...],
        on_ground: Stages,
        loads_nm: Mapping[int, Floats | None],
        columns: Sequence[int] | None = None,
        rough: bool = False,
    ) -> dict[int, JointRun]:
        """``predict`` of the runs that ``loads_nm`` has an entry of, by their places in the session;
        ``on_ground``: the robot with these effects there.
        """
        made: dict[int, JointRun] = {}
        for in_air in {self.data.runs[i].lifted for i in loads_nm}:
            stages = self.stages(specs, in_air=True) if in_air else on_ground
            here = [i for i in loads_nm if self.data.runs[i].lifted is in_air]
            given = [
                self._given(stages, i, stages.link(*self.set_points[i]), rough, loads_nm[i]) for i in here
            ]
            made.update(zip(here, joint_runs(stages, given, columns), strict=True))
        return made

    def joints(self, stages: Stages, index: int, track: Track) -> JointRun:
        """What the joints do and show in a run if these set-points leave the link."""
        return joint_run(stages, self._given(stages, index, track))

    def _given(
        self,
        stages: Stages,
        index: int,
        track: Track,
        rough: bool = False,
        load_nm: Floats | None = None,
    ) -> ServoRun:
        t_s, known = self.data.runs[index].t_s, self.measured[index]
        if stages.sensor_filters():
            known = stages.true_angle(t_s, known)
        rows = stages.servo_rows
        if rough and stages.model is not None and stages.feels_load and not _goes_along(rows):
            load_nm = self.measured_load(index)
        return ServoRun(t_s, track, known_rad=known, load_nm=load_nm)

    def between_samples(self, index: int, parts: int) -> tuple[Floats, Floats]:
        """Times (M,) and nominal joint angles (M, k) of a run, each sample's interval cut into ``parts``."""
        run = self.data.runs[index]
        stages = self.stages((), in_air=run.lifted)
        steps = np.arange(run.t_s.size * parts - parts + 1) / parts
        t_s = np.interp(steps, np.arange(run.t_s.size), run.t_s)
        known = np.stack([np.interp(t_s, run.t_s, column) for column in self.measured[index].T], axis=1)
        track = stages.link(*self.set_points[index])
        return t_s, joint_run(stages, ServoRun(t_s, track, known_rad=known)).angle_rad

    def load(self, index: int) -> Floats | None:
        """Torques (N, k) of the nominal motion; None on a bench without an arm."""

        def torque() -> Floats | None:
            run = self.data.runs[index]
            stages = self.stages((), in_air=run.lifted)
            track = stages.link(*self.set_points[index])
            return stages.torque_of(run.t_s, self.joints(stages, index, track).angle_rad)

        return self._kept(self._loads, index, torque)

    def measured_load(self, index: int) -> Floats | None:
        """Torques (N, k) of the measured motion, by inverse dynamics; None on a bench without an arm."""

        def torque() -> Floats | None:
            run = self.data.runs[index]
            return self.stages((), in_air=run.lifted).torque_of(run.t_s, self.smooth[index])

        return self._kept(self._measured_loads, index, torque)

    def _kept(self, known: dict[int, Floats], index: int, make: Callable[[], Floats | None]) -> Floats | None:
        """What is ``known`` of a run, made at the first time that it is asked for."""
        if index not in known:
            made = make()
            if made is None:
                return None
            with self._lock:
                known[index] = made
        return known[index]


def _meets(stages: Stages, rough: bool) -> bool:
    """Whether joints disturb each other through the body, which must be simulated then; ``rough``: though the torques
    of the measured motion would do.
    """
    goes_along = _goes_along(stages.servo_rows)
    return stages.model is not None and (goes_along or (stages.feels_load and not rough))


def _goes_along(rows: Floats) -> bool:
    """Whether some joint goes where the rest of the body takes it: torques of a motion say little of it."""
    limited = np.isfinite(rows[:, TORQUE_LIMIT_NM]) | (rows[:, LOCKED] == FREE_JOINT)
    return bool(limited.any())


def _slowed(rows: Floats) -> bool:
    """Whether some joint is slower under load."""
    return bool((rows[:, RATE_DROP_PER_NM] > 0).any())
