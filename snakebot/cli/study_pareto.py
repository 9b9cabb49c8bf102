"""``snakebot study pareto``: the 9000 gaits and their front."""

from __future__ import annotations

from pathlib import Path

import click

from snakebot.cli.study_output import common, finish, progress_bar


@click.command(
    name="pareto",
    epilog="""\b
Examples:
  snakebot study pareto --robot penn_state
  snakebot study pareto --robot saito --refine 1 --out results/saito --json
""",
)
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
        from rich.table import Table

        from snakebot.cli.console import StandardOutput

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
        console = StandardOutput()
        console.print(table)
        console.print(
            f"omega = {slope:.3f} v {intercept:+.3f}; {len(result.front)} of {len(result.rows)} gaits on the front"
        )

    finish(result.summary(), as_json, show, files)
