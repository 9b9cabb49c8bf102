"""``snakebot analyze``: what runs say about tracking, speed, power and link."""

from __future__ import annotations

from pathlib import Path

import click

from snakebot.cli.robot_option import robot_option

EPILOG = """\b
Examples:
  snakebot analyze runs/2026-11-21_a66_b80_w2.mcap
  snakebot analyze runs/*.mcap --report report.html
  snakebot analyze session/ --json
  snakebot analyze session/run_01.csv --robot configs/robots/penn_state.yaml

\b
RUN is a run log (.mcap, also an unfinished .mcap.part), a session folder (all its runs), or one run of a session.
"""


@click.command(name="analyze", epilog=EPILOG)
@click.argument("runs", metavar="RUN...", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--report", type=click.Path(path_type=Path), help="Write figures and tables to one HTML file.")
@robot_option("Use this robot description in place of the one in the runs.", default=None)
@click.option("--no-model", is_flag=True, help="Leave the simulation out: no predicted speed, no power.")
@click.option("--json", "as_json", is_flag=True, help="Print the results as one JSON object, SI units.")
def command(
    runs: tuple[Path, ...], report: Path | None, robot_source: str | None, no_model: bool, as_json: bool
) -> None:
    """Tracking error, least-squares sines, harmonics, hysteresis, speed, power and link quality of runs.

    Figures are taken over the steady state, which is chosen automatically and shown. Several runs are also set side by
    side: speed of each gait, speed around a gait, speed with failed joints. Runs with other effects, another robot or
    another bend stand apart; one that did not finish is listed and enters no average.
    """
    import json

    from snakebot.analysis import analyze_run, load, paper_tables
    from snakebot.cli.analysis_output import command_line, write_page
    from snakebot.robot import load_robot

    found = load(runs, load_robot(robot_source) if robot_source else None)
    analyses = [analyze_run(item.run, item.robot, predict=not no_model) for item in found]
    tables = paper_tables(analyses)
    if report is not None:
        from snakebot.analysis.report import analysis_page

        write_page(analysis_page(analyses, tables, command_line()), report)
    if as_json:
        from snakebot.analysis.as_json import analysis_json

        click.echo(json.dumps(analysis_json(analyses, tables), allow_nan=False))
        return
    from snakebot.analysis.as_text import analysis_text

    click.echo(analysis_text(analyses, tables))
    if report is not None:
        click.echo(f"report: {report}")
