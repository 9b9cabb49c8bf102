"""The page that ``snakebot compare --report`` writes."""

from __future__ import annotations

import math

import numpy as np

from snakebot.analysis import figures
from snakebot.analysis.bodies import model_path, recorded_path
from snakebot.analysis.comparison import Comparison
from snakebot.analysis.conditions import conditions_text
from snakebot.analysis.report import gait_text, link_table, steady_text
from snakebot.analysis.report_many import TE_HELP
from snakebot.report import (
    Axis,
    BarChart,
    Bars,
    Column,
    Curve,
    Facts,
    Line,
    LineChart,
    Note,
    Page,
    SnakeAnimation,
    Table,
    XYChart,
)
from snakebot.report.blocks import significant

POINTS = 2000  # of a drawn line; chosen, more than a screen has columns


def comparison_page(found: Comparison, footer: str = "") -> Page:
    """One page: figures of the gap, joint by joint, and both bodies over ground."""
    real = found.real
    about = [
        real.robot.name,
        gait_text(real) if real.gait else "",
        conditions_text(real),
        f"against {found.sim_source}",
    ]
    page = Page(f"{real.name}: robot and simulation", " · ".join(text for text in about if text), footer)
    section = page.section("Overview")
    section.add(_facts(found))
    for warning in (*found.warnings, *real.warnings):
        section.add(Note(warning, "warning"))
    section.add(Note(alignment_text(found)))
    section.add(Note(steady_text(real)))
    section.add(joint_table(found))
    shares = [100 * joint.share if math.isfinite(joint.share) else None for joint in found.joints]
    names = [f"joint {joint.joint}" for joint in found.joints]
    if len(names) > 1:
        section.add(
            BarChart(
                "Share of the squared difference", names, [Bars("", shares, "error")], Axis("share", "%")
            )
        )
    body = _bodies(found)
    if body is not None:
        page.section("Over ground").add(body)
    traces = page.section(
        "Joint angles",
        "Drag to zoom, double click for all; the shaded part is what the figures are taken from.",
    )
    for j in range(real.run.joints):
        traces.add(_trace(found, j))
    traces.add(_difference(found))
    if real.omega_rad_s:
        page.section("Rate against angle").add_grid(*[_portrait(found, j) for j in range(real.run.joints)])
    page.section("Link of the robot").add(link_table(real))
    return page


def alignment_text(found: Comparison) -> str:
    """What was done to bring the two onto one clock."""
    if found.alignment.overlap_s != found.alignment.overlap_s:
        return f"Time: {found.aligned_by}; nothing was shifted."
    a = found.alignment
    return (
        f"Time: the simulation trails by {1e3 * a.shift_s:.2f} ms ({a.shift_samples:.2f} samples), found by "
        f"aligning the {found.aligned_by}; {100 * a.misfit:.2g} % of their rms is left; {a.overlap_s:.1f} s in common."
    )


def joint_table(found: Comparison) -> Table:
    columns = [
        Column("joint"),
        Column(
            "RMS difference",
            "deg",
            3,
            "root mean square of the measured angle of the robot minus that of the simulation",
            decimals=3,
        ),
        Column("max", "deg", 3, decimals=3),
        Column("mean", "deg", 3, decimals=3),
        Column("share", "%", 3, "of the summed squared difference of all joints", decimals=1),
        Column("correlation", "", 5, decimals=4),
        Column(
            "TE robot",
            "",
            3,
            TE_HELP,
            decimals=4,
        ),
        Column(
            "TE sim",
            "",
            3,
            TE_HELP,
            decimals=4,
        ),
        Column("gain robot", "", 4, "measured over commanded amplitude", decimals=3),
        Column("gain sim", "", 4, decimals=3),
        Column("lag robot", "ms", 3, decimals=1),
        Column("lag sim", "ms", 3, decimals=1),
        Column("harmonics robot", "%", 3, decimals=2),
        Column("harmonics sim", "%", 3, decimals=2),
    ]
    rows: list[list[object]] = [
        [
            joint.joint,
            math.degrees(joint.rms_rad),
            math.degrees(joint.max_rad),
            math.degrees(joint.mean_rad),
            100 * joint.share,
            joint.correlation,
            joint.real.tracking.te,
            joint.sim.tracking.te,
            joint.real.gain,
            joint.sim.gain,
            1e3 * joint.real.lag_s,
            1e3 * joint.sim.lag_s,
            100 * joint.real.thd,
            100 * joint.sim.thd,
        ]
        for joint in found.joints
    ]
    return Table(columns, rows, "Robot minus simulation, joint by joint")


