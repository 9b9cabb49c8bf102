"""Tables of the page: the numbers of the causes, the budget of the gap, what else was tried, the stated numbers."""

from __future__ import annotations

from snakebot.diagnosis.result import BudgetEntry, Diagnosis, RankingEntry, StatedNumber
from snakebot.diagnosis.show.named import (
    cause_name,
    effect_of,
    effect_title,
    explanation,
    in_degrees,
    joint_count,
    parameter_of,
    parameter_rows,
    runs_in_words,
    short_specification,
)
from snakebot.diagnosis.sizes import BEYOND_CHANCE, CLEAR
from snakebot.effects.telling import joints_in_words, shown, shown_span
from snakebot.in_words import span, three
from snakebot.report import Axis, BarChart, Bars, Column, Note, Section, Table
from snakebot.robot import SERVO_LAG, Robot

STATED = {  # numbers of a robot's description: what they are called, and the unit
    SERVO_LAG: ("lag of the servo", "ms"),
    "friction.ct": ("friction along the links", "N s/m"),
    "friction.cn": ("friction across the links", "N s/m"),
    "link_mass_kg": ("mass of a link", "kg"),
}


def _in_si_unit(unit: str) -> float:
    """How many of these are in one SI unit."""
    return 1e3 if unit == "ms" else 1.0


def add_numbers(section: Section, found: Diagnosis) -> None:
    """What the numbers of the causes are."""
    rows: list[list[object]] = []
    for cause in found.causes:
        name, chance = cause_name(cause, joint_count(found)), f"{cause.probability:.0%}"
        for called, value, ends in parameter_rows(cause) or [("", "", "")]:
            rows.append([name, called, value, ends, chance])
            name = chance = ""
    columns = [
        Column("cause"),
        Column("number"),
        Column("value"),
        Column("between", help="95 % interval, with the tolerance of the stated numbers in it"),
        Column("probability", help="of answers like this one, so many are right"),
    ]
    section.add(Table(columns, rows))
    lines = "  ".join(f"--effect {short_specification(cause)}" for cause in found.causes)
    section.add(Note(f"In the simulation: {lines}"))


def add_by_run(section: Section, found: Diagnosis) -> None:
    """What differs from run to run, if anything does."""
    values = found.where.values
    if values is None:
        return
    parameter = parameter_of(values.effect, values.parameter)
    rows: list[list[object]] = []
    for row in values.values:
        if parameter is None:
            value, ends = f"{three(row.estimate)} {values.unit}", ""
        else:
            value = shown(parameter, row.estimate)
            ends = "" if row.ci95 is None else shown_span(parameter, row.ci95)
        rows.append([row.run, value, ends, "unlike the others" if row.run in values.unlike else ""])
    on = joints_in_words(values.joints, joint_count(found))
    called = values.parameter if parameter is None else parameter.called
    columns = [Column("run"), Column(called), Column("between", help="95 % interval"), Column("")]
    caption = (
        f"{called[:1].upper()}{called[1:]} by run, {effect_title(values.effect)} on {on}. With a value for each, "
        f"{values.of_rest:.0%} of the rest goes away"
    )
    section.add(Table(columns, rows, caption=caption))


def add_budget(section: Section, found: Diagnosis) -> None:
    """What each cause carries: in all, by joint, by run."""
    for of, title in (("joint_angle", "Joint angles"), ("ground", "Motion over ground")):
        entries = found.shares_of(of)
        if not entries:
            continue
        names = [_carrier(found, entry) for entry in entries]
        ends = [entry.ci95 for entry in entries]
        bars = Bars(
            "share",
            [100 * entry.share for entry in entries],
            "predicted",
            [None if e is None else 100 * e[0] for e in ends],
            [None if e is None else 100 * e[1] for e in ends],
        )
        section.add(BarChart(f"{title}: share of the gap", names, [bars], Axis("share of the gap", "%", 1)))
        columns = [Column(""), *(Column(name, "%") for name in names)]
        rows: list[list[object]] = [["all", *(_percent(e.share) for e in entries)]]
        rows += [
            [f"joint {joint + 1}", *(_percent(e.by_joint[joint]) for e in entries)]
            for joint in range(len(entries[0].by_joint))
        ]
        rows += [[run, *(_percent(e.by_run[run]) for e in entries)] for run in entries[0].by_run]
        section.add(Table(columns, rows, caption=f"{title}, by joint and by run"))
        if any(e is None for e in ends):
            section.add(Note("Shares without an interval: the runs give too few numbers for one."))
    angle = found.closure.joint_angle
    if angle.rms_floor is not None:
        section.add(Note(f"Noise, which is no part of the gap: {in_degrees(angle.rms_floor)} deg."))


def _carrier(found: Diagnosis, entry: BudgetEntry) -> str:
    return "the rest" if entry.cause is None else effect_title(found.causes[entry.cause].effect)


def _percent(share: float | None) -> str:
    return "no gap" if share is None else f"{100 * share:z.0f}"


