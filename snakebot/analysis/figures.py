"""The figures of one run, as blocks of a report page. Angles are shown in degrees."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from snakebot.analysis.bodies import BodyPath, model_path, recorded_path
from snakebot.analysis.curves import amplitude_spectrum, smooth_rate
from snakebot.arrays import Floats, Ints
from snakebot.report import Axis, Band, Curve, Line, LineChart, SnakeAnimation, SnakeMotion, XYChart

if TYPE_CHECKING:
    from snakebot.analysis.run_analysis import RunAnalysis

TIME = Axis("time", "s", 3)
ANGLE = Axis("angle", "deg", 2)
ERROR = Axis("error", "deg", 3)
PORTRAIT_CYCLES = 3  # the last so many cycles of the gait in a phase portrait; chosen
SPECTRUM_ORDERS = 10  # a spectrum is drawn up to this multiple of the gait's frequency; chosen


def joint_color(joint: int) -> str:
    return f"series{(joint - 1) % 8 + 1}"


def steady_band(run: RunAnalysis) -> list[Band]:
    label = "steady state" if run.steady.settled else "window used"
    return [Band(run.steady.start_s, run.steady.end_s, label)]


def joint_traces(run: RunAnalysis, points: int) -> list[LineChart]:
    """Command, what the board executed, and what was measured: a chart a joint, zooming together."""
    record = run.run
    charts = []
    for j in range(record.joints):
        lines = [Line("command", np.degrees(record.command_rad[:, j]), "command", dash=True)]
        if record.applied_rad is not None:
            lines.append(
                Line("executed by the board", np.degrees(record.applied_rad[:, j]), "applied", width=1.1)
            )
        lines.append(Line("measured", np.degrees(record.measured_rad[:, j]), "measured"))
        charts.append(
            LineChart(
                f"Joint {j + 1}",
                record.t_s,
                lines,
                TIME,
                ANGLE,
                steady_band(run),
                sync=run.name,
                height=190,
                points=points,
            )
        )
    return charts


def error_traces(run: RunAnalysis, points: int) -> LineChart:
    error = np.degrees(run.run.measured_rad - run.run.command_rad)
    lines = [
        Line(f"joint {j + 1}", column, joint_color(j + 1), width=1.2) for j, column in enumerate(error.T)
    ]
    return LineChart(
        "Error, measured − command",
        run.run.t_s,
        lines,
        TIME,
        ERROR,
        steady_band(run),
        sync=run.name,
        points=points,
    )


def set_point_portraits(run: RunAnalysis, points: int) -> list[XYChart]:
    """Measured against set-point: the diagonal is a perfect servo, an open loop a lag."""
    part = portrait_window(run)
    return [
        XYChart(
            f"Joint {j + 1}: measured against set-point",
            [
                Curve(
                    "",
                    np.degrees(run.run.command_rad[part, j]),
                    np.degrees(run.run.measured_rad[part, j]),
                    joint_color(j + 1),
                )
            ],
            Axis("set-point", "deg", 2),
            Axis("measured", "deg", 2),
            equal=True,
            diagonal=True,
            points=points,
        )
        for j in range(run.run.joints)
    ]


def phase_portraits(run: RunAnalysis, points: int) -> list[XYChart]:
    """Rate against angle: a sine is an ellipse, a rate limit flattens it."""
    charts = []
    for j in range(run.run.joints):
        curves = []
        for name, signals, color, dash in (
            ("command", run.run.command_rad, "command", True),
            ("measured", run.run.measured_rad, "measured", False),
        ):
            angle, rate = angle_and_rate(run, signals[:, j])
            curves.append(Curve(name, angle, rate, color, dash=dash))
        charts.append(
            XYChart(
                f"Joint {j + 1}: rate against angle",
                curves,
                Axis("angle", "deg", 2),
                Axis("rate", "rad/s", 3),
                points=points,
            )
        )
    return charts


def hysteresis_portraits(run: RunAnalysis, points: int) -> list[XYChart]:
    """Error against the command's velocity: a lag is a line through the origin, play a step at its middle."""
    part, base = portrait_window(run), _rate_base(run)
    charts = []
    for j in range(run.run.joints):
        rate = smooth_rate(run.run.t_s, run.run.command_rad[:, j], base)
        error = np.degrees(run.run.measured_rad[:, j] - run.run.command_rad[:, j])
        curve = Curve("", rate[part], error[part], joint_color(j + 1))
        charts.append(
            XYChart(
                f"Joint {j + 1}: error against velocity",
                [curve],
                Axis("command's rate", "rad/s", 3),
                Axis("error", "deg", 3),
                points=points,
            )
        )
    return charts


def spectra(run: RunAnalysis) -> LineChart | None:
    """Amplitude spectra of the measured angles, over multiples of the gait's frequency where there is one."""
    inside = run.steady.mask(run.run.t_s)
    t = run.run.t_s[inside]
    found = [
        (j + 1, *amplitude_spectrum(t, column)) for j, column in enumerate(run.run.measured_rad[inside].T)
    ]
    found = [item for item in found if len(item[1])]
    if not found:
        return None
    unit = run.omega_rad_s or 1.0
    frequency = found[0][1]
    keep = (frequency > 0) & (frequency <= (SPECTRUM_ORDERS * unit if run.omega_rad_s else np.inf))
    lines = [
        Line(f"joint {joint}", np.maximum(np.degrees(amplitude[keep]), 1e-3), joint_color(joint), width=1.2)
        for joint, _, amplitude in found
        if len(amplitude) == len(frequency)
    ]
    axis = Axis("frequency over the gait's", "", 3) if run.omega_rad_s else Axis("frequency", "rad/s", 3)
    return LineChart(
        "Spectrum of the measured angles",
        frequency[keep] / unit,
        lines,
        axis,
        Axis("amplitude", "deg", 4, log=True),
        points=1200,
    )


