"""Motion over ground of a chain all of whose joints follow given angles, compiled.

Such a chain has three unknowns, whatever its length. So the equations of ``kernel`` are summed over the links here, in
axes that turn with the mean link angle: there the shape's own motion is known beforehand, and with it all of a link's
motion but the share of the three. The time step is that of ``rosenbrock``: the same stages, the same results.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from snakebot.arrays import Floats
from snakebot.physics.compiled import in_place, in_place_in_any_order
from snakebot.physics.elementary import sign_over_speed, sine_cosine
from snakebot.physics.kernel import CN, CN0, CR, CT, CT0, HALF, INERTIA, MASS, first_angle
from snakebot.physics.rosenbrock import GAMMA

# Rows of a shape, (SHAPE_ROWS, n), in axes that turn with the mean link angle: direction of each link; along and across
# it the place of its centre from the centre of mass, its velocity, its acceleration; its rate of turn and the change
# of that.
C, S, RT, RN, VT, VN, BT, BN, OMEGA, BA = range(10)
SHAPE_ROWS = 10
# Of a shape as a whole, (SHAPE_SUMS,): moment of inertia about the centre of mass; moment of the links' mass and
# inertia times their accelerations; half the rate at which the moment of inertia changes.
INERTIA_ALL, MOMENT, CHANGE = range(3)
SHAPE_SUMS = 3
# Rows of the links' own part of a stage, (LINK_ROWS, n): speed and acceleration along and across, friction over speed.
ALONG, ACROSS, ACC_ALONG, ACC_ACROSS, RUB_ALONG, RUB_ACROSS = range(6)
LINK_ROWS = 6


@in_place
def _hermite(u: float, h: float, a: Any, b: Any, da: Any, db: Any, phi: Any, dphi: Any, acc: Any) -> None:
    for j in range(a.size):
        step = b[j] - a[j]
        c2 = 3 * step - h * (2 * da[j] + db[j])
        c3 = -2 * step + h * (da[j] + db[j])
        phi[j] = a[j] + u * (h * da[j] + u * (c2 + u * c3))
        dphi[j] = (h * da[j] + u * (2 * c2 + 3 * u * c3)) / h
        acc[j] = (2 * c2 + 6 * u * c3) / (h * h)


@in_place_in_any_order
def _shape(links: Any, phi: Any, dphi: Any, acc: Any, shape: Any, sums: Any) -> None:
    """Fill a shape: the kinematics of ``kernel`` for a centre of mass and a mean link angle that stay zero.

    Written out again: angles first and their sines together make a step a fifth faster than calling it.
    """
    n = links.shape[1]
    angle = first_angle(0.0, phi, n)
    rate = first_angle(0.0, dphi, n)
    bias = first_angle(0.0, acc, n)
    for i in range(n):
        if i > 0:
            angle += phi[i - 1]
            rate += dphi[i - 1]
            bias += acc[i - 1]
        shape[C, i] = angle
        shape[OMEGA, i] = rate
        shape[BA, i] = bias
    for i in range(n):
        sine, cosine = sine_cosine(shape[C, i])
        shape[C, i] = cosine
        shape[S, i] = sine
    x = y = vx = vy = bx = by = 0.0
    total = mx = my = mvx = mvy = mbx = mby = 0.0
    for i in range(n):
        half, rate, bias = links[HALF, i], shape[OMEGA, i], shape[BA, i]
        ex, ey = half * shape[C, i], half * shape[S, i]
        dx, dy = -rate * ey, rate * ex
        cx, cy = -bias * ey - rate * rate * ex, bias * ex - rate * rate * ey
        if i > 0:  # from the joint to the centre; link 1 starts the chain at its own centre
            x += ex
            y += ey
            vx += dx
            vy += dy
            bx += cx
            by += cy
        shape[RT, i], shape[RN, i] = x, y
        shape[VT, i], shape[VN, i] = vx, vy
        shape[BT, i], shape[BN, i] = bx, by
        m = links[MASS, i]
        total += m
        mx += m * x
        my += m * y
        mvx += m * vx
        mvy += m * vy
        mbx += m * bx
        mby += m * by
        x += ex
        y += ey
        vx += dx
        vy += dy
        bx += cx
        by += cy
    inverse = 1.0 / total
    inertia = moment = change = 0.0
    for i in range(n):
        c, s = shape[C, i], shape[S, i]
        x, y = shape[RT, i] - mx * inverse, shape[RN, i] - my * inverse
        vx, vy = shape[VT, i] - mvx * inverse, shape[VN, i] - mvy * inverse
        bx, by = shape[BT, i] - mbx * inverse, shape[BN, i] - mby * inverse
        m = links[MASS, i]
        inertia += links[INERTIA, i] + m * (x * x + y * y)
        moment += links[INERTIA, i] * shape[BA, i] + m * (x * by - y * bx)
        change += m * (x * vx + y * vy)
        shape[RT, i], shape[RN, i] = c * x + s * y, c * y - s * x
        shape[VT, i], shape[VN, i] = c * vx + s * vy, c * vy - s * vx
        shape[BT, i], shape[BN, i] = c * bx + s * by, c * by - s * bx
    sums[INERTIA_ALL], sums[MOMENT], sums[CHANGE] = inertia, moment, change


@in_place_in_any_order
def _solve(
    links: Any, rubs_along: bool, rubs_across: bool, slope: Any, eps: float, gh: float, time_sign: float,
    memory: Any, shape: Any, sums: Any, speed: Any, own: Any, k: Any,
) -> None:  # fmt: skip
    """Solve (M + gh K) k = forces for the three unknowns, in the axes of the shape.

    Args:
        rubs_along, rubs_across: whether any link has Coulomb friction that way.
        slope: (2,) gravity along the slope over mass, m/s^2, against which the links move.
        gh, time_sign: as for ``kernel.solve``.
        memory: (3,) acceleration of an earlier stage; M times it is taken off the forces.
        speed: (3,) velocity of the centre of mass, rate of the mean link angle.
        own: (LINK_ROWS, n), out.
        k: (3,), out.
    """
    n = links.shape[1]
    u, v, w = speed[0], speed[1], speed[2]
    inverse_eps = 1.0 / eps
    g = gh * time_sign
    for i in range(n):
        c, s, rt, rn, vt, vn = (
            shape[C, i],
            shape[S, i],
            shape[RT, i],
            shape[RN, i],
            shape[VT, i],
            shape[VN, i],
        )
        own[ALONG, i] = c * u + s * v - w * rn + vt
        own[ACROSS, i] = c * v - s * u + w * rt + vn
        own[ACC_ALONG, i] = shape[BT, i] - 2.0 * w * vn - w * w * rt
        own[ACC_ACROSS, i] = shape[BN, i] + 2.0 * w * vt - w * w * rn
        own[RUB_ALONG, i] = links[CT, i]
        own[RUB_ACROSS, i] = links[CN, i]
    if rubs_along:
        for i in range(n):
            own[RUB_ALONG, i] += links[CT0, i] * sign_over_speed(own[ALONG, i], inverse_eps)
    if rubs_across:
        for i in range(n):
            own[RUB_ACROSS, i] += links[CN0, i] * sign_over_speed(own[ACROSS, i], inverse_eps)
    total = hx = hy = ha = 0.0
    kxx = kxy = kyy = kxa = kya = kaa = 0.0
    for i in range(n):
        c, s, rt, rn = shape[C, i], shape[S, i], shape[RT, i], shape[RN, i]
        kt, kn, kr = own[RUB_ALONG, i], own[RUB_ACROSS, i], links[CR, i]
        ft = kt * (own[ALONG, i] + g * own[ACC_ALONG, i])
        fn = kn * (own[ACROSS, i] + g * own[ACC_ACROSS, i])
        total += links[MASS, i]
        hx += c * ft - s * fn
        hy += s * ft + c * fn
        ha += rt * fn - rn * ft + kr * (shape[OMEGA, i] + w + g * shape[BA, i])
        kxx += kt * c * c + kn * s * s
        kxy += (kt - kn) * c * s
        kyy += kt * s * s + kn * c * c
        kxa -= kt * c * rn + kn * s * rt
        kya += kn * c * rt - kt * s * rn
        kaa += kt * rn * rn + kn * rt * rt + kr
    inertia = sums[INERTIA_ALL]
    hx = -(hx + total * (slope[0] + memory[0]))
    hy = -(hy + total * (slope[1] + memory[1]))
    ha = -(ha + sums[MOMENT] + 2.0 * w * sums[CHANGE] + inertia * memory[2])
    # a symmetric 3 x 3 system
    ixx, ixy, iyy = total + gh * kxx, gh * kxy, total + gh * kyy
    ixa, iya, iaa = gh * kxa, gh * kya, inertia + gh * kaa
    inv = 1.0 / ixx
    lyx = ixy * inv
    lax = ixa * inv
    iyy -= lyx * ixy
    iya -= lyx * ixa
    hy -= lyx * hx
    lay = iya / iyy
    iaa -= lax * ixa + lay * iya
    ha -= lax * hx + lay * hy
    k[2] = ha / iaa
    k[1] = (hy - iya * k[2]) / iyy
    k[0] = (hx - ixy * k[1] - ixa * k[2]) * inv


@in_place
def _add_torques(
    links: Any, slope: Any, gh: float, time_sign: float, memory: Any, shape: Any, speed: Any, own: Any, k: Any,
    share: float, rate: Any, torque: Any, power: Any,
) -> None:  # fmt: skip
    """Add ``share`` of a stage's joint torques (n-1,), and of the power that they put in at these joint rates."""
    g = gh * time_sign
    x = y = moment = 0.0  # of all links behind a joint: force, and moment about the joint
    for i in range(links.shape[1] - 1, 0, -1):
        c, s, rt, rn = shape[C, i], shape[S, i], shape[RT, i], shape[RN, i]
        m, j, kr = links[MASS, i], links[INERTIA, i], links[CR, i]
        kt, kn = own[RUB_ALONG, i], own[RUB_ACROSS, i]
        ax, ay, aa = k[0] + memory[0] + slope[0], k[1] + memory[1] + slope[1], k[2] + memory[2]
        along = m * (c * ax + s * ay - aa * rn + own[ACC_ALONG, i])
        along += kt * (gh * (c * k[0] + s * k[1] - k[2] * rn) + own[ALONG, i] + g * own[ACC_ALONG, i])
        across = m * (c * ay - s * ax + aa * rt + own[ACC_ACROSS, i])
        across += kn * (gh * (c * k[1] - s * k[0] + k[2] * rt) + own[ACROSS, i] + g * own[ACC_ACROSS, i])
        turning = j * (aa + shape[BA, i]) + kr * (gh * k[2] + shape[OMEGA, i] + speed[2] + g * shape[BA, i])
        half = links[HALF, i]
        moment += turning + half * across + 2.0 * half * (c * y - s * x)
        x += c * along - s * across
        y += s * along + c * across
        torque[i - 1] += share * moment
        power[0] += share * moment * rate[i - 1]


