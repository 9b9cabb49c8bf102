"""``snakebot optimize --live``: diagnose the robot, choose with and without what was found, run both, say if it paid.

Every motion is made, asked for and stopped as ``diagnose --live`` makes its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from snakebot.cli.diagnose_live import Live, live, run_one, stoppable, told_what_is_left
from snakebot.cli.live_story import Story
from snakebot.cli.optimize_show import beyond_words
from snakebot.cli.study_output import table_text
from snakebot.errors import BadInputError
from snakebot.whole_files import write_all

if TYPE_CHECKING:
    from snakebot.cli.run_options import RunOptions
    from snakebot.diagnosis import Diagnosis
    from snakebot.gait import Gait
    from snakebot.optimise.goal import Goal
    from snakebot.optimise.optimum import Optimum
    from snakebot.optimise.promise import OptimiseOptions, Promise
    from snakebot.optimise.proof import Measured, Proof
    from snakebot.robot import Robot
    from snakebot.runlog import Session

CYCLES = 6  # of a run that counts, between its ramps; chosen


@dataclass(frozen=True)
class Undertaking:
    """What is to be done.

    Attributes:
        folder: new; the logs of the diagnosis and of the gaits go into folders of it.
        budget: most runs of the diagnosis.
        repeats: runs of each of the two choices.
    """

    folder: Path
    goal: Goal
    options: OptimiseOptions
    run_options: RunOptions
    budget: int
    repeats: int


def optimize_live(asked: Undertaking, robot: Robot, say: Callable[[str], None]) -> tuple[Optimum, Proof]:
    """The choice on the calibrated description, and what both choices did on the robot.

    Raises:
        BadInputError: the goal cannot be reached, or the user said no too early.
        BoardFaultError: an emergency stop, in a run or between two.
        SnakebotError: a run failed; see ``snakebot run``.
    """
    from snakebot.calibrated.recorded import reached
    from snakebot.diagnosis.show.apply import calibrated
    from snakebot.optimise.optimum import optimise
    from snakebot.optimise.proof import neighbours, prove

    say("Choosing on the description as it is.")
    nominal = optimise(
        robot, asked.goal, asked.options
    )  # what cannot be reached is refused before anything moves
    found = live(Live(asked.folder / "diagnosis", asked.budget, asked.run_options), robot, _diagnosed, say)
    runs = _session(asked.folder / "diagnosis").runs
    try:
        known = calibrated(robot, found, runs)
        path = asked.folder / "calibrated.yaml"
        write_all([(path, known.to_yaml())])
        say(f"wrote {path}")
    except BadInputError:
        known = robot.model_copy(update={"recorded": reached(robot, runs)})
        say(f"The verdict is {found.verdict.replace('_', ' ')}: the description stays as it is.")
    say("Choosing on the calibrated description.")
    chosen = optimise(known, asked.goal, asked.options)
    for line in beyond_words(chosen.found):
        say(line)
    around = neighbours(known, chosen.found, asked.options)
    plain = _on(known, nominal.found, asked.options)
    plan = Live(asked.folder / "gaits", asked.budget, asked.run_options)
    plan.folder.mkdir(parents=True, exist_ok=True)
    with told_what_is_left(plan.folder, say), stoppable(plan.options.port):
        proof = prove(
            asked.goal, plain, chosen.found, around, _Runner(plan, robot, say), repeats=asked.repeats
        )
    return chosen, proof


def _diagnosed(folder: Path) -> Diagnosis:
    from snakebot.diagnosis import diagnose

    return diagnose(_session(folder))


def _session(folder: Path) -> Session:
    from dataclasses import replace

    from snakebot.runlog import open_session
    from snakebot.runlog.repeats import mark_repeats

    session = open_session(folder)
    return replace(session, runs=mark_repeats(session.runs))


def _on(robot: Robot, promise: Promise, options: OptimiseOptions) -> Promise:
    """The same gait, with what the calibrated description promises of it."""
    from snakebot.optimise.promise import promises

    return promises(robot, [("without calibration", promise.row)], options)[0]


class _Runner:
    """Runs a gait after a yes; its speed and power. ``robot``: as it was described, without what was found."""

    def __init__(self, plan: Live, robot: Robot, say: Callable[[str], None]) -> None:
        self._plan, self._robot, self._say, self._done = plan, robot, say, 0

    def __call__(self, gait: Gait, what: str) -> tuple[float, float] | None:
        from snakebot.analysis import analyze_run, load_one
        from snakebot.control.plans import RAMP_S
        from snakebot.diagnosis.live import Experiment

        duration_s = round(CYCLES * gait.period_s + 2 * RAMP_S, 2)
        words = (
            f"snakebot run --alpha {math.degrees(gait.alpha_rad):.2f} --beta {math.degrees(gait.beta_rad):.2f} "
            f"--omega {gait.omega_rad_s:.4f}{gait.shares_option} --duration {duration_s:g}"
        )
        experiment = Experiment(gait, duration_s, RAMP_S, False, what, words)
        if not run_one(self._plan, self._robot, experiment, self._done, self._say, Story(None)):
            return None
        self._done += 1
        run = load_one(self._plan.folder / f"live_{self._done:02d}.mcap").run
        analysis = analyze_run(run, self._robot)
        if not math.isfinite(analysis.speed_m_s):
            raise BadInputError(
                f"{self._plan.options.port}: the run has no speed: the board reports no pose, and --speed of a run is "
                "asked for by `snakebot run` alone"
            )
        power = analysis.power_electrical_w
        return analysis.speed_m_s, power if math.isfinite(power) else analysis.power_in_w


def lines(goal: Goal, proof: Proof) -> list[str]:
    """What came of it, in words."""
    rows = [m for m in (proof.calibrated, proof.nominal, *proof.neighbours) if m is not None]
    head = ["on the robot", "runs", "speed m/s", "95 %", "promised", "95 %", "power W", "promised"]
    told = [table_text(f"Promise and outcome, for {goal.aim}", head, [_row(m) for m in rows], [0])]
    what = "faster" if goal.aim == "speed" else "cheaper"
    if proof.verdict == "same choice":
        told.append("The calibration does not change the choice: there is nothing to gain by it here.")
    elif proof.gain is None:
        told.append("Not both choices were run: whether the calibration pays cannot be told.")
    else:
        span = proof.gain_ci95
        known = "" if span is None else f" (95 %: {100 * span[0]:+.1f} to {100 * span[1]:+.1f} %)"
        told.append(
            f"With the calibration {100 * proof.gain:+.1f} % {what}{known}: {_VERDICT[proof.verdict]}."
        )
    kept, among = proof.held
    if among:
        told.append(f"{kept} of {among} gaits moved as fast as promised, within the promise's 95 %.")
    return told


_VERDICT = {
    "paid": "it paid",
    "did not pay": "it did not pay",
    "cannot be told": "the runs cannot tell whether it paid",
}


def _row(measured: Measured) -> list[str]:
    promise = measured.promise
    mean: dict[str, Any] = {
        name: sum(values) / len(values)
        for name, values in (("speed", measured.speed_m_s), ("power", measured.power_w))
    }
    return [
        promise.what if promise.what != "found" else "calibrated", str(len(measured.speed_m_s)),
        f"{mean['speed']:.4f}", _span(measured.interval("speed_m_s")), f"{promise.speed_m_s:.4f}",
        _span(promise.speed_ci95), f"{mean['power']:.3f}", f"{promise.power_w:.3f}",
    ]  # fmt: skip


def _span(ends: tuple[float, float] | None) -> str:
    return "" if ends is None else f"{ends[0]:.3f} to {ends[1]:.3f}"
