"""Before anybody records: which effects some gaits would tell apart, which not, and which runs to add.

The nominal robot is simulated on the gaits, as a session of a sound robot would be; then every effect of the library,
at the size of its example, on all joints. What is seized, broken or wired wrong is read off any motion, and left out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats
from snakebot.clock import RATE_HZ
from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import Evidence, gather
from snakebot.diagnosis.evidence.score import ALIKE
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.live import Experiment, numbered, starting_set
from snakebot.diagnosis.options import ProgressCallback
from snakebot.diagnosis.proposal.experiment import channel_told
from snakebot.diagnosis.proposal.foresee import Foreseen, foresee, lead_over, shows
from snakebot.diagnosis.proposal.menu import MenuMotion, menu
from snakebot.diagnosis.proposal.motions import DURATION_S, RAMP_S, known_motions
from snakebot.diagnosis.proposal.separation import SimulatedMotion
from snakebot.diagnosis.search.library import usable_effects
from snakebot.diagnosis.sizes import MOST_TOLD
from snakebot.effects import predict
from snakebot.effects.effect import Effect
from snakebot.effects.spec import parse_effect
from snakebot.errors import BadInputError
from snakebot.gait import Gait, GaitMotion, check_motion
from snakebot.runlog import Run, Session

if TYPE_CHECKING:
    from snakebot.robot import Robot

BETWEEN_RUNS_S = 20.0  # to put the robot back, s; chosen
EffectPair = tuple[str, str]


@dataclass(frozen=True)
class Added:
    """A run to add, and the pairs that it parts."""

    option: MenuMotion
    parts: tuple[EffectPair, ...]


@dataclass(frozen=True)
class Plan:
    """What some runs would tell.

    Attributes:
        experiments: the runs, the first gait once more at the end.
        shown: effects that would show; ``hidden``: those that would not, at the size of their example.
        parted, tied: pairs of ``shown`` that the runs tell apart, or do not.
        added: runs that part more.
        channel: what would part those that no motion does; None where nothing is left.
    """

    experiments: tuple[Experiment, ...]
    shown: tuple[str, ...]
    hidden: tuple[str, ...]
    parted: tuple[EffectPair, ...]
    tied: tuple[EffectPair, ...]
    added: tuple[Added, ...]
    channel: str | None

    @property
    def left(self) -> tuple[EffectPair, ...]:
        """Pairs that are tied with the runs to add, too."""
        gone = {pair for run in self.added for pair in run.parts}
        return tuple(pair for pair in self.tied if pair not in gone)

    @property
    def duration_s(self) -> float:
        """Of all runs, those to add with them, and of putting the robot back."""
        runs = [run.duration_s for run in self.experiments] + [run.option.duration_s for run in self.added]
        return sum(runs) + BETWEEN_RUNS_S * (len(runs) - 1)


@dataclass(frozen=True, eq=False)
class _Tie:
    """Two effects, and each as near to the other as it can come."""

    pair: EffectPair
    one: Foreseen
    near_one: Foreseen  # the other effect
    other: Foreseen
    near_other: Foreseen


def plan(
    robot: Robot,
    gaits: Sequence[Gait] = (),
    *,
    pose: bool = False,
    progress: ProgressCallback = lambda text, share: None,
) -> Plan:
    """Foresee what runs of these gaits, or of the default ones, would tell.

    Args:
        pose: whether a pose is measured.

    Raises:
        BadInputError: a gait breaks the robot's limits, they allow none of the default ones, or the file of the motions
            is not sound.
    """
    known_motions()  # a fault in their file is told by itself, and before anything is simulated
    experiments = _given(robot, gaits) if gaits else _default(robot)
    progress("a sound robot", 0.0)
    evidence = _evidence(robot, experiments, pose)
    motions = [_simulated(evidence, option, pose) for option in _options(robot, experiments)]
    nominal = foresee(motions, Hypothesis(), np.zeros(0))
    effects = []
    library = usable_effects(evidence.data, over_ground=evidence.ground is not None)
    wanted = [e for e in library.effects if not e.is_read_off and not e.fault]
    for index, effect in enumerate(wanted):
        progress(effect.name, 0.05 + 0.4 * index / len(wanted))
        effects.append(foresee(motions, *_at_example(effect, robot)))
    seen = [e for e in effects if shows(motions, e, nominal) >= ALIKE]
    parted: list[EffectPair] = []
    ties: list[_Tie] = []
    for index, (a, b) in enumerate(pairs := list(combinations(seen, 2))):
        progress(f"{a.name} or {b.name}", 0.45 + 0.3 * index / len(pairs))
        lead, near_a = lead_over(motions, a, b)
        back, near_b = lead_over(motions, b, a)
        if min(lead, back) >= ALIKE:
            parted.append((a.name, b.name))
        else:
            ties.append(_Tie((a.name, b.name), a, near_a, b, near_b))
    added = _added(evidence, motions, ties, pose, lambda share: progress("runs to add", 0.75 + 0.25 * share))
    gone = {pair for run in added for pair in run.parts}
    left = [tie for tie in ties if tie.pair not in gone]
    hopeless = list({e.name: e.hypothesis for tie in left for e in (tie.one, tie.other)}.values())
    return Plan(
        experiments=tuple(experiments),
        shown=tuple(e.name for e in seen),
        hidden=tuple(e.name for e in effects if e not in seen),
        parted=tuple(parted),
        tied=tuple(tie.pair for tie in ties),
        added=tuple(added),
        channel=channel_told(hopeless, robot.body is None) if hopeless else None,
    )


def _default(robot: Robot) -> list[Experiment]:
    try:
        return starting_set(robot)
    except BadInputError as error:
        raise BadInputError(f"{str(error).removeprefix('--live: ')}; give your own by --gait") from None


def _given(robot: Robot, gaits: Sequence[Gait]) -> list[Experiment]:
    for gait in gaits:
        check_motion(GaitMotion(gait, robot.joints, DURATION_S, RAMP_S), robot)
    return numbered([*gaits, gaits[0]])


def _options(robot: Robot, experiments: Sequence[Experiment]) -> list[MenuMotion]:
    """Each gait once."""
    gaits = dict.fromkeys(e.motion for e in experiments if isinstance(e.motion, Gait))
    return [
        MenuMotion(gait, None, False, GaitMotion(gait, robot.joints, DURATION_S, RAMP_S)) for gait in gaits
    ]


def _evidence(robot: Robot, experiments: Sequence[Experiment], pose: bool) -> Evidence:
    """Of a robot without any gap, read by its own encoders."""
    rng, runs = np.random.default_rng(0), []
    t = np.arange(int(DURATION_S * RATE_HZ)) / RATE_HZ
    for index, experiment in enumerate(experiments):
        assert isinstance(experiment.motion, Gait)
        motion = GaitMotion(experiment.motion, robot.joints, DURATION_S, RAMP_S)
        command = motion.sampled(t)
        made = predict(robot, (), t, command, body=pose and robot.body is not None, quantise=False)
        reading = made.encoder_rad + np.sqrt(made.variance_rad2) * rng.normal(size=command.shape)
        where = None
        if made.motion is not None:
            where = np.column_stack([made.motion.com_m, made.motion.heading_rad])
            noise = robot.tolerance
            where += rng.normal(size=where.shape) * (noise.pose_m, noise.pose_m, noise.heading_rad)
        first = experiment.motion == experiments[0].motion and index > 0
        runs.append(
            Run(f"{index}", t, command, reading, pose=where, gait=experiment.motion, repeat_of="0" if first else None)
        )  # fmt: skip
    return gather(prepare(Session(robot, tuple(runs))))


def _simulated(evidence: Evidence, option: MenuMotion, pose: bool) -> SimulatedMotion:
    return SimulatedMotion(evidence, option, over_ground=pose)


def _at_example(effect: Effect, robot: Robot) -> tuple[Hypothesis, Floats]:
    """The effect on all joints, at the size of its example."""
    values = parse_effect(effect.example).values
    fixed = []
    for parameter in effect.parameters:
        value = values.get(parameter.name)
        if parameter.integer and isinstance(value, float):
            most = robot.body.links if robot.body is not None and parameter.name == "link" else value
            fixed.append((parameter.name, min(value, float(most))))
    term = Term(effect.name, None, tuple(fixed))
    theta = []
    for parameter in term.open:
        value = values.get(parameter.name, parameter.default)
        theta.append(parameter.typical if value is None or isinstance(value, tuple) else value)
    return Hypothesis((term,)), np.array(theta, dtype=np.float64)


def _added(
    evidence: Evidence,
    motions: Sequence[SimulatedMotion],
    ties: Sequence[_Tie],
    pose: bool,
    progress: Callable[[float], None],
) -> list[Added]:
    """Motions of the menu that part what is tied: each time the one that parts most."""
    if not ties:
        return []
    robot = evidence.data.robot
    loads = any(
        evidence.predictor.simulator.stages(e.specs).feels_load for tie in ties for e in (tie.one, tie.other)
    )
    run = {str(motion.option) for motion in motions}
    options = [o for o in menu(robot, range(1, robot.joints + 1), loads=loads) if str(o) not in run]
    parts: list[tuple[MenuMotion, frozenset[EffectPair]]] = []
    for index, option in enumerate(options):
        progress(index / len(options))
        new = _simulated(evidence, option, pose)
        parts.append((option, frozenset(t.pair for t in ties if _parts(motions, new, t))))
    out: list[Added] = []
    gone: frozenset[EffectPair] = frozenset()
    for _ in range(MOST_TOLD if parts else 0):
        option, pairs = max(parts, key=lambda p: (len(p[1] - gone), -p[0].lifted, -p[0].duration_s))
        if not pairs - gone:
            break
        out.append(Added(option, tuple(t.pair for t in ties if t.pair in pairs - gone)))
        gone |= pairs
    return out


def _parts(motions: Sequence[SimulatedMotion], new: SimulatedMotion, tie: _Tie) -> bool:
    """Whether one more motion tells two effects apart, whichever of them is there."""
    every = [*motions, new]
    for truth, near in ((tie.one, tie.near_one), (tie.other, tie.near_other)):
        shown = foresee([new], truth.hypothesis, truth.theta, turns=False)
        alone = foresee([new], near.hypothesis, near.theta, turns=False)
        if shows([new], shown, alone) < ALIKE:
            return False  # not even at these values
        longer = Foreseen(
            truth.hypothesis, truth.theta, truth.angle + shown.angle, truth.ground + shown.ground
        )
        lead, _ = lead_over(every, longer, near.joined(foresee([new], near.hypothesis, near.theta)))
        if lead < ALIKE:
            return False
    return True
