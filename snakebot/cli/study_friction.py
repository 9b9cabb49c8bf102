"""``snakebot study friction | dissipation``: friction and power from what a treadmill and encoders tell."""

from __future__ import annotations

from pathlib import Path

import click

from snakebot.cli.study_output import common, finish, table_text


@click.command(
    name="friction",
    epilog="""\b
Examples:
  snakebot study friction bench.csv
  snakebot study friction bench.csv --link-mass 1.43 --json

\b
bench.csv, one row an equilibrium (link_angle_deg 0 for straight joints):
  incline_deg,belt_speed_m_s,link_angle_deg
  2.4,0.12,0
  9.1,0.20,15
""",
)
@click.argument("table_path", metavar="TABLE", type=click.Path(path_type=Path))
@common
@click.option("--link-mass", type=float, help="kg [the robot's mean].")
def friction_command(
    table_path: Path, robot_source: str, out: Path | None, as_json: bool, link_mass: float | None
) -> None:
    """Friction coefficients of a link from inclines and belt speeds, with 95 % intervals."""
    import pyarrow as pa

    from snakebot.errors import BadInputError
    from snakebot.robot import load_robot
    from snakebot.studies.figures import friction_figure, save
    from snakebot.studies.friction import NAMES, UNITS, fit_friction, read_table
    from snakebot.studies.sweep import write_parquet

    robot = load_robot(robot_source)
    if link_mass is None:
        if robot.body is None:
            raise BadInputError(f"robot {robot.name!r} has no body: give --link-mass")
        masses = robot.body.link_mass_kg
        link_mass = sum(masses) / len(masses) if isinstance(masses, tuple) else masses
    table = read_table(table_path)
    fit = fit_friction(table, link_mass)
    folder = out or Path("results") / f"friction_{table_path.stem}"
    summary = fit.summary()
    rows = [{"name": name, **values} for name, values in summary["coefficients"].items()]
    write_parquet(folder / "friction.parquet", pa.Table.from_pylist(rows))
    files = [folder / "friction.parquet", *save(friction_figure(table, fit), folder, "friction")]

    def show() -> None:
        body = [
            [
                name,
                f"{fit.estimate[name]:.4g}",
                f"{fit.ci95[name][0]:.4g}",
                f"{fit.ci95[name][1]:.4g}",
                UNITS[name],
            ]
            for name in NAMES
        ]
        title = f"{fit.rows} rows, link of {link_mass:g} kg, residual {fit.residual_rms_n:.3g} N rms"
        click.echo(table_text(title, ["", "estimate", "95 % from", "to", "unit"], body))

    finish(summary, as_json, show, files)


@click.command(
    name="dissipation",
    epilog="""\b
Examples:
  snakebot study dissipation runs/REAL.mcap
  snakebot study dissipation runs/REAL.mcap --speed 0.131 --json
""",
)
@click.argument("run_path", metavar="RUN", type=click.Path(path_type=Path))
@click.option("--speed", type=float, help="Measured forward speed, m/s [the run's own].")
@click.option("--json", "as_json", is_flag=True, help="Print the result as one JSON object.")
def dissipation_command(run_path: Path, speed: float | None, as_json: bool) -> None:
    """Power that a run loses on the ground, from encoders and a speed alone."""
    from snakebot.studies.dissipation import dissipation

    result = dissipation(run_path, speed)

    def show() -> None:
        model = result["power_in_model_w"]
        click.echo(
            f"{result['run']}: {result['power_dissipated_w']:.4f} W lost on the ground at {result['speed_m_s']:.4f} m/s"
            + ("" if model is None else f"; the model puts {model:.4f} W in for the same joint angles")
        )

    finish(result, as_json, show, [])
