"""Servo electronics and motors, step by step beside MuJoCo: everything between a set-point and a joint's torque.

A servo wakes at its own rate, reads its own counter and computes in integers: error and change of error times whole
gains, shifted right, cut at full duty. Duty below the dead zone moves nothing. The winding has a time constant; a
battery with internal resistance feeds all motors.
"""

from __future__ import annotations

import ctypes
import math
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit

from blind_wheels.body import DT_S, TIGHT_RAD, Body, Floats, mjcf

SHAFT_COUNTS = 16384  # a turn, of the counter inside the servo
FULL_DUTY = 1000
RUNAWAY_M_S = 20.0  # no snake is that fast: the simulation has become unstable
SHIFT = 8  # bits that a product of gain and counts is shifted right

# Rows of the table of joints (row, joint).
ROWS = (
    "kp", "kd", "period_s", "phase_s", "dead_zone", "ohm", "tau_s", "kt_nm_a", "ratio", "heat_k", "warming_k_a2s",
    "trim_rad", "play_rad", "worn_rad", "worn_at_rad", "worn_width_rad",
)  # fmt: skip
(
    KP, KD, PERIOD, PHASE, DEAD_ZONE, OHM, TAU, KT, RATIO, HEAT, WARMING, TRIM, PLAY, WORN, WORN_AT, WORN_WIDTH,
) = range(len(ROWS))  # fmt: skip
# What a servo remembers (row, joint).
CURRENT, DUTY, BEFORE, NEXT, KELVIN, HELD = range(6)
COPPER_1_K = 0.0039  # change of a winding's resistance
MAGNET_1_K = 0.002  # loss of a ferrite magnet
# The battery: volts at rest, internal resistance, what the electronics draw.
VOLTS, INNER_OHM, IDLE_A = range(3)
# Bearings: (row, wheel).
DRY, STRIBECK, STRIBECK_RAD_S = range(3)


class Driven:
    """One robot body with its motors; ``run`` starts from rest, straight."""

    def __init__(self, body: Body) -> None:
        import mujoco

        self.body, self._mujoco = body, mujoco
        self.model = mujoco.MjModel.from_xml_string(mjcf(body))
        if body.floor_m is not None:
            top = max(float(np.max(body.floor_m)), 1e-6)
            self.model.hfield_data[:] = (body.floor_m / top).ravel()
        m, k = self.model, body.links - 1
        self._q = np.array([m.joint(f"servo_{j}").qposadr[0] for j in range(k)])
        self._v = np.array([m.joint(f"servo_{j}").dofadr[0] for j in range(k)])
        loose = [j in body.second_hinge for j in range(k)]
        self._play = np.array([m.joint(f"play_{j}").id if loose[j] else -1 for j in range(k)])
        self._play_q = np.array([m.joint(f"play_{j}").qposadr[0] if loose[j] else -1 for j in range(k)])
        self._spin = np.array(
            [m.joint(f"spin_{i}_{s}").dofadr[0] for i in range(body.links) for s in (0, 1)], dtype=np.int64
        )
        wheel = [m.body(f"wheel_{i}_0").id for i in range(body.links)]
        self._link = np.array(m.body_parentid[wheel], dtype=np.int64)
        library = ctypes.CDLL(str(next(Path(mujoco.__file__).parent.glob("libmujoco.so*"))))
        self._step = library.mj_step
        self._step.argtypes = (ctypes.c_void_p, ctypes.c_void_p)
        self._step.restype = None

    def run(
        self, joints: Floats, battery: Floats, bearings: Floats, arrival_s: Floats, setpoint_rad: Floats,
        sample_s: Floats, gaps: Floats, push: Floats | None = None,
    ) -> tuple[Floats, Floats, Floats]:  # fmt: skip
        """Joint angles (T, k), pose (T, 3) of the centre of mass, and what a scale shows (T, 2) at ``sample_s``.

        Set-points take hold at ``arrival_s``, rising. ``gaps``: (g, 3) joint, begin and end of moments without
        contact at its connector. ``push``: a speed (vx, vy), m/s, at which the robot is led by the hand, all links
        alike, with the scale in between; its yaw is held.
        """
        data = self._mujoco.MjData(self.model)
        self._mujoco.mj_forward(self.model, data)
        k = joints.shape[1]
        angle, pose, force = (
            np.zeros((sample_s.size, k)),
            np.zeros((sample_s.size, 3)),
            np.zeros((sample_s.size, 2)),
        )
        state = np.zeros((6, k))
        state[NEXT] = joints[PHASE]
        state[KELVIN] = joints[HEAT]
        lead = np.array([0.0, 0.0, 0.0]) if push is None else np.array([1.0, push[0], push[1]])
        _loop(
            self._step, self.model._address, data._address, data.qpos, data.qvel, data.qfrc_applied,
            data.subtree_com, self.model.jnt_range, self.model.dof_frictionloss, self._q, self._v, self._play,
            self._play_q, self._spin, np.ascontiguousarray(joints), battery, bearings,
            np.ascontiguousarray(arrival_s), np.ascontiguousarray(setpoint_rad), np.ascontiguousarray(sample_s),
            gaps, lead, data.xfrc_applied, self._link, self.body.mass_kg, DT_S, angle, pose, force, state,
        )  # fmt: skip
        if not (np.isfinite(angle).all() and np.isfinite(pose).all()):
            raise FloatingPointError("the robot on wheels blew up")
        pose[:, :2] -= pose[0, :2]
        pose[:, 2] = np.unwrap(pose[:, 2])
        return angle, pose, force


