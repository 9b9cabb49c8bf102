"""The equations of motion, compiled: accelerations of a chain of which some joints are prescribed and some are not.

Unknowns are the centre of mass w, the mean link angle psi, and the angles phi_j of the joints that are not prescribed.
The paper's (14)-(20) build dense n x n matrices; here the same equations are solved link by link (the articulated-body
recursion), so the cost grows with n and not with its cube, and a prescribed joint costs less than a driven one.

The ground force of a link is -K v with K = diag(c + c0 tanh(v/eps)/v) in the link's own axes: (22) with (25).
It is stiff where a link is about to stop, so a step treats it linearly implicitly: the matrix M + gamma h K takes the
place of M (see ``rosenbrock``), which in this recursion only means a heavier link.

Misprints of the paper, not followed here: (21) prints M I_n for the translation of the whole robot, it is M I_2; (22)
prints the same rotation twice, velocities are brought into the link's axes by its transpose.

Every function here works on numbers, or on eight robots of the same links and drives at once (see ``lanes``).
"""

from __future__ import annotations

from typing import Any

from snakebot.physics.compiled import in_place
from snakebot.physics.elementary import sign_over_speed, sine_cosine

# Rows of ChainModel.packed, (8, n).
MASS, HALF, INERTIA, CT, CN, CT0, CN0, CR = range(8)

# Kinds of joint drive.
PRESCRIBED, TORQUE, FREE = 0, 1, 2

# Rows of the work space, (WORK_ROWS, n).
(
    SIN, COS, OMEGA, X, Y, VX, VY, BX, BY, BA, GX, GY, GA,
    IXX, IXY, IYY, IXA, IYA, IAA, HX, HY, HA,
    UX, UY, UA, DINV, UU,
    AX, AY, AA, PIN, PDIS, FX, FY, FA,
) = range(35)  # fmt: skip
WORK_ROWS = 35  # as many as there are names below


@in_place
def first_angle(psi: Any, phi: Any, n: int) -> Any:
    """Angle of link 1 from the mean link angle."""
    total = 0.0
    for j in range(n - 1):
        total += (n - 1 - j) * phi[j]
    return psi - total / n


@in_place
def kinematics(links: Any, base: Any, phi: Any, dphi: Any, acc: Any, work: Any) -> None:
    """Link directions, positions and velocities about the centre of mass, and accelerations not due to unknowns.

    ``base`` is (w_x, w_y, psi, and their rates); ``acc`` (n-1,) is the acceleration of prescribed joints, 0 elsewhere.
    """
    n = links.shape[1]
    angle = first_angle(base[2], phi, n)
    rate = first_angle(base[5], dphi, n)
    bias = first_angle(0.0, acc, n)
    total = 0.0
    x = y = vx = vy = bx = by = 0.0
    mx = my = mvx = mvy = mbx = mby = 0.0
    for i in range(n):
        if i > 0:
            angle += phi[i - 1]
            rate += dphi[i - 1]
            bias += acc[i - 1]
        half = links[HALF, i]
        sine, cosine = sine_cosine(angle)
        ex = half * cosine
        ey = half * sine
        work[COS, i] = ex
        work[SIN, i] = ey
        work[OMEGA, i] = rate
        work[BA, i] = bias
        dx = -rate * ey
        dy = rate * ex
        cx = -bias * ey - rate * rate * ex
        cy = bias * ex - rate * rate * ey
        if i > 0:  # from the joint to the centre; link 1 starts the chain at its own centre
            x += ex
            y += ey
            vx += dx
            vy += dy
            bx += cx
            by += cy
        work[X, i] = x
        work[Y, i] = y
        work[VX, i] = vx
        work[VY, i] = vy
        work[BX, i] = bx
        work[BY, i] = by
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
    x = mx / total
    y = my / total
    vx = base[3] - mvx / total
    vy = base[4] - mvy / total
    bx = mbx / total
    by = mby / total
    for i in range(n):
        work[X, i] -= x
        work[Y, i] -= y
        work[VX, i] += vx
        work[VY, i] += vy
        work[BX, i] -= bx
        work[BY, i] -= by


