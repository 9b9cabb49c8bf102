"""A chain on the ground in MuJoCo, with its servos: everything that moves, compiled into one loop.

Each joint is two bodies: a rotor, driven by the motor, and the output, which is MuJoCo's hinge. They touch through the
gear's play: a spring and damper on either side of the gap. The ground acts on every link as an external force.
"""

from __future__ import annotations

import ctypes
import math
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]

GRAVITY_M_S2 = 9.80665
DT_S = 2e-4
GROUND_EPS_M_S = 0.001  # over which the sign of a sliding speed turns

# Whatever MuJoCo would look for and not find: forces on this chain are all applied from outside.
OFF = " ".join(
    f'{part}="disable"'
    for part in ("contact", "constraint", "limit", "spring", "damper", "actuation", "sensor", "autoreset")
)

# Rows of the joint table (row, joint).
JOINT_ROWS = (
    "lag_s", "deadband_rad", "rate_plus_rad_s", "rate_minus_rad_s", "rate_drop_per_s", "loop_nm_s_rad",
    "integral_nm_rad", "stall_nm", "no_load_rad_s", "torque_limit_nm", "rotor_kg_m2", "coulomb_nm", "bristle_nm_rad",
    "viscous_nm_s_rad", "play_rad", "gear_nm_rad", "gear_nm_s_rad", "offset_rad", "eccentric_rad", "eccentric_turns",
    "eccentric_phase_rad", "natural_rad_s", "damping", "free", "stuck", "stuck_rad", "mount_gain_rad_nm",
    "mount_rad_s",
)  # fmt: skip
(
    LAG, DEADBAND, RATE_PLUS, RATE_MINUS, RATE_DROP, LOOP, INTEGRAL, STALL, NO_LOAD, TORQUE_LIMIT, ROTOR, COULOMB,
    BRISTLE, VISCOUS, PLAY, GEAR_K, GEAR_D, OFFSET, ECC, ECC_N, ECC_PHASE, NATURAL, DAMPING, FREE, STUCK, STUCK_AT,
    MOUNT_GAIN, MOUNT_W,
) = range(len(JOINT_ROWS))  # fmt: skip

# Rows of the link table (row, link).
LINK_ROWS = ("mass_kg", "half_length_m", "ct", "cn", "ct0", "cn0")
MASS, HALF, CT, CN, CT0, CN0 = range(len(LINK_ROWS))

# What a servo remembers from step to step (row, joint); and of the whole chain: time, pull of all motors.
STATE_ROWS = ("motor_rad", "rate_rad_s", "integral_nm", "bristle_rad", "shaped_rad", "shaped_rad_s", "mount_rad",
              "mount_rad_s", "held_rad")  # fmt: skip
MOTOR, RATE, INTEGRAL_STATE, BRISTLE_STATE, SHAPED, SHAPED_RATE, SWAY, SWAY_RATE, HELD = range(
    len(STATE_ROWS)
)

# The ground as a whole: share of gravity along +x and +y, height and wave number of its bumps, sag of the supply.
GROUND = ("slope_rad", "bump_m", "bump_rad_m", "bump_phase_rad", "sag_per_nm")


def chain_xml(links: Floats) -> str:
    """MJCF of a planar chain: link 1 slides and turns freely, each further link hangs on the one before."""
    out = [
        f'<mujoco><option timestep="{DT_S!r}" integrator="Euler" gravity="0 0 0">'
        f"<flag {OFF}/></option><worldbody>"
    ]
    for i in range(links.shape[1]):
        mass, half = float(links[MASS, i]), float(links[HALF, i])
        inertia = mass * half**2 / 3
        if i == 0:
            out.append('<body><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>')
        else:
            before = float(links[HALF, i - 1]) * (1 if i == 1 else 2)
            out.append(f'<body pos="{before!r} 0 0">')
        at = half if i else 0.0
        out.append(
            f'<joint type="hinge" axis="0 0 1"/><inertial pos="{at!r} 0 0" mass="{mass!r}" '
            f'diaginertia="{inertia!r} {inertia!r} {inertia!r}"/>'
            f'<geom type="sphere" size="0.001" pos="{at!r} 0 0" contype="0" conaffinity="0"/>'
        )
    return "".join(out) + "</body>" * len(links[0]) + "</worldbody></mujoco>"


