"""How each cause shows: its mark and its doubles, in words, beside the trace in which it shows best."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.result import Cause, Diagnosis, RunSpeed, Trace
from snakebot.diagnosis.show.named import cause_name, effect_of, effect_title, joint_count
from snakebot.report import Axis, BarChart, Bars, Block, Explain, Line, LineChart, Section


def add_causes(section: Section, found: Diagnosis) -> None:
    """One block for each cause."""
    details = found.details
    traces = {trace.cause: trace for trace in (details.traces if details else ())}
    for number, cause in enumerate(found.causes):
        trace = traces.get(number)
        charts = trace_charts(trace) if trace is not None else []
        if cause.stage == "body" and details is not None and details.speeds:
            charts = speed_charts(details.speeds)
        section.add_beside(explain(cause, joint_count(found)), *charts)


def explain(cause: Cause, count: int) -> Explain:
    """What to see in the plot, and what else would leave nearly the same."""
    effect, name = effect_of(cause), cause_name(cause, count)
    parts: list[tuple[str, str]] = []
    if effect is not None:
        parts.append(("How to recognise it:", effect.mark))
        parts += [(f"Not {effect_title(other)}:", f"{tells}.") for other, tells in effect.confused_with]
    return Explain(name[0].upper() + name[1:], parts)


def speed_charts(speeds: Sequence[RunSpeed]) -> list[Block]:
    """The forward speed of each run, and below it its error before and after."""
    runs = [one.run for one in speeds]
    return [
        BarChart(
            "Forward speed by run",
            runs,
            [
                Bars("measured", [one.measured for one in speeds], "measured"),
                Bars("simulation now", [one.before for one in speeds], "error"),
                Bars("simulation with it", [one.after for one in speeds], "predicted"),
            ],
            Axis("forward speed", "m/s", 4),
        ),
        BarChart(
            "Forward speed by run: error (measured less simulated)",
            runs,
            [
                Bars("now", [one.measured - one.before for one in speeds], "error"),
                Bars("with it", [one.measured - one.after for one in speeds], "predicted"),
            ],
            Axis("error", "m/s", 4),
        ),
    ]


def trace_charts(trace: Trace) -> list[Block]:
    """The angle over time, and below it the error before and after; of one of several causes without it and with it."""

    def degrees(values: tuple[float | None, ...]) -> Floats:
        return np.rad2deg(np.array([np.nan if v is None else v for v in values], dtype=np.float64))

    t, measured = np.array(trace.t_s), degrees(trace.measured_rad)
    before, after = degrees(trace.before_rad), degrees(trace.after_rad)
    others = degrees(trace.others_rad) if trace.others_rad else None  # without this cause, with all others
    sync, x = f"{trace.run} joint {trace.joint} cause {trace.cause}", Axis("time", "s", 3)
    angles = LineChart(
        f"{trace.run}, joint {trace.joint}: angle",
        t,
        [
            Line("command", degrees(trace.command_rad), "command", dash=True),
            Line("measured", measured, "measured"),
            Line("simulation now", before, "error"),
            Line("simulation with it", after, "predicted"),
        ],
        x=x,
        y=Axis("angle", "deg", 2),
        sync=sync,
        height=200,
    )
    errors = LineChart(
        f"{trace.run}, joint {trace.joint}: error (measured less simulated)",
        t,
        [
            Line("now", measured - before, "error")
            if others is None
            else Line("with all causes but this", measured - others, "error"),
            Line("with it", measured - after, "predicted"),
        ],
        x=x,
        y=Axis("error", "deg", 3),
        sync=sync,
        height=160,
    )
    return [angles, errors]
