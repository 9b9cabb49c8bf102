"""Picture of an optimum: the front, the gait that was found, and those it is set beside."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from snakebot.studies.figures import new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from snakebot.optimise.optimum import Optimum
    from snakebot.optimise.promise import Promise

_COLOURS = ("C0", "C2", "C4", "C5")


def optimum_figure(result: Optimum) -> Figure:
    """Power over speed, and the front's alpha, beta and omega over speed."""
    figure = new_figure(columns=2, width=5.4)
    cloud, gaits = figure.axes
    front = result.front
    speed, power = (np.array([getattr(row, name) for row in front]) for name in ("speed_m_s", "power_w"))
    marked = (result.found, *result.others)
    fastest = max([*speed, *(row.speed_m_s for row in marked)])
    most = 1.3 * max([*power, *(row.power_w for row in marked)])
    cloud.plot(*result.seen.T, ".", markersize=2, color="0.75", label="gaits simulated")
    cloud.plot(speed, power, "-o", markersize=3, color="0.3", label="front")
    for row, colour in zip(marked, ("C3", *_COLOURS), strict=False):
        cloud.errorbar(
            row.speed_m_s, row.power_w, xerr=_span(row.speed_m_s, row.speed_ci95),
            yerr=_span(row.power_w, row.power_ci95), fmt="*" if row is result.found else "D",
            markersize=12 if row is result.found else 6, color=colour, capsize=3, label=_label(row),
        )  # fmt: skip
    cloud.set(xlabel="speed, m/s", ylabel="power, W", title=f"{result.robot}: best for {result.goal.aim}")
    cloud.set(xlim=(0, 1.15 * fastest), ylim=(0, most))
    if result.goal.speed_m_s is not None:
        cloud.axvline(result.goal.speed_m_s, color="0.6", linewidth=0.8, linestyle="--")
    cloud.legend(frameon=False, fontsize=8)
    for name, unit, style in (("alpha", "deg", "o-"), ("beta", "deg", "s-")):
        gaits.plot(
            speed,
            [getattr(row, f"{name}_{unit}") for row in front],
            style,
            markersize=4,
            label=f"{name}, {unit}",
        )
    gaits.plot(speed, [10 * row.omega_rad_s for row in front], "^-", markersize=4, label="omega, 0.1 rad/s")
    gaits.set(xlabel="speed, m/s", title="gaits of the front", ylim=(0, None))
    gaits.legend(frameon=False, fontsize=8)
    return figure


def _label(row: Promise) -> str:
    return f"{row.what} ({row.alpha_deg:.0f}, {row.beta_deg:.0f}, {row.omega_rad_s:.2f})"


def _span(value: float, ends: tuple[float, float] | None) -> list[list[float]] | None:
    return None if ends is None else [[max(value - ends[0], 0.0)], [max(ends[1] - value, 0.0)]]
