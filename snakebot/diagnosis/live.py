"""Experiments by turns: run a starting set, diagnose, run what is proposed, until one cause is left or nothing helps.

Nothing here moves a robot: whoever calls ``experiments`` says how a motion is run, and may ask a person first.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import degrees
from typing import TYPE_CHECKING

from snakebot.diagnosis.proposal.motions import DURATION_S, RAMP_S, WrittenGait, known_motions
from snakebot.diagnosis.sizes import LITTLE, NEARLY_ALL, SOME, SURE
from snakebot.errors import BadInputError
from snakebot.gait import Gait, GaitMotion, Probe, check_motion, parse_probe

if TYPE_CHECKING:
    from snakebot.diagnosis.result import Diagnosis, NextExperiment
    from snakebot.robot import Robot

_SMALLER = NEARLY_ALL  # a gait beyond the robot's limits is tried with so much of its amplitude


@dataclass(frozen=True)
class Experiment:
    """A motion to be run.

    Attributes:
        motion: a gait or a probe.
        duration_s: with its ramps.
        ramp_s: smooth start and end, each.
        lifted: off the ground.
        what: which one it is, in words.
        command: the command that makes the same run; only the port is missing.
    """

    motion: Gait | Probe
    duration_s: float
    ramp_s: float
    lifted: bool
    what: str
    command: str


def experiments(
    robot: Robot,
    run: Callable[[Experiment], bool],
    diagnose: Callable[[], Diagnosis],
    *,
    budget: int | None = None,
    can_lift: bool = True,
    say: Callable[[str], None] = lambda text: None,
) -> Diagnosis:
    """Run and diagnose by turns; the last verdict.

    Args:
        run: makes a run and keeps it for ``diagnose``; False where it is not wanted. What it raises ends everything.
        diagnose: the verdict on all runs so far.
        budget: most runs in all; None: the starting set, and some more to separate what is left.
        can_lift: whether the robot can be lifted off the ground for a run.
        say: is told how it goes, a line at a time.

    Raises:
        BadInputError: the budget is too small, the robot's limits allow no gait, or fewer than two runs were made.
    """
    from snakebot.robot import robot_option

    which = robot_option(robot)
    start = starting_set(robot, budget)
    most = len(start) + SOME if budget is None else budget
    done = 0
    for experiment in start:
        if not run(experiment):
            break
        done += 1
    if done < 2:
        raise BadInputError("--live: fewer than two runs were made: nothing to diagnose")
    found = diagnose()
    if done < len(start):
        return found  # a run was refused: no further one is asked for
    tried: set[str] = set()
    while True:
        so_far = f"After {done} runs: {found.verdict.replace('_', ' ')}"
        proposal = found.next_experiment
        if _stands(found):
            say(f"{so_far}. Nothing is left to tell apart.")
        elif proposal is None:
            say(f"{so_far}. No further motion is known to help.")
        elif proposal.command in tried:
            say(f"{so_far}. The same motion is proposed again: it has told what it can.")
        elif done >= most:
            say(f"{so_far}. The budget of {most} runs is used up; next would be: {proposal.command}{which}")
        else:
            say(f"{so_far}. {proposal.reason[:1].upper()}{proposal.reason[1:]}.")
            tried.add(proposal.command)
            if proposal.lifted and not can_lift:
                say(f"The robot would have to be lifted off the ground first: {proposal.command}{which}")
            elif run(proposed(proposal)):
                done += 1
                found = diagnose()
                continue
        return found


def proposed(proposal: NextExperiment) -> Experiment:
    """The experiment that a verdict proposes."""
    if proposal.probe is not None:
        motion: Gait | Probe = parse_probe(proposal.probe)
    else:
        assert proposal.gait is not None, "a proposal is a gait or a probe"
        wave = proposal.gait
        motion = Gait.from_degrees(wave.alpha_deg, wave.beta_deg, wave.omega_rad_s, wave.offset_deg)
    return Experiment(
        motion,
        proposal.duration_s,
        proposal.ramp_s,
        proposal.lifted,
        "the proposed experiment",
        proposal.command,
    )


def starting_set(robot: Robot, budget: int | None = None) -> list[Experiment]:
    """The gaits to begin with, as wide as the robot's limits allow, the first one again at the end.

    Raises:
        BadInputError: the limits allow none of them, they are more than ``budget``, or the file of the motions is not
            sound.
    """
    fitted = [
        gait for gait in (_fitted(robot, wanted) for wanted in known_motions().start) if gait is not None
    ]
    if not fitted:
        raise BadInputError(
            f"--live: the limits of robot {robot.name!r} allow none of the gaits of the starting set"
        )
    if budget is not None and budget <= len(fitted):
        raise BadInputError(f"--budget {budget}: the starting set needs {len(fitted) + 1} runs")
    return numbered([*fitted, fitted[0]])


def numbered(gaits: Sequence[Gait]) -> list[Experiment]:
    return [
        Experiment(
            gait,
            DURATION_S,
            RAMP_S,
            False,
            f"run {number} of {len(gaits)} of the starting set",
            f"snakebot run --alpha {degrees(gait.alpha_rad):g} --beta {degrees(gait.beta_rad):g} "
            f"--omega {gait.omega_rad_s:g}{f' --offset {degrees(gait.offset_rad):g}' if gait.offset_rad else ''} "
            f"--duration {DURATION_S:g} --ramp {RAMP_S:g}",
        )
        for number, gait in enumerate(gaits, 1)
    ]


def _fitted(robot: Robot, wanted: WrittenGait) -> Gait | None:
    """The gait with as much of its amplitude as is safe; None where hardly any is."""
    least_deg = LITTLE * wanted.alpha_deg
    while wanted.alpha_deg > least_deg:
        try:
            check_motion(GaitMotion(wanted.gait, robot.joints, DURATION_S, RAMP_S), robot)
        except BadInputError:
            wanted = replace(wanted, alpha_deg=round(wanted.alpha_deg * _SMALLER, 2))
            continue
        return wanted.gait
    return None


def _stands(found: Diagnosis) -> bool:
    """Whether there is no gap, or every cause is sure, ties with no other, and explains what there is."""
    return found.verdict == "no_gap" or (
        found.verdict == "explained"
        and bool(found.causes)
        and all(c.probability >= SURE and not c.indistinguishable_from for c in found.causes)
    )
