"""``snakebot study grid | faults | speed``: one gait and its surroundings."""

from __future__ import annotations

from pathlib import Path

import click

from snakebot.cli import names
from snakebot.cli.study_output import common, finish, progress_bar, table_text

OPTIMUM = "penn_state_optimum"


@click.command(
    name="grid",
    epilog="""\b
Examples:
  snakebot study grid
  snakebot study grid --gait penn_state_optimum --alpha-step 3 --beta-step 5 --reach 3 --json
""",
)
@common
@click.option(
    "--gait",
    "gait_source",
    shell_complete=names.gaits,
    default=OPTIMUM,
    show_default=True,
    help="The gait in the middle.",
)
@click.option("--alpha-step", type=click.FloatRange(min=0.01), default=6.0, show_default=True, help="deg")
@click.option("--beta-step", type=click.FloatRange(min=0.01), default=10.0, show_default=True, help="deg")
@click.option("--reach", type=click.IntRange(1, 10), default=2, show_default=True, help="Steps either side.")
def grid_command(
    robot_source: str,
    out: Path | None,
    as_json: bool,
    gait_source: str,
    alpha_step: float,
    beta_step: float,
    reach: int,
) -> None:
    """Speed and power of the gaits around one gait: rows are alpha, columns beta."""
    from snakebot.gait import load_gait
    from snakebot.robot import load_robot
    from snakebot.studies.figures import grid_figure, save
    from snakebot.studies.near_optimum import near_optimum
    from snakebot.studies.sweep import write_parquet

    robot, gait = load_robot(robot_source), load_gait(gait_source).even()
    grid = near_optimum(robot, gait, alpha_step, beta_step, reach)
    folder = out or Path("results") / f"grid_{robot.name}"
    import pyarrow as pa

    rows = [
        {"alpha_deg": a, "beta_deg": b, "speed_m_s": grid.speed_m_s[i, j], "power_w": grid.power_w[i, j]}
        for i, a in enumerate(grid.alpha_deg)
        for j, b in enumerate(grid.beta_deg)
    ]
    write_parquet(folder / "grid.parquet", pa.Table.from_pylist(rows))
    files = [folder / "grid.parquet", *save(grid_figure(grid), folder, "grid")]

    def show() -> None:
        head = ["alpha \\ beta deg", *(f"{b:g}" for b in grid.beta_deg)]
        for title, values in (("speed, m/s", grid.speed_m_s), ("power, W", grid.power_w)):
            body = [
                [f"{a:g}", *(f"{v:.4f}" for v in line)]
                for a, line in zip(grid.alpha_deg, values, strict=True)
            ]
            click.echo(table_text(f"{robot.name}, omega {grid.omega_rad_s:g} rad/s: {title}", head, body))

    finish(grid.summary(), as_json, show, files)


@click.command(
    name="faults",
    epilog="""\b
Examples:
  snakebot study faults
  snakebot study faults --robot penn_state --most 2 --json
""",
)
@common
@click.option(
    "--gait",
    "gait_source",
    shell_complete=names.gaits,
    default=OPTIMUM,
    show_default=True,
    help="Gait by name or file.",
)
@click.option(
    "--most", type=click.IntRange(1, 5), default=3, show_default=True, help="Failed joints at a time."
)
def faults_command(robot_source: str, out: Path | None, as_json: bool, gait_source: str, most: int) -> None:
    """Speed and power with every single, pair and triple of joints free or rigid, beside the healthy robot."""
    from dataclasses import asdict

    import pyarrow as pa

    from snakebot.gait import load_gait
    from snakebot.robot import load_robot
    from snakebot.studies.figures import faults_figure, save
    from snakebot.studies.hyperredundancy import fault_cases
    from snakebot.studies.sweep import write_parquet

    robot, gait = load_robot(robot_source), load_gait(gait_source).even()
    with progress_bar("faults", as_json) as progress:
        cases = fault_cases(robot, gait, most, progress)
    folder = out or Path("results") / f"faults_{robot.name}"
    rows = [{**asdict(case), "joints": list(case.joints), "label": case.label} for case in cases]
    write_parquet(folder / "faults.parquet", pa.Table.from_pylist(rows))
    files = [folder / "faults.parquet", *save(faults_figure(cases), folder, "faults")]

    def show() -> None:
        head = ["joints", "speed m/s", "ratio", "power W", "ratio"]
        body = [
            [
                case.label,
                f"{case.speed_m_s:.4f}",
                f"{case.speed_ratio:.3f}",
                f"{case.power_w:.3f}",
                f"{case.power_ratio:.2f}",
            ]
            for case in cases
        ]
        click.echo(table_text(f"{robot.name}: {gait}", head, body))

    finish({"robot": robot.name, "gait": str(gait), "cases": rows}, as_json, show, files)


