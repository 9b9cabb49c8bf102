"""How the studies' figures look, and where they go: PNG and SVG beside the results."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from snakebot.errors import BadInputError
from snakebot.studies.pareto import POWER, SPEED, Pareto

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def new_figure(columns: int = 1, width: float = 6.0, height: float = 4.0) -> Figure:
    """A figure without a window, with that many plots side by side."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width * columns, height), layout="constrained")
    for axes in figure.subplots(1, columns, squeeze=False)[0]:
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
        raise BadInputError(f"{folder}: cannot write the figures: {error.strerror}") from None
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
    angles.set(xlabel="omega, rad/s", ylabel="deg", title="gaits of the front", ylim=(0, 125))
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
