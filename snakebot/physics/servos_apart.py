"""Servos that do not feel each other: whole runs at once, compiled, joint by joint, each by a clock of its own.

Joints that share no body need no common time: each steps from set-point to set-point, or on a fine grid only where its
own closed forms do not hold over a whole set-point. First-order ones have a loop of their own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from snakebot.arrays import Floats, Ints
from snakebot.physics import servo_layout as layout
from snakebot.physics.compiled import in_place
from snakebot.physics.servo import is_free, servo_step
from snakebot.physics.servo_chain import end_of_step, interpolate, plain
from snakebot.physics.servo_first_order import is_first_order, run_first_order
from snakebot.physics.servo_layout import OUTPUT, PARAMETERS, SOURCE, STATES, TIME_GRAIN_S

_NO_ROWS = np.zeros((0, 0))
_NO_LOAD = np.zeros(0)


def run_apart(
    params: Floats,
    angle_rad: Floats,
    joints: Ints,
    t_s: Sequence[Floats],
    switch_s: Sequence[Floats],
    setpoint_rad: Sequence[Floats],
    *,
    grid_s: float,
    late_s: Floats | None = None,
    load_nm: Sequence[Floats] | None = None,
    known_rad: Sequence[Floats | None] | None = None,
) -> tuple[list[Floats], list[Floats]]:
    """Joint angles (T, joints) of each run, and the torques that the servos felt; NaN for joints not asked for.

    All runs are one call of the compiled loop: a session may have a hundred of a second each.

    Args:
        params: (joints, PARAMETERS) of ``servo_layout``.
        angle_rad: (runs, joints) at the first time, at rest.
        joints: 0-based, those that are asked for.
        t_s: (T,) times of each run, not falling; what sags with time does so from the first on.
        switch_s: (M,) of each run, rising: when each set-point comes into force.
        setpoint_rad: (M, joints) of each run.
        grid_s: longest step of servos whose closed forms do not hold over a whole set-point.
        late_s: (joints,) how much later than ``switch_s`` the set-points of each joint's source come into force.
        load_nm: (T, joints) of each run, torques on the servos that are known.
        known_rad: (T, joints) of runs in which an unpowered joint takes these angles where they are not NaN.
    """
    k = params.shape[0]
    ends = np.cumsum([t.size for t in t_s])
    known = _NO_ROWS
    if known_rad is not None and any(table is not None for table in known_rad):
        known = np.concatenate(
            [np.full((t.size, k), np.nan) if a is None else a for t, a in zip(t_s, known_rad, strict=True)]
        )
    angle, felt = np.full((ends[-1], k), np.nan), np.full((ends[-1], k), np.nan)
    longest = max(t.size for t in t_s)
    _run_apart(
        plain(params), layout.state_at_rest(angle_rad.ravel()).reshape(-1, k, STATES),
        layout.holding_setpoint_rad(params, angle_rad), layout.fine_joints(params), joints,
        ends, plain(np.concatenate(t_s)), np.cumsum([t.size for t in switch_s]), plain(np.concatenate(switch_s)),
        plain(np.concatenate(setpoint_rad)), grid_s, np.zeros(k) if late_s is None else plain(late_s),
        _NO_ROWS if load_nm is None else plain(np.concatenate(load_nm)), plain(known), np.zeros((1, PARAMETERS)),
        np.zeros((1, STATES)), np.zeros((2, 1)), np.zeros(longest), np.zeros((longest, 1)), angle, felt,
    )  # fmt: skip
    return np.split(angle, ends[:-1]), np.split(felt, ends[:-1])


@in_place
def _run_apart(
    params: Any, states: Any, holding: Any, fine: Any, joints: Any, ends: Any, t_all: Any, switch_ends: Any,
    switch_t_all: Any, switch_u_all: Any, grid: float, late: Any, load_given: Any, known: Any, p: Any, s: Any,
    felt: Any, times: Any, torques: Any, out_angle: Any, out_load: Any,
) -> None:  # fmt: skip
    """``p``, ``s``, ``felt``, ``times`` and ``torques`` are scratch, of one joint in one run."""
    setpoint, load = felt[0], felt[1]
    loaded = load_given.shape[0] > 0
    first, first_switch = 0, 0
    for run in range(ends.size):
        t_out = t_all[first : ends[run]]
        switch_t = switch_t_all[first_switch : switch_ends[run]]
        switch_u = switch_u_all[first_switch : switch_ends[run]]
        torque = torques[: t_out.size if loaded else 0]
        own_t = times[: t_out.size]
        for j in joints:
            source = int(params[j, SOURCE])
            wanted = switch_u[:, source]
            if is_first_order(params[j]) and not _any_is_nan(wanted):
                run_first_order(
                    params[j], states[run, j, OUTPUT], holding[run, source], late[source],
                    t_out, load_given[first : ends[run], j] if loaded else _NO_LOAD, switch_t, wanted,
                    out_angle[first : ends[run], j], out_load[first : ends[run], j],
                )  # fmt: skip
                continue
            _copy(params[j], p[0])
            _copy(states[run, j], s[0])
            p[0, SOURCE] = 0.0
            setpoint[0], load[0] = holding[run, source], 0.0
            for row in range(t_out.size):
                own_t[row] = t_out[row] - late[source]
            for row in range(torque.shape[0]):
                torque[row, 0] = load_given[first + row, j]
            now, start = own_t[0], own_t[0]
            coming, at, steps = 0, 0, 0.0
            for row in range(own_t.size):
                while True:
                    while coming < switch_t.size and switch_t[coming] <= now + TIME_GRAIN_S:
                        setpoint[0] = switch_u[coming, source]
                        coming += 1
                    if own_t[row] <= now + TIME_GRAIN_S:
                        break
                    mark = start + (steps + 1.0) * grid if fine[j] else math.inf
                    until, tick = end_of_step(own_t[row], switch_t, coming, mark)
                    if loaded:
                        at = interpolate(own_t, torque, 0.5 * (now + until), at, load)
                    servo_step(s, p, setpoint, load, now - start, until - now)
                    now = until
                    if tick:
                        steps += 1.0
                if known.shape[0] > 0 and is_free(p, setpoint, 0) and not math.isnan(known[first + row, j]):
                    s[0, OUTPUT] = known[first + row, j]
                out_angle[first + row, j] = s[0, OUTPUT]
                out_load[first + row, j] = load[0]
        first, first_switch = ends[run], switch_ends[run]


@in_place
def _any_is_nan(values: Any) -> bool:
    found = False
    for value in values:
        found = found or math.isnan(value)
    return found


@in_place
def _copy(source: Any, target: Any) -> None:
    for i in range(target.size):
        target[i] = source[i]
