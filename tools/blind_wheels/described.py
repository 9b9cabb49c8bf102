"""What a description says that a robot will do: joints that lag, links that rub. Only used to take sizes and floors.

Written for this check; neither the product's simulation nor the first blind robot's is asked.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from blind_wheels.body import Floats
from blind_wheels.lab import Description

STEP_S = 2.5e-4
SIGN_M_S = 0.002  # of a sliding speed, over which its sign turns


def foretold(about: Description, t_s: Floats, command_rad: Floats) -> tuple[Floats, Floats]:
    """Joint angles (T, k) and pose (T, 3) from rest; the command of a tick holds until the next."""
    angle, pose = np.zeros_like(command_rad), np.zeros((t_s.size, 3))
    friction = np.array([about.ct, about.cn, about.ct0, about.cn0])
    _go(
        np.ascontiguousarray(t_s), np.ascontiguousarray(command_rad), about.lag_s, about.half_length_m, about.mass_kg,
        friction, STEP_S, SIGN_M_S, angle, pose,
    )  # fmt: skip
    return angle, pose


@njit(cache=True)
def _go(
    t: Any, command: Any, lag: float, half: float, mass: float, f: Any, step: float, eps: float, angle: Any, pose: Any
) -> None:  # fmt: skip
    """State: centre of mass, its speed, the first link's heading, angular momentum; joints are as the lag has them."""
    k = command.shape[1]
    n = k + 1
    inertia = mass * half * half / 3.0
    q, dq = np.zeros(k), np.zeros(k)
    rx, ry, ux, uy, turn = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    x = y = vx = vy = head = spin = 0.0
    for tick in range(t.size):
        angle[tick] = q
        bent = total = 0.0
        for j in range(k):
            bent += q[j]
            total += bent
        pose[tick, 0], pose[tick, 1], pose[tick, 2] = x, y, head + total / n
        if tick + 1 == t.size:
            break
        count = max(1, round((t[tick + 1] - t[tick]) / step))
        h = (t[tick + 1] - t[tick]) / count
        keep = math.exp(-h / lag)
        for _ in range(count):
            for j in range(k):
                after = command[tick, j] + (q[j] - command[tick, j]) * keep
                dq[j] = (after - q[j]) / h
                q[j] = after
            # Places and speeds relative to the first link's centre, then to the centre of mass.
            heading = head
            rate = px = py = sx = sy = mx = my = msx = msy = 0.0
            for i in range(n):
                if i > 0:
                    for _half in range(2):
                        if _half == 1:
                            heading += q[i - 1]
                            rate += dq[i - 1]
                        c, s = half * math.cos(heading), half * math.sin(heading)
                        px += c
                        py += s
                        sx -= s * rate
                        sy += c * rate
                rx[i], ry[i], ux[i], uy[i], turn[i] = px, py, sx, sy, rate
                mx += px / n
                my += py / n
                msx += sx / n
                msy += sy / n
            whole = own = 0.0
            for i in range(n):
                rx[i] -= mx
                ry[i] -= my
                ux[i] -= msx
                uy[i] -= msy
                whole += inertia + mass * (rx[i] * rx[i] + ry[i] * ry[i])
                own += inertia * turn[i] + mass * (rx[i] * uy[i] - ry[i] * ux[i])
            swing = (spin - own) / whole
            fx = fy = moment = 0.0
            heading = head
            for i in range(n):
                if i > 0:
                    heading += q[i - 1]
                c, s = math.cos(heading), math.sin(heading)
                wx = vx + ux[i] - swing * ry[i]
                wy = vy + uy[i] + swing * rx[i]
                along, across = c * wx + s * wy, c * wy - s * wx
                a = -f[0] * along - f[2] * math.tanh(along / eps)
                b = -f[1] * across - f[3] * math.tanh(across / eps)
                gx, gy = c * a - s * b, s * a + c * b
                fx += gx
                fy += gy
                moment += rx[i] * gy - ry[i] * gx
            vx += h * fx / (n * mass)
            vy += h * fy / (n * mass)
            spin += h * moment
            x += h * vx
            y += h * vy
            head += h * swing