@click.command(
    name="speed",
    epilog="""\b
Examples:
  snakebot study speed
  snakebot study speed --effect rate_limit:limit_rad_s=2.6 --effect servo_lag:time_constant_s=0.1
  snakebot study speed --omega 1 --omega 3 --omega 5 --json
""",
)
@common
@click.option(
    "--gait",
    "gait_source",
    shell_complete=names.gaits,
    default=OPTIMUM,
    show_default=True,
    help="Alpha and beta of all gaits.",
)
@click.option(
    "--omega", "omegas", type=float, multiple=True, help="rad/s; several [0.5 to 5 in steps of 0.5]."
)
@click.option(
    "--effect",
    "effects",
    shell_complete=names.effects,
    multiple=True,
    help="What the servos do besides their lag: NAME:param=value.",
)
def speed_command(
    robot_source: str,
    out: Path | None,
    as_json: bool,
    gait_source: str,
    omegas: tuple[float, ...],
    effects: tuple[str, ...],
) -> None:
    """Speed and tracking error against omega with servos that are not ideal.

    Beside it stands the speed with the least-squares sines of the joint angles replayed.
    """
    from dataclasses import asdict, replace

    import pyarrow as pa

    from snakebot.gait import load_gait
    from snakebot.robot import load_robot
    from snakebot.studies.figures import save, speed_figure
    from snakebot.studies.speed import speed_study, summary
    from snakebot.studies.sweep import write_parquet

    robot, gait = load_robot(robot_source), load_gait(gait_source).even()
    chosen = omegas or tuple(0.5 * step for step in range(1, 11))
    gaits = [replace(gait, omega_rad_s=omega) for omega in chosen]
    with progress_bar("gaits", as_json) as progress:
        rows = speed_study(robot, gaits, effects, progress)
    folder = out or Path("results") / f"speed_{robot.name}"
    plain = [{**asdict(row), "tracking_error": list(row.tracking_error)} for row in rows]
    write_parquet(folder / "speed.parquet", pa.Table.from_pylist(plain))
    files = [folder / "speed.parquet", *save(speed_figure(rows), folder, "speed")]

    def show() -> None:
        head = ["omega rad/s", "ideal m/s", "speed m/s", "error %", "sine replay m/s"]
        head += [f"TE {joint + 1}" for joint in range(robot.joints)]
        body = [
            [
                f"{row.omega_rad_s:g}",
                f"{row.ideal_speed_m_s:.4f}",
                f"{row.speed_m_s:.4f}",
                f"{row.speed_error_percent:.1f}",
                f"{row.sine_replay_speed_m_s:.4f}",
                *(f"{error:.3f}" for error in row.tracking_error),
            ]
            for row in rows
        ]
        click.echo(table_text(f"{robot.name}: {', '.join(effects) or 'nominal servos'}", head, body))
        click.echo("TE 1, ...: tracking error of each joint: rms error over the gait's amplitude")

    finish(summary(robot, effects, rows), as_json, show, files)
