"""The verdict as a page: the gap's map, traces before and after, ranking, closure, the proposed experiment."""

from __future__ import annotations

import numpy as np

from snakebot import __version__
from snakebot.diagnosis.result import Diagnosis, Trace
from snakebot.diagnosis.words import cause_name, headline
from snakebot.report import Axis, BarChart, Bars, Column, Facts, Line, LineChart, Note, Page, Section, Table
from snakebot.runlog import Session

DEG = 180 / np.pi
ONE_MOTION = "Only one motion may be fitted: there is no other to test it on."


def page(session: Session, diagnosis: Diagnosis) -> str:
    """One self-contained HTML file."""
    name = session.path.name if session.path is not None else "session"
    out = Page(
        f"Diagnosis of {name}",
        subtitle=f"{session.robot.name}, {len(session.runs)} runs, {session.robot.joints} joints",
        footer=f"snakebot {__version__} diagnose, seed {diagnosis.details.seed if diagnosis.details else 0}",
    )
    _verdict(out.section("Verdict"), diagnosis)
    held_out = bool(diagnosis.closure.held_out_runs)
    if diagnosis.causes:
        earned = "Each earns its place on gaits that it was not fitted to."
        _causes(out.section("Causes", earned if held_out else ONE_MOTION), diagnosis)
    _map(out.section("Where the gap lies"), diagnosis)
    taken_on = "On runs that no parameter was fitted to." if held_out else ONE_MOTION
    _closure(out.section("How far it closes", taken_on), diagnosis)
    if diagnosis.details is not None and diagnosis.details.traces:
        shown = "Predictions of held-out runs" if held_out else "The runs that were fitted"
        section = out.section("Before and after", f"{shown}, the joint with the largest gap.")
        for trace in diagnosis.details.traces:
            section.add(_trace(trace))
    _ranking(out.section("What else was tried"), diagnosis)
    if diagnosis.next_experiment is not None:
        nxt = diagnosis.next_experiment
        section = out.section("The next experiment")
        section.add(Note(f"{nxt.motion[0].upper()}{nxt.motion[1:]}: {nxt.reason}."))
        if nxt.lifted:
            section.add(Note("Lift the robot off the ground before it, and put it back after it.", "warning"))
        section.add(Note(nxt.command))
        pairs = "; ".join(" from ".join(pair) for pair in nxt.separates)
        section.add(
            Note(f"It tells {pairs}. Expected probability after it: {nxt.expected_probability_after:.0%}.")
        )
    return out.html()


def _verdict(section: Section, diagnosis: Diagnosis) -> None:
    angle, speed = diagnosis.closure.joint_angle, diagnosis.closure.forward_speed
    tiles = [
        ("verdict", diagnosis.verdict.replace("_", " "), f"stage: {diagnosis.where.stage}"),
        (
            "joint angles",
            f"{angle.rms_before * DEG:.2g} to {angle.rms_after * DEG:.2g} deg",
            _closed_text(angle.closed, angle.reason),
        ),
    ]
    if speed is not None:
        tiles.append(
            (
                "forward speed off by",
                f"{speed.error_before:.2g} to {speed.error_after:.2g} m/s",
                _closed_text(speed.closed, speed.reason),
            )
        )
    section.add(Facts(tiles))
    section.add(Note(headline(diagnosis), "info" if diagnosis.verdict != "unexplained" else "warning"))
    if diagnosis.unexplained.significant:
        section.add(
            Note(f"Left over: {diagnosis.unexplained.share:.1%} of the gap; {diagnosis.unexplained.where}.")
        )
    for warning in diagnosis.warnings:
        section.add(Note(warning, "warning"))


def _closed_text(closed: float | None, reason: str | None) -> str:
    return f"{closed:.1%} of the gap closed" if closed is not None else (reason or "")


def _causes(section: Section, diagnosis: Diagnosis) -> None:
    rows: list[list[object]] = []
    for cause in diagnosis.causes:
        for number, (name, value) in enumerate(cause.parameters.items()):
            low, high = value.ci95 if value.ci95 is not None else (None, None)
            first = number == 0
            rows.append(
                [
                    cause_name(cause) if first else "",
                    cause.probability if first else None,
                    name,
                    value.estimate,
                    low,
                    high,
                    value.unit,
                ]
            )
        if not cause.parameters:
            rows.append([cause_name(cause), cause.probability, "", None, None, None, ""])
    columns = [
        Column("cause"),
        Column("probability", digits=3),
        Column("parameter"),
        Column("estimate", digits=4),
        Column("from (95 %)", digits=4),
        Column("to (95 %)", digits=4),
        Column("unit"),
    ]
    section.add(Table(columns, rows))
    for cause in diagnosis.causes:
        section.add(Note(f"--effect {cause.specification}"))


