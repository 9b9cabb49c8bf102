"""``snakebot diagnose --live``: run gaits, diagnose, run what is proposed, until one cause stands or nothing helps.

Every motion is made as ``snakebot run`` makes it: its limits, its safe end, its log. Nothing moves without a yes, nor
after an emergency stop, in a run or between two. Whatever ends it early, the logs of the runs that were made are whole,
and ``snakebot diagnose FOLDER`` takes them.
"""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from snakebot.cli.live_story import Story
from snakebot.cli.ports import SIM
from snakebot.cli.run_options import RunOptions
from snakebot.clock import RATE_HZ
from snakebot.errors import EXIT_INTERRUPTED, BadInputError, BoardFaultError

if TYPE_CHECKING:
    from snakebot.diagnosis import Diagnosis
    from snakebot.diagnosis.live import Experiment
    from snakebot.robot import Robot


@dataclass(frozen=True)
class Live:
    """How to run.

    Attributes:
        folder: where the logs go; new.
        budget: most runs in all.
        options: of every run; ``yes``: do not ask before each motion.
    """

    folder: Path
    budget: int
    options: RunOptions

    @property
    def simulated(self) -> bool:
        """The board is in this process: its randomness has a seed, and there is nothing to lift by hand."""
        return self.options.port == SIM


def live(
    plan: Live,
    robot: Robot,
    diagnose_folder: Callable[[Path], Diagnosis],
    say: Callable[[str], None],
    story: Story | None = None,
) -> Diagnosis:
    """Run and diagnose by turns; the last verdict. ``story`` is told what has become of it so far.

    Raises:
        BadInputError: the folder holds something already, the budget is too small, the robot's limits allow no gait, or
            the user said no too early.
        BoardFaultError: an emergency stop, in a run or between two.
        SnakebotError: a run failed; see ``snakebot run``.
    """
    from snakebot.diagnosis.live import experiments

    check_plan(plan, robot)
    plan.folder.mkdir(parents=True, exist_ok=True)
    story = story or Story(None)
    done = 0

    def run(experiment: Experiment) -> bool:
        nonlocal done
        story.check(plan.options.port)
        made = run_one(plan, robot, experiment, done, say, story)
        done += made
        return made

    with told_what_is_left(plan.folder, say), stoppable(plan.options.port):
        found = experiments(
            robot,
            run,
            lambda: story.verdict(diagnose_folder(plan.folder)),
            budget=plan.budget,
            can_lift=plan.simulated or not plan.options.yes,
            say=say,
        )
        story.check(plan.options.port)  # whatever a page asked for, and when, is not followed by a verdict
        return found


def run_one(
    plan: Live, robot: Robot, experiment: Experiment, done: int, say: Callable[[str], None], story: Story
) -> bool:
    """One run; False where the user does not want it."""
    from snakebot.cli.execution import execute
    from snakebot.cli.summary import tell_warnings
    from snakebot.control import plan_run

    shown = f"{experiment.what}: {experiment.command}"
    lifted = " off the ground: lift it first" if experiment.lifted and not plan.simulated else ""
    if not plan.options.yes and not click.confirm(
        f"{shown}\nThe robot on {plan.options.port} will move{lifted}. Go on?", default=False, err=True
    ):
        return False
    motion = plan_run(
        experiment.motion,
        robot.joints,
        duration_s=experiment.duration_s,
        ramp_s=experiment.ramp_s,
        lifted=experiment.lifted,
    )
    options = replace(
        plan.options,
        log_path=plan.folder / f"live_{done + 1:02d}.mcap",
        yes=True,
        as_json=True,  # standard output is for the verdict: no panel
        # The noise of a simulated board would be the same in each run, and repeats would show none.
        seed=done if plan.simulated else plan.options.seed,
        keep_stop=done > 0,  # a stop between two runs is meant for all that would follow
    )
    story.check(options.port)
    story.begins(experiment.what)
    recorded = execute(robot, motion, options.settings(robot, RATE_HZ), options, story.page)
    tell_warnings(recorded)
    progress = recorded.progress
    if recorded.ended == "interrupted" or recorded.asked_late:
        early = recorded.ended == "interrupted"
        say(f"{shown}: " + ("ended early: interrupted" if early else "finished; no further run is made"))
        sys.exit(EXIT_INTERRUPTED)
    how = f"{progress.ticks} ticks, {progress.lost} without an answer, {progress.clamped} clamped"
    say(f"{shown}: {how}")
    story.ran(experiment.command, how)
    return True


def _stopped(port: str) -> BoardFaultError:
    return BoardFaultError(f"{port}: emergency stop: no further run is made")


@contextlib.contextmanager
def stoppable(port: str) -> Iterator[None]:
    """``snakebot stop`` finds us between two runs too, and then none follows; in a run, the run obeys it."""
    import threading

    from snakebot.control import registry
    from snakebot.control.attending import signals_handled

    def stop(*_: object) -> None:
        raise _stopped(port)

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    # The signal that a reader of the registration may send must have its handler by then.
    with signals_handled({registry.STOP_SIGNAL: stop}), registry.registered(port):
        yield


@contextlib.contextmanager
def told_what_is_left(folder: Path, say: Callable[[str], None]) -> Iterator[None]:
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


def check_plan(plan: Live, robot: Robot) -> None:
    """What is refused before there is a folder, and before anybody asks the board.

    Raises:
        BadInputError: the folder holds something already, the budget is too small, or the robot's limits allow no gait.
    """
    from snakebot.diagnosis.live import starting_set

    starting_set(robot, plan.budget)
    if plan.folder.exists() and (not plan.folder.is_dir() or any(plan.folder.iterdir())):
        raise BadInputError(f"{plan.folder}: holds something already; give a new folder for the logs")


def check_runs(options: RunOptions, robot: Robot) -> None:
    """What any run with these options would end with, before anything is chosen, asked or made for them.

    The board is asked who it is, and let go.

    Raises:
        BadInputError: the port does not fit, nobody is there to say yes, or the board is not this robot's.
        NoBoardError: the port cannot be opened, or nobody answers on it.
        BoardFaultError: a servo reports an error, or stands beyond its joint's limit.
    """
    from snakebot.control import open_board
    from snakebot.control.ports import check_port

    check_port(options.port, robot, options.effects, virtual=options.fast)
    confirmable(options)
    with open_board(
        options.port, robot, effects=options.effects, virtual=options.fast, tell=lambda line: None
    ):
        pass


def confirmable(options: RunOptions) -> None:
    """
    Raises:
        BadInputError: somebody has to say yes, and nobody is there.
    """
    if not options.yes and not sys.stdin.isatty():
        raise BadInputError(
            f"{options.port}: there is nobody to ask before each motion: add --yes if it may move"
        )
