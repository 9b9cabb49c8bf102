"""How the studies' figures look, and where they go: PNG and SVG beside the results."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from snakebot.errors import cannot_write
from snakebot.report.blocks import significant
from snakebot.studies.pareto import Pareto
from snakebot.studies.sweep import POWER, SPEED

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from snakebot.studies.friction import FrictionFit, Measurement
    from snakebot.studies.hyperredundancy import FaultCase
    from snakebot.studies.near_optimum import Grid
    from snakebot.studies.speed import SimulatedSpeed


def new_figure(columns: int = 1, width: float = 6.0, height: float = 4.0, rows: int = 1) -> Figure:
    """A figure without a window, with that many columns and rows of plots."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width * columns, height * rows), layout="constrained")
    for axes in figure.subplots(rows, columns, squeeze=False).flat:
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(alpha=0.25)
    return figure


def save(figure: Figure, folder: Path, name: str) -> list[Path]:
    """Write ``name.png`` and ``name.svg``.

    Raises:
        BadInputError: the files cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(figure)
    paths = [folder / f"{name}.{kind}" for kind in ("png", "svg")]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for path in paths:
            figure.savefig(path, dpi=130)
    except OSError as error:
        raise cannot_write(f"{folder}: cannot write the figures", error) from None
    return paths


def pareto_figure(result: Pareto) -> Figure:
    """Power over speed with the front, the front's alpha and beta over omega, and omega over speed."""
    import numpy as np

    figure = new_figure(columns=3, width=4.6)
    cloud, angles, line = figure.axes
    rows, front = result.rows, result.front
    moving = rows[:, SPEED] > 0
    cloud.plot(rows[moving, SPEED], rows[moving, POWER], ".", markersize=2, color="0.7", label="all gaits")
    cloud.plot(rows[front, SPEED], rows[front, POWER], "-o", markersize=3, color="C3", label="front")
    top = rows[front, POWER].max() if front.size else 1.0
    cloud.set(xlabel="speed, m/s", ylabel="power, W", title=f"{result.robot.name}: power", ylim=(0, 2 * top))
    cloud.legend(frameon=False)
    omega = rows[front, 2]
    angles.plot(omega, np.degrees(rows[front, 0]), "o", markersize=4, label="alpha", alpha=0.6)
    angles.plot(omega, np.degrees(rows[front, 1]), "s", markersize=4, label="beta", alpha=0.6)
    angles.set(xlabel="omega, rad/s", ylabel="deg", title="gaits of the front", ylim=(0, None))
    angles.legend(frameon=False)
    optima = result.optima
    speeds = np.array([row["speed_m_s"] for row in optima])
    line.plot(speeds, [row["omega_rad_s"] for row in optima], "o", color="C0")
    slope, intercept = result.omega_over_speed()
    if np.isfinite(slope):
        line.plot(
            speeds, slope * speeds + intercept, color="C3", label=f"omega = {slope:.2f} v {intercept:+.2f}"
        )
        line.legend(frameon=False)
    line.set(xlabel="speed, m/s", ylabel="omega, rad/s", title="fastest gait of each omega")
    return figure