def _facts(found: Comparison) -> Facts:
    def text(value: float, unit: str) -> str:
        return f"{significant(value, 3, 4)} {unit}" if math.isfinite(value) else "–"

    worst = max(found.joints, key=lambda joint: joint.rms_rad if math.isfinite(joint.rms_rad) else -1)
    tiles = [
        ("RMS difference", text(math.degrees(found.rms_rad), "deg"), "all joints"),
        ("worst joint", str(worst.joint), f"{text(100 * worst.share, '%')} of the squared difference"),
    ]
    if found.real.robot.body is not None:
        tiles += [
            (
                "speed of the robot",
                text(found.real.speed_m_s, "m/s"),
                found.real.speed_source or "not recorded",
            ),
            ("speed of the simulation", text(found.sim.speed_m_s, "m/s"), found.sim_source),
            ("speed error", text(found.speed_error_percent, "%"), "the simulation predicts"),
        ]
    return Facts(tiles)


def _trace(found: Comparison, j: int) -> LineChart:
    real, sim = found.real.run, found.sim.run
    lines = [
        Line("command", np.degrees(real.command_rad[:, j]), "command", dash=True),
        Line("simulation", np.degrees(sim.measured_rad[:, j]), "predicted"),
        Line("robot", np.degrees(real.measured_rad[:, j]), "measured"),
    ]
    band = figures.steady_band(found.real)
    return LineChart(
        f"Joint {j + 1}", real.t_s, lines, figures.TIME, figures.ANGLE, band, "angles", 190, POINTS
    )


def _difference(found: Comparison) -> LineChart:
    real, sim = found.real.run, found.sim.run
    difference = np.degrees(real.measured_rad - sim.measured_rad)
    lines = [
        Line(f"joint {j + 1}", d, figures.joint_color(j + 1), width=1.2) for j, d in enumerate(difference.T)
    ]
    band = figures.steady_band(found.real)
    return LineChart(
        "Robot − simulation",
        real.t_s,
        lines,
        figures.TIME,
        Axis("difference", "deg", 3),
        band,
        "angles",
        240,
        POINTS,
    )


def _portrait(found: Comparison, j: int) -> XYChart:
    curves = []
    for name, run, color in (("simulation", found.sim, "predicted"), ("robot", found.real, "measured")):
        angle, rate = figures.angle_and_rate(run, run.run.measured_rad[:, j])
        curves.append(Curve(name, angle, rate, color))
    return XYChart(f"Joint {j + 1}", curves, Axis("angle", "deg", 2), Axis("rate", "rad/s", 3))


def _bodies(found: Comparison) -> SnakeAnimation | None:
    real, sim = found.real, found.sim
    if real.robot.body is None:
        return None
    robot_path = recorded_path(real.run) or model_path(real.run, real.robot, real.run.measured_rad)
    sim_path = recorded_path(sim.run)
    recorded = recorded_path(real.run) is not None
    paths = [
        (name, path, color)
        for name, path, color in (
            ("robot" if recorded else "robot's angles in the model", robot_path, "measured"),
            ("simulation", sim_path, "predicted"),
        )
        if path is not None
    ]
    caption = (
        "" if recorded else "No pose was recorded with the run: its measured angles move the nominal model."
    )
    return figures.animation("Robot and simulation", paths, real.robot.body.half_length_m, 1200, caption)