def add_ranking(section: Section, found: Diagnosis) -> None:
    """One row for each explanation: what error it leaves, and why it lost."""
    best = next((entry for entry in found.ranking if _is_best(found, entry)), None)
    names = [explanation(entry, joint_count(found)) for entry in found.ranking]
    left = ["" if entry.rms_after is None else in_degrees(entry.rms_after) for entry in found.ranking]
    tells = len(set(left)) > 1  # what is over ground leaves the joint angles as they are
    rows: list[list[object]] = []
    for entry, name, error in zip(found.ranking, names, left, strict=True):
        if names.count(name) > 1 and entry.parameters:
            name += f", {entry.parameters} number{'s' if entry.parameters > 1 else ''} fitted"
        why = why_it_lost(found, entry, best)
        rows.append([name, *([error] if tells else []), f"{entry.probability:.0%}", why])
    columns = [Column("explanation")]
    if tells:
        help_ = "of joint angles, on runs held out where there are any"
        columns.append(Column("error left", "deg", help=help_))
    columns += [
        Column("probability"),
        Column("why", help="on blocks of a second, by the logarithm of the squared error"),
    ]
    section.add(Table(columns, rows))


def _is_best(found: Diagnosis, entry: RankingEntry) -> bool:
    named = {cause.effect for cause in found.causes}
    return set(entry.effects) == named and entry.delta == 0


def why_it_lost(found: Diagnosis, entry: RankingEntry, best: RankingEntry | None) -> str:
    """In words; of the one that is named, that it is."""
    runs = len(found.closure.held_out_runs)
    if entry is best:
        return "named" if found.verdict in ("explained", "partly") else "the nearest"
    if not entry.effects:
        return "there is a gap" if found.verdict != "no_gap" else "named: there is no gap"
    if entry.worse_in:
        return f"fails in {runs_in_words(entry.worse_in, runs)}" + (
            f": {', '.join(entry.worse_in[:3])}" if len(entry.worse_in) < runs else ""
        )
    group = {name for cause in found.causes for name in cause.indistinguishable_from}
    if set(entry.effects) & group:
        return "not told apart by these runs"
    extra = (entry.parameters or 0) - (best.parameters or 0) if best is not None else 0
    if best is not None and extra > 0 and entry.delta <= CLEAR * max(entry.delta_se, 1e-9):
        return f"no better, with {extra} more number{'s' if extra > 1 else ''} to fit"
    if entry.delta > 0:
        return "a little worse in all, in no run clearly"
    return "no worse in these runs, but does not stand beside the other causes"


def add_stated(section: Section, found: Diagnosis, robot: Robot) -> None:
    """Every number of the description: what the runs say of it, or that they say nothing."""
    rows = [_stated_row(number, joint_count(found)) for number in found.nominal]
    rows += _not_told(found, robot)
    columns = [
        Column("number"),
        Column("where"),
        Column("stated"),
        Column("found"),
        Column("between", help="95 % interval"),
        Column("off by"),
        Column(
            "in tolerances", help="how many times its stated tolerance (one standard deviation) it is off"
        ),
    ]
    section.add(Table(columns, rows))


def _not_told(found: Diagnosis, robot: Robot) -> list[list[object]]:
    """Numbers of the description that these runs say nothing of, and those that are taken as exact."""
    told = {number.number for number in found.nominal}
    causes = found.causes if found.verdict in ("explained", "partly") else ()
    set_by_cause = {kind for cause in causes if (effect := effect_of(cause)) for kind in effect.covers}
    stated: list[tuple[str, float | tuple[float, ...]]] = [(SERVO_LAG, robot.servo.time_constant_s)]
    exact: list[tuple[str, str]] = []
    if robot.body is not None:
        friction = robot.body.friction
        stated += [("friction.ct", friction.ct), ("friction.cn", friction.cn)]
        stated.append(("link_mass_kg", robot.body.link_mass_kg))
        exact += [
            ("dry friction along the links", f"{_listed(friction.ct0)} N"),
            ("dry friction across the links", f"{_listed(friction.cn0)} N"),
            ("half length of a link", f"{_listed(robot.body.half_length_m)} m"),
        ]
    exact.append(("counts of the encoder in a turn", str(robot.encoder_counts_per_rev)))
    rows: list[list[object]] = []
    for name, value in stated:
        if name in told:
            continue
        called, unit = STATED[name]
        kind = {"friction": "friction", "servo": "delay"}.get(name.split(".")[0])
        why = "see the cause" if kind in set_by_cause else "not told by these runs"
        rows.append([called, "the robot", f"{_listed(value, _in_si_unit(unit))} {unit}", why, "", "", ""])
    return rows + [[called, "the robot", value, "taken as stated", "", "", ""] for called, value in exact]


def _listed(value: float | tuple[float, ...], factor: float = 1.0) -> str:
    """One number, or the ends of several."""
    values = value if isinstance(value, tuple) else (value,)
    low, high = factor * min(values), factor * max(values)
    return three(low) if low == high else f"{three(low)} to {three(high)}"


def _stated_row(number: StatedNumber, count: int) -> list[object]:
    called, unit = STATED.get(number.number, (number.number.replace("_", " "), ""))
    factor = _in_si_unit(unit)
    off = number.estimate - number.stated
    times = abs(off) / number.tolerance if number.tolerance > 0 else 0.0
    word = "far off" if times > BEYOND_CHANCE else "off" if times > CLEAR else "as stated"
    percent = f" ({100 * off / number.stated:+.0f} %)" if number.stated else ""
    low, high = number.ci95
    return [
        called,
        joints_in_words(number.joints, count) if number.joints else "the robot",
        f"{three(number.stated * factor)} {unit}",
        f"{three(number.estimate * factor)} {unit}",
        f"{span(low * factor, high * factor)} {unit}",
        f"{three(off * factor)} {unit}{percent}",
        f"{times:.1f}, {word}",
    ]
