"""``snakebot study``: the paper's experiments."""

from __future__ import annotations

import contextlib
import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import click

EPILOG = """\b
Examples:
  snakebot study pareto --robot penn_state
  snakebot study pareto --robot saito --out results/saito --json
"""


@click.group(name="study", epilog=EPILOG)
def command() -> None:
    """The paper's experiments on any robot: results as Parquet, figures as PNG and SVG.

    Each study can be interrupted and started again: what is computed is kept.
    """


def common(function: Callable[..., None]) -> Callable[..., None]:
    """Options that every study has."""
    for option in (
        click.option("--json", "as_json", is_flag=True, help="Print the result as one JSON object."),
        click.option(
            "--out",
            type=click.Path(path_type=Path, file_okay=False),
            help="Folder [results/<study>_<robot>].",
        ),
        click.option(
            "--robot", "robot_source", default="penn_state", show_default=True, help="Robot description."
        ),
    ):
        function = option(function)
    return function


@contextlib.contextmanager
def progress_bar(title: str, as_json: bool) -> Iterator[Callable[[int, int], None]]:
    """A bar on standard error; silent where nobody looks."""
    if as_json or not sys.stderr.isatty():
        yield lambda done, total: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=None)

        def update(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total)

        yield update


def finish(summary: dict[str, Any], as_json: bool, show: Callable[[], None], files: list[Path]) -> None:
    """Print the summary as JSON or through ``show``, and where the files are."""
    summary = {**summary, "files": [str(path) for path in files]}
    if as_json:
        click.echo(json.dumps(summary))
        return
    show()
    for path in files:
        click.echo(str(path))


@command.command(name="pareto", epilog=EPILOG)
@common
@click.option(
    "--refine",
    type=click.IntRange(0, 4),
    default=0,
    show_default=True,
    help="Rounds of finer gaits near the front.",
)
@click.option("--dask", metavar="ADDRESS", help="Hand the chunks to a dask.distributed cluster.")
def pareto_command(robot_source: str, out: Path | None, as_json: bool, refine: int, dask: str | None) -> None:
    """Speed and power of the paper's 9000 gaits, their front, and the optimal alpha, beta and omega."""
    from snakebot.robot import load_robot
    from snakebot.studies.figures import pareto_figure, save
    from snakebot.studies.pareto import pareto

    robot = load_robot(robot_source)
    folder = out or Path("results") / f"pareto_{robot.name}"
    with progress_bar(f"gaits of {robot.name}", as_json) as progress:
        result = pareto(robot, folder, refinements=refine, progress=progress, dask=dask)
    files = [folder / "pareto.parquet", *save(pareto_figure(result), folder, "pareto")]

    def show() -> None:
        from rich.console import Console
        from rich.table import Table

        slope, intercept = result.omega_over_speed()
        table = Table(title=f"{robot.name}: fastest gait of the front at each omega")
        for name in ("omega rad/s", "alpha deg", "beta deg", "speed m/s", "power W"):
            table.add_column(name, justify="right")
        for row in result.optima:
            table.add_row(
                f"{row['omega_rad_s']:g}",
                f"{row['alpha_deg']:.1f}",
                f"{row['beta_deg']:.1f}",
                f"{row['speed_m_s']:.4f}",
                f"{row['power_in_w']:.4f}",
            )
        console = Console(highlight=False)
        console.print(table)
        console.print(
            f"omega = {slope:.3f} v {intercept:+.3f}; {len(result.front)} of {len(result.rows)} gaits on the front"
        )

    finish(result.summary(), as_json, show, files)
