"""The chain of ``snakebot.physics`` built a second and a third time, to test it against and to measure it by.

``PaperChain``: the paper's equations as printed (14)-(25), dense matrices, plain numpy, any ODE solver of scipy.
``MujocoChain``: the same links in MuJoCo, with the ground's forces applied as generalised forces by a compiled
function, and the whole loop compiled around MuJoCo's own ``mj_step``.

Neither shares code with the kernels of snakebot beyond the ``ChainModel`` that holds the numbers.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit

from snakebot.physics import ChainModel

GRAVITY_M_S2 = 9.80665


class PaperChain:
    """Equations (14)-(25) for equal links; the misprints that model.md lists are put right.

    State u: w_x, w_y, psi (mean link angle), phi of driven-by-torque joints, and the rates of all these. Joints in
    ``prescribed`` follow ``reference(t) -> (phi, dphi, ddphi)``, each (n-1,); the others feel ``torque(t, phi, dphi)``.
    """

    def __init__(
        self,
        model: ChainModel,
        reference: Callable[[float], tuple[Any, Any, Any]],
        prescribed: np.ndarray[Any, Any] | None = None,
        torque: Callable[[float, Any, Any], Any] | None = None,
    ) -> None:
        n = model.links
        self.model, self.reference, self.n = model, reference, n
        self.torque = torque
        mask = np.ones(n - 1, dtype=bool) if prescribed is None else np.asarray(prescribed, dtype=bool)
        self.moving = np.flatnonzero(~mask)
        D = np.eye(n - 1, n) - np.eye(n - 1, n, 1)
        A = np.eye(n - 1, n) + np.eye(n - 1, n, 1)
        self.m, self.l = model.mass[0], model.half_length[0]
        if np.ptp(model.mass) or np.ptp(model.half_length):
            raise ValueError("the paper's equations are for equal links")
        self.J = model.inertia[0]
        self.G = -self.l * D.T @ np.linalg.inv(D @ D.T) @ A
        self.H = self.m * self.G.T @ self.G
        below = np.vstack([np.zeros(n - 1), np.tril(np.ones((n - 1, n - 1)))])
        self.from_joints = below - below.mean(axis=0)  # theta = psi + from_joints phi
        # columns: d theta / d (psi, moving joints)
        self.L = np.column_stack([np.ones(n), self.from_joints[:, self.moving]])

    @property
    def size(self) -> int:
        return 2 * (3 + self.moving.size)

    def joints(self, t: float, u: Any) -> tuple[Any, Any, Any]:
        k = self.moving.size
        phi, dphi, ddphi = (np.array(v, dtype=float) for v in self.reference(t))
        phi[self.moving] = u[3 : 3 + k]
        dphi[self.moving] = u[6 + k :]
        ddphi[self.moving] = 0.0
        return phi, dphi, ddphi

    def rates(self, t: float, u: Any) -> Any:
        """du/dt."""
        model, k = self.model, self.moving.size
        phi, dphi, ddphi = self.joints(t, u)
        theta = u[2] + self.from_joints @ phi
        omega = u[5 + k] + self.from_joints @ dphi
        known = self.from_joints @ ddphi
        s, c = np.sin(theta), np.cos(theta)
        S, C = np.diag(s), np.diag(c)
        vx = u[3 + k] - self.G @ (s * omega)
        vy = u[4 + k] + self.G @ (c * omega)
        vt, vn = c * vx + s * vy, -s * vx + c * vy
        ft = -model.ct * vt - model.ct0 * np.tanh(vt / model.eps)
        fn = -model.cn * vn - model.cn0 * np.tanh(vn / model.eps)
        fx, fy = c * ft - s * fn, s * ft + c * fn
        M = self.J * np.eye(self.n) + S @ self.H @ S + C @ self.H @ C
        V = (S @ self.H @ C - C @ self.H @ S) @ omega**2
        Q = -s * (self.G.T @ fx) + c * (self.G.T @ fy) - model.rotational_drag * omega
        force = self.L.T @ (Q - V - M @ known)
        if self.torque is not None:
            force[1:] += self.torque(t, phi, dphi)[self.moving]
        generalised = np.linalg.solve(self.L.T @ M @ self.L, force)
        ax = fx.sum() / (self.n * self.m) - GRAVITY_M_S2 * math.sin(model.slope_rad)
        ay = fy.sum() / (self.n * self.m)
        return np.concatenate([u[3 + k :], [ax, ay], generalised])

    def solve(self, t_s: Any, u0: Any, **options: Any) -> Any:
        """States (T, size) at times t_s, with scipy's solve_ivp."""
        from scipy.integrate import solve_ivp

        options = {"method": "LSODA", "rtol": 1e-6, "atol": 1e-9} | options
        answer = solve_ivp(self.rates, (t_s[0], t_s[-1]), u0, t_eval=t_s, **options)
        if not answer.success:
            raise RuntimeError(answer.message)
        return answer.y.T


