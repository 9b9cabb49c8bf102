"""One joint of one run: how it followed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from snakebot.analysis.sine import SineFit, fit_sine, usable_harmonics, wrap_rad
from snakebot.analysis.tracking import Hysteresis, Tracking, hysteresis, tracking
from snakebot.arrays import Floats
from snakebot.runlog.matching.shift import find_shift, shifted

NO_MOTION_RAD = 1e-4  # an amplitude below this is no motion
MOST_LAG_S = 1.0  # a reading is looked for so far behind its command; chosen, ten times a slow servo's lag


@dataclass(frozen=True)
class JointAnalysis:
    """Figures of one joint over the steady state; ``nan`` or ``None`` where the data does not tell.

    ``gain`` is measured over commanded amplitude, for a motion that is not periodic the least-squares
    factor; ``lag_rad`` the phase by which the joint trails, in (-pi, pi], and ``lag_s`` the same as a time,
    for a motion that is not periodic the shift that brings the two closest. ``thd`` is the harmonics' share
    (see ``SineFit.thd``); ``sine_residual`` the rms of all that the least-squares sine leaves, over the rms
    of that sine. ``lost`` is the share of samples that never came.
    """

    joint: int
    tracking: Tracking
    command: SineFit | None
    measured: SineFit | None
    gain: float
    lag_rad: float
    lag_s: float
    thd: float
    thd_command: float
    harmonic_fit: SineFit | None  # of the measured angle, with all harmonics that the sampling allows
    sine_residual: float
    hysteresis: Hysteresis
    lost: float


def analyze_joint(
    joint: int,
    t_s: Floats,
    command_rad: Floats,
    measured_rad: Floats,
    omega_rad_s: float | None,
    amplitude_rad: float | None = None,
) -> JointAnalysis:
    """Figures of one joint (1-based number), from its samples (N,) in the steady state.

    Args:
        omega_rad_s: the gait's frequency; ``None`` leaves everything that needs a sine unknown.
        amplitude_rad: the gait's, for TE (37); by default that of the command's least-squares sine.
    """
    command = measured = rich_command = rich = None
    cycles = math.nan
    if omega_rad_s is not None and len(t_s) > 1:
        order = usable_harmonics(t_s, omega_rad_s)
        command, rich_command = (fit_sine(t_s, command_rad, omega_rad_s, n) for n in (1, order))
        measured, rich = (fit_sine(t_s, measured_rad, omega_rad_s, n) for n in (1, order))
        cycles = omega_rad_s * (t_s[-1] - t_s[0] + float(np.median(np.diff(t_s)))) / (2 * math.pi)
    if amplitude_rad is None and command is not None:
        amplitude_rad = command.amplitude
    gain = lag_rad = math.nan
    if command is not None and measured is not None and command.amplitude > NO_MOTION_RAD:
        gain = measured.amplitude / command.amplitude
        if measured.amplitude > NO_MOTION_RAD:
            lag_rad = wrap_rad(command.phase_rad - measured.phase_rad)
    lag_s = lag_rad / omega_rad_s if omega_rad_s else math.nan
    if omega_rad_s is None:
        gain, lag_s = _gain_and_shift(t_s, command_rad, measured_rad)
    moving = measured is not None and measured.amplitude > NO_MOTION_RAD
    return JointAnalysis(
        joint=joint,
        tracking=tracking(measured_rad, command_rad, amplitude_rad or 0.0),
        command=command,
        measured=measured,
        gain=gain,
        lag_rad=lag_rad,
        lag_s=lag_s,
        thd=rich.thd if rich is not None and moving else math.nan,
        thd_command=rich_command.thd if rich_command is not None and gain == gain else math.nan,
        harmonic_fit=rich,
        sine_residual=math.sqrt(2) * measured.residual_rms / measured.amplitude
        if measured is not None and moving
        else math.nan,
        hysteresis=hysteresis(t_s, measured_rad, command_rad, cycles),
        lost=float(np.mean(~np.isfinite(measured_rad))) if len(measured_rad) else math.nan,
    )


def _gain_and_shift(t_s: Floats, command_rad: Floats, measured_rad: Floats) -> tuple[float, float]:
    if len(t_s) < 8:
        return math.nan, math.nan
    found = find_shift(t_s, command_rad[:, None], t_s, measured_rad[:, None], most_s=MOST_LAG_S, least_s=0.0)
    if found is None:
        return math.nan, math.nan
    later = shifted(t_s, t_s, measured_rad[:, None], found.shift_s)[:, 0]
    known = np.isfinite(later) & np.isfinite(command_rad)
    x, y = command_rad[known], later[known]
    variance = float(np.var(x)) if len(x) else 0.0
    gain = (
        float(np.mean((x - x.mean()) * (y - y.mean()))) / variance
        if variance > NO_MOTION_RAD**2
        else math.nan
    )
    return gain, found.shift_s
