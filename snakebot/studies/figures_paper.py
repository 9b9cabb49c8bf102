"""Figures of the studies about the paper: its claims, the inferred links, the gap to the robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from snakebot.studies.figures import new_figure
from snakebot.studies.gap import TARGETS, GapFit
from snakebot.studies.inference import LINE_OMEGAS, Inference, line_alpha_deg, line_speed
from snakebot.studies.paper_claims import PaperEvidence
from snakebot.studies.speed import SimulatedSpeed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# What the paper's text gives for each set: omega over speed (slope, intercept), alpha at 1 and 5 rad/s, beta.
PRINTED = {
    "saito": (0.83, 0.0, (15, 25), 60),
    "saito_wheeled": (0.88, 0.0, (27, 27), 78),
    "penn_state": (7.88, 0.97, (70, 40), 80),
    "penn_state_viscous": (9.30, 0.0, (30, 30), 80),
}


def optima_figure(evidence: PaperEvidence) -> Figure:
    """Optimal alpha, beta and speed over omega, ours beside the paper's text (Figs. 6, 7, 9, 10, 16, 17, 19, 20)."""
    figure = new_figure(columns=len(PRINTED), width=3.6, height=3.2, rows=2)
    for column, (name, (slope, intercept, alpha, beta)) in enumerate(PRINTED.items()):
        optima = sorted(evidence.fronts[name].swept, key=lambda o: o.omega_rad_s)
        omega = [o.omega_rad_s for o in optima]
        angles, speed = figure.axes[column], figure.axes[len(PRINTED) + column]
        alphas = [(o.alpha_deg, *o.alpha_range_deg) for o in optima]
        betas = [(o.beta_deg, *o.beta_range_deg) for o in optima]
        for which, ours, printed, colour in (
            ("alpha", alphas, alpha, "C0"),
            ("beta", betas, (beta, beta), "C1"),
        ):
            middle, low, high = np.array(ours).reshape(-1, 3).T
            angles.fill_between(omega, low, high, color=colour, alpha=0.15, linewidth=0)
            angles.plot(omega, middle, color=colour, label=which)
            angles.plot((1, 5), printed, "--", color=colour, label=f"{which}, paper")
        angles.set(xlabel="omega, rad/s", ylabel="deg", title=name, ylim=(0, 110))
        angles.legend(frameon=False, fontsize=7)
        line = np.linspace(max(1.0, intercept), 5, 2)
        speed.plot(omega, [o.speed_m_s for o in optima], label="cheapest gaits")
        speed.plot(line, (line - intercept) / slope, "--", label="paper")
        speed.set(xlabel="omega, rad/s", ylabel="speed, m/s", title=name, ylim=(0, None))
        speed.legend(frameon=False, fontsize=7)
    return figure


def infer_figure(results: Sequence[Inference]) -> Figure:
    """Optimal alpha and speed over omega for each reading of the friction model; its half length with interval."""
    figure = new_figure(columns=3, width=4.4)
    alpha, speed, length = figure.axes
    speeds = [line_speed(omega) for omega in LINE_OMEGAS]
    for result in results:
        omega = [result.ours[f"omega at {v:.3f} m/s, rad/s"] for v in speeds]
        alpha.plot(
            omega,
            [result.ours[f"alpha at {v:.3f} m/s, deg"] for v in speeds],
            ".-",
            label=result.reading.name,
        )
        speed.plot(omega, speeds, ".-", label=result.reading.name)
    alpha.plot(LINE_OMEGAS, [line_alpha_deg(omega) for omega in LINE_OMEGAS], "k--", label="paper")
    speed.plot(LINE_OMEGAS, speeds, "k--", label="paper")
    alpha.set(xlabel="omega, rad/s", ylabel="deg", title="alpha of the optimal gaits", ylim=(0, 90))
    speed.set(xlabel="omega, rad/s", ylabel="m/s", title="speed of the optimal gaits", ylim=(0, None))
    alpha.legend(frameon=False, fontsize=7)
    for place, result in enumerate(results):
        low, high = result.ci95["half_length_m"]
        length.plot((low, high), (place, place), color=f"C{place}")
        length.plot(result.estimate["half_length_m"], place, "o", color=f"C{place}")
    length.set_yticks(range(len(results)), [f"{r.reading.name}\nchi2 {r.chi2:.0f}" for r in results])
    length.set(xlabel="half length of a link, m", title="with 95 % interval", ylim=(-0.5, len(results) - 0.5))
    return figure


def gap_figure(fits: Sequence[GapFit], curves: Mapping[str, Sequence[SimulatedSpeed]]) -> Figure:
    """Misfit of each candidate, and the speeds over omega of some of them beside what is published."""
    figure = new_figure(columns=2, width=5.6, height=4.6)
    bars, speed = figure.axes
    places = range(len(fits))
    bars.barh(
        places, [fit.misfit for fit in fits], color=["C2" if fit.misfit < 10 else "0.7" for fit in fits]
    )
    bars.set_yticks(places, [fit.label for fit in fits], fontsize=7)
    bars.invert_yaxis()
    bars.axvline(len(TARGETS), color="C3", linewidth=0.8, label="one sigma a target")
    bars.set(
        xscale="log",
        xlabel="misfit (sum of squared errors over sigma)",
        title="what fits the published numbers",
    )
    bars.legend(frameon=False, fontsize=7)
    for index, (label, rows) in enumerate(curves.items()):
        omega = [row.omega_rad_s for row in rows]
        if index == 0:
            speed.plot(omega, [row.ideal_speed_m_s for row in rows], color="0.6", label="ideal tracking")
        speed.plot(omega, [row.speed_m_s for row in rows], "-", color=f"C{index}", label=label)
        speed.plot(omega, [row.sine_replay_speed_m_s for row in rows], ":", color=f"C{index}")
    for quantity, mark, text in (
        ("speed_m_s", "ko", "robot"),
        ("sine_replay_speed_m_s", "kx", "sine replayed (dotted)"),
    ):
        points = [(t.omega_rad_s, t.value) for t in TARGETS if t.quantity == quantity]
        speed.plot(*zip(*points, strict=True), mark, label=text)
    speed.set(xlabel="omega, rad/s", ylabel="speed, m/s", title="speed", ylim=(0, None))
    speed.legend(frameon=False, fontsize=7)
    return figure
