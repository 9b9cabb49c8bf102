"""What a session lacks for a confident verdict, each with the command that mends it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.data import CLEAN_LOSS, FEWEST_TO_COMPARE, MIN_SAMPLES, holes, motion_numbers
from snakebot.diagnosis.live import Experiment, starting_set
from snakebot.diagnosis.proposal.motions import DURATION_S, RAMP_S, known_motions
from snakebot.diagnosis.sizes import LITTLE, MOST_TOLD, MUCH, OUTSTANDING
from snakebot.errors import BadInputError
from snakebot.gait import Gait
from snakebot.in_words import span
from snakebot.runlog import Run, Session
from snakebot.runlog.number_table import stem_and_suffix

SMALL_DEG = 6.0  # swing of a motion that shows dead bands, play and friction; chosen


@dataclass(frozen=True)
class Missing:
    """A lack: which, what it costs, and what mends it."""

    kind: str
    text: str
    command: str


def missing(session: Session, *, robot: str = "penn_state", port: str = "sim:") -> list[Missing]:
    """What to do before a diagnosis, the most telling first; nothing where the session is complete.

    Args:
        robot, port: as in the commands: the description's name or file, and where the board is.

    Raises:
        BadInputError: the file of the motions is not sound.
    """
    runs = [run for run in session.runs if len(run) >= MIN_SAMPLES]
    way = _Commands(session, robot, port)
    motions = motion_numbers(runs)
    found = [
        *_not_alike(session),
        *_still_joints(runs, session, way),
        *_too_few(runs, motions, way),
        *_too_short(session.runs, way),
        *_lost(runs, way),
        *_clocks(runs, way),
    ]
    if session.robot.body is not None and not any(_knows_way(run) for run in runs):
        found.append(
            Missing(
                "no pose",
                "no run has a pose or a forward speed: nothing is said about the ground, and an encoder that is off "
                "cannot be told from a joint that is off",
                f"{way.run(way.gaits[0])} --speed MEASURED_M_S",
            )
        )
    return found


class _Commands:
    """Commands of the default plan for this robot."""

    def __init__(self, session: Session, robot: str, port: str) -> None:
        self.end = f" --robot {robot} --port {port}"
        known_motions()  # a fault in their file is told, and not taken for limits that allow nothing
        try:
            start = starting_set(session.robot)
            self.gaits = [e.command for e in start]
            self.smallest = min(start, key=_alpha_rad).command
        except BadInputError:  # limits that allow none of them
            self.smallest = f"snakebot run --alpha 10 --beta 80 --omega 1 --duration {DURATION_S:g}"
            self.gaits = [self.smallest]

    def run(self, command: str) -> str:
        return command + self.end

    def again(self, run: Run) -> str:
        """The command that makes a run once more, as far as its gait is known."""
        if run.gait is None:
            return self.run(self.gaits[0])
        gait = run.gait
        offset = f" --offset {math.degrees(gait.offset_rad):g}" if gait.offset_rad else ""
        length = max(run.duration_s, DURATION_S)
        return self.run(
            f"snakebot run --alpha {math.degrees(gait.alpha_rad):g} --beta {math.degrees(gait.beta_rad):g} "
            f"--omega {gait.omega_rad_s:g}{offset}{gait.shares_option} --duration {length:.3g}"
        )


def _not_alike(session: Session) -> list[Missing]:
    """Runs of a robot in another state than the rest, or that were broken off: a session is of one robot as it is."""
    states = {run.name: _state(run) for run in session.runs}
    rest = "snakebot session make SESSION " + " ".join(
        f"{stem_and_suffix(run.name)[0]}.mcap"
        for run in session.runs
        if not run.aborted and not states[run.name]
    )
    out = []
    if len(set(states.values())) > 1:
        told = "; ".join(f"{name}: {state}" for name, state in states.items() if state)
        text = f"not all runs are of one robot in one state ({told}); leave those out, or diagnose them by themselves"
        out.append(Missing("mixed runs", text, rest))
    broken_off = [run.name for run in session.runs if run.aborted]
    if broken_off:
        text = f"{', '.join(broken_off)}: broken off; make the run again, and leave this one out"
        out.append(Missing("aborted run", text, rest))
    return out


def _state(run: Run) -> str:
    """Faults and effects that were put in, as the log says; empty where there are none."""
    parts = []
    for name in ("faults", "effects"):
        value = run.metadata.get(name)
        text = " ".join(map(str, value)) if isinstance(value, list) else str(value or "")
        parts += [f"{name.rstrip('s')} {text}"] if text else []
    return ", ".join(parts)


def _still_joints(runs: Sequence[Run], session: Session, way: _Commands) -> list[Missing]:
    least, out = OUTSTANDING * session.robot.rad_per_count, []
    for joint in range(session.robot.joints):
        told = max((_swing(run.command_rad[:, joint]) for run in runs), default=0.0)
        seen = max((_swing(run.measured_rad[:, joint]) for run in runs), default=0.0)
        if told <= least:
            number = joint + 1
            text = f"joint {number} is never commanded to move: nothing can be said about it"
            probe = f"triangle:amplitude_deg=6,rate_deg_s=6,joints={number} --duration {DURATION_S:g}"
            out.append(Missing("still joint", text, way.run(f"snakebot run --probe {probe}")))
        elif seen <= least:
            text = (
                f"joint {joint + 1} never moves, though up to {math.degrees(told):.0f} deg are commanded: is its servo "
                "powered, its encoder connected?"
            )
            doctor = way.end.split(" --port ")[1]
            out.append(Missing("still joint", text, f"snakebot doctor {doctor}"))
    return out


def _too_few(runs: Sequence[Run], motions: Sequence[int], way: _Commands) -> list[Missing]:
    out = []
    kinds = len(set(motions))
    if kinds < FEWEST_TO_COMPARE:
        unlike = [c for c in way.gaits[:-1] if not any(_is(c, run) for run in runs)]
        wanted = unlike[: FEWEST_TO_COMPARE - kinds] or way.gaits[: FEWEST_TO_COMPARE - kinds]
        only = (
            "one motion alone" if kinds == 1 else f"only {kinds} different motions" if kinds else "no motion"
        )
        text = f"{only}: a cause is checked on gaits that it was not fitted to; record at least "
        text += f"{FEWEST_TO_COMPARE}, of different frequency and amplitude"
        out.append(Missing("few motions", text, "; ".join(map(way.run, wanted))))
    if runs and kinds == len(runs):
        text = "no motion is recorded twice: the noise floor is that of the encoders alone"
        out.append(Missing("no repeat", text, way.again(runs[0])))
    swings = [max(_swing(column) for column in run.command_rad.T) for run in runs]
    if swings and min(swings) > math.radians(2 * SMALL_DEG):
        text = "no small slow motion: dead band, play and friction hardly show in wide ones"
        out.append(Missing("no small motion", text, way.run(way.smallest)))
    return out


def _too_short(runs: Sequence[Run], way: _Commands) -> list[Missing]:
    alike: dict[str, list[Run]] = {}  # by the command that makes them again: one line each
    for run in runs:
        if run.duration_s < DURATION_S - 2 * RAMP_S:  # with ramps of its own it holds few cycles
            alike.setdefault(way.again(run), []).append(run)
    return [
        Missing("short run", f"{_told(short)}; 10 to 20 s tell more", command)
        for command, short in alike.items()
    ]


def _told(runs: Sequence[Run]) -> str:
    """Each with its length; of many the first, and how long they are."""
    if len(runs) <= MOST_TOLD:
        return "; ".join(f"{run.name}: {run.duration_s:.3g} s{_cycles(run)}" for run in runs)
    lengths = [run.duration_s for run in runs]
    return f"{runs[0].name} and {len(runs) - 1} more: {span(min(lengths), max(lengths))} s"


def _cycles(run: Run) -> str:
    if run.gait is None:
        return ""
    return f", {run.duration_s * run.gait.omega_rad_s / (2 * math.pi):.2g} cycles"


def _lost(runs: Sequence[Run], way: _Commands) -> list[Missing]:
    out = []
    for run in runs:
        lost = float(np.mean(~np.isfinite(run.measured_rad)))
        gaps = len(holes(run.t_s))
        if lost > CLEAN_LOSS or gaps > CLEAN_LOSS * len(run):
            what = f"{lost:.1%} of the readings are lost" if lost > CLEAN_LOSS else f"{gaps} holes in time"
            text = f"{run.name}: {what}: look at the line, then record it again"
            out.append(Missing("lost samples", text, way.again(run)))
    return out


def _clocks(runs: Sequence[Run], way: _Commands) -> list[Missing]:
    """Times that a board or a spreadsheet made up: steps that jitter, or all equal but for a few that are none."""
    out = []
    for run in runs:
        steps = np.diff(run.t_s)
        usual = float(np.median(steps))
        off = float(np.mean(np.abs(steps - usual) > LITTLE * usual))
        if off > MUCH:
            text = (
                f"{run.name}: {off:.0%} of the time steps are off the usual {1e3 * usual:.3g} ms by more than a tenth: "
                "is t_s the time at which each set-point was sent, by one clock?"
            )
            out.append(Missing("clock", text, way.again(run)))
    return out


def _is(command: str, run: Run) -> bool:
    if run.gait is None:
        return False
    words = f"--alpha {math.degrees(run.gait.alpha_rad):g} --beta {math.degrees(run.gait.beta_rad):g} "
    return f"{words}--omega {run.gait.omega_rad_s:g} " in command


def _knows_way(run: Run) -> bool:
    return run.forward_speed_m_s is not None or (run.pose is not None and bool(np.isfinite(run.pose).any()))


def _alpha_rad(experiment: Experiment) -> float:
    assert isinstance(experiment.motion, Gait)  # of the starting set
    return experiment.motion.alpha_rad


def _swing(values: Floats) -> float:
    finite = values[np.isfinite(values)]
    return float(np.ptp(finite)) if finite.size else 0.0
