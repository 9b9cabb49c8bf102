"""Servos that drive a chain, compiled: one loop serves the simulated board, sample by sample, and a whole run at once.

Time goes on in steps that end at every set-point, every sample and every point of the chain's own grid; on the grid
the chain follows its servos (``servo_grip``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from snakebot.arrays import Floats
from snakebot.physics import rosenbrock
from snakebot.physics import servo_layout as layout
from snakebot.physics.compiled import in_place
from snakebot.physics.model import STANDARD_GRAVITY_M_S2
from snakebot.physics.servo import is_free, servo_step
from snakebot.physics.servo_grip import GRIP_COLUMNS, GRIP_SCRATCH_ROWS, SMOOTHING_S, follow, grips_of
from snakebot.physics.servo_layout import OUTPUT, TIME_GRAIN_S, state_at_rest

if TYPE_CHECKING:
    from snakebot.physics.model import ChainModel


LOAD_FILTER_S = 0.02  # first order, on the torque that a servo feels

_NO_LINKS = np.zeros((8, 0))
_NO_LINKS.setflags(write=False)  # as those of a model: one type, compiled once


class _Body:
    """The state of a chain inside the loop; of none where ``model`` is None."""

    def __init__(
        self, model: ChainModel | None, params: Floats, angle_rad: Floats, pose: npt.ArrayLike
    ) -> None:
        k = 0 if model is None else model.joints
        self.rows = _NO_LINKS if model is None else model.packed
        self.slope = 0.0 if model is None else STANDARD_GRAVITY_M_S2 * math.sin(model.slope_rad)
        self.eps = 1.0 if model is None else model.eps
        self.grips = np.zeros((0, GRIP_COLUMNS)) if model is None else grips_of(params, model)
        self.base = np.zeros(6)  # x, y, heading of the centre of mass, and their rates
        self.base[:3] = pose
        self.angle = angle_rad[:k].copy()
        self.rate, self.torque, self.power = np.zeros(k), np.zeros(k), np.zeros(2)
        self.kind = np.zeros(k, dtype=np.int64)
        self.work, self.stage = rosenbrock.workspace(0 if model is None else model.links)
        self.scratch = np.zeros((GRIP_SCRATCH_ROWS, max(k, 6)))

    def arguments(self) -> tuple[Any, ...]:
        return (
            self.rows, self.slope, self.eps, self.grips, self.kind, self.base, self.angle, self.rate, self.torque,
            self.power, self.work, self.stage, self.scratch,
        )  # fmt: skip


@dataclass
class Samples:
    """What the loop leaves behind at T times; without a chain ``base`` and ``torque`` stay zero."""

    angle: Floats  # (T, joints)
    base: Floats  # (T, 6) x, y, heading of the body and their rates, at the time of the angles
    load: Floats  # (T, joints) torque that the servos felt
    torque: Floats  # (T, joints) of the chain, mean since the sample before
    power: Floats  # (T, 2) put in, lost to the ground, mean since the sample before

    @classmethod
    def zeros(cls, size: int, joints: int) -> Samples:
        return cls(
            np.zeros((size, joints)), np.zeros((size, 6)), np.zeros((size, joints)), np.zeros((size, joints)),
            np.zeros((size, 2)),
        )  # fmt: skip


class DrivenChain:
    """Servos with or without a body, at one moment of time; ``run`` takes them on.

    Args:
        params: (joints, PARAMETERS) of ``servo_layout``. The copy in ``params`` may be changed between two runs in what
            locks a joint.
        angle_rad: (joints,) at the start, at rest.
        model: the body, or None for a bench, or where the body does not matter to the joints.
        pose: x, y, heading at the start.
        grid_s: step of the chain, and longest step of the servos where ``fine``.
        fine: False lets a servo cross the time between two set-points in one step.
    """

    def __init__(
        self,
        params: Floats,
        angle_rad: npt.ArrayLike,
        *,
        model: ChainModel | None = None,
        pose: npt.ArrayLike = (0.0, 0.0, 0.0),
        t_s: float = 0.0,
        grid_s: float = 1e-3,
        fine: bool = True,
    ) -> None:
        joints = params.shape[0]
        self.state = state_at_rest(np.broadcast_to(np.asarray(angle_rad, dtype=np.float64), (joints,)))
        self.setpoint = layout.holding_setpoint_rad(params, self.state[:, OUTPUT])
        self.load = np.zeros(joints)
        self.grid_s = grid_s
        self.t_start_s = t_s
        self._clock = np.array([t_s, 0.0])  # time, number of grid steps done
        self._fine = fine or model is not None
        self._body = _Body(model, params, self.state[:, OUTPUT], pose)
        self.params = np.array(params)
        if model is not None:  # the chain sees to these, see servo_grip
            for column in (
                layout.COULOMB_NM,
                layout.LOOP_COMPLIANCE_RAD_NM,
                layout.COMPLIANCE_RAD_NM,
                layout.LOOP_STIFFNESS_NM_RAD,
            ):
                self.params[:, column] = 0.0
            self.params[layout.loose(params), layout.BACKLASH_RAD] = 0.0
            line = self.params[:, layout.RATE_DROP_PER_NM] > 0
            self.params[line, layout.RATE_LIMIT_RAD_S] = math.inf
            self.params[line, layout.RATE_DROP_PER_NM] = self.params[line, layout.RATE_DROP_PER_S] = 0.0
        self._moving = (
            self._clock, self.t_start_s, self.grid_s, self._fine,
            self.state, self.params, self.setpoint, self.load,
        )  # fmt: skip
        self._body_arguments = self._body.arguments()
        self._until, self._one = np.zeros(1), Samples.zeros(1, joints)
        self._no_times, self._no_rows = np.zeros(0), np.zeros((0, joints))
        self._carried = np.zeros(6)
        _carry_on(self._body.base, self._carried)

    @property
    def t_s(self) -> float:
        return float(self._clock[0])

    @property
    def angle_rad(self) -> Floats:
        angle: Floats = self.state[:, OUTPUT]
        return angle

    @property
    def base(self) -> Floats:
        """(6,) x, y, heading of the centre of mass and their rates, see ``Samples``; zeros on a bench."""
        return self._carried

    def run(
        self,
        t_s: Floats,
        switch_s: Floats,
        setpoint_rad: Floats,
        *,
        since_s: float = 0.0,
        load_t_s: Floats | None = None,
        load_nm: Floats | None = None,
        known_rad: Floats | None = None,
    ) -> Samples:
        """Go through the times ``t_s`` (T,), not falling, none before now.

        Args:
            switch_s: (M,) rising: when each set-point comes into force.
            setpoint_rad: (M, joints).
            since_s: time at which the run began, for what sags with time.
            load_t_s, load_nm: (L,), (L, joints): torques on the servos that are known, where there is no body.
            known_rad: (T, joints) measured angles; an unpowered joint takes them where they are not NaN.
        """
        out = Samples.zeros(t_s.size, self.params.shape[0])
        given = load_nm is not None and load_t_s is not None
        self._go(
            (plain(t_s), plain(switch_s), plain(setpoint_rad), since_s),
            plain(load_t_s if given else self._no_times),
            plain(load_nm if given else self._no_rows),
            plain(self._no_rows if known_rad is None else known_rad),
            out,
        )
        return out

    def go_to(
        self,
        t_s: float,
        switch_s: Floats | None = None,
        setpoint_rad: Floats | None = None,
        *,
        since_s: float = 0.0,
    ) -> Samples:
        """``run`` to one time, for whoever goes on many times a second: the next call overwrites what it returns."""
        out = self._one
        out.torque.fill(0.0)
        out.power.fill(0.0)
        self._until[0] = t_s
        switches = self._no_times if switch_s is None else switch_s
        table = self._no_rows if setpoint_rad is None else setpoint_rad
        self._go((self._until, switches, table, since_s), self._no_times, self._no_rows, self._no_rows, out)
        return out

    def _go(
        self,
        way: tuple[Floats, Floats, Floats, float],
        load_t_s: Floats,
        load_nm: Floats,
        known_rad: Floats,
        out: Samples,
    ) -> None:
        _run(  # type: ignore[call-arg]
            *self._moving, *way, load_t_s, load_nm, known_rad, *self._body_arguments,
            out.angle, out.base, out.load, out.torque, out.power,
        )  # fmt: skip
        if out.base.size:
            self._carried = out.base[-1].copy()


def plain(array: Floats | None) -> Floats:
    """Contiguous and writable, as all others: what is compiled once serves every caller."""
    plain: Floats = np.require(array, dtype=np.float64, requirements=["C", "W"])
    return plain


@in_place
def _run(
    clock: Any, t0: float, grid: float, fine: bool, state: Any, params: Any, setpoint: Any, load: Any,
    t_out: Any, switch_t: Any, switch_u: Any, since: float,
    load_t: Any, load_given: Any, known: Any,
    links: Any, slope: float, eps: float, grips: Any, kind: Any, base: Any, phi: Any, dphi: Any, torque: Any,
    power: Any, work: Any, stage: Any, scratch: Any,
    out_angle: Any, out_base: Any, out_load: Any, out_torque: Any, out_power: Any,
) -> None:  # fmt: skip
    k = state.shape[0]
    has_body = links.shape[1] > 0
    coming = 0  # next set-point
    at = 0  # next known load
    smooth = 1.0 - math.exp(-grid / LOAD_FILTER_S)
    for row in range(t_out.size):
        ticks = 0
        while True:
            now = clock[0]
            while coming < switch_t.size and switch_t[coming] <= now + TIME_GRAIN_S:
                for j in range(k):
                    setpoint[j] = switch_u[coming, j]
                coming += 1
            if t_out[row] <= now + TIME_GRAIN_S:
                break
            mark = t0 + (clock[1] + 1.0) * grid if fine else math.inf
            until, tick = end_of_step(t_out[row], switch_t, coming, mark)
            if load_t.size > 0:
                at = interpolate(load_t, load_given, 0.5 * (now + until), at, load)
            servo_step(state, params, setpoint, load, now - since, until - now)
            clock[0] = until
            if tick:
                clock[1] += 1.0
                if has_body:
                    ticks += 1
                    follow(links, slope, eps, grips, kind, base, phi, dphi, torque, power, work, stage, scratch,
                            until - since, grid, state, params, setpoint, load)  # fmt: skip
                    for a in range(power.size):
                        out_power[row, a] += power[a]
                    for j in range(k):
                        out_torque[row, j] += torque[j]
                        load[j] += smooth * (torque[j] - load[j])
        for j in range(k):
            if known.shape[0] > 0 and is_free(params, setpoint, j) and not math.isnan(known[row, j]):
                state[j, OUTPUT] = known[row, j]
            out_angle[row, j] = state[j, OUTPUT]
            out_load[row, j] = load[j]
        if has_body:
            _carry_on(base, out_base[row])
            if ticks > 0:
                for j in range(k):
                    out_torque[row, j] /= ticks
                for a in range(power.size):
                    out_power[row, a] /= ticks


@in_place
def end_of_step(sample: float, switch_t: Any, coming: int, mark: float) -> tuple[float, bool]:
    """The first of the next sample, the next set-point and the next mark of the grid, and whether it is the mark."""
    until = sample
    if coming < switch_t.size and switch_t[coming] < until:
        until = switch_t[coming]
    return (mark, True) if mark <= until + TIME_GRAIN_S else (until, False)


@in_place
def _carry_on(base: Any, out: Any) -> None:
    """The chain follows its servos late by the delay of the smoothing: carry its pose on to the time of the angles."""
    for a in range(3):
        out[a] = base[a] + 2.0 * SMOOTHING_S * base[a + 3]
        out[a + 3] = base[a + 3]


@in_place
def interpolate(t: Any, values: Any, now: float, at: int, out: Any) -> int:
    """``values`` (T, k) at the time ``now`` into ``out`` (k,), looked for from row ``at``; the row to go on from."""
    while at < t.size - 2 and t[at + 1] < now:
        at += 1
    u = min(max((now - t[at]) / (t[at + 1] - t[at]), 0.0), 1.0) if t.size > 1 else 0.0
    last = min(at + 1, t.size - 1)
    for j in range(out.size):
        out[j] = values[at, j] + u * (values[last, j] - values[at, j])
    return at