@in_place
def impose(
    links: Any, slope: float, eps: float, t: Any, angle: Any, rate: Any, max_step: float, base: Any, forces: bool,
    torque: Any, power: Any, joints: Any, shape: Any, sums: Any, own: Any, planar: Any, state: Any,
) -> None:  # fmt: skip
    """Impose joint angles ``angle`` (T, n-1) with their rates, at times ``t`` (T,); the rest follows.

    Args:
        slope: gravity along the slope over mass, m/s^2, along -x.
        base: (T, 6) centre of mass, mean link angle, and their rates; the first row is given, the others come out.
        forces: whether the next two are wanted.
        torque: (T, n-1), power: (T, 2), zeros; come out as means over the time since the sample before.
        joints, shape, sums, own, planar, state: see ``scratch``.
    """
    n = links.shape[1]
    rubs_along = rubs_across = False
    for link in range(n):
        rubs_along = rubs_along or links[CT0, link] > 0.0
        rubs_across = rubs_across or links[CN0, link] > 0.0
    phi, dphi, acc = joints[0], joints[1], joints[2]
    down, speed, k1, k2, memory, nothing = planar[0], planar[1], planar[2], planar[3], planar[4], planar[5]
    for a in range(6):
        state[a] = base[0, a]
    for i in range(1, t.size):
        span = t[i] - t[i - 1]
        parts = math.ceil(span / max_step * (1 - 1e-9))
        h = span / parts
        gh = GAMMA * h
        _hermite(0.0, span, angle[i - 1], angle[i], rate[i - 1], rate[i], phi, dphi, acc)
        _shape(links, phi, dphi, acc, shape, sums)
        for part in range(parts):
            sine, cosine = sine_cosine(state[2])
            down[0], down[1] = cosine * slope, -sine * slope
            speed[0] = cosine * state[3] + sine * state[4]
            speed[1] = cosine * state[4] - sine * state[3]
            speed[2] = state[5]
            _solve(links, rubs_along, rubs_across, down, eps, gh, 1.0, nothing, shape, sums, speed, own, k1)
            if forces:
                _add_torques(
                    links, down, gh, 1.0, nothing, shape, speed, own, k1, 0.5 / parts, dphi, torque[i], power[i]
                )  # fmt: skip
                for link in range(n):
                    turn = shape[OMEGA, link] + speed[2]
                    power[i, 1] += (
                        own[RUB_ALONG, link] * own[ALONG, link] ** 2
                        + own[RUB_ACROSS, link] * own[ACROSS, link] ** 2
                        + links[CR, link] * turn * turn
                    ) / parts
            x1, y1 = cosine * k1[0] - sine * k1[1], sine * k1[0] + cosine * k1[1]
            vx, vy = state[3] + h * x1, state[4] + h * y1
            sine, cosine = sine_cosine(state[2] + h * (state[5] + gh * k1[2]))
            down[0], down[1] = cosine * slope, -sine * slope
            speed[0], speed[1] = cosine * vx + sine * vy, cosine * vy - sine * vx
            speed[2] = state[5] + h * k1[2]
            memory[0] = 2.0 * (cosine * x1 + sine * y1)
            memory[1] = 2.0 * (cosine * y1 - sine * x1)
            memory[2] = 2.0 * k1[2]
            u = (part + 1) / parts
            _hermite(u, span, angle[i - 1], angle[i], rate[i - 1], rate[i], phi, dphi, acc)
            _shape(links, phi, dphi, acc, shape, sums)
            _solve(links, rubs_along, rubs_across, down, eps, gh, -1.0, memory, shape, sums, speed, own, k2)
            if forces:
                _add_torques(
                    links, down, gh, -1.0, memory, shape, speed, own, k2, 0.5 / parts, dphi, torque[i], power[i]
                )  # fmt: skip
            x2, y2 = cosine * k2[0] - sine * k2[1], sine * k2[0] + cosine * k2[1]
            state[0] += h * (state[3] + 0.5 * h * ((1.0 + GAMMA) * x1 + GAMMA * x2))
            state[1] += h * (state[4] + 0.5 * h * ((1.0 + GAMMA) * y1 + GAMMA * y2))
            state[2] += h * (state[5] + 0.5 * h * ((1.0 + GAMMA) * k1[2] + GAMMA * k2[2]))
            state[3] += h * (1.5 * x1 + 0.5 * x2)
            state[4] += h * (1.5 * y1 + 0.5 * y2)
            state[5] += h * (1.5 * k1[2] + 0.5 * k2[2])
        for a in range(6):
            base[i, a] = state[a]
    for a in range(2):
        power[0, a] = power[1, a]
    for joint in range(n - 1):
        torque[0, joint] = torque[1, joint]


def scratch(links: int) -> tuple[Floats, ...]:
    """What ``impose`` writes on as it goes, for a chain of so many links; zeros at first."""
    return (
        np.zeros((3, links - 1)),
        np.zeros((SHAPE_ROWS, links)),
        np.zeros(SHAPE_SUMS),
        np.zeros((LINK_ROWS, links)),
        np.zeros((6, 3)),
        np.zeros(6),
    )
