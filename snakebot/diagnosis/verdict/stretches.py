"""Times at which most of what is left over lies: somebody held the robot, a wire came loose for two seconds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from snakebot.arrays import Bools, Floats, Ints
from snakebot.diagnosis.evidence.blocks import few_stretches
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.result import HALF, Stretch
from snakebot.diagnosis.verdict.rest import Rest
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
        mine = (blocks.joint == joint) & np.isin(blocks.run, runs)
        total = float(over[mine].sum())
        if total <= 0:
            continue
        usual = np.maximum(np.median(square[mine]), allowed)
        parts = few_stretches(np.flatnonzero(mine), square[mine], usual[mine])
        high = np.isin(np.arange(blocks.count), np.concatenate([[], *parts]))
        if over[high].sum() < HALF * total or _fills_a_run(blocks.run, mine, high):
            continue
        found += [_stretch(evidence, joint, part, float(over[part].sum()) / total) for part in parts]
    return tuple(sorted(found, key=lambda one: -one.share))


def _fills_a_run(run: Ints, mine: Bools, high: Bools) -> bool:
    """Whether most of the blocks of some run are among them: it is then the run that differs, not a time in it."""
    return any(np.sum(high & (run == r)) > HALF * np.sum(mine & (run == r)) for r in np.unique(run[high]))


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


def in_words(found: Sequence[Stretch]) -> list[str]:
    """A warning for each joint."""
    joints = dict.fromkeys(one.joint for one in found)
    return [_of_joint(joint, [one for one in found if one.joint == joint]) for joint in joints]


def _of_joint(joint: int, found: Sequence[Stretch]) -> str:
    share = sum(one.share for one in found)
    when = listed([f"from {one.begin_s:.1f} to {one.end_s:.1f} s in {one.run}" for one in found])
    return (
        f"joint {joint}: {share:.0%} of what is left over is {when}: look at what the motion does then, and at what "
        "happened (somebody touched the robot, it met something, a wire was loose)"
    )