def link_timing(run: RunAnalysis, points: int) -> LineChart | None:
    """Interval between ticks and the board's answering time, where a run shows any unevenness."""
    t = run.run.t_s
    if len(t) < 3:
        return None
    interval = np.concatenate([[np.nan], np.diff(t) * 1e3])
    lines = [Line("interval between ticks", interval, "series1", width=1.0)]
    latency = run.run.extra.get("latency_s")
    if latency is not None and np.isfinite(latency).any():
        lines.append(
            Line("set-point to answer", np.asarray(latency, dtype=np.float64) * 1e3, "series2", width=1.0)
        )
    elif np.nanstd(interval) < 1e-3 * np.nanmean(interval):
        return None
    return LineChart(
        "Timing of the link", t, lines, TIME, Axis("time", "ms", 3), sync=run.name, points=points
    )


TELEMETRY = (
    ("Supply voltage", "V", re.compile(r"supply_v")),
    ("Current of the supply", "A", re.compile(r"supply_a")),
    ("Current of the servos", "A", re.compile(r"current_(\d+)_a")),
    ("Temperature of the servos", "°C", re.compile(r"temperature_(\d+)_c")),
    ("Temperature of the board", "°C", re.compile(r"supply_temperature_c")),
)


def telemetry(run: RunAnalysis, points: int) -> list[LineChart]:
    """Supply, currents and temperatures, as far as the run recorded them."""
    charts = []
    for title, unit, pattern in TELEMETRY:
        lines = []
        for name, values in sorted(run.run.extra.items()):
            found = pattern.fullmatch(name)
            if found is None or not np.issubdtype(values.dtype, np.number) or not np.isfinite(values).any():
                continue
            joint = int(found[1]) if found.groups() else 0
            label, color = (f"joint {joint}", joint_color(joint)) if joint else ("supply", "series1")
            lines.append(Line(label, values.astype(np.float64), color, width=1.2))
        if lines:
            axis = Axis(title.split()[0].lower(), unit, 3)
            charts.append(
                LineChart(title, run.run.t_s, lines, TIME, axis, steady_band(run), run.name, points=points)
            )
    return charts


def body_animation(run: RunAnalysis, frames: int) -> SnakeAnimation | None:
    """The body over ground: as recorded, or by the nominal model from the measured angles, beside ideal
    tracking."""
    record, robot = run.run, run.robot
    if robot.body is None:
        return None
    paths: list[tuple[str, BodyPath | None, str]] = []
    recorded = recorded_path(record)
    if recorded is not None:
        paths.append(("recorded pose", recorded, "measured"))
        caption = "The recorded pose, beside the nominal model with its joints exactly at the set-points."
        if record.pose is not None and not np.isfinite(record.pose[:, 2]).any():
            caption += " Its heading was not recorded: the body is drawn along its way."
    else:
        paths.append(
            ("measured angles in the model", model_path(record, robot, record.measured_rad), "measured")
        )
        caption = (
            "No pose was recorded: the nominal model moves with the measured angles, and with the set-points."
        )
    paths.append(("set-points in the model", model_path(record, robot, record.command_rad), "command"))
    return animation(
        "Body over ground",
        [(n, p, c) for n, p, c in paths if p is not None],
        robot.body.half_length_m,
        frames,
        caption,
    )


def animation(
    title: str, paths: Sequence[tuple[str, BodyPath, str]], half_length_m: float, frames: int, caption: str
) -> SnakeAnimation | None:
    """Paths that share their times, as one animation; ``None`` without any."""
    if not paths or len(paths[0][1].t_s) < 3:
        return None
    snakes = [
        SnakeMotion(name, path.x_m, path.y_m, path.heading_rad, path.joint_angle_rad, half_length_m, color)
        for name, path, color in paths
    ]
    return SnakeAnimation(title, paths[0][1].t_s, snakes, caption, frames)


def portrait_window(run: RunAnalysis) -> Ints:
    """Indices of the last few steady cycles."""
    inside = np.flatnonzero(run.steady.mask(run.run.t_s))
    if run.omega_rad_s:
        t = run.run.t_s
        inside = inside[t[inside] >= t[inside[-1]] - PORTRAIT_CYCLES * 2 * math.pi / run.omega_rad_s]
    return inside


def angle_and_rate(run: RunAnalysis, signal_rad: Floats) -> tuple[Floats, Floats]:
    """Angle in deg and its rate in rad/s over the last few steady cycles, of one joint's angles (N,)."""
    part = portrait_window(run)
    rate = smooth_rate(run.run.t_s, signal_rad, _rate_base(run))
    return np.degrees(signal_rad[part]), rate[part]


def _rate_base(run: RunAnalysis) -> float:
    step = float(np.median(np.diff(run.run.t_s))) if len(run.run) > 1 else 0.01
    return max(2 * step, 2 * math.pi / run.omega_rad_s / 60 if run.omega_rad_s else 0.0)
