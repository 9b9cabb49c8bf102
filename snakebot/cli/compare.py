"""``snakebot compare``: one run beside its simulation."""

from __future__ import annotations

from pathlib import Path

import click

from snakebot.cli.robot_option import robot_option

EPILOG = """\b
Examples:
  snakebot compare runs/2026-11-21_a66_b80_w2.mcap
  snakebot compare real.mcap sim.mcap --report gap.html
  snakebot compare session/run_01.csv --json

\b
Without SIM the nominal simulation is made from the run's own robot description: the same commands at the same times.
"""


@click.command(name="compare", epilog=EPILOG)
@click.argument("real", type=click.Path(path_type=Path))
@click.argument("sim", required=False, type=click.Path(path_type=Path))
@click.option("--report", type=click.Path(path_type=Path), help="Write figures and tables to one HTML file.")
@robot_option("Use this robot description in place of the one in the run.", default=None)
@click.option("--json", "as_json", is_flag=True, help="Print the results as one JSON object, SI units.")
def command(
    real: Path, sim: Path | None, report: Path | None, robot_source: str | None, as_json: bool
) -> None:
    """Set REAL beside SIM: aligned in time to a fraction of a sample, then joint by joint.

    Each is a run log or one run of a session.
    """
    import json

    from snakebot.analysis import compare, load_one
    from snakebot.cli.analysis_output import command_line, write_page
    from snakebot.robot import load_robot

    robot = load_robot(robot_source) if robot_source else None
    found = compare(load_one(real, robot), load_one(sim) if sim is not None else None)
    if report is not None:
        from snakebot.analysis.report_compare import comparison_page

        write_page(comparison_page(found, command_line()), report)
    if as_json:
        from snakebot.analysis.as_json import comparison_json

        click.echo(json.dumps(comparison_json(found), allow_nan=False))
        return
    from snakebot.analysis.as_text import comparison_text

    click.echo(comparison_text(found))
    if report is not None:
        click.echo(f"report: {report}")