class Chain:
    """One robot body; ``run`` starts from rest, straight, centre of mass in the origin."""

    def __init__(self, links: Floats) -> None:
        import mujoco

        self.links = np.ascontiguousarray(links)
        self._mujoco = mujoco
        self._model = mujoco.MjModel.from_xml_string(chain_xml(links))
        library = ctypes.CDLL(str(next(Path(mujoco.__file__).parent.glob("libmujoco.so*"))))
        self._step = library.mj_step
        self._step.argtypes = (ctypes.c_void_p, ctypes.c_void_p)
        self._step.restype = None

    def run(
        self, joints: Floats, ground: Floats, arrival_s: Floats, setpoint_rad: Floats, sample_s: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Joint angles (T, k), what a swaying mount adds to their readings (T, k), pose (T, 3), at ``sample_s``.

        Set-points take hold at ``arrival_s``, rising; before the first one the servos hold the straight pose.
        """
        return self.start(joints).go_on(joints, ground, arrival_s, setpoint_rad, sample_s)[:3]

    def start(self, joints: Floats) -> Going:
        """The chain at rest, to be moved on bit by bit."""
        data = self._mujoco.MjData(self._model)
        half, mass = self.links[HALF], self.links[MASS]
        centre = np.concatenate(([0.0], np.cumsum(half[:-1] + half[1:])))
        data.qpos[0] = -float(centre @ mass / mass.sum())
        state = np.zeros((len(STATE_ROWS), joints.shape[1]))
        state[MOTOR] = -joints[OFFSET] - joints[ECC] * np.sin(joints[ECC_PHASE])
        stuck = joints[STUCK] > 0
        data.qpos[3:][stuck] = joints[STUCK_AT][stuck]
        return Going(self, data, state)


class Going:
    """A chain on its way. ``state`` and ``moment`` are rows of ``STATE_ROWS`` and (time, pull of all motors)."""

    def __init__(self, chain: Chain, data: Any, state: Floats) -> None:
        self.chain, self.data, self.state = chain, data, state
        self.moment = np.zeros(2)

    def go_on(
        self, joints: Floats, ground: Floats, arrival_s: Floats, setpoint_rad: Floats, sample_s: Floats
    ) -> tuple[Floats, Floats, Floats, int]:
        """As ``Chain.run``, from where it stands to a step past the last sample; also, how many set-points held."""
        data, k = self.data, joints.shape[1]
        angle, sway = np.zeros((sample_s.size, k)), np.zeros((sample_s.size, k))
        pose = np.zeros((sample_s.size, 3))
        taken = _loop(
            self.chain._step, self.chain._model._address, data._address, data.qpos, data.qvel, data.qfrc_applied,
            self.chain.links, np.ascontiguousarray(joints), ground, arrival_s, np.ascontiguousarray(setpoint_rad),
            sample_s, DT_S, angle, sway, pose, self.state, self.moment,
        )  # fmt: skip
        if not (np.isfinite(angle).all() and np.isfinite(pose).all()):
            raise FloatingPointError("the blind robot's simulation blew up")
        return angle, sway, pose, int(taken)


@njit(cache=True)
def _loop(
    mj_step: Any, m: Any, d: Any, qpos: Any, qvel: Any, applied: Any, links: Any, P: Any, ground: Any, arrival: Any,
    setpoint: Any, sample: Any, dt: float, angle: Any, sway: Any, pose: Any, state: Any, moment: Any,
) -> int:  # fmt: skip
    k = P.shape[1]
    motor, rate, integral, bristle = state[MOTOR], state[RATE], state[INTEGRAL_STATE], state[BRISTLE_STATE]
    shaped, shaped_rate = state[SHAPED], state[SHAPED_RATE]
    mount, mount_rate = state[SWAY], state[SWAY_RATE]
    held = state[HELD]
    at = np.zeros((2, k + 1))
    row = np.zeros(3)
    following = recorded = 0
    t, pull = moment  # pull of all motors together, for the supply
    while recorded < sample.size:
        while following < arrival.size and arrival[following] <= t:
            held[:] = setpoint[following]
            following += 1
        while recorded < sample.size and sample[recorded] < t + dt:
            ahead = sample[recorded] - t
            for j in range(k):
                angle[recorded, j] = qpos[3 + j] + ahead * qvel[3 + j]
                sway[recorded, j] = mount[j] + ahead * mount_rate[j]
            _pose(qpos, links, row)
            pose[recorded] = row
            recorded += 1
        _ground(qpos, qvel, links, ground, applied, at)
        sag = max(0.2, 1.0 - ground[4] * pull)
        pull = 0.0
        for j in range(k):
            q, w = qpos[3 + j], qvel[3 + j]
            if P[STUCK, j] > 0.0:
                applied[3 + j] -= 300.0 * (q - P[STUCK_AT, j]) + 1.5 * w
                continue
            if P[FREE, j] > 0.0:
                applied[3 + j] -= 1e-4 * w
                continue
            target = held[j]
            if P[NATURAL, j] > 0.0:  # firmware that shapes the set-point, and a stiff loop behind it
                f = P[NATURAL, j]
                shaped_rate[j] += dt * (
                    f * f * (target - shaped[j]) - 2.0 * P[DAMPING, j] * f * shaped_rate[j]
                )
                shaped[j] += dt * shaped_rate[j]
                target = shaped[j]
            error = target - motor[j]
            wanted = error / P[LAG, j] if abs(error) >= P[DEADBAND, j] else 0.0
            fade = sag * math.exp(-P[RATE_DROP, j] * t) if P[RATE_DROP, j] > 0.0 else sag
            wanted = min(max(wanted, -P[RATE_MINUS, j] * fade), P[RATE_PLUS, j] * fade)
            # LuGre without the Stribeck dip; the bristle is advanced implicitly, which keeps it stable
            hold = max(P[COULOMB, j], 1e-9)
            before = bristle[j]
            bristle[j] = (before + dt * rate[j]) / (1.0 + dt * abs(rate[j]) * P[BRISTLE, j] / hold)
            friction = P[BRISTLE, j] * bristle[j] + P[VISCOUS, j] * rate[j]
            out = motor[j] + P[OFFSET, j]
            if P[ECC, j] > 0.0:
                out += P[ECC, j] * math.sin(P[ECC_N, j] * motor[j] + P[ECC_PHASE, j])
            twist, half = out - q, 0.5 * P[PLAY, j]
            gear = 0.0
            if twist > half:
                gear = max(0.0, P[GEAR_K, j] * (twist - half) + P[GEAR_D, j] * (rate[j] - w))
            elif twist < -half:
                gear = min(0.0, P[GEAR_K, j] * (twist + half) + P[GEAR_D, j] * (rate[j] - w))
            load = (integral[j] - friction - gear) / P[ROTOR, j]
            gain = P[LOOP, j] / P[ROTOR, j]
            after = (rate[j] + dt * (gain * wanted + load)) / (1.0 + dt * gain)
            torque = P[LOOP, j] * (wanted - after) + integral[j]
            speed = rate[j] / (P[NO_LOAD, j] * fade)
            most = max(0.0, min(P[TORQUE_LIMIT, j], P[STALL, j] * fade * (1.0 - speed)))
            least = min(0.0, max(-P[TORQUE_LIMIT, j], -P[STALL, j] * fade * (1.0 + speed)))
            if torque > most or torque < least:
                torque = min(max(torque, least), most)
                after = rate[j] + dt * (torque - friction - gear) / P[ROTOR, j]
            else:
                integral[j] += dt * P[INTEGRAL, j] * (wanted - after)
            pull += abs(torque)
            rate[j] = after
            motor[j] += dt * after
            applied[3 + j] += gear
            if P[MOUNT_W, j] > 0.0:
                f = P[MOUNT_W, j]
                mount_rate[j] += dt * (f * f * (P[MOUNT_GAIN, j] * gear - mount[j]) - 0.1 * f * mount_rate[j])
                mount[j] += dt * mount_rate[j]
        mj_step(m, d)
        t += dt
    moment[0], moment[1] = t, pull
    return following


@njit(cache=True)
def _pose(qpos: Any, links: Any, out: Any) -> None:
    x, y, angle = qpos[0], qpos[1], qpos[2]
    total = mx = my = turn = 0.0
    n = links.shape[1]
    for i in range(n):
        if i > 0:
            x += links[HALF, i - 1] * math.cos(angle)
            y += links[HALF, i - 1] * math.sin(angle)
            angle += qpos[2 + i]
            x += links[HALF, i] * math.cos(angle)
            y += links[HALF, i] * math.sin(angle)
        total += links[MASS, i]
        mx += links[MASS, i] * x
        my += links[MASS, i] * y
        turn += angle
    out[0] = mx / total
    out[1] = my / total
    out[2] = turn / n


@njit(cache=True)
def _sign(speed_m_s: float) -> float:
    """Of a sliding speed, turning over ``GROUND_EPS_M_S``."""
    x = speed_m_s / GROUND_EPS_M_S
    if abs(x) > 12.0:  # where tanh is one to ten digits
        return math.copysign(1.0, x)
    return math.tanh(x)


@njit(cache=True)
def _ground(qpos: Any, qvel: Any, links: Any, ground: Any, applied: Any, at: Any) -> None:
    """Generalised forces of friction, slope and bumps, by virtual work."""
    n = links.shape[1]
    x, y, angle = qpos[0], qpos[1], qpos[2]
    vx, vy, rate = qvel[0], qvel[1], qvel[2]
    down = math.sin(ground[0])
    for v in range(applied.size):
        applied[v] = 0.0
    for i in range(n):
        if i > 0:
            half = links[HALF, i - 1]
            x += half * math.cos(angle)
            y += half * math.sin(angle)
            vx -= half * math.sin(angle) * rate
            vy += half * math.cos(angle) * rate
            at[0, i], at[1, i] = x, y
            angle += qpos[2 + i]
            rate += qvel[2 + i]
            half = links[HALF, i]
            x += half * math.cos(angle)
            y += half * math.sin(angle)
            vx -= half * math.sin(angle) * rate
            vy += half * math.cos(angle) * rate
        c, s = math.cos(angle), math.sin(angle)
        vt, vn = c * vx + s * vy, c * vy - s * vx
        ft = -links[CT, i] * vt - links[CT0, i] * _sign(vt)
        fn = -links[CN, i] * vn - links[CN0, i] * _sign(vn)
        weight = links[MASS, i] * GRAVITY_M_S2
        fx = c * ft - s * fn - weight * down
        fy = s * ft + c * fn
        if ground[1] > 0.0:
            k = ground[2]
            fx -= weight * k * ground[1] * math.cos(k * x + ground[3]) * math.cos(k * y)
            fy += weight * k * ground[1] * math.sin(k * x + ground[3]) * math.sin(k * y)
        applied[0] += fx
        applied[1] += fy
        applied[2] += (x - qpos[0]) * fy - (y - qpos[1]) * fx
        for j in range(i):
            applied[3 + j] += (x - at[0, j + 1]) * fy - (y - at[1, j + 1]) * fx