@njit(cache=True)
def _heading(qpos: Any) -> float:
    w, x, y, z = qpos[3], qpos[4], qpos[5], qpos[6]
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


@njit(cache=True)
def _loop(
    mj_step: Any, m: Any, d: Any, qpos: Any, qvel: Any, applied: Any, com: Any, limits: Any, loss: Any, at_q: Any,
    at_v: Any, play: Any, play_q: Any, spin: Any, P: Any, battery: Any, bearings: Any, arrival: Any, setpoint: Any,
    sample: Any, gaps: Any, lead: Any, pushed: Any, link: Any, share_kg: Any,
    dt: float, angle: Any, pose: Any, force: Any, S: Any,
) -> None:  # fmt: skip
    k = P.shape[1]
    following = recorded = 0
    t = 0.0
    drawn = battery[IDLE_A]
    count = 2.0 * math.pi / SHAFT_COUNTS
    while recorded < sample.size:
        while following < arrival.size and arrival[following] <= t:
            S[HELD, :] = setpoint[following]
            following += 1
        while recorded < sample.size and sample[recorded] < t + dt:
            total = bent = 0.0
            for j in range(k):
                q = qpos[at_q[j]]
                if play[j] >= 0:
                    q += qpos[play_q[j]]
                angle[recorded, j] = q
                bent += q
                total += bent
            pose[recorded, 0], pose[recorded, 1] = com[1, 0], com[1, 1]
            pose[recorded, 2] = _heading(qpos) + total / (k + 1)
            force[recorded, 0] = pushed[link, 0].sum()
            force[recorded, 1] = pushed[link, 1].sum()
            recorded += 1
        volts = max(battery[VOLTS] - battery[INNER_OHM] * drawn, 0.2 * battery[VOLTS])
        drawn = battery[IDLE_A]
        for j in range(k):
            q, w = qpos[at_q[j]], qvel[at_v[j]]
            alive = True
            for g in range(gaps.shape[0]):
                if int(gaps[g, 0]) == j and gaps[g, 1] <= t < gaps[g, 2]:
                    alive = False
            if t >= S[NEXT, j]:
                S[NEXT, j] += P[PERIOD, j]
                error = math.floor((S[HELD, j] + P[TRIM, j]) / count + 0.5) - math.floor(q / count)
                change = error - int(S[BEFORE, j])
                S[BEFORE, j] = error
                duty = (int(P[KP, j]) * error + int(P[KD, j]) * change) >> SHIFT
                S[DUTY, j] = min(max(duty, -FULL_DUTY), FULL_DUTY)
            kt = P[KT, j] * (1.0 - MAGNET_1_K * S[KELVIN, j])
            ohm = P[OHM, j] * (1.0 + COPPER_1_K * S[KELVIN, j])
            if alive:
                share = S[DUTY, j] / FULL_DUTY
                if abs(S[DUTY, j]) < P[DEAD_ZONE, j]:
                    share = 0.0
                steady = (volts * share - kt * P[RATIO, j] * w) / ohm
                S[CURRENT, j] += (steady - S[CURRENT, j]) * (1.0 - math.exp(-dt / P[TAU, j]))
                drawn += max(share * S[CURRENT, j], 0.0)
            else:
                S[CURRENT, j] = 0.0
            S[KELVIN, j] += dt * P[WARMING, j] * S[CURRENT, j] * S[CURRENT, j]
            applied[at_v[j]] = kt * P[RATIO, j] * S[CURRENT, j]
            if play[j] >= 0:
                near = (q - P[WORN_AT, j]) / max(P[WORN_WIDTH, j], 1e-6)
                wide = TIGHT_RAD + 0.5 * (P[PLAY, j] + P[WORN, j] * math.exp(-0.5 * near * near))
                limits[play[j], 0], limits[play[j], 1] = -wide, wide
        for i in range(spin.size):
            speed = qvel[spin[i]] / bearings[STRIBECK_RAD_S, i]
            loss[spin[i]] = bearings[DRY, i] + bearings[STRIBECK, i] * math.exp(-speed * speed)
        if lead[0] > 0.0:
            turn = -5.0 * _heading(qpos) - 0.05 * qvel[5]
            for i in range(link.size):  # each link by its share, so that none is bent
                pushed[link[i], 0] = 60.0 * share_kg[i] * (lead[1] - qvel[0])
                pushed[link[i], 1] = 60.0 * share_kg[i] * (lead[2] - qvel[1])
                pushed[link[i], 5] = share_kg[i] * turn
        mj_step(m, d)
        t += dt
        if not abs(qvel[0]) + abs(qvel[1]) < RUNAWAY_M_S:
            angle[:] = math.nan
            return
