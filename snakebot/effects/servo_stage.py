"""The servo stage of whole runs: set-points behind the link to joint angles, by the kernels of the simulated board."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from snakebot.arrays import Bools, Floats, Ints
from snakebot.effects.effect import Track
from snakebot.effects.stages import FILTER_STEP_S, Stages
from snakebot.physics import servo_layout as layout

GRID_S = 2e-3  # step of chains and of what the servo's closed forms do not cover; chosen


@dataclass(frozen=True, eq=False)
class ServoRun:
    """What the servo stage takes of a run.

    Attributes:
        t_s: (T,) times of the samples.
        track: set-points behind the link.
        initial_rad: (joints,) joint angles at the first sample; None: those of ``known_rad``, or at rest.
        known_rad: (T, joints) true joint angles where they are known: a joint without a set-point takes them, so that
            its servo wakes up from the right place. (A broken joint does not: it is simulated.)
        load_nm: (T, joints) torques that are known: sag and friction are then quasi-static, without simulating the
            body, play is crossed as ``physics.borne_play`` says, and no torque limit is felt.
        pose: x, y, heading of the body at the first sample.
    """

    t_s: Floats
    track: Track
    initial_rad: npt.ArrayLike | None = None
    known_rad: Floats | None = None
    load_nm: Floats | None = None
    pose: npt.ArrayLike = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Servos:
    """What the servo stage makes of a run.

    Attributes:
        joint_angle_rad, load_nm: (T, joints).
        powered: (T, joints) whether the servo had a set-point at that sample. A joint without one has its known angle,
            if any, and says nothing about the servo.
        base: (T, 6) x, y, heading of the body and their rates, where the servo stage had to simulate it.
        torque_nm, power_in_w: (T, joints), (T,) of the body, means since the sample before, where it was simulated.
    """

    joint_angle_rad: Floats
    load_nm: Floats
    powered: Bools
    base: Floats | None = None
    torque_nm: Floats | None = None
    power_in_w: Floats | None = None


def setpoint_at(track: Track, t_s: Floats) -> Floats:
    """(T, joints) set-points in force from each time on; before the first one: the first one."""
    if track.late_s is None:
        found: Floats = track.setpoint_rad.take(track.rows_at(t_s, 0), axis=0)
        return found
    return np.stack([track.setpoint_rad[track.rows_at(t_s, j), j] for j in range(track.late_s.size)], axis=1)


def servo_stages(
    stages: Stages, runs: Sequence[ServoRun], joints: Sequence[int] | None = None
) -> list[Servos]:
    """Set-points to joint angles, run by run.

    Args:
        joints: 0-based, those that are asked for; where no joint feels the others, the others come out as NaN.
    """
    driven = [_Driven.of(stages, run) for run in runs]
    apart: dict[bool, list[_Driven]] = {}
    for each in driven:
        if not each.coupled:
            apart.setdefault(each.run.load_nm is not None, []).append(each)
    wanted = np.arange(stages.servo_rows.shape[0]) if joints is None else np.asarray(joints, dtype=np.int64)
    made = {id(each): servos for group in apart.values() for each, servos in _apart(stages, group, wanted)}
    return [_on_a_body(stages, each) if each.coupled else made[id(each)] for each in driven]


@dataclass(frozen=True, eq=False)
class _Driven:
    """A run as the kernels take it: set-points behind the servo filters, and where the joints are at first.

    Attributes:
        powered: (T, joints), see ``Servos``.
        start_rad: (joints,).
        known_rad: (T, joints) where unpowered joints are, NaN where they have power; None: all have.
        coupled: whether one joint feels the others, through the body.
    """

    run: ServoRun
    track: Track
    powered: Bools
    start_rad: Floats
    known_rad: Floats | None
    coupled: bool

    @staticmethod
    def of(stages: Stages, run: ServoRun) -> _Driven:
        rows = stages.servo_rows
        track = followed(stages, run.track, run.t_s)
        all_powered = bool(np.isfinite(track.setpoint_rad).all())
        if all_powered:
            powered = np.ones((run.t_s.size, rows.shape[0]), dtype=np.bool_)
        else:
            powered = np.isfinite(setpoint_at(track, run.t_s))[:, rows[:, layout.SOURCE].astype(np.int64)]
            all_powered = bool(powered.all())
        coupled = stages.model is not None and (
            stages.broken[0]
            or (stages.feels_load and run.load_nm is None)
            or (run.known_rad is None and not all_powered)
        )
        known = None if run.known_rad is None or all_powered else np.where(powered, np.nan, run.known_rad)
        return _Driven(run, track, powered, _start(stages, track, run), known, coupled)


def _on_a_body(stages: Stages, driven: _Driven) -> Servos:
    from snakebot.physics.servo_chain import DrivenChain

    run, whole = driven.run, driven.track.of_one_clock()
    begin_s = float(run.t_s[0])
    chain = DrivenChain(
        stages.servo_rows, driven.start_rad, model=stages.model, pose=run.pose, t_s=begin_s, grid_s=GRID_S
    )
    out = chain.run(
        run.t_s,
        whole.time_s,
        whole.setpoint_rad,
        since_s=begin_s,
        load_t_s=run.t_s if run.load_nm is not None else None,
        load_nm=run.load_nm,
        known_rad=driven.known_rad,
    )
    return Servos(out.angle, out.load, driven.powered, out.base, out.torque, out.power[:, 0])


def _apart(stages: Stages, driven: Sequence[_Driven], joints: Ints) -> list[tuple[_Driven, Servos]]:
    from snakebot.physics.borne_play import borne_side
    from snakebot.physics.servos_apart import run_apart

    loads = [each.run.load_nm for each in driven]
    rows, swing_rad = stages.servo_rows, layout.half_swing_rad(stages.servo_rows)
    swings = loads[0] is not None and bool(swing_rad.any())
    if swings:
        rows = rows.copy()
        rows[swing_rad > 0, layout.BACKLASH_RAD] = 0.0
    angle, felt = run_apart(
        rows,
        np.stack([each.start_rad for each in driven]),
        joints,
        [each.run.t_s for each in driven],
        [each.track.time_s for each in driven],
        [each.track.setpoint_rad for each in driven],
        grid_s=GRID_S,
        late_s=driven[0].track.late_s,
        load_nm=None if loads[0] is None else [load for load in loads if load is not None],
        known_rad=[each.known_rad for each in driven],
    )
    if swings:
        for a, each, load in zip(angle, driven, loads, strict=True):
            assert load is not None
            a += np.where(each.powered, swing_rad * borne_side(each.run.t_s, load), 0.0)
    return [(each, Servos(a, f, each.powered)) for each, a, f in zip(driven, angle, felt, strict=True)]


def followed(stages: Stages, track: Track, t_s: Floats) -> Track:
    """Set-points behind the servo filters; as they are where there is none."""
    filters = stages.servo_filters()
    if not filters:
        return track
    steps = np.arange(np.floor(t_s[0] / FILTER_STEP_S), np.ceil(t_s[-1] / FILTER_STEP_S) + 1)
    times = steps * FILTER_STEP_S
    driven = setpoint_at(track, times)
    for servo_filter in filters:
        driven = servo_filter.follow(times, driven)
    return Track(times, driven)


def _start(stages: Stages, track: Track, run: ServoRun) -> Floats:
    """(joints,) joint angles at the first sample."""
    rows = stages.servo_rows
    if run.initial_rad is not None:
        start: Floats = np.broadcast_to(np.asarray(run.initial_rad, dtype=np.float64), rows.shape[:1])
    elif run.known_rad is not None and np.isfinite(run.known_rad[0]).all():
        start = run.known_rad[0]
    else:
        first = np.where(np.isfinite(track.setpoint_rad[0]), track.setpoint_rad[0], 0.0)
        start = layout.rest_angle_rad(rows, first)
        if run.known_rad is not None:
            start = np.where(np.isfinite(run.known_rad[0]), run.known_rad[0], start)
    if stages.broken[1]:
        start = np.where(rows[:, layout.LOCKED] == layout.RIGID_JOINT, rows[:, layout.LOCK_RAD], start)
    return start
