"""``snakebot diagnose --live``: run gaits, diagnose, run what is proposed, until one cause stands or nothing helps.

Every motion is a plain ``snakebot run``: its limits, its safe end, its log. Nothing moves without a yes.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from snakebot.cli.ports import SIM
from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.diagnosis import Diagnosis
    from snakebot.robot import Robot

# Fast and slow, wide and small: one of them twice, for the noise floor. (alpha deg, beta deg, omega rad/s)
START = ((50, 80, 2.0), (30, 80, 4.0), (30, 80, 1.0), (4, 80, 0.5), (50, 80, 2.0))
DURATION_S, RAMP_S = 12.0, 2.0
SURE = 0.85  # one cause stands, and nothing ties with it


@dataclass(frozen=True)
class Live:
    """How to run.

    Attributes:
        port: as for ``snakebot run``.
        folder: where the logs go; new.
        budget: most runs in all.
        yes: do not ask before each motion.
        passed: further arguments for ``snakebot run`` (robot, effects of a simulated board).
    """

    port: str
    folder: Path
    budget: int
    yes: bool
    passed: tuple[str, ...] = ()


def live(
    plan: Live, robot: Robot, diagnose_folder: Callable[[Path], Diagnosis], say: Callable[[str], None]
) -> Diagnosis:
    """Run and diagnose by turns; the last verdict.

    Raises:
        BadInputError: the folder holds something already, the budget is too small, or the user said no too early.
    """
    gaits = [gait for gait in START if _is_safe(robot, gait)]
    if plan.budget < len(gaits):
        raise BadInputError(f"--budget {plan.budget}: the starting set needs {len(gaits)} runs")
    if plan.folder.exists() and any(plan.folder.iterdir()):
        raise BadInputError(f"{plan.folder}: holds something already; give a new folder for the logs")
    plan.folder.mkdir(parents=True, exist_ok=True)
    done = 0
    for number, (alpha, beta, omega) in enumerate(gaits):
        wave = ["--alpha", f"{alpha:g}", "--beta", f"{beta:g}", "--omega", f"{omega:g}"]
        arguments = [*wave, "--duration", f"{DURATION_S:g}", "--ramp", f"{RAMP_S:g}"]
        if not _run(plan, arguments, f"run {number + 1} of {len(gaits)} of the starting set"):
            break
        done += 1
    if done < 2:
        raise BadInputError("--live: fewer than two runs were made: nothing to diagnose")
    found = diagnose_folder(plan.folder)
    tried: set[str] = set()
    while done < plan.budget:
        proposal = found.next_experiment
        if proposal is None or proposal.command in tried or _stands(found):
            break
        say(f"After {done} runs: {found.verdict}. {proposal.reason}.")
        tried.add(proposal.command)
        if proposal.lifted and plan.yes and plan.port != SIM:
            say(
                "The proposed experiment needs somebody who lifts the robot off the ground: run without --yes."
            )
            break
        air = ", with the robot lifted off the ground" if proposal.lifted else ""
        if not _run(plan, shlex.split(proposal.command)[2:], f"the proposed experiment{air}"):
            break
        done += 1
        found = diagnose_folder(plan.folder)
    return found


def _stands(found: Diagnosis) -> bool:
    """Whether every cause is sure and ties with no other."""
    return found.verdict == "no_gap" or (
        bool(found.causes)
        and all(c.probability >= SURE and not c.indistinguishable_from for c in found.causes)
    )


def _is_safe(robot: Robot, gait: tuple[float, float, float]) -> bool:
    from snakebot.gait import Gait, GaitMotion, check_motion

    alpha, beta, omega = gait
    try:
        wave = Gait.from_degrees(alpha, beta, omega, 0.0)
        check_motion(GaitMotion(wave, robot.joints, DURATION_S, RAMP_S), robot)
    except BadInputError:
        return False
    return True


def _run(plan: Live, arguments: Sequence[str], what: str) -> bool:
    """One ``snakebot run``; False where the user does not want it."""
    from snakebot.cli.run import command

    shown = "snakebot run " + shlex.join(arguments)
    if not plan.yes and not click.confirm(
        f"{what}: {shown}\nThe robot will move. Go on?", default=False, err=True
    ):
        return False
    log = plan.folder / f"live_{len(list(plan.folder.glob('*.mcap'))) + 1:02d}.mcap"
    full = [*arguments, "--port", plan.port, "--log", str(log), "--yes", "--json", *plan.passed]
    command.main(full, standalone_mode=False)
    return True
