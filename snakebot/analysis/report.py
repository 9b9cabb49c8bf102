"""The page that ``snakebot analyze --report`` writes."""

from __future__ import annotations

import math
from collections.abc import Sequence

from snakebot.analysis import course_figures, figures
from snakebot.analysis.conditions import conditions_text
from snakebot.analysis.report_many import ERROR_HELP, TE_HELP, add_overview
from snakebot.analysis.run_analysis import RunAnalysis
from snakebot.analysis.tables import PaperTables
from snakebot.report import Column, Facts, Note, Page, Section, Table
from snakebot.report.blocks import significant

TOTAL_POINTS = 24_000  # over all joint charts of a page: a minute of five joints stays far below 2 MB
DETAILED_RUNS = 40  # runs with a table of their own; chosen


def analysis_page(runs: Sequence[RunAnalysis], tables: PaperTables, footer: str = "") -> Page:
    """One page for one run or several."""
    robots = sorted({run.robot.name for run in runs})
    if len(runs) == 1:
        page = Page(runs[0].name, " · ".join([robots[0], *_about(runs[0])]), footer)
    else:
        page = Page(f"{len(runs)} runs", ", ".join(robots), footer)
        add_overview(page, runs, tables)
    shown = runs[:DETAILED_RUNS]
    joints = sum(run.run.joints for run in shown)
    points = min(max(TOTAL_POINTS // max(joints, 1), 250), 2400)
    for run in shown:
        section = page.section("Overview" if len(runs) == 1 else run.name, folded=len(runs) > 1)
        _add_run(section, run, points)
    if len(runs) > len(shown):
        page.section("Further runs").add(
            Note(f"Figures are shown for the first {len(shown)} runs; the tables above hold all {len(runs)}.")
        )
    return page


def _add_run(section: Section, run: RunAnalysis, points: int) -> None:
    fine = min(max(points // 4, 60), 600)  # a portrait is a cycle or three, not the whole run
    section.add(_facts(run))
    for warning in run.warnings:
        section.add(Note(warning, "warning"))
    section.add(Note(steady_text(run), "info" if run.steady.settled or not run.omega_rad_s else "warning"))
    section.add(joint_table(run))
    body = figures.body_animation(run, frames=min(1200, points))
    if body is not None:
        section.add(body)
    course = course_figures.charts(run, points)
    if course:
        section.add_grid(*course)
    if predictions := prediction_table(run):
        section.add(predictions)
    for chart in figures.joint_traces(run, points):
        section.add(chart)
    section.add(figures.error_traces(run, points))
    if run.omega_rad_s:
        section.add_grid(*figures.phase_portraits(run, fine))
        section.add_grid(*figures.set_point_portraits(run, fine))
        section.add_grid(*figures.hysteresis_portraits(run, fine))
    if (spectrum := figures.spectra(run)) is not None:
        section.add(spectrum)
    section.add_grid(*figures.telemetry(run, points))
    section.add(link_table(run))
    if (timing := figures.link_timing(run, points)) is not None:
        section.add(timing)


def _about(run: RunAnalysis) -> list[str]:
    metadata = run.run.metadata
    about = [gait_text(run)] if run.gait else []
    if told := conditions_text(run):
        about.append(told)
    if metadata.get("simulated") is True:
        about.append("simulated board")
    if isinstance(metadata.get("port"), str):
        about.append(metadata["port"])
    return about


def gait_text(run: RunAnalysis) -> str:
    if run.gait is None:
        return "no gait given"
    alpha, beta = (f"{math.degrees(angle):.4g}°" for angle in (run.gait.alpha_rad, run.gait.beta_rad))
    return f"α {alpha}, β {beta}, ω {run.gait.omega_rad_s:.4g} rad/s"


def steady_text(run: RunAnalysis) -> str:
    steady = run.steady
    head = "Steady state" if steady.settled else "Window used"
    omega = "" if run.omega_rad_s is None else f" Frequency {run.omega_rad_s:.5g} rad/s ({run.omega_source})."
    return f"{head}: {steady.start_s:.2f} to {steady.end_s:.2f} s; {steady.reason}.{omega}"


def _facts(run: RunAnalysis) -> Facts:
    def text(value: float, unit: str, digits: int = 3) -> str:
        return f"{significant(value, digits, 4)} {unit}".strip() if math.isfinite(value) else "–"

    rms = max((j.tracking.rms_rad for j in run.joints if math.isfinite(j.tracking.rms_rad)), default=math.nan)
    worst = max(run.joints, key=lambda j: j.tracking.rms_rad if math.isfinite(j.tracking.rms_rad) else -1)
    tiles = []
    if run.robot.body is not None:
        origin = {
            "given": "measured, given with the run",
            "pose": "from the recorded pose",
            "": "not recorded",
        }
        tiles.append(("forward speed", text(run.speed_m_s, "m/s"), origin[run.speed_source]))
        ideal = run.predictions.ideal
        predicted = ideal.speed_m_s if ideal else run.predictions.angle_replay_speed_m_s
        error = run.speed_error_percent
        remark = "ideal tracking" if ideal else "measured angles in the model"
        if math.isfinite(error):
            remark += f"; measured is {text(error, '%')} off"
        tiles.append(("predicted speed", text(predicted, "m/s"), remark))
        tiles.append(("power dissipated", text(run.power_dissipated_w, "W"), "encoders and measured speed"))
        tiles.append(("power in", text(run.power_in_w, "W"), "measured angles in the model"))
    if math.isfinite(run.power_electrical_w):
        tiles.append(("electrical power", text(run.power_electrical_w, "W"), "supply; standby included"))
    tiles.append(
        (
            "tracking error TE",
            text(run.te, ""),
            "all joints" if math.isfinite(run.te) else "no amplitude",
        )
    )
    tiles.append(("largest RMS error", text(math.degrees(rms), "deg"), f"joint {worst.joint}"))
    tiles.append(
        (
            "samples lost",
            text(100 * run.link.lost, "%"),
            f"of {run.link.ticks} ticks, {run.run.duration_s:.1f} s",
        )
    )
    return Facts(tiles)


def joint_table(run: RunAnalysis) -> Table:
    columns = [
        Column("joint"),
        Column("TE", "", 3, TE_HELP, decimals=4),
        Column("RMS error", "deg", 3, decimals=2),
        Column("max error", "deg", 3, decimals=2),
        Column("mean error", "deg", 3, "constant part of the error", decimals=2),
        Column(
            "amplitude",
            "deg",
            4,
            "least-squares sine of the measured angle at the gait's frequency",
            decimals=2,
        ),
        Column("gain", "", 4, "measured over commanded amplitude", decimals=3),
        Column("phase lag", "deg", 3, decimals=2),
        Column(
            "lag",
            "ms",
            3,
            "phase lag as a time; for a motion that is not periodic, the best shift",
            decimals=2,
        ),
        Column("harmonics", "%", 3, "THD: rms of harmonics 2 to 9 over the fundamental", decimals=2),
        Column(
            "off the sine", "%", 3, "rms of all that the sine leaves, over the rms of the sine", decimals=2
        ),
        Column("hysteresis", "deg", 3, "half the jump of the error where the motion turns round", decimals=2),
        Column("loop", "", 2, "area of error against velocity: 0 on a line, 1 a full ellipse", decimals=3),
        Column("lost", "%", 3, decimals=2),
    ]
    rows: list[list[object]] = []
    for joint in run.joints:
        track, measured, hyst = joint.tracking, joint.measured, joint.hysteresis
        rows.append(
            [
                joint.joint,
                track.te,
                math.degrees(track.rms_rad),
                math.degrees(track.max_rad),
                math.degrees(track.mean_rad),
                math.degrees(measured.amplitude) if measured else None,
                joint.gain,
                math.degrees(joint.lag_rad),
                1e3 * joint.lag_s,
                100 * joint.thd,
                100 * joint.sine_residual,
                math.degrees(hyst.half_width_rad) if hyst.explained >= 0.5 else None,
                hyst.loop,
                100 * joint.lost,
            ]
        )
    return Table(
        columns,
        rows,
        "Joints, over the steady state" if run.steady.settled else "Joints, over the window used",
    )


def prediction_table(run: RunAnalysis) -> Table | None:
    """The sine-replay prediction beside the ideal one."""
    predictions = run.predictions
    named = [
        ("ideal tracking of the gait", predictions.ideal),
        ("least-squares sines of the measured angles", predictions.sine_replay),
        ("measured angles with their harmonics", predictions.angle_replay),
    ]
    rows: list[list[object]] = [
        [name, p.speed_m_s, _percent(run.speed_m_s, p.speed_m_s), p.power_in_w, p.power_dissipated_w]
        for name, p in named
        if p is not None
    ]
    if not rows:
        return None
    if math.isfinite(run.speed_m_s):
        rows.append(["measured", run.speed_m_s, None, None, run.power_dissipated_w])
    columns = [
        Column("motion of the joints in the nominal model"),
        Column("speed", "m/s", 4),
        Column(
            "measured is off by",
            "%",
            3,
            ERROR_HELP,
            decimals=1,
        ),
        Column("power in", "W", 4),
        Column("power dissipated", "W", 4),
    ]
    return Table(columns, rows, "Speed and power, predicted and measured")


def link_table(run: RunAnalysis) -> Table:
    link = run.link
    row: list[object] = [
        link.ticks,
        link.period_s * 1e3,
        link.jitter_std_s * 1e3,
        link.jitter_p99_s * 1e3,
        link.late_ticks,
        100 * link.lost,
        link.latency_median_s * 1e3,
        link.latency_p99_s * 1e3,
        link.latency_max_s * 1e3,
        link.delay_to_board_s * 1e3,
    ]
    columns = [
        Column("ticks"),
        Column("interval", "ms", 4, decimals=2),
        Column("jitter rms", "ms", 3, decimals=2),
        Column("jitter 99 %", "ms", 3, decimals=2),
        Column("late ticks"),
        Column("lost", "%", 3, decimals=2),
        Column("delay median", "ms", 3, "from a set-point sent to the board's answer", decimals=2),
        Column("delay 99 %", "ms", 3, decimals=2),
        Column("delay max", "ms", 3, decimals=2),
        Column(
            "set-point delay", "ms", 3, "by how much the set-points the board executed trail those commanded"
        ),
    ]
    return Table(columns, [row], "Link and timing")


def _percent(measured: float, predicted: float) -> float:
    return 100 * (measured - predicted) / predicted if predicted else math.nan
