"""All that does not depend on an explanation, gathered once: the room's one result."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.angles import AngleEvidence
from snakebot.diagnosis.evidence.blocks import block_map
from snakebot.diagnosis.evidence.data import Data
from snakebot.diagnosis.evidence.floor import Floor, noise_floor
from snakebot.diagnosis.evidence.folds import Split, split_of
from snakebot.diagnosis.evidence.ground_evidence import GroundEvidence, ground_evidence
from snakebot.diagnosis.evidence.predictor import Predictor
from snakebot.diagnosis.evidence.score import GROUND, Scoring
from snakebot.diagnosis.evidence.simulator import Simulator
from snakebot.diagnosis.evidence.usual import usual_of
from snakebot.effects.effect import Usual
from snakebot.effects.spec import EffectSpec
from snakebot.robot import Robot


@dataclass(frozen=True, eq=False)
class Evidence:
    """A session as evidence.

    Attributes:
        floor: noise of each joint.
        angles: the joint angles with what they may be off by.
        ground: the same of the motion over ground; None where nothing was measured.
        split: which runs are fitted and which are scored.
        scoring: how residuals of angles and ground are scored together.
        predictor: what the runs would have shown under any effects.
    """

    floor: Floor
    angles: AngleEvidence
    ground: GroundEvidence | None
    split: Split
    scoring: Scoring
    predictor: Predictor

    @cached_property
    def usual(self) -> Usual:
        """What the servos bear and how fast the joints turn in the runs that may be fitted."""
        return usual_of(self.predictor.simulator, self.split.free)

    @property
    def data(self) -> Data:
        return self.angles.data

    def with_misfit(self, left_square: Floats) -> Evidence:
        """The same, where all everyday effects together leave the mean squares (B,) of the angles."""
        blocks, allowed = self.angles.blocks, self.angles.allowed_square
        over = np.maximum(left_square - allowed, 0.0)
        decides = self.scoring.decides[: blocks.count]
        middle = np.zeros(self.data.joints)
        for joint in range(middle.size):
            mine = (blocks.joint == joint) & decides
            middle[joint] = np.median(over[mine]) if mine.any() else 0.0
        misfit = middle[blocks.joint]
        over_ground = np.zeros(self.scoring.run.size - blocks.count)
        return replace(
            self,
            angles=replace(self.angles, misfit_square=misfit),
            scoring=replace(self.scoring, misfit_square=np.concatenate([misfit, over_ground])),
        )

    def beside(self, specs: Iterable[EffectSpec]) -> Evidence:
        """The same, for first looks at more on top of these effects: see ``Simulator.beside``."""
        return replace(
            self, predictor=replace(self.predictor, simulator=self.predictor.simulator.beside(specs))
        )

    def of_robot(self, robot: Robot) -> Evidence:
        """The same runs, of a robot with other nominal numbers; what they may be off by stays."""
        data = Data(robot, self.data.runs, 0)
        return replace(
            self,
            angles=replace(self.angles, data=data),
            predictor=self.predictor.with_simulator(Simulator(data)),
        )

    def of_readings(self, readings: Sequence[Floats], ground_value: Floats | None) -> Evidence:
        """The same, had other joint angles (N, k) a run, and other features of the ground (G,), been measured.

        Nothing is left without credit: what was healthy in the recorded runs need not be in these.
        """
        runs = [replace(run, measured_rad=made) for run, made in zip(self.data.runs, readings, strict=True)]
        data = Data(self.data.robot, tuple(runs), 0)
        ground, predictor = self.ground, self.predictor.with_simulator(Simulator(data))
        if ground is not None and ground_value is not None:
            features = replace(ground.features, value=ground_value)
            ground, predictor = replace(ground, features=features), replace(predictor, ground=features)
        return replace(
            self,
            angles=replace(self.angles, data=data),
            ground=ground,
            scoring=replace(self.scoring, healthy=None),
            predictor=predictor,
        )


def gather(data: Data) -> Evidence:
    """The evidence of prepared runs."""
    simulator = Simulator(data)
    nominal = tuple(p.reading_rad for p in simulator.predict(()))
    floor = noise_floor(data, nominal)
    angles = _angle_evidence(data, simulator, nominal, floor)
    ground = ground_evidence(data, simulator, nominal, floor)
    split = split_of(data)
    return Evidence(
        floor=floor,
        angles=angles,
        ground=ground,
        split=split,
        scoring=_scoring(angles, ground, split),
        predictor=Predictor(simulator, nominal, None if ground is None else ground.features),
    )


def _angle_evidence(
    data: Data, simulator: Simulator, nominal: Sequence[Floats], floor: Floor
) -> AngleEvidence:
    """No servo is quite the first-order lag that the nominal model takes it for, nor quite stiff: that is no gap."""
    blocks = block_map(data)
    known = data.robot.tolerance
    lagging = _with_lag(data, 1 + known.lag_shape)
    tolerance = blocks.mean_square([a - b for a, b in zip(nominal, lagging, strict=True)])
    loads = [simulator.load(i) for i in range(len(data.runs))]
    tolerance += blocks.mean_square(
        [
            np.zeros_like(a) if load is None else known.sag_rad_per_nm * load
            for a, load in zip(nominal, loads, strict=True)
        ]
    )
    return AngleEvidence(data, blocks, np.square(floor.rad)[blocks.joint], tolerance)


def _with_lag(data: Data, factor: float) -> list[Floats]:
    """Nominal readings with the servo's time constant changed."""
    servo = data.robot.servo
    robot = data.robot.model_copy(
        update={"servo": servo.model_copy(update={"time_constant_s": servo.time_constant_s * factor})}
    )
    return [p.reading_rad for p in Simulator(replace(data, robot=robot)).predict(())]


def _scoring(angles: AngleEvidence, ground: GroundEvidence | None, split: Split) -> Scoring:
    blocks, nothing = angles.blocks, np.zeros(0)
    whole_numbers = np.zeros(0, dtype=np.int64)
    features = None if ground is None else ground.features
    run = np.concatenate([blocks.run, whole_numbers if features is None else features.run])
    over_ground = run.size - blocks.count
    kind = np.full(blocks.count, -1, dtype=np.int64)
    held = np.isin(run, split.held_out)
    return Scoring(
        joints=angles.data.joints,
        run=run,
        joint=np.concatenate([blocks.joint, np.full(over_ground, GROUND, dtype=np.int64)]),
        kind=np.concatenate([kind, whole_numbers if features is None else features.kind]),
        samples=np.concatenate([blocks.samples, np.ones(over_ground)]),
        floor_square=np.concatenate(
            [angles.floor_square, nothing if features is None else features.floor_square]
        ),
        allowed_square=np.concatenate(
            [angles.allowed_square, nothing if ground is None else ground.allowed_square]
        ),
        decides=~held if split.free else np.ones(run.size, dtype=bool),
    )
