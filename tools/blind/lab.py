"""The lab that owns the sealed robots: it runs the motion that a diagnosis proposes, or one drawn at random."""

from __future__ import annotations

import argparse
import shlex
from dataclasses import dataclass, field

import numpy as np

from blind.cases import Case, ticks
from blind.chain import LINK_ROWS
from blind.robot import JOINTS, Parameters, Recording, Robot
from snakebot.errors import BadInputError
from snakebot.gait import Gait, GaitMotion, Motion, ProbeMotion, check_motion, parse_probe
from snakebot.robot import load_robot

DURATION_S, RAMP_S = 10.0, 2.0


@dataclass(frozen=True)
class Experiment:
    """A motion to be run: ``gait`` as session.yaml writes it, or ``probe`` as written after ``--probe``."""

    motion: Motion
    gait: dict[str, float] | None
    probe: str | None = None
    lifted: bool = False


def proposed(command: str, joints: int = JOINTS) -> Experiment:
    """What ``snakebot run ...`` in a proposal asks for.

    Raises:
        ValueError: an option that this lab does not know.
    """
    parser = argparse.ArgumentParser(add_help=False, exit_on_error=False)
    for name in ("--alpha", "--beta", "--omega", "--offset", "--duration", "--ramp"):
        parser.add_argument(name, type=float, default=0.0 if name == "--offset" else None)
    parser.add_argument("--probe")
    parser.add_argument("--lifted", action="store_true")
    try:
        asked, rest = parser.parse_known_args(shlex.split(command))
    except argparse.ArgumentError as error:
        raise ValueError(f"{command}: {error}") from None
    if rest != ["snakebot", "run"] or (
        asked.probe is None and None in (asked.alpha, asked.beta, asked.omega)
    ):
        raise ValueError(f"{command}: not understood by the lab")
    duration = DURATION_S if asked.duration is None else asked.duration
    ramp = RAMP_S if asked.ramp is None else asked.ramp
    if asked.probe is not None:
        motion: Motion = ProbeMotion(parse_probe(asked.probe), joints, duration, ramp)
        return Experiment(motion, None, asked.probe, asked.lifted)
    gait = Gait.from_degrees(asked.alpha, asked.beta, asked.omega, asked.offset)
    return Experiment(GaitMotion(gait, joints, duration, ramp), _words(gait), None, asked.lifted)


def at_random(rng: np.random.Generator, joints: int = JOINTS) -> Experiment:
    """A safe gait drawn evenly from what a user may ask for: the control."""
    robot = load_robot("penn_state").model_copy(update={"joints": joints})
    while True:
        gait = Gait.from_degrees(
            rng.uniform(2, 80), rng.uniform(40, 120), float(np.exp(rng.uniform(np.log(0.5), np.log(6.0)))),
            rng.uniform(-15, 15),
        )  # fmt: skip
        motion = GaitMotion(gait, joints, DURATION_S, RAMP_S)
        try:
            check_motion(motion, robot)
        except BadInputError:
            continue
        return Experiment(motion, _words(gait))


def _words(gait: Gait) -> dict[str, float]:
    return {
        "alpha_deg": float(np.degrees(gait.alpha_rad)),
        "beta_deg": float(np.degrees(gait.beta_rad)),
        "omega_rad_s": gait.omega_rad_s,
        "offset_deg": float(np.degrees(gait.offset_rad)),
    }


@dataclass
class Lab:
    """One sealed robot. Its noise goes on where the runs of the session have ended."""

    case: Case
    _robots: dict[bool, Robot] = field(default_factory=dict, repr=False)

    def perform(self, experiment: Experiment, rng: np.random.Generator) -> Recording:
        lifted = experiment.lifted
        if lifted not in self._robots:
            self._robots[lifted] = Robot(
                off_the_ground(self.case.parameters) if lifted else self.case.parameters
            )
        t = ticks(self.case.build, experiment.motion.duration_s)
        return self._robots[lifted].run(t, experiment.motion.sampled(t), rng)


def off_the_ground(parameters: Parameters) -> Parameters:
    """Nothing rubs, and nothing rolls down a slope. The links keep their weight: they still swing each other."""
    free = parameters.copy()
    for row in ("ct", "cn", "ct0", "cn0"):
        free.links[LINK_ROWS.index(row)] = 0.0
    free.ground[:2] = 0.0
    return free