def grid_figure(grid: Grid) -> Figure:
    """Speed and power over alpha and beta, a number in every cell: the figure grows with the grid."""
    import numpy as np

    alphas, betas = np.asarray(grid.alpha_deg), np.asarray(grid.beta_deg)
    width, height = max(5.4, 1.8 + 0.62 * len(betas)), max(4.4, 1.4 + 0.42 * len(alphas))
    figure = new_figure(columns=2, width=width, height=height)
    pairs = (("speed", "m/s", grid.speed_m_s), ("power", "W", grid.power_w))
    for axes, (name, unit, values) in zip(figure.axes, pairs, strict=True):
        axes.grid(visible=False)
        image = axes.pcolormesh(betas, alphas, values, cmap="viridis")
        low, high = image.get_clim()
        for i, alpha in enumerate(alphas):
            for j, beta in enumerate(betas):
                # viridis ends in yellow: white is read on its lower part only
                color = "k" if values[i, j] > low + 0.6 * (high - low) else "w"
                text = significant(float(values[i, j]), 3, 3)
                axes.text(beta, alpha, text, ha="center", va="center", fontsize=10, color=color)
        axes.set_xticks(betas)
        axes.set_yticks(alphas)
        axes.tick_params(labelsize=11)
        axes.set_xlabel("beta, deg (phase from joint to joint)", fontsize=12)
        axes.set_ylabel("alpha, deg (amplitude)", fontsize=12)
        axes.set_title(f"{grid.robot.name}: {name} at omega {grid.omega_rad_s:g} rad/s", fontsize=13)
        bar = figure.colorbar(image, ax=axes)
        bar.set_label(f"{name}, {unit}", fontsize=12)
        bar.ax.tick_params(labelsize=11)
    return figure


def faults_figure(cases: Sequence[FaultCase]) -> Figure:
    """Speed ratio and power ratio of single and double faults."""
    shown = [case for case in cases if len(case.joints) in (1, 2)]
    figure = new_figure(width=11)
    axes = figure.axes[0]
    places = range(len(shown))
    colours = ["C0" if case.kind == "free" else "C3" for case in shown]
    axes.bar(places, [case.speed_ratio for case in shown], color=colours)
    axes.plot(places, [case.power_ratio for case in shown], "k_", markersize=9, label="power ratio")
    axes.axhline(1.0, color="0.5", linewidth=0.8)
    axes.set_xticks(places, [case.label for case in shown], rotation=90)
    axes.set(ylabel="ratio to the healthy robot", title="speed with failed joints (blue free, red rigid)")
    axes.legend(frameon=False)
    return figure


def speed_figure(rows: Sequence[SimulatedSpeed]) -> Figure:
    """Speed against omega for ideal joints, these servos and their fitted sines (Fig. 21); tracking error."""
    figure = new_figure(columns=2, width=5.0)
    speed, error = figure.axes
    omega = [row.omega_rad_s for row in rows]
    speed.plot(omega, [row.ideal_speed_m_s for row in rows], "-", color="0.6", label="ideal tracking")
    speed.plot(omega, [row.speed_m_s for row in rows], "o-", label="with these servos")
    speed.plot(omega, [row.sine_replay_speed_m_s for row in rows], "x", color="C3", label="replayed sines")
    speed.set(xlabel="omega, rad/s", ylabel="speed, m/s", title="speed", ylim=(0, None))
    speed.legend(frameon=False)
    for joint in range(len(rows[0].tracking_error)):
        error.plot(omega, [row.tracking_error[joint] for row in rows], ".-", label=f"joint {joint + 1}")
    error.set(
        xlabel="omega, rad/s",
        ylabel="TE",
        title="tracking error TE: rms error over amplitude",
        ylim=(0, None),
    )
    error.legend(frameon=False)
    return figure


def friction_figure(table: Sequence[Measurement], fit: FrictionFit) -> Figure:
    """Tangential and normal friction against velocity, measured and fitted (Figs. 12 and 14)."""
    import numpy as np

    from snakebot.studies.friction import forces

    figure = new_figure(columns=2, width=4.6)
    names = (("tangential", "ct", "ct0"), ("normal", "cn", "cn0"))
    for axes, points, (name, slope, offset) in zip(figure.axes, forces(table, fit), names, strict=True):
        axes.set(xlabel="velocity, m/s", ylabel="force, N", title=f"{name} friction of a link")
        if not points or np.isnan(fit.estimate[slope]):
            continue
        velocity, force = np.array(points).T
        line = np.linspace(0, velocity.max() * 1.05, 50)
        axes.plot(velocity, force, "o")
        label = f"{fit.estimate[slope]:.3g} v + {fit.estimate[offset]:.3g}"
        axes.plot(line, fit.estimate[slope] * line + fit.estimate[offset], color="C3", label=label)
        axes.legend(frameon=False)
    return figure
