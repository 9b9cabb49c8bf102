"""What two runs of one motion differ by, joint by joint: noise, or a robot that changed in between.

Noise does not depend on the motion. White noise, counts, set-points lost at random, a servo that sticks here today and
there tomorrow: what they did in one part of a run says nothing about another part. A robot that changed (a horn that
slipped, a joint that jammed, a servo that became slow) differs as a function of the motion: fitted to parts of the run,
that function predicts the other parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from snakebot.arrays import Bools, Floats, Ints
from snakebot.diagnosis.evidence.data import (
    BLOCK_S,
    FEWEST_SAMPLES,
    FEWEST_TO_COMPARE,
    MIN_SAMPLES,
    QUARTERS,
    Data,
    PreparedRun,
)
from snakebot.diagnosis.evidence.operators import play
from snakebot.diagnosis.sizes import BEYOND_CHANCE, HALF, LITTLE, MOST_TOLD, MUCH, NEARLY_ALL, OUTSTANDING
from snakebot.in_words import numbered
from snakebot.runlog.matching.motion import same_motion

# Mean square of the predicted part over that of the runs' gaps, under which it hides none of them: little, as an angle.
LEAST_OF_GAP = LITTLE * LITTLE
# Usual steps in time, that lost readings are interpolated over at most. Fewer than ``ticks.is_bridged`` has,
# which is for set-points: they lie on a smooth curve, and what readings differ by is told from their noise.
MOST_BRIDGED = OUTSTANDING
# After a difference of the commands, in which the joints may still show it. No multiple of the stated time
# constant, as ``data.SETTLED`` is: readings are compared with readings, of servos that may be much slower than stated.
FORGOTTEN_S = MUCH * BLOCK_S


@dataclass(frozen=True, eq=False)
class RepeatDifference:
    """What a joint does in one run less what it does in another, which repeats it.

    Attributes:
        rows: (n,) samples of the one run that are compared.
        rad: (n,) differences.
        predicted_rad: root mean square of the part that depends on the motion; 0 where that is not most of it.
        of_gap: that part over the gaps of the two runs to their prediction, in mean squares.
    """

    joint: int
    rows: Ints
    rad: Floats
    predicted_rad: float = 0.0
    of_gap: float = 0.0

    @property
    def rms_rad(self) -> float:
        return float(np.sqrt(np.square(self.rad).mean()))


@dataclass(frozen=True, eq=False)
class RepeatedPair:
    """Two runs (indices) told the same.

    Attributes:
        changed: 0-based joints whose difference is no noise.
        unlike: those whose difference depends on the motion, but is no more than such joints differ by anyway.
    """

    one: int
    other: int
    shift_s: float
    differences: tuple[RepeatDifference, ...]
    changed: tuple[int, ...] = ()
    unlike: tuple[int, ...] = ()


def difference(
    a: PreparedRun, b: PreparedRun, joint: int, shift_s: float, same: Bools
) -> tuple[Ints, Floats]:
    """Samples of ``a`` at which a joint can be compared, and how far it is from where it is in ``b``; none if few.

    Args:
        shift_s, same: see ``matching.motion.Match``.
    """
    nothing = np.zeros(0, dtype=np.int64), np.zeros(0)
    ua, ub = a.use[:, joint], b.use[:, joint]
    if ua.sum() < MIN_SAMPLES or ub.sum() < MIN_SAMPLES:
        return nothing
    t, tb = a.t_s + shift_s, b.t_s[ub]
    told = ua & ~_soon_after(~same[:, joint], a.t_s)
    inside = told & (t >= tb[0]) & (t <= tb[-1])
    # a stretch that b lost cannot be bridged
    after = np.searchsorted(tb, t[inside])
    gap = tb[np.minimum(after, tb.size - 1)] - tb[np.maximum(after - 1, 0)]
    rows = np.flatnonzero(inside)[gap < MOST_BRIDGED * b.period_s]
    if rows.size < MIN_SAMPLES:
        return nothing
    return rows, a.measured_rad[rows, joint] - np.interp(t[rows], tb, b.measured_rad[ub, joint])


def repeated_pairs(data: Data, white_rad: Floats, nominal: Sequence[Floats] | None) -> list[RepeatedPair]:
    """All pairs of runs that are told the same, in the order of the runs.

    Args:
        white_rad: (k,) noise of the readings.
        nominal: predicted readings (N, k) a run, for changes to be told from noise; None: none is a change.
    """
    found: list[RepeatedPair] = []
    for i, a in enumerate(data.runs):
        for j in range(i + 1, len(data.runs)):
            b = data.runs[j]
            if a.motion != b.motion:
                continue
            side = same_motion(a.commanded, b.commanded, claimed=True)
            if side is None:
                continue
            differences = []
            for joint in range(data.joints):
                rows, rad = difference(a, b, joint, side.shift_s, side.same)
                if rows.size:
                    one = RepeatDifference(joint, rows, rad)
                    if nominal is not None:
                        one = _with_prediction(
                            one, (a, b), (nominal[i], nominal[j]), side.shift_s, white_rad[joint]
                        )
                    differences.append(one)
            if differences:
                found.append(RepeatedPair(i, j, side.shift_s, tuple(differences)))
    return _with_changes(data, found)


def _with_prediction(
    one: RepeatDifference,
    runs: tuple[PreparedRun, PreparedRun],
    nominal: tuple[Floats, Floats],
    shift_s: float,
    white_rad: float,
) -> RepeatDifference:
    """The same with how much of it depends on the motion, if that is most of it and beyond the readings' noise, and
    whether it could hide a gap.
    """
    a, b = runs
    rows, joint = one.rows, one.joint
    if rows.size < FEWEST_SAMPLES:
        return one
    reading = nominal[0][:, joint]
    rate = np.gradient(reading, a.t_s)[rows]
    late_s = float(one.rad @ rate) / max(float(rate @ rate), 1e-12)
    most_s = max(a.period_s, b.period_s)  # a reading is no more punctual than the samples
    left = one.rad - np.clip(late_s, -most_s, most_s) * rate
    slack = reading - play(reading, float(np.sqrt(np.square(left).mean())))
    regressors = np.column_stack([np.ones(rows.size), reading[rows], rate, slack[rows]])
    strokes = _strokes(rate)
    if strokes[-1] + 1 < FEWEST_TO_COMPARE:
        return one
    predicted = _predicted_by_motion(regressors, left, strokes)
    size = float(np.square(predicted).mean())
    share = 1 - float(np.square(left - predicted).sum()) / max(float(np.square(left).sum()), 1e-300)
    if share < NEARLY_ALL or 0.5 * size < (BEYOND_CHANCE * white_rad) ** 2:
        return one
    gap_a = a.measured_rad[rows, joint] - reading[rows]
    gap_b = gap_a - one.rad + reading[rows] - np.interp(a.t_s[rows] + shift_s, b.t_s, nominal[1][:, joint])
    gap = float(np.square(gap_a).mean() + np.square(gap_b).mean())
    return RepeatDifference(joint, rows, one.rad, float(np.sqrt(size)), size / max(gap, 1e-300))


def _strokes(rate: Floats) -> Ints:
    """(n,) number of the stroke, from one turn of the joint to the next, that each sample belongs to."""
    way = np.sign(rate)
    moving = np.maximum.accumulate(np.where(way != 0, np.arange(way.size), 0))
    return np.cumsum(np.diff(way[moving], prepend=way[0]) != 0)


def _predicted_by_motion(regressors: Floats, values: Floats, strokes: Ints) -> Floats:
    """Each of the parts of ``values`` (n,) as a linear fit of ``regressors`` (n, p) to the other parts says.

    Parts are whole strokes: where a joint comes to rest within one says nothing about the next.
    """
    out = np.empty_like(values)
    for part in np.array_split(np.arange(strokes[-1] + 1), min(QUARTERS, int(strokes[-1]) + 1)):
        mine = np.isin(strokes, part)
        out[mine] = regressors[mine] @ np.linalg.lstsq(regressors[~mine], values[~mine], rcond=1e-6)[0]
    return out


def _with_changes(data: Data, pairs: list[RepeatedPair]) -> list[RepeatedPair]:
    """The pairs with their changed joints.

    How well a joint repeats itself is known where several motions were repeated: there a difference that hides little
    must be unusual, too. Where a joint changed between two runs, it differs by as much in another motion, or by as
    large a share of it, for the same reason, even if that motion has too few strokes to show that it depends on them.
    """
    usual = np.zeros(data.joints)
    for joint in range(data.joints):
        least: dict[int, float] = {}
        for pair in pairs:
            for d in pair.differences:
                if d.joint == joint and d.rows.size >= FEWEST_SAMPLES:
                    motion = data.runs[pair.one].motion
                    least[motion] = min(least.get(motion, np.inf), d.rms_rad)
        if len(least) >= FEWEST_TO_COMPARE:
            usual[joint] = np.median(list(least.values()))

    def change(d: RepeatDifference) -> bool:
        if d.of_gap > MUCH:
            return True
        return d.of_gap > LEAST_OF_GAP and d.predicted_rad > OUTSTANDING * usual[d.joint]

    def sizes(pair: RepeatedPair, d: RepeatDifference) -> Floats:
        """A change may be an angle (a horn that slipped) or a share of the motion (a gain): rad, and a share."""
        swing = float(np.std(data.runs[pair.one].command_rad[d.rows, d.joint]))
        return np.array([d.rms_rad, d.rms_rad / swing if swing > 0 else 0.0])

    largest = np.zeros((data.joints, 2))
    for pair in pairs:
        for d in filter(change, pair.differences):
            largest[d.joint] = np.maximum(largest[d.joint], sizes(pair, d))

    def as_much(pair: RepeatedPair, d: RepeatDifference) -> bool:
        known = largest[d.joint] > 0
        return change(d) or bool((known & (sizes(pair, d) > HALF * largest[d.joint])).any())

    def told(pair: RepeatedPair) -> RepeatedPair:
        changed = tuple(d.joint for d in pair.differences if as_much(pair, d))
        unlike = (d.joint for d in pair.differences if d.of_gap > LEAST_OF_GAP and d.joint not in changed)
        return replace(pair, changed=changed, unlike=tuple(unlike))

    return [told(pair) for pair in pairs]


def change_warnings(data: Data, pairs: Sequence[RepeatedPair]) -> tuple[str, ...]:
    """A line for each pair of runs between which joints changed, the largest first, ``MOST_TOLD`` at most; and one for
    the largest difference that depends on the motion and is taken for noise nevertheless.
    """
    changed = _largest_first([(pair, pair.changed) for pair in pairs])
    lines = [
        f"{_moves_otherwise(data, pair, pair.changed, size)}: the robot changed in between, or does not repeat itself; "
        "this is not taken for noise. Repeat the motion once more"
        for size, pair in changed[:MOST_TOLD]
    ]
    if len(changed) > MOST_TOLD:
        lines.append(f"so it is with {len(changed) - MOST_TOLD} further pairs of runs of the same motion")
    lines += [
        f"{_moves_otherwise(data, pair, pair.unlike, size)}, as a function of the motion: something differs between "
        "these runs (load, supply, temperature, a setting). This difference is counted as noise"
        for size, pair in _largest_first([(pair, pair.unlike) for pair in pairs])[:1]
    ]
    return tuple(lines)


def _largest_first(
    pairs: Sequence[tuple[RepeatedPair, tuple[int, ...]]],
) -> list[tuple[float, RepeatedPair]]:
    """Root mean square of the largest difference of some joints of each pair, rad; pairs without such joints are left
    out.
    """
    found = [
        (max(d.rms_rad for d in pair.differences if d.joint in joints), pair)
        for pair, joints in pairs
        if joints
    ]
    return sorted(found, key=lambda item: -item[0])


def _moves_otherwise(data: Data, pair: RepeatedPair, joints: Sequence[int], size_rad: float) -> str:
    names = sorted(
        (data.runs[pair.one].name, data.runs[pair.other].name),
        key=lambda name: name == data.runs[pair.one].name,
    )
    which, verb = numbered("joint", [j + 1 for j in joints]), "moves" if len(joints) == 1 else "move"
    return (
        f"{which} {verb} otherwise in {names[0]} than in the same motion in {names[1]}, by "
        f"{np.degrees(size_rad):.2g} deg rms"
    )


def doubt_warning(data: Data, pairs: Sequence[RepeatedPair], joint: int) -> str:
    """A line on a joint (0-based) whose repeats are so far apart that they would hide what is plain to see."""
    size, one, other = max(
        (d.rms_rad, pair.one, pair.other)
        for pair in pairs
        for d in pair.differences
        if d.joint == joint and joint not in pair.changed
    )
    return (
        f"joint {joint + 1}: {data.runs[other].name} and {data.runs[one].name}, the same motion, are "
        f"{np.degrees(size):.2g} deg rms apart, about as much as the joint is off its prediction: that is too much to "
        "be taken for noise. Repeat the motion once more"
    )


def _soon_after(flag: Bools, t_s: Floats) -> Bools:
    """(N,) samples that come less than ``FORGOTTEN_S`` after one where ``flag`` (N,) holds, or where it holds."""
    last = np.maximum.accumulate(np.where(flag, t_s, -np.inf))
    return np.asarray(t_s - last < FORGOTTEN_S)
