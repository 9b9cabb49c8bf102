"""Times at which most of what is left over lies: somebody held the robot, a wire came loose for two seconds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from snakebot.arrays import Bools, Floats, Ints
from snakebot.diagnosis.evidence.blocks import few_stretches, marked
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.result import Stretch
from snakebot.diagnosis.sizes import HALF, MOST_TOLD
from snakebot.diagnosis.verdict.rest import Rest
from snakebot.effects.telling import joints_in_words
from snakebot.in_words import listed


def stretches(evidence: Evidence, best: Trial, rest: Rest, runs: Sequence[int]) -> tuple[Stretch, ...]:
    """A few stretches of some runs, of some joints, that hold most of what ``best`` leaves over on a joint; the largest
    first. None where it is spread out, or fills a whole run.
    """
    blocks, allowed = evidence.angles.blocks, evidence.angles.allowed_square
    square = best.held_square[: blocks.count]
    over = np.maximum(square - allowed, 0.0) * blocks.samples
    found: list[Stretch] = []
    for joint in np.flatnonzero(rest.gap.significant).tolist():
        mine = np.flatnonzero((blocks.joint == joint) & np.isin(blocks.run, runs))
        total = float(over[mine].sum())
        if total <= 0:
            continue
        usual = np.maximum(np.median(square[mine]), allowed[mine])
        parts = few_stretches(blocks.run[mine], blocks.place[mine], square[mine], usual)
        high = marked(parts, mine.size)
        if over[mine[high]].sum() < HALF * total or _fills_a_run(blocks.run[mine], high):
            continue
        there = [mine[part] for part in parts]
        found += [_stretch(evidence, joint, part, float(over[part].sum()) / total) for part in there]
    return tuple(sorted(found, key=lambda one: -one.share))


def _fills_a_run(run: Ints, high: Bools) -> bool:
    """Whether most of the blocks of some run are among them: it is then the run that differs, not a time in it."""
    return any(np.sum(high & (run == r)) > HALF * np.sum(run == r) for r in np.unique(run[high]))


def _stretch(evidence: Evidence, joint: int, part: Ints, share: float) -> Stretch:
    index = int(evidence.angles.blocks.run[part[0]])
    run = evidence.data.runs[index]
    t_s: Floats = run.t_s[np.isin(evidence.angles.blocks.of_sample[index][:, joint], part)]
    return Stretch(
        run=run.name,
        joint=joint + 1,
        begin_s=round(float(t_s[0]), 3),
        end_s=round(float(t_s[-1]), 3),
        share=round(share, 4),
    )


def in_words(found: Sequence[Stretch], count: int) -> list[str]:
    """A warning for joints of the same times, of a robot with ``count`` joints; the first ``MOST_TOLD``."""
    times: dict[int, list[Stretch]] = {}
    for one in found:
        times.setdefault(one.joint, []).append(one)
    alike: dict[tuple[tuple[str, float, float], ...], list[int]] = {}
    for joint, mine in times.items():
        when = sorted((one.run, round(one.begin_s), round(one.end_s)) for one in mine)
        alike.setdefault(tuple(when), []).append(joint)
    return [_of_joints(joints, times[joints[0]], count) for joints in list(alike.values())[:MOST_TOLD]]


def _of_joints(joints: Sequence[int], found: Sequence[Stretch], count: int) -> str:
    share = sum(one.share for one in found)
    when = listed([f"from {one.begin_s:.1f} to {one.end_s:.1f} s in {one.run}" for one in found])
    return (
        f"{joints_in_words(sorted(joints), count)}: {share:.0%} of what is left over is {when}: look at what the "
        "motion does then, and at what happened (somebody touched the robot, it met something, a wire was loose)"
    )