def gait_reference(
    alpha: float, beta: float, omega: float, joints: int
) -> Callable[[float], tuple[Any, Any, Any]]:
    """(27) with its amplitude ramped in over one cycle by 10 s^3 - 15 s^4 + 6 s^5."""
    i = np.arange(joints)
    period = 2 * math.pi / omega

    def reference(t: float) -> tuple[Any, Any, Any]:
        s = min(t / period, 1.0)
        r = s**3 * (10 - 15 * s + 6 * s * s)
        dr = 30 * (s * (1 - s)) ** 2 / period
        ddr = 60 * s * (1 - s) * (1 - 2 * s) / period**2
        f = alpha * np.sin(omega * t + i * beta)
        df = alpha * omega * np.cos(omega * t + i * beta)
        return r * f, dr * f + r * df, ddr * f + 2 * dr * df - r * omega**2 * f

    return reference


def mujoco_xml(model: ChainModel, dt_s: float, rigid: dict[int, float], integrator: str) -> str:
    """Link 1 slides and turns freely in the plane; each further link hangs on the one before by a hinge, or rigidly."""
    slope = model.slope_rad
    lines = [
        "<mujoco>",
        f'<option timestep="{dt_s!r}" integrator="{integrator}" '
        f'gravity="{-GRAVITY_M_S2 * math.sin(slope)!r} 0 0"><flag contact="disable"/></option>',
        "<worldbody>",
    ]
    for i in range(model.links):
        half, m, J = float(model.half_length[i]), float(model.mass[i]), float(model.inertia[i])
        if i == 0:
            lines.append(
                '<body pos="0 0 0"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>'
            )
            lines.append('<joint type="hinge" axis="0 0 1"/>')
        else:
            turn = math.degrees(rigid.get(i, 0.0))
            place = 2 * float(model.half_length[i - 1]) if i > 1 else float(model.half_length[0])
            lines.append(f'<body pos="{place!r} 0 0" euler="0 0 {turn!r}">')
            if i not in rigid:
                lines.append(f'<joint name="j{i}" type="hinge" axis="0 0 1"/>')
        centre = half if i > 0 else 0.0
        lines.append(
            f'<inertial pos="{centre!r} 0 0" mass="{m!r}" diaginertia="{J!r} {J!r} {J!r}"/>'
            f'<geom type="sphere" size="0.001" pos="{centre!r} 0 0" contype="0" conaffinity="0"/>'
        )
    lines.append("</body>" * model.links + "</worldbody></mujoco>")
    return "\n".join(lines)