@in_place
def generalised_to_links(links: Any, k: Any, kphi: Any, work: Any) -> None:
    """Link accelerations J k of generalised accelerations: k of (w_x, w_y, psi), and kphi (n-1,)."""
    n = links.shape[1]
    alpha = first_angle(k[2], kphi, n)
    total = 0.0
    x = y = mx = my = 0.0
    for i in range(n):
        if i > 0:
            alpha += kphi[i - 1]
        dx = -alpha * work[SIN, i]
        dy = alpha * work[COS, i]
        if i > 0:
            x += dx
            y += dy
        work[GX, i] = x
        work[GY, i] = y
        work[GA, i] = alpha
        m = links[MASS, i]
        total += m
        mx += m * x
        my += m * y
        x += dx
        y += dy
    x = k[0] - mx / total
    y = k[1] - my / total
    for i in range(n):
        work[GX, i] += x
        work[GY, i] += y


@in_place
def solve(
    links: Any, slope_force: float, eps: Any, gh: Any, time_sign: float, memory: float,
    kind: Any, torque: Any, damping: Any, work: Any, k: Any, kphi: Any,
) -> None:  # fmt: skip
    """Solve (M + gh K) k = forces, link by link, where ``work`` holds the kinematics.

    Args:
        slope_force: gravity along the slope over mass, m/s^2, along -x.
        gh: gamma h; 0 gives the true accelerations.
        time_sign: +1 in the first stage, -1 in the second: share of the forces' own change in time (prescribed motion).
        memory: how often M J k of the earlier stage (rows GX, GY, GA) is taken off the forces.
        torque: (n-1,) torque on joints that are not prescribed.
        damping: (n-1,) implicit damping of joints that are not prescribed, N m s.
        k, kphi: out, generalised accelerations (3,), (n-1,).
    """
    n = links.shape[1]
    inverse_eps = 1.0 / eps
    for i in range(n):
        m = links[MASS, i]
        inv = 1.0 / links[HALF, i]
        c = work[COS, i] * inv
        s = work[SIN, i] * inv
        vx = work[VX, i]
        vy = work[VY, i]
        vt = c * vx + s * vy
        vn = c * vy - s * vx
        kt = links[CT, i]
        kn = links[CN, i]
        if links[CT0, i] > 0.0:
            kt += links[CT0, i] * sign_over_speed(vt, inverse_eps)
        if links[CN0, i] > 0.0:
            kn += links[CN0, i] * sign_over_speed(vn, inverse_eps)
        kr = links[CR, i]
        # K in the world's axes
        kxx = kt * c * c + kn * s * s
        kyy = kt * s * s + kn * c * c
        kxy = (kt - kn) * c * s
        fx = -(kxx * vx + kxy * vy)
        fy = -(kxy * vx + kyy * vy)
        fa = -kr * work[OMEGA, i]
        work[FX, i] = fx
        work[FY, i] = fy
        work[FA, i] = fa
        bx = work[BX, i]
        by = work[BY, i]
        ba = work[BA, i]
        J = links[INERTIA, i]
        g = gh * time_sign
        work[IXX, i] = m + gh * kxx
        work[IXY, i] = gh * kxy
        work[IYY, i] = m + gh * kyy
        work[IXA, i] = 0.0
        work[IYA, i] = 0.0
        work[IAA, i] = J + gh * kr
        hx = m * bx - fx + m * slope_force + g * (kxx * bx + kxy * by)
        hy = m * by - fy + g * (kxy * bx + kyy * by)
        ha = J * ba - fa + g * kr * ba
        if memory != 0.0:
            hx += memory * m * work[GX, i]
            hy += memory * m * work[GY, i]
            ha += memory * J * work[GA, i]
        work[HX, i] = hx
        work[HY, i] = hy
        work[HA, i] = ha

    for i in range(n - 1, 0, -1):
        ixx = work[IXX, i]
        ixy = work[IXY, i]
        iyy = work[IYY, i]
        ixa = work[IXA, i]
        iya = work[IYA, i]
        iaa = work[IAA, i]
        hx = work[HX, i]
        hy = work[HY, i]
        ha = work[HA, i]
        # from the centre of the link to its joint with the link before
        p = -work[SIN, i]
        q = work[COS, i]
        jxa = ixa + p * ixx + q * ixy
        jya = iya + p * ixy + q * iyy
        jaa = iaa + p * (ixa + jxa) + q * (iya + jya)
        ha += p * hx + q * hy
        ixa = jxa
        iya = jya
        iaa = jaa
        j = i - 1
        work[UX, i] = ixa
        work[UY, i] = iya
        work[UA, i] = iaa
        if kind[j] == PRESCRIBED:
            work[UU, i] = ha
        else:
            d = 1.0 / (iaa + damping[j])
            u = torque[j] - ha
            work[DINV, i] = d
            work[UU, i] = u
            tx = ixa * d
            ty = iya * d
            ta = iaa * d
            ixx -= tx * ixa
            ixy -= tx * iya
            iyy -= ty * iya
            hx += tx * u
            hy += ty * u
            ha += ta * u
            ixa -= tx * iaa
            iya -= ty * iaa
            iaa -= ta * iaa
        # from the joint to the centre of the link before
        p = -work[SIN, j]
        q = work[COS, j]
        jxa = ixa + p * ixx + q * ixy
        jya = iya + p * ixy + q * iyy
        jaa = iaa + p * (ixa + jxa) + q * (iya + jya)
        work[IXX, j] += ixx
        work[IXY, j] += ixy
        work[IYY, j] += iyy
        work[IXA, j] += jxa
        work[IYA, j] += jya
        work[IAA, j] += jaa
        work[HX, j] += hx
        work[HY, j] += hy
        work[HA, j] += ha + p * hx + q * hy

    # link 1 floats: a symmetric 3 x 3 system
    ixx = work[IXX, 0]
    ixy = work[IXY, 0]
    iyy = work[IYY, 0]
    ixa = work[IXA, 0]
    iya = work[IYA, 0]
    iaa = work[IAA, 0]
    hx = -work[HX, 0]
    hy = -work[HY, 0]
    ha = -work[HA, 0]
    inv = 1.0 / ixx
    lyx = ixy * inv
    lax = ixa * inv
    iyy -= lyx * ixy
    iya -= lyx * ixa
    hy -= lyx * hx
    lay = iya / iyy
    iaa -= lax * ixa + lay * iya
    ha -= lax * hx + lay * hy
    aa = ha / iaa
    ay = (hy - iya * aa) / iyy
    ax = (hx - ixy * ay - ixa * aa) * inv
    work[AX, 0] = ax
    work[AY, 0] = ay
    work[AA, 0] = aa

    total = links[MASS, 0]
    mx = total * ax
    my = total * ay
    ma = aa
    for i in range(1, n):
        j = i - 1
        ax -= aa * work[SIN, j]
        ay += aa * work[COS, j]
        if kind[j] == PRESCRIBED:
            kphi[j] = 0.0
            work[UU, i] += work[UX, i] * ax + work[UY, i] * ay + work[UA, i] * aa
        else:
            kphi[j] = (work[UU, i] - work[UX, i] * ax - work[UY, i] * ay - work[UA, i] * aa) * work[DINV, i]
            work[UU, i] = torque[j] - damping[j] * kphi[j]
        aa += kphi[j]
        ax -= aa * work[SIN, i]
        ay += aa * work[COS, i]
        work[AX, i] = ax
        work[AY, i] = ay
        work[AA, i] = aa
        m = links[MASS, i]
        total += m
        mx += m * ax
        my += m * ay
        ma += aa
    k[0] = mx / total
    k[1] = my / total
    k[2] = ma / n


@in_place
def dissipation(n: int, work: Any) -> Any:
    """Power that the links lose to the ground, W, at the state of the last ``solve``."""
    lost = 0.0
    for i in range(n):
        lost -= work[FX, i] * work[VX, i] + work[FY, i] * work[VY, i] + work[FA, i] * work[OMEGA, i]
    return lost
