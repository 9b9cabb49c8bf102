"""``snakebot study paper | infer | gap``: how far the paper is reproduced, and what it leaves to be inferred."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

import click

from snakebot.cli.study_output import common, finish, progress_bar, table_text

if TYPE_CHECKING:
    from snakebot.optimise.rechosen import Rechosen
    from snakebot.robot import Robot
    from snakebot.studies.gap import GapFit

VERDICT = {True: "yes", False: "NO", None: "-"}


@click.command(
    name="paper",
    epilog="""\b
Examples:
  snakebot study paper
  snakebot study paper --quick --json
""",
)
@click.option("--quick", is_flag=True, help="An eighth of the gaits, around the optima: for a look.")
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Folder [results/paper].")
@click.option("--json", "as_json", is_flag=True, help="Print the result as one JSON object.")
def paper_command(quick: bool, out: Path | None, as_json: bool) -> None:
    """Each claim of the paper: its value, ours, agree or not, and why.

    Computes what the claims need: four sweeps, the faults, the speeds with the inferred servo. Sweeps that are in the
    folder already are not computed again.
    """
    from snakebot.studies.figures import faults_figure, save, speed_figure
    from snakebot.studies.figures_paper import optima_figure
    from snakebot.studies.paper import paper_study, summary

    folder = out or Path("results") / ("paper_quick" if quick else "paper")
    with progress_bar("the paper's claims", as_json) as progress:
        done = iter(range(8))
        table, evidence = paper_study(folder, quick=quick, step=lambda what: progress(next(done), 7))
    files = [
        *save(optima_figure(evidence), folder, "optima"),
        *save(faults_figure(evidence.faults), folder, "faults"),
        *save(speed_figure(evidence.servo), folder, "speed"),
    ]

    def show() -> None:
        head = ["claim", "what", "paper", "ours", "agrees"]
        body = [[row.claim, row.what, row.paper, row.ours, VERDICT[row.agrees]] for row in table]
        title = "Mehta, Brennan & Gandhi 2008, reproduced" + (
            " (quick: a part of the gaits)" if quick else ""
        )
        lines = table_text(title, head, body, left=(0, 1, 2, 3, 4), screen=None).splitlines()
        click.echo("\n".join(lines[:2]))
        for line, row in zip(lines[2:], table, strict=False):
            click.echo(line.rstrip())
            if row.why:
                click.echo(textwrap.fill(row.why, 110, initial_indent=" " * 7, subsequent_indent=" " * 7))
        agree, disagree = (sum(row.agrees is value for row in table) for value in (True, False))
        click.echo(f"\n{agree} agree, {disagree} do not, {len(table) - agree - disagree} cannot be told\n")

    finish(summary(table, evidence), as_json, show, files)


@click.command(
    name="infer",
    epilog="""\b
Examples:
  snakebot study infer
  snakebot study infer --reading printed --reading no_normal_coulomb --json
""",
)
@common
@click.option(
    "--reading", "names", multiple=True, metavar="NAME", help="Only these readings of the friction model."
)
def infer_command(robot_source: str, out: Path | None, as_json: bool, names: tuple[str, ...]) -> None:
    """Half length and mass of the paper's links, by least squares on what its text gives.

    The friction model is read in several ways: none is told by the paper beyond the printed one, which does not lead
    to the paper's own optimal gaits. Beside them: which gait other rules than the least power for the speed choose.
    """
    from dataclasses import asdict

    from snakebot.errors import BadInputError
    from snakebot.robot import load_robot
    from snakebot.studies.figures import save
    from snakebot.studies.figures_paper import infer_figure
    from snakebot.studies.inference import READINGS, facts, infer, summary
    from snakebot.studies.rules import choices

    known = {reading.name: reading for reading in READINGS}
    for name in names:
        if name not in known:
            raise BadInputError(f"--reading {name}: known are {', '.join(known)}")
    robot = load_robot(robot_source)
    with progress_bar("readings of the friction model", as_json) as progress:
        results = infer(robot, [known[name] for name in names] or READINGS, progress)
    rules = choices(robot)
    folder = out or Path("results") / f"infer_{robot.name}"
    files = save(infer_figure(results), folder, "infer")

    def show() -> None:
        body = []
        for result in results:
            for index, (name, value) in enumerate(result.estimate.items()):
                low, high = result.ci95[name]
                first = (
                    [result.reading.name, f"{result.chi2:.0f} / {result.freedom}"] if index == 0 else ["", ""]
                )
                body.append([*first, name, f"{value:.4f}", f"{low:.4f} to {high:.4f}"])
        head = ["friction", "chi2 / freedom", "parameter", "estimate", "95 % interval"]
        click.echo(table_text("what is fitted, the best reading first", head, body, left=(0, 2)))
        for result in results:
            click.echo(f"{result.reading.name}: {result.reading.what}")
        click.echo()
        head = ["fact", "paper", *(result.reading.name for result in results)]
        body = [
            [
                fact.name,
                {0: "", 1: "over ", -1: "under "}[fact.bound] + f"{fact.paper:.3f}",
                *(
                    f"{r.ours[fact.name]:.3f}" + ("" if abs(fact.error(r.ours[fact.name])) <= 2 else " !")
                    for r in results
                ),
            ]
            for fact in facts()
        ]
        click.echo(table_text("what it comes to (! more than two sigma off)", head, body, left=(0,)))
        head = ["rule", "alpha deg", "beta deg", "speed m/s"]
        body = [[c.rule, f"{c.alpha_deg:.0f}", f"{c.beta_deg:.0f}", f"{c.speed_m_s:.3f}"] for c in rules]
        title = f"{robot.name} as it is: optimal gait at omega = 2 by other rules (the paper: 66, 80, 0.131)"
        click.echo(table_text(title, head, body, left=(0,)))

    finish({**summary(robot, results), "rules": [asdict(c) for c in rules]}, as_json, show, files)


@click.command(
    name="gap",
    epilog="""\b