def _map(section: Section, diagnosis: Diagnosis) -> None:
    shares = diagnosis.where.stage_shares.model_dump()
    details = diagnosis.details
    stage = BarChart(
        "Share of each stage",
        list(shares),
        [Bars("share", [100 * v for v in shares.values()], "error")],
        Axis("share of the gap", "%", 1),
    )
    if details is None:
        section.add(stage)
        return
    joints = [f"joint {j + 1}" for j in range(len(details.gap_rms_rad))]
    per_joint = BarChart(
        "Rms by joint",
        joints,
        [
            Bars("before", [v * DEG for v in details.gap_rms_rad], "error"),
            Bars("after", [v * DEG for v in details.rest_rms_rad], "predicted"),
            Bars("noise floor", [None if f is None else f * DEG for f in details.floor_rad], "muted"),
        ],
        Axis("prediction error", "deg", 3),
    )
    section.add_grid(stage, per_joint)
    section.add(Note(diagnosis.where.regime.capitalize() + "."))
    charts = []
    for axis in dict.fromkeys(r.axis for r in details.regimes):
        bins = [r for r in details.regimes if r.axis == axis]
        charts.append(
            BarChart(
                f"By {axis}",
                [r.bin for r in bins],
                [
                    Bars("before", [r.rms_before_rad * DEG for r in bins], "error"),
                    Bars("after", [r.rms_after_rad * DEG for r in bins], "predicted"),
                ],
                Axis("prediction error", "deg", 3),
            )
        )
    section.add_grid(*charts)


def _closure(section: Section, diagnosis: Diagnosis) -> None:
    angle, speed = diagnosis.closure.joint_angle, diagnosis.closure.forward_speed
    names: list[str] = []
    values: list[float | None] = []
    low: list[float | None] = []
    high: list[float | None] = []
    for name, part in (("joint angles", angle), ("forward speed", speed)):
        if part is None or part.closed is None:
            continue
        names.append(name)
        values.append(100 * part.closed)
        low.append(100 * part.ci95[0] if part.ci95 else None)
        high.append(100 * part.ci95[1] if part.ci95 else None)
    if names:
        bars = Bars("closed", values, "predicted", low, high)
        section.add(BarChart("Share of the gap closed", names, [bars], Axis("closed", "%", 1)))
    else:
        section.add(Note(angle.reason or "there is no gap to close"))
    if len(diagnosis.closure.steps) > 1:
        rows = [
            [
                step.effect,
                ", ".join(map(str, step.joints)),
                step.joint_angle_closed,
                step.forward_speed_closed,
            ]
            for step in diagnosis.closure.steps
        ]
        columns = [
            Column("after adding"),
            Column("joints"),
            Column("angles closed", digits=4),
            Column("speed closed", digits=3),
        ]
        section.add(Table(columns, rows))
    section.add(Note("Held-out runs: " + (", ".join(diagnosis.closure.held_out_runs) or "none") + "."))


def _trace(trace: Trace) -> LineChart:
    def degrees(values: tuple[float | None, ...]) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        return np.array([np.nan if v is None else v for v in values], dtype=np.float64) * DEG

    return LineChart(
        f"{trace.run}, joint {trace.joint}",
        np.array(trace.t_s),
        [
            Line("command", degrees(trace.command_rad), "command", dash=True),
            Line("measured", degrees(trace.measured_rad), "measured"),
            Line("predicted before", degrees(trace.before_rad), "error"),
            Line("predicted after", degrees(trace.after_rad), "predicted"),
        ],
        x=Axis("time", "s", 3),
        y=Axis("angle", "deg", 2),
    )


def _ranking(section: Section, diagnosis: Diagnosis) -> None:
    rows = [
        [
            " + ".join(entry.effects) or "nothing (nominal)",
            ", ".join(map(str, entry.joints)),
            entry.held_out_score,
            entry.delta,
            entry.delta_se,
            entry.probability,
        ]
        for entry in diagnosis.ranking
    ]
    columns = [
        Column("explanation"),
        Column("joints"),
        Column(
            "held-out score",
            digits=4,
            help="0 is perfect; half the log of the mean square over the allowed one",
        ),
        Column("behind the best", digits=3),
        Column("standard error", digits=2),
        Column("probability", digits=3),
    ]
    section.add(Table(columns, rows))
