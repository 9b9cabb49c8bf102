"""``snakebot diagnose --live``: run gaits, diagnose, run what is proposed, until one cause stands or nothing helps.

Every motion is a plain ``snakebot run``: its limits, its safe end, its log. Nothing moves without a yes, nor after an
emergency stop, in a run or between two. Whatever ends it early, the logs of the runs that were made are whole, and
``snakebot diagnose FOLDER`` takes them.
"""

from __future__ import annotations

import contextlib
import io
import json
import shlex
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from snakebot.cli.ports import SIM
from snakebot.errors import BadInputError, BoardFaultError

if TYPE_CHECKING:
    from snakebot.diagnosis import Diagnosis
    from snakebot.robot import Robot

Gait = tuple[float, float, float]  # alpha deg, beta deg, omega rad/s

# Fast and slow, wide and small; the first one again at the end, for the noise floor.
START: tuple[Gait, ...] = ((50, 80, 2.0), (30, 80, 4.0), (30, 80, 1.0), (4, 80, 0.5))
DURATION_S, RAMP_S = 12.0, 2.0
SURE = 0.85  # one cause stands, and nothing ties with it
_SMALLER = 0.8  # a gait beyond the robot's limits is tried with so much of its amplitude
_TIMES = 12


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

    @property
    def simulated(self) -> bool:
        """The board is in this process: its randomness has a seed, and there is nothing to lift by hand."""
        return self.port == SIM


def live(
    plan: Live, robot: Robot, diagnose_folder: Callable[[Path], Diagnosis], say: Callable[[str], None]
) -> Diagnosis:
    """Run and diagnose by turns; the last verdict.

    Raises:
        BadInputError: the folder holds something already, the budget is too small, the robot's limits allow no gait, or
            the user said no too early.
        BoardFaultError: an emergency stop, in a run or between two.
        SnakebotError: a run failed; see ``snakebot run``.
    """
    gaits = starting_set(robot)
    if plan.budget < len(gaits):
        raise BadInputError(f"--budget {plan.budget}: the starting set needs {len(gaits)} runs")
    if plan.folder.exists() and (not plan.folder.is_dir() or any(plan.folder.iterdir())):
        raise BadInputError(f"{plan.folder}: holds something already; give a new folder for the logs")
    plan.folder.mkdir(parents=True, exist_ok=True)
    with _told_what_is_left(plan.folder, say), _stoppable(plan.port):
        return _by_turns(plan, gaits, diagnose_folder, say)


def _by_turns(
    plan: Live,
    gaits: Sequence[Gait],
    diagnose_folder: Callable[[Path], Diagnosis],
    say: Callable[[str], None],
) -> Diagnosis:
    done = 0
    for number, (alpha, beta, omega) in enumerate(gaits, 1):
        wave = ["--alpha", f"{alpha:g}", "--beta", f"{beta:g}", "--omega", f"{omega:g}"]
        arguments = [*wave, "--duration", f"{DURATION_S:g}", "--ramp", f"{RAMP_S:g}"]
        if not _run(plan, arguments, f"run {number} of {len(gaits)} of the starting set", done, say):
            break
        done += 1
    if done < 2:
        raise BadInputError("--live: fewer than two runs were made: nothing to diagnose")
    found = diagnose_folder(plan.folder)
    if done < len(gaits):
        return found  # who said no once is not asked again
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
        elif done >= plan.budget:
            say(f"{so_far}. The budget of {plan.budget} runs is used up; next would be: {proposal.command}")
        else:
            say(f"{so_far}. {proposal.reason[:1].upper()}{proposal.reason[1:]}.")
            tried.add(proposal.command)
            arguments = shlex.split(proposal.command)[2:]
            if plan.yes and not plan.simulated and "--lifted" in arguments:
                say(f"The robot would have to be lifted off the ground first: {proposal.command}")
            elif _run(plan, arguments, "the proposed experiment", done, say):
                done += 1
                found = diagnose_folder(plan.folder)
                continue
        return found


