"""Power of the moving robot from what was measured: dissipated on the ground (Section IX), drawn by the
servos."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats

if TYPE_CHECKING:
    from collections.abc import Mapping

    from snakebot.physics.model import ChainModel

_NEWTON_STEPS = 20  # at most; chosen
_STEP_LENGTHS = (1.0, 0.5, 0.2, 0.05, 0.01)  # shares of a Newton step that are tried, longest first; chosen


def dissipated_power(
    model: ChainModel, t_s: Floats, joint_angle_rad: Floats, forward_speed_m_s: float
) -> Floats:
    """Friction force times contact velocity, summed over the links, in W (N,): from encoders and a speed
    alone.

    Encoders tell how the links move against each other. The centre of mass moves forward at the measured
    speed; its sway to the side and the turning of the whole body are not seen. They are taken as those at
    which the ground pushes neither sideways nor round (inertia is neglected), which makes the mean lateral
    velocity zero, as in Section IX.

    Args:
        t_s: times (N,), rising.
        joint_angle_rad: (N, joints), without gaps.
    """
    rates = np.gradient(joint_angle_rad, t_s, axis=0)
    relative, relative_rate = _link_angles(joint_angle_rad), _link_angles(rates)
    turn = np.zeros(len(t_s))  # mean link angle against the direction of travel
    power = np.zeros(len(t_s))
    for _ in range(3):
        angle = relative + turn[:, None]
        turn_rate, power = _balance(model, angle, relative_rate, forward_speed_m_s)
        steps = np.diff(t_s) * (turn_rate[1:] + turn_rate[:-1]) / 2
        turn = np.concatenate([[0.0], np.cumsum(steps)])
        # Neither heading nor side drifts over whole cycles: a straight line is all that the balance cannot
        # know.
        turn -= np.polyval(np.polyfit(t_s, turn, 1), t_s)
    return power


def electrical_power(extra: Mapping[str, Floats], joints: int) -> Floats | None:
    """Supply voltage times the sum of the servos' currents, in W (N,), where a run recorded both.

    The standby current of servos is in it: it says little about locomotion (Section IX).
    """
    currents = [extra[name] for name in (f"current_{j}_a" for j in range(1, joints + 1)) if name in extra]
    if "supply_v" not in extra or not currents:
        return None
    return np.asarray(
        np.asarray(extra["supply_v"], dtype=np.float64) * np.sum(currents, axis=0), dtype=np.float64
    )


def _link_angles(joint: Floats) -> Floats:
    """Angles (or rates) of the links about their mean, (N, links)."""
    links = np.concatenate([np.zeros((len(joint), 1)), np.cumsum(joint, axis=1)], axis=1)
    return np.asarray(links - links.mean(axis=1, keepdims=True))


def _balance(model: ChainModel, angle: Floats, relative_rate: Floats, speed: float) -> tuple[Floats, Floats]:
    """Turning rate at which the ground's side force and moment vanish, and the power lost then; each (N,).

    That is where the dissipation potential, a convex function of sway and turning rate, is least: Newton's
    method with a choice of step lengths, because Coulomb friction bends the potential sharply.
    """
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = _centres(model, cos, sin)
    x_rate, y_rate = _centres(model, -sin * relative_rate, cos * relative_rate)
    # Each unknown velocity moves the contacts by so much along (t) and across (n) the links.
    turn_t, turn_n = sin * x - cos * y, cos * x + sin * y
    fixed_t, fixed_n = cos * (x_rate + speed) + sin * y_rate, cos * y_rate - sin * (x_rate + speed)
    drag = model.rotational_drag

    def velocities(unknown: Floats) -> tuple[Floats, Floats, Floats]:
        sway, turn = unknown[:, 0:1], unknown[:, 1:2]
        return (
            fixed_t + sin * sway + turn_t * turn,
            fixed_n + cos * sway + turn_n * turn,
            relative_rate + turn,
        )

    def potential(unknown: Floats) -> Floats:
        vt, vn, rate = velocities(unknown)
        along, across = (
            _potential(vt, model.ct, model.ct0, model.eps),
            _potential(vn, model.cn, model.cn0, model.eps),
        )
        return np.asarray(np.sum(along + across + drag * rate**2 / 2, axis=1))

    unknown = np.zeros((len(angle), 2))  # sway velocity, turning rate
    least = potential(unknown)
    for _ in range(_NEWTON_STEPS):
        vt, vn, rate = velocities(unknown)
        ft, dft = _friction(vt, model.ct, model.ct0, model.eps)
        fn, dfn = _friction(vn, model.cn, model.cn0, model.eps)
        side = np.sum(ft * sin + fn * cos, 1)
        moment = np.sum(ft * turn_t + fn * turn_n + drag * rate, 1)
        ss = np.sum(dft * sin**2 + dfn * cos**2, 1)
        tt = np.sum(dft * turn_t**2 + dfn * turn_n**2 + drag, 1)
        st = np.sum(dft * sin * turn_t + dfn * cos * turn_n, 1)
        determinant = np.maximum(ss * tt - st**2, 1e-12)
        step = np.stack([tt * side - st * moment, ss * moment - st * side], 1) / determinant[:, None]
        start = unknown
        for length in _STEP_LENGTHS:
            tried = start - length * step
            value = potential(tried)
            better = value < least
            unknown = np.where(better[:, None], tried, unknown)
            least = np.where(better, value, least)
    vt, vn, rate = velocities(unknown)
    ft, _ = _friction(vt, model.ct, model.ct0, model.eps)
    fn, _ = _friction(vn, model.cn, model.cn0, model.eps)
    return unknown[:, 1], np.sum(ft * vt + fn * vn + drag * rate**2, axis=1)


def _centres(model: ChainModel, cos: Floats, sin: Floats) -> tuple[Floats, Floats]:
    """Link centres about the centre of mass for link directions (cos, sin); linear, so it serves for rates
    too."""
    half = model.half_length
    out = []
    for part in (cos, sin):
        reach = half * part
        start = np.concatenate([np.zeros((len(part), 1)), np.cumsum(2 * reach, axis=1)[:, :-1]], axis=1)
        centre = start + reach
        out.append(centre - (centre @ model.mass / model.mass.sum())[:, None])
    return out[0], out[1]


def _friction(v: Floats, c: Floats, c0: Floats, eps: float) -> tuple[Floats, Floats]:
    """Friction force against a velocity (25) and its slope, the sign regularised as tanh(v / eps)."""
    sign = np.tanh(v / eps)
    return c * v + c0 * sign, c + c0 * (1 - sign**2) / eps


def _potential(v: Floats, c: Floats, c0: Floats, eps: float) -> Floats:
    """Integral of the friction force over the velocity; log cosh in a form that does not overflow."""
    z = np.abs(v) / eps
    return c * v**2 / 2 + c0 * eps * (z + np.log1p(np.exp(-2 * z)) - math.log(2))


def mean_power(power_w: Floats | None) -> float:
    return float(np.nanmean(power_w)) if power_w is not None and np.isfinite(power_w).any() else math.nan