class MujocoChain:
    """A MuJoCo chain that does a gait. Free joints feel nothing, rigid ones are welded, the others have a PD servo.

    The servo's torque kp (ref - phi) + kd (dref - dphi) and the ground's force are generalised forces of the state at
    the start of each step, which is what MuJoCo's Euler integrator asks for. The torque is cut off at ``limit_nm`` and
    at the motor's line from ``stall_nm`` at rest through 0 at ``no_load_rad_s``.
    """

    def __init__(
        self,
        model: ChainModel,
        *,
        dt_s: float,
        kp: float,
        kd: float,
        free: tuple[int, ...] = (),
        rigid: dict[int, float] | None = None,
        integrator: str = "Euler",
        limit_nm: float = math.inf,
        stall_nm: float = math.inf,
        no_load_rad_s: float = math.inf,
    ) -> None:
        import mujoco

        self.model, self.dt_s = model, dt_s
        self.rigid = dict(rigid or {})
        self._m = mujoco.MjModel.from_xml_string(mujoco_xml(model, dt_s, self.rigid, integrator))
        self.data = mujoco.MjData(self._m)
        self.kp, self.kd = np.full(model.joints, kp), np.full(model.joints, kd)
        self.motor = np.array([limit_nm, stall_nm, no_load_rad_s])
        for j in (*free, *self.rigid):
            self.kp[j - 1] = self.kd[j - 1] = 0.0
        self.dof = np.full(model.joints, -1)
        moving = [j for j in range(model.joints) if j + 1 not in self.rigid]
        self.dof[moving] = 3 + np.arange(len(moving))
        self.stuck = np.array([self.rigid.get(j + 1, 0.0) for j in range(model.joints)])
        library = ctypes.CDLL(str(next(Path(mujoco.__file__).parent.glob("libmujoco.so*"))))
        self._step = library.mj_step
        self._step.argtypes = (ctypes.c_void_p, ctypes.c_void_p)
        self._step.restype = None

    def put_down(self) -> None:
        """At rest, straight but for rigid joints, centre of mass in the origin, mean link angle 0."""
        import mujoco

        mujoco.mj_resetData(self._m, self.data)
        row = np.zeros(5)
        self.data.qpos[2] = -np.mean(np.concatenate(([0.0], np.cumsum(self.stuck))))
        _pose(self.data.qpos, self.data.qvel, self.dof, self.stuck, self.model.packed, row)
        self.data.qpos[0:2] -= row[0:2]

    def run(self, gait: tuple[float, float, float], steps: int, every: int) -> np.ndarray[Any, Any]:
        """Rows (t, com_x, com_y, psi, power_in, power_dissipated) every ``every`` steps; powers are means."""
        self.put_down()
        out = np.zeros((steps // every, 6))
        _mujoco_loop(
            self._step, self._m._address, self.data._address, self.data.qpos, self.data.qvel, self.data.qfrc_applied,
            self.dof, self.stuck, self.kp, self.kd, self.motor, self.model.packed, self.model.eps, np.array(gait),
            self.dt_s, steps, every, out,
        )  # fmt: skip
        return out


@njit(cache=True)
def _mujoco_loop(
    mj_step: Any, m: Any, d: Any, qpos: Any, qvel: Any, applied: Any, dof: Any, stuck: Any, kp: Any, kd: Any,
    motor: Any, links: Any, eps: float, gait: Any, dt: float, steps: int, every: int, out: Any,
) -> None:  # fmt: skip
    k = dof.size
    alpha, beta, omega = gait[0], gait[1], gait[2]
    pose = np.zeros(5)
    forces = np.zeros((3, k + 1))
    power_in = lost = 0.0
    for i in range(steps):
        t = i * dt
        lost += _ground(qpos, qvel, dof, stuck, links, eps, applied, forces)
        s = min(t * omega / (2 * math.pi), 1.0)
        r = s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
        dr = 30.0 * (s * (1.0 - s)) ** 2 * omega / (2 * math.pi)
        for j in range(k):
            if dof[j] >= 0 and kp[j] > 0.0:
                f = alpha * math.sin(omega * t + j * beta)
                df = alpha * omega * math.cos(omega * t + j * beta)
                u = kp[j] * (r * f - qpos[dof[j]]) + kd[j] * (dr * f + r * df - qvel[dof[j]])
                speed = qvel[dof[j]] / motor[2]
                u = min(max(u, -motor[1] * (1.0 + speed)), motor[1] * (1.0 - speed))
                u = min(max(u, -motor[0]), motor[0])
                applied[dof[j]] += u
                power_in += u * qvel[dof[j]]
        mj_step(m, d)
        if (i + 1) % every == 0:
            row = (i + 1) // every - 1
            _pose(qpos, qvel, dof, stuck, links, pose)
            out[row, 0] = (i + 1) * dt
            out[row, 1:4] = pose[0:3]
            out[row, 4] = power_in / every
            out[row, 5] = lost / every
            power_in = lost = 0.0


@njit(cache=True)
def _pose(qpos: Any, qvel: Any, dof: Any, stuck: Any, links: Any, out: Any) -> None:
    """Centre of mass and mean link angle."""
    n = dof.size + 1
    x, y, angle = qpos[0], qpos[1], qpos[2]
    total = mx = my = ma = 0.0
    for i in range(n):
        if i > 0:
            x += links[1, i - 1] * math.cos(angle)
            y += links[1, i - 1] * math.sin(angle)
            angle += qpos[dof[i - 1]] if dof[i - 1] >= 0 else stuck[i - 1]
            x += links[1, i] * math.cos(angle)
            y += links[1, i] * math.sin(angle)
        total += links[0, i]
        mx += links[0, i] * x
        my += links[0, i] * y
        ma += angle
    out[0] = mx / total
    out[1] = my / total
    out[2] = ma / n


@njit(cache=True)
def _ground(
    qpos: Any, qvel: Any, dof: Any, stuck: Any, links: Any, eps: float, applied: Any, forces: Any
) -> float:
    """Generalised forces of the ground, by virtual work: link by link, then summed towards link 1."""
    n = dof.size + 1
    x, y, angle = qpos[0], qpos[1], qpos[2]
    vx, vy, rate = qvel[0], qvel[1], qvel[2]
    fx_all = fy_all = moment_all = 0.0
    lost = 0.0
    for v in range(applied.size):
        applied[v] = 0.0
    for i in range(n):
        if i > 0:
            half = links[1, i - 1]
            x += half * math.cos(angle)
            y += half * math.sin(angle)
            vx -= half * math.sin(angle) * rate
            vy += half * math.cos(angle) * rate
            forces[0, i] = x
            forces[1, i] = y
            if dof[i - 1] >= 0:
                angle += qpos[dof[i - 1]]
                rate += qvel[dof[i - 1]]
            else:
                angle += stuck[i - 1]
            half = links[1, i]
            x += half * math.cos(angle)
            y += half * math.sin(angle)
            vx -= half * math.sin(angle) * rate
            vy += half * math.cos(angle) * rate
        c, s = math.cos(angle), math.sin(angle)
        vt, vn = c * vx + s * vy, c * vy - s * vx
        ft, fn, moment = -links[3, i] * vt, -links[4, i] * vn, -links[7, i] * rate
        if links[5, i] > 0.0:
            ft -= links[5, i] * math.tanh(vt / eps)
        if links[6, i] > 0.0:
            fn -= links[6, i] * math.tanh(vn / eps)
        lost -= ft * vt + fn * vn + moment * rate
        fx, fy = c * ft - s * fn, s * ft + c * fn
        fx_all += fx
        fy_all += fy
        moment_all += moment + (x - qpos[0]) * fy - (y - qpos[1]) * fx
        # every joint before this link feels its moment about the joint
        for j in range(i):
            if dof[j] >= 0:
                applied[dof[j]] += moment + (x - forces[0, j + 1]) * fy - (y - forces[1, j + 1]) * fx
    applied[0] = fx_all
    applied[1] = fy_all
    applied[2] = moment_all
    return lost
