"""``snakebot study``: the paper's experiments. A study's module is imported only when it is called."""

from __future__ import annotations

import importlib

import click

from snakebot.cli.groups import Group

# name -> (module, attribute, one line of help)
STUDIES: dict[str, tuple[str, str, str]] = {
    "pareto": (
        "study_pareto",
        "pareto_command",
        "Speed and power of 9000 gaits, and which is cheapest at each speed.",
    ),
    "grid": ("study_gaits", "grid_command", "Speed and power of the gaits around one gait."),
    "faults": (
        "study_gaits",
        "faults_command",
        "Speed and power with joints that are free or rigid, up to three at a time.",
    ),
    "speed": (
        "study_gaits",
        "speed_command",
        "Speed and tracking error against omega, with servos that are not ideal.",
    ),
    "friction": (
        "study_friction",
        "friction_command",
        "Friction coefficients from a treadmill bench.",
    ),
    "dissipation": (
        "study_friction",
        "dissipation_command",
        "Power that a run loses on the ground, from its encoders.",
    ),
    "paper": ("study_paper", "paper_command", "Each claim of the paper: its value, ours, agree or not, why."),
    "infer": (
        "study_paper",
        "infer_command",
        "Length and mass of the paper's links, from what its text gives.",
    ),
    "gap": ("study_paper", "gap_command", "Servo effects that explain the paper's robot at omega = 4 and 5."),
}

EPILOG = """\b
Examples:
  snakebot study pareto --robot penn_state
  snakebot study faults --json
  snakebot study speed --effect rate_limit:limit_rad_s=2.6
  snakebot study friction bench.csv
  snakebot study paper --quick
"""


class LazyStudies(Group):
    """Studies by name, imported when asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(STUDIES)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in STUDIES:
            return None
        module, attribute, _ = STUDIES[cmd_name]
        found = getattr(importlib.import_module(f"snakebot.cli.{module}"), attribute)
        assert isinstance(found, click.Command)
        return found

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, _, text) in STUDIES.items()])


@click.group(name="study", cls=LazyStudies, epilog=EPILOG)
def command() -> None:
    """The paper's experiments on any robot: results as Parquet, figures as PNG and SVG.

    A long study can be interrupted and started again: what is computed is kept.
    """