def starting_set(robot: Robot) -> list[Gait]:
    """The gaits to begin with, as wide as the robot's limits allow, the first one again at the end.

    Raises:
        BadInputError: the limits allow none of them.
    """
    fitted = [gait for gait in (_fitted(robot, wanted) for wanted in START) if gait is not None]
    if not fitted:
        raise BadInputError(
            f"--live: the limits of robot {robot.name!r} allow none of the gaits of the starting set"
        )
    return [*fitted, fitted[0]]


def _fitted(robot: Robot, wanted: Gait) -> Gait | None:
    """The gait with as much of its amplitude as is safe; None where hardly any is."""
    from snakebot.gait import Gait as Wave
    from snakebot.gait import GaitMotion, check_motion

    alpha, beta, omega = wanted
    for _ in range(_TIMES):
        try:
            wave = Wave.from_degrees(alpha, beta, omega, 0.0)
            check_motion(GaitMotion(wave, robot.joints, DURATION_S, RAMP_S), robot)
        except BadInputError:
            alpha = round(alpha * _SMALLER, 2)
            continue
        return alpha, beta, omega
    return None


def _stands(found: Diagnosis) -> bool:
    """Whether there is no gap, or every cause is sure, ties with no other, and explains what there is."""
    return found.verdict == "no_gap" or (
        found.verdict == "explained"
        and bool(found.causes)
        and all(c.probability >= SURE and not c.indistinguishable_from for c in found.causes)
    )


def _run(plan: Live, arguments: Sequence[str], what: str, done: int, say: Callable[[str], None]) -> bool:
    """One ``snakebot run``; False where the user does not want it."""
    from snakebot.cli.run import command

    shown = "snakebot run " + shlex.join(arguments)
    lifted = " off the ground: lift it first" if "--lifted" in arguments and not plan.simulated else ""
    if not plan.yes and not click.confirm(
        f"{what}: {shown}\nThe robot on {plan.port} will move{lifted}. Go on?", default=False, err=True
    ):
        return False
    log = plan.folder / f"live_{done + 1:02d}.mcap"
    full = [*arguments, "--port", plan.port, "--log", str(log), "--yes", "--json", *plan.passed]
    if plan.simulated:  # or its noise would be the same in each run, and repeats would show none
        full += ["--seed", str(done)]
    if done:  # a stop between two runs is meant for all that would follow
        full.append("--keep-stop")
    heard = io.StringIO()  # standard output is for the verdict
    with contextlib.redirect_stdout(heard):
        command.main(full, standalone_mode=False)
    ended = json.loads(heard.getvalue().splitlines()[-1])
    if ended["ended"] == "finished":
        how = f"{ended['ticks']} ticks, {ended['lost']} without an answer, {ended['clamped']} clamped"
    else:
        how = f"ended early: {ended['ended']}"
    say(f"{what}: {shown}: {how}")
    return True


@contextlib.contextmanager
def _stoppable(port: str) -> Iterator[None]:
    """``snakebot stop`` finds us between two runs too, and then none follows; in a run, the run obeys it."""
    from snakebot.control import registry

    def stop(*_: object) -> None:
        raise BoardFaultError(f"{port}: emergency stop: no further run is made")

    with registry.registered(port):
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = signal.signal(registry.STOP_SIGNAL, stop)
        try:
            yield
        finally:
            signal.signal(registry.STOP_SIGNAL, before)


@contextlib.contextmanager
def _told_what_is_left(folder: Path, say: Callable[[str], None]) -> Iterator[None]:
    """Where it does not come to a verdict, say which runs there are."""
    try:
        yield
    except BaseException:
        logs = len(list(folder.glob("*.mcap")))
        if logs:
            say(
                f"{folder} holds {logs} log{'s' if logs > 1 else ''}: snakebot diagnose {folder} takes what is there"
            )
        raise