Examples:
  snakebot study gap --quick
  snakebot study gap --effect torque_speed --rechoose
  snakebot study gap --effect torque_speed --effect servo_lag+rate_limit --json
""",
)
@common
@click.option(
    "--effect", "which", multiple=True, metavar="NAME[+NAME]", help="Only these effects or pairs [all]."
)
@click.option("--quick", is_flag=True, help="A coarser search.")
@click.option(
    "--rechoose",
    is_flag=True,
    help="Which gait would have been faster at 4 and 5, on the robot so explained?",
)
def gap_command(
    robot_source: str, out: Path | None, as_json: bool, which: tuple[str, ...], quick: bool, rechoose: bool
) -> None:
    """Which servo effects explain why the paper's robot falls short at omega = 4 and 5.

    Each effect alone and each pair is fitted by least squares to the published speeds. Fits that are in the folder
    already are not computed again.
    """
    from snakebot.errors import BadInputError
    from snakebot.robot import load_robot
    from snakebot.studies.figures import save
    from snakebot.studies.figures_paper import gap_figure
    from snakebot.studies.gap import RANGES, TARGETS, gap_study, paper_gait, summary
    from snakebot.studies.speed import speed_study

    chosen = [tuple(text.split("+")) for text in which]
    for name in {name for names in chosen for name in names}:
        if name not in RANGES:
            raise BadInputError(f"--effect {name}: known are {', '.join(RANGES)}")
    robot = load_robot(robot_source)
    folder = out or Path("results") / f"gap_{robot.name}"
    with progress_bar("effects", as_json) as progress:
        fits = gap_study(robot, folder, which=chosen or None, quick=quick, progress=progress)
    gaits = [paper_gait(0.5 * step) for step in range(2, 11)]
    shown = [*fits[:1], *(fit for fit in fits[1:] if len(fit.effects) == 1)]
    curves = {fit.label: speed_study(robot, gaits, fit.effects) for fit in shown}
    files = save(gap_figure(fits, curves), folder, "gap")
    again = _rechosen(robot, fits[0], quick) if rechoose else None

    def show() -> None:
        names = [f"{target.quantity}@{target.omega_rad_s:g}" for target in TARGETS]
        short = ["v/ideal @2", "v/ideal @3", "TE @3", "v @4", "v @5", "sine @4", "sine @5"]
        head = ["effects", "misfit", "score", *short, "values"]
        published = [f"{'< ' if t.quantity.endswith('_max') else ''}{t.value:g}" for t in TARGETS]
        body = [["published", "", "", *published, ""]]
        body += [
            [
                fit.label,
                f"{fit.misfit:.1f}",
                f"{fit.score:.1f}",
                *(f"{fit.values[name]:.3f}" for name in names),
                " ".join(text.partition(":")[2] for text in fit.effects),
            ]
            for fit in fits
        ]
        click.echo(table_text(f"{robot.name}: best score first", head, body, left=(0, len(head) - 1)))
        click.echo(
            "misfit: sum of squared errors over sigma; score: misfit and 2 for each fitted number\n"
            "@2 to @5: at omega 2 to 5 rad/s; v: speed, m/s; v/ideal: over that with ideal servos; TE: largest\n"
            "tracking error, rms over amplitude; sine: speed with the sines of the joint angles replayed, m/s\n"
        )
        if again is not None:
            _show_rechosen(again, fits[0].label)

    told = summary(robot, fits)
    if again is not None:
        told["rechosen"] = [row.summary() for row in again]
    finish(told, as_json, show, files)


def _rechosen(robot: Robot, best: GapFit, quick: bool) -> list[Rechosen]:
    """
    Raises:
        BadInputError: the best fit is the servo as it is.
    """
    from snakebot.errors import BadInputError
    from snakebot.optimise.rechosen import rechosen
    from snakebot.studies.gap import paper_gait

    if not best.effects:
        raise BadInputError("--rechoose: no effect explains the published speeds better than none")
    return rechosen(robot, best.effects, paper_gait, **({"grid": (5, 5, 2)} if quick else {}))


def _show_rechosen(rows: list[Rechosen], label: str) -> None:
    from snakebot.optimise.rechosen import CAVEATS

    head = ["omega rad/s", "gait", "alpha deg", "beta deg", "speed m/s", "to the paper's", "power W"]
    body = []
    for row in rows:
        told = (
            ("the paper's", row.paper),
            ("chosen without the effects", row.plain),
            ("chosen with them", row.found),
        )
        for what, gait in told:
            body.append(
                [
                    f"{row.omega_rad_s:g}", what, f"{gait.alpha_deg:.0f}", f"{gait.beta_deg:.0f}",
                    f"{gait.speed_m_s:.3f}", f"{gait.speed_m_s / row.paper.speed_m_s - 1:+.0%}", f"{gait.power_w:.2f}",
                ]
            )  # fmt: skip
    click.echo(table_text(f"Fastest gaits of the robot with {label}", head, body, left=(1,)))
    for row in rows:
        click.echo(
            f"omega {row.omega_rad_s:g}: the paper's gait makes {row.ideal_speed_m_s:.3f} m/s without the effects"
        )
    for caveat in CAVEATS:
        click.echo(textwrap.fill(caveat, 110))
    click.echo()
