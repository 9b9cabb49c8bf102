"""The verdict as a page: the answer on the first screen, then what it rests on."""

from __future__ import annotations

from math import degrees

from snakebot import __version__
from snakebot.diagnosis.result import AngleClosure, Diagnosis, SpeedClosure
from snakebot.diagnosis.show.answer import of_this_robot
from snakebot.diagnosis.show.first_screen import first_screen
from snakebot.diagnosis.show.marks import add_causes, trace_charts
from snakebot.diagnosis.show.named import effect_title, plain, share_in_words
from snakebot.diagnosis.show.tables import add_budget, add_by_run, add_numbers, add_ranking, add_stated
from snakebot.effects.telling import STAGES_IN_WORDS
from snakebot.in_words import three
from snakebot.report import Axis, BarChart, Bars, Column, Note, Page, Section, Table
from snakebot.runlog import Session

ONE_MOTION = "Of runs that it was fitted to: no other motion tests it."


def page(session: Session, found: Diagnosis) -> str:
    """One self-contained HTML file."""
    name = session.path.name if session.path is not None else "session"
    joints = "joint" if session.robot.joints == 1 else "joints"
    out = Page(
        f"Diagnosis of {name}",
        subtitle=f"{session.robot.name}, {len(session.runs)} runs, {session.robot.joints} {joints}",
        footer=f"snakebot {__version__} diagnose, seed {found.details.seed if found.details else 0}",
    )
    out.section("").add(first_screen(found, body=session.robot.body is not None))
    held_out = bool(found.closure.held_out_runs)
    if found.warnings:
        section = out.section("Mind")
        for warning in found.warnings:
            text = plain(warning)
            section.add(Note(f"{text[0].upper()}{text[1:]}.", "warning"))
    if found.causes:
        what = "How it shows" if found.verdict != "unexplained" else "How the nearest explanation shows"
        shown = "Predictions of runs that it was not fitted to." if held_out else ONE_MOTION
        section = out.section(what, shown)
        add_causes(section, found)
        add_numbers(out.section("Its numbers"), found)
    if found.budget:
        add_budget(
            out.section("What carries the gap", "Each cause's share of the squared error above noise."), found
        )
    if found.verdict != "no_gap":
        section = out.section("Where the gap lies")
        _map(section, found)
        add_by_run(section, found)
    if found.ranking:
        add_ranking(out.section("What else was tried"), found)
    stated = out.section("The stated numbers", "What the runs say of the robot's description.")
    add_stated(stated, found, session.robot)
    if found.next_experiment is not None:
        _next(out.section("The next experiment"), found)
    if found.details is not None:
        rest = [trace for trace in found.details.traces if trace.cause is None]
        if rest:
            section = out.section("More runs", "The joint with the largest gap.", folded=True)
            for trace in rest:
                section.add_grid(*trace_charts(trace))
    _closure(
        out.section(
            "How far it closes",
            "On runs that no parameter was fitted to." if held_out else ONE_MOTION,
            folded=True,
        ),
        found,
    )
    return out.html()


def _map(section: Section, found: Diagnosis) -> None:
    shares = found.where.stage_shares.model_dump()
    details = found.details
    stage = BarChart(
        "Share of each stage of the signal",
        [STAGES_IN_WORDS[name] for name in shares],
        [Bars("share", [100 * v for v in shares.values()], "error")],
        Axis("share of the gap", "%", 1),
    )
    if details is None:
        section.add(stage)
        return
    joints = [f"joint {j + 1}" for j in range(len(details.gap_rms_rad))]
    per_joint = BarChart(
        "Error by joint",
        joints,
        [
            Bars("now", [degrees(v) for v in details.gap_rms_rad], "error"),
            Bars("with it", [degrees(v) for v in details.rest_rms_rad], "predicted"),
            Bars("noise", [None if f is None else degrees(f) for f in details.floor_rad], "muted"),
        ],
        Axis("error, rms", "deg", 3),
    )
    section.add_grid(stage, per_joint)
    section.add(Note(found.where.regime[:1].upper() + found.where.regime[1:] + "."))
    charts = []
    for axis in dict.fromkeys(r.axis for r in details.regimes):
        bins = [r for r in details.regimes if r.axis == axis]
        charts.append(
            BarChart(
                f"By {axis}",
                [r.bin for r in bins],
                [
                    Bars("now", [degrees(r.rms_before_rad) for r in bins], "error"),
                    Bars("with it", [degrees(r.rms_after_rad) for r in bins], "predicted"),
                ],
                Axis("error, rms", "deg", 3),
            )
        )
    section.add_grid(*charts)


def _next(section: Section, found: Diagnosis) -> None:
    run = found.next_experiment
    assert run is not None
    section.add(Note(f"{run.motion[0].upper()}{run.motion[1:]}: {plain(run.reason)}."))
    if run.lifted:
        section.add(Note("Lift the robot off the ground before it, and put it back after it.", "warning"))
    section.add(Note(of_this_robot(run.command, found)))
    pairs = "; ".join(" from ".join(effect_title(name) for name in pair) for pair in run.separates)
    section.add(
        Note(f"It tells {pairs}. Expected probability after it: {run.expected_probability_after:.0%}.")
    )


def _closure(section: Section, found: Diagnosis) -> None:
    angle, speed = found.closure.joint_angle, found.closure.forward_speed
    before_after = (degrees(angle.rms_before), degrees(angle.rms_after))
    floor = None if angle.rms_floor is None else degrees(angle.rms_floor)
    rows = [_closure_row("joint angles", angle, before_after, floor, "deg")]
    if speed is not None:
        before_after = (speed.error_before, speed.error_after)
        rows.append(_closure_row("forward speed", speed, before_after, speed.floor, "m/s"))
    columns = [Column("error of"), Column("now"), Column("with it"), Column("noise"), Column("closed")]
    columns += [
        Column("between", help="95 %, by the bootstrap over blocks; over 100 % is noise"),
        Column("remark"),
    ]
    section.add(Table(columns, rows))
    if len(found.closure.steps) > 1:
        steps = [
            [
                effect_title(s.effect),
                ", ".join(map(str, s.joints)),
                _closed(s.joint_angle_closed),
                _closed(s.joint_angle_closed_beyond_tolerance),
                _closed(s.forward_speed_closed),
            ]
            for s in found.closure.steps
        ]
        section.add(
            Table(
                [
                    Column("after adding"),
                    Column("joints"),
                    Column("angles closed"),
                    Column(
                        "beyond tolerance", help="the same of the angles, with the lags that these runs tell"
                    ),
                    Column("speed closed"),
                ],
                steps,
            )
        )
    section.add(Note("Runs: " + (", ".join(found.closure.held_out_runs) or "none held out") + "."))


def _closure_row(
    name: str,
    part: AngleClosure | SpeedClosure,
    before_after: tuple[float, float],
    floor: float | None,
    unit: str,
) -> list[object]:
    ends = "" if part.ci95 is None else f"{100 * part.ci95[0]:.1f} to {100 * part.ci95[1]:.1f} %"
    noise = "not known" if floor is None else f"{three(floor)} {unit}"
    texts = [f"{three(value)} {unit}" for value in before_after]
    return [name, *texts, noise, _closed(part.closed), ends, part.reason or ""]


def _closed(share: float | None) -> str:
    return "" if share is None else share_in_words(share)
