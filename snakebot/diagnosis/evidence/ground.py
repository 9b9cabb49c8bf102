"""The motion over ground: measured by a pose or by one forward speed a run, predicted by replaying joint angles.

A run with a pose is cut into quarters of its gait's cycle (or seconds); of each the mean velocity along and across
the mean heading and the turn rate are compared. Errors therefore do not pile up along the way, and mass, which hardly
changes the speed of a cycle, shows within it. A run with a forward speed alone gives one number: the speed over its
second half. A pose without headings is cut into whole cycles, and gives the speed along its way, nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass, replace
from enum import IntEnum
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats, Ints
from snakebot.diagnosis.evidence.data import BLOCK_S, HOLE_S, MIN_SAMPLES, QUARTERS, Data, PreparedRun, holes
from snakebot.diagnosis.sizes import HALF, MUCH, NO_PERCENT
from snakebot.robot import Tolerance
from snakebot.smoothing import SMOOTH_S, smoothed

if TYPE_CHECKING:
    from snakebot.physics import ChainModel


SPEED_ACCURACY = NO_PERCENT  # relative error of a measured speed
# Shares of a run, from which to its end a forward speed may have been taken as well.
OTHER_BEGINS = (MUCH, HALF)


class Feature(IntEnum):
    """Kinds of features of the motion over ground."""

    FORWARD = 0
    LATERAL = 1
    TURN = 2


@dataclass(frozen=True, eq=False)
class Window:
    """A stretch of a run over which a velocity is taken; ``place`` is its number there.

    Of a pose without headings the speed is that of the ``course``, the way from the stretch's beginning to its end.
    """

    run: int
    start_s: float
    end_s: float
    speed_only: bool
    place: int = 0
    course: bool = False


@dataclass(frozen=True, eq=False)
class GroundFeatures:
    """What was measured of the motion over ground.

    Attributes:
        windows: (W,) stretches.
        value: (F,) measured features: of each window forward and lateral velocity and turn rate, or forward alone.
        window, kind: (F,) which window and which ``Feature``.
        floor_square: (F,) variance from repeats or from the resolution of the measurement.
        from_repeats: whether the floor of the forward speed comes from repeats.
    """

    windows: tuple[Window, ...]
    value: Floats
    window: Ints
    kind: Ints
    floor_square: Floats
    from_repeats: bool

    @cached_property
    def run(self) -> Ints:
        """(F,) of each feature."""
        return np.array([self.windows[w].run for w in self.window], dtype=np.int64)

    @property
    def count(self) -> int:
        return int(self.value.size)


def measured_ground(data: Data, like: Set[tuple[int, int]]) -> GroundFeatures | None:
    """The measured motion over ground; None where the session says nothing about it.

    Args:
        like: pairs of runs (indices, rising) that repeat each other, for the floor.
    """
    if not data.has_ground:
        return None
    windows: list[Window] = []
    for index, run in enumerate(data.runs):
        windows += [w for w in _windows(index, run) if not broken(run, w.start_s, w.end_s)]
    poses: dict[int, Floats] = {}
    noise_square: dict[int, Floats] = {}
    for index, run in enumerate(data.runs):
        mine = [window for window in windows if window.run == index]
        if run.pose is not None:
            poses[index] = _smoothed_pose(run.t_s, run.pose)
        if run.pose is not None and mine:
            noise_square[index] = _noise_square(run.t_s, run.pose, poses[index], mine)
    values: list[float] = []
    window_of: list[int] = []
    kinds: list[int] = []
    for number, window in enumerate(windows):
        run = data.runs[window.run]
        if window.speed_only:
            assert run.forward_speed_m_s is not None
            features: tuple[float, ...] = (run.forward_speed_m_s,)
        else:
            features = tuple(window_features(run.t_s, poses[window.run], [window])[0])
        for kind, feature in enumerate(features):
            if np.isfinite(feature):
                values.append(feature)
                window_of.append(number)
                kinds.append(kind)
    if not values:
        return None
    value, what, of = np.array(values), np.array(kinds, dtype=np.int64), np.array(window_of, dtype=np.int64)
    still = np.zeros(3)  # a forward speed alone has no noise that we could see
    noise = np.array(
        [noise_square.get(windows[n].run, still)[k] for n, k in zip(window_of, kinds, strict=True)]
    )
    floor, from_repeats = _floor(data.robot.tolerance, windows, value, what, of, like, noise)
    return GroundFeatures(tuple(windows), value, of, what, floor, from_repeats)


def _windows(index: int, run: PreparedRun) -> list[Window]:
    end = run.duration_s
    if run.pose is None:
        if run.forward_speed_m_s is None:
            return []
        return [Window(index, *steady_span(run), True)]
    length = 2 * np.pi / abs(run.omega_rad_s) if run.omega_rad_s else 1.0
    first = min(
        length, end / 3
    )  # the start from rest tells of mass, but every lab starts its clock elsewhere
    course = not has_heading(run.pose)
    if run.omega_rad_s and not course:  # without headings, the sway within a cycle would pass for speed
        length /= int(np.clip(length / SMOOTH_S, 1, QUARTERS))
    count = int((end - first) / length + 1e-6)
    if count < 1:
        return [Window(index, first, end, False, course=course)]
    return [
        Window(index, first + i * length, first + (i + 1) * length, False, i, course) for i in range(count)
    ]


def has_heading(pose: Floats | None) -> bool:
    """Whether a heading is known anywhere in a pose (N, 3); where there is no pose, none is missed."""
    return pose is None or bool(np.isfinite(pose).all(axis=1).any())


def start_pose(t_s: Floats, pose: Floats) -> Floats:
    """x, y and heading (3,) where a pose begins; without headings, the direction of travel over its first third."""
    headed = has_heading(pose)
    known = np.flatnonzero(np.isfinite(pose if headed else pose[:, :2]).all(axis=1))
    first: Floats = pose[known[0]].copy()
    if not headed:
        end = known[np.searchsorted(t_s[known], t_s[0] + (t_s[-1] - t_s[0]) / 3).clip(max=known.size - 1)]
        way = pose[end, :2] - first[:2]
        first[2] = np.arctan2(way[1], way[0])
    return first


def _smoothed_pose(t_s: Floats, pose: Floats) -> Floats:
    if has_heading(pose):
        return smoothed(t_s, pose)
    return np.column_stack([smoothed(t_s, pose[:, :2]), pose[:, 2]])


def broken(run: PreparedRun, start_s: float, end_s: float) -> bool:
    """Whether a stretch of a run has, or comes soon after, a hole in the log: no replay knows the way through it, and
    the simulated body regains the pace of the real one only when what was before is forgotten.
    """
    before = holes(run.t_s, HOLE_S)
    return bool(np.any((run.t_s[before] < end_s) & (run.t_s[before + 1] + BLOCK_S > start_s)))


def steady_span(run: PreparedRun) -> tuple[float, float]:
    """The second half of a run, in whole cycles: what a forward speed is taken over."""
    end, half = run.duration_s, run.duration_s / 2
    if run.omega_rad_s:
        period = 2 * np.pi / abs(run.omega_rad_s)
        cycles = int(half / period)
        if cycles >= 1:
            return end - cycles * period, end
    return half, end


def _noise_square(t_s: Floats, pose: Floats, smooth: Floats, windows: Sequence[Window]) -> Floats:
    """(3,) variance of forward and lateral velocity and turn rate of a run's windows by the noise of its pose.

    What the smoothing takes off the pose is its noise. How much of it is still in the velocities is seen by smoothing
    white noise.
    """
    rng = np.random.default_rng(0)
    white = [np.where(np.isfinite(pose), rng.normal(size=pose.shape), np.nan) for _ in range(MIN_SAMPLES)]
    left = [_smoothed_pose(t_s, noise) for noise in white]
    taken = np.mean([_square(noise - rest) for noise, rest in zip(white, left, strict=True)], axis=0)
    scale = np.sqrt(np.divide(_square(pose - smooth), taken, out=np.zeros(3), where=taken > 0))
    base = window_features(t_s, smooth, windows)
    shaken = [window_features(t_s, smooth + scale * rest, windows) - base for rest in left]
    return _square(np.concatenate(shaken))


def _square(table: Floats) -> Floats:
    """Mean square of each column, over what is known of it; zero where nothing is."""
    known = np.isfinite(table)
    return np.asarray(np.square(np.where(known, table, 0.0)).sum(axis=0) / np.maximum(known.sum(axis=0), 1))


def window_features(t_s: Floats, pose: Floats, windows: Sequence[Window]) -> Floats:
    """(W, 3) forward, lateral velocity (m/s) along the mean heading and turn rate (rad/s) over windows of one kind.

    Of a course there is the speed alone.
    """
    course = windows[0].course
    known = np.isfinite(pose[:, :2] if course else pose).all(axis=1)
    t, path = t_s[known], pose[known]
    start, end = (np.array([getattr(window, name) for window in windows]) for name in ("start_s", "end_s"))
    out = np.full((len(windows), 3), np.nan)
    if t.size < 2:
        return out
    span = end - start
    x, y, turn = (_gained(t, column, start, end) / span for column in path.T)
    if course:
        out[:, 0] = np.hypot(x, y)
    else:
        mean = _mean(t, path[:, 2], start, end)
        c, s = np.cos(mean), np.sin(mean)
        out[:] = np.column_stack([c * x + s * y, c * y - s * x, turn])
    out[(t[0] > start + SMOOTH_S) | (t[-1] < end - SMOOTH_S)] = np.nan
    return out


def _gained(t_s: Floats, value: Floats, start_s: Floats, end_s: Floats) -> Floats:
    """(W,) by how much a value has grown from the beginning to the end of each stretch."""
    gained: Floats = np.interp(end_s, t_s, value) - np.interp(start_s, t_s, value)
    return gained


def _mean(t_s: Floats, value: Floats, start_s: Floats, end_s: Floats) -> Floats:
    """(W,) mean of the samples in each stretch; of one without samples, the value in its middle."""
    first, last = np.searchsorted(t_s, start_s), np.searchsorted(t_s, end_s, side="right")
    total = np.concatenate([[0.0], np.cumsum(value)])
    count = last - first
    middle = np.interp((start_s + end_s) / 2, t_s, value)
    return np.where(count > 0, (total[last] - total[first]) / np.maximum(count, 1), middle)


def predicted(
    ground: GroundFeatures,
    data: Data,
    angle_rad: Sequence[Floats],
    model: ChainModel,
    runs: Sequence[int] | None = None,
    t_s: Sequence[Floats] | None = None,
) -> Floats:
    """(F,) features of the motion that joint angles (one (N, k) a run) make; nan for runs not asked for.

    Args:
        t_s: times of the angles, a run; those of the samples if None.
    """
    from snakebot.physics import replayed_pose

    made = np.full((len(ground.windows), 3), np.nan)
    of_run = np.array([window.run for window in ground.windows])
    for index in sorted(set(of_run.tolist()) & set(range(len(data.runs)) if runs is None else runs)):
        run = data.runs[index]
        start = np.zeros(3) if run.pose is None else start_pose(run.t_s, run.pose)
        times = run.t_s if t_s is None else t_s[index]
        pose = replayed_pose(model, times, angle_rad[index], start)
        if run.pose is not None:
            pose = smoothed(times, pose)
        mine = np.flatnonzero(of_run == index)
        made[mine] = window_features(times, pose, [ground.windows[number] for number in mine])
    features: Floats = made[ground.window, ground.kind]
    return features


def doubt(
    ground: GroundFeatures,
    data: Data,
    angle_rad: Sequence[Floats],
    noisier_rad: Sequence[Floats],
    model: ChainModel,
) -> tuple[Floats, Floats]:
    """(F,) squared change of the features by what is not known of the measurement, and (F,) what noise does to them.

    The readings have noise (``noisier_rad`` are the angles with as much of it again, which shakes the simulated body
    as much again); and the span over which a lone speed was taken is not known.
    """
    base = predicted(ground, data, angle_rad, model)
    shaken = np.nan_to_num(predicted(ground, data, noisier_rad, model) - base)
    total = np.square(shaken)
    for begin in OTHER_BEGINS:
        other = replace(ground, windows=tuple(_from(data, window, begin) for window in ground.windows))
        if other.windows != ground.windows:
            total += 0.5 * np.square(predicted(other, data, angle_rad, model) - base)
    return np.nan_to_num(total), shaken


def tolerance_marks(
    ground: GroundFeatures, data: Data, angle_rad: Sequence[Floats], model: ChainModel
) -> Floats:
    """(F, 3 (1 + links)) change of the features by the tolerance of friction along, friction across, and mass: of all
    links, of the first, of the second ...
    """
    base = predicted(ground, data, angle_rad, model)
    rub, mass = data.robot.tolerance.friction, data.robot.tolerance.mass
    changed = []
    for links in (np.ones(model.links), *np.eye(model.links)):
        rough, heavy = 1 + rub * links, 1 + mass * links
        changed += [
            replace(model, ct=model.ct * rough, ct0=model.ct0 * rough),
            replace(model, cn=model.cn * rough, cn0=model.cn0 * rough),
            replace(model, mass=model.mass * heavy, inertia=model.inertia * heavy),
        ]
    return np.nan_to_num(
        np.stack([predicted(ground, data, angle_rad, other) - base for other in changed], axis=1)
    )


def _from(data: Data, window: Window, share: float) -> Window:
    """Another span that a speed may have been taken over, from a share of the run to its end."""
    if not window.speed_only:
        return window
    length_s = data.runs[window.run].duration_s
    return replace(window, start_s=share * length_s, end_s=length_s)


def _floor(
    known: Tolerance,
    windows: list[Window],
    value: Floats,
    kind: Ints,
    of: Ints,
    like: Set[tuple[int, int]],
    noise_square: Floats,
) -> tuple[Floats, bool]:
    """Variance of each feature: from windows of repeats that coincide, at least the resolution of the measurement and
    the noise of its pose.
    """
    least = np.where(
        kind == Feature.TURN,
        known.heading_rad / BLOCK_S,
        known.pose_m / BLOCK_S + SPEED_ACCURACY * np.abs(value),
    )
    # run and value of each (n-th window, kind, with a heading or without)
    place: dict[tuple[int, int, bool], list[tuple[int, float]]] = {}
    for i in range(value.size):
        window = windows[of[i]]
        place.setdefault((window.place, int(kind[i]), window.course), []).append(
            (window.run, float(value[i]))
        )
    squares: dict[int, list[float]] = {feature: [] for feature in Feature}
    for (_, what, _), group in place.items():
        squares[what] += [0.5 * (a - b) ** 2 for (i, a), (j, b) in combinations(group, 2) if (i, j) in like]
    floor = np.square(least) + noise_square
    for what, found in squares.items():
        if found:
            rows = kind == what
            floor[rows] = np.maximum(floor[rows], np.mean(found))
    return floor, bool(squares[Feature.FORWARD])
