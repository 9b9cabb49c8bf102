"""How ``snakebot optimize`` tells what it chose: tables, sentences, a file that ``snakebot run --gait`` reads."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from snakebot.cli.study_output import table_text

if TYPE_CHECKING:
    from snakebot.optimise.optimum import Optimum
    from snakebot.optimise.promise import Promise
    from snakebot.robot import Robot


def gait_file(result: Optimum, folder: Path, robot_source: str) -> Path:
    """``gait.yaml``, as `snakebot run --gait` reads it; it says for which robot, as the command was given it."""
    from snakebot.safe_yaml import dump_yaml
    from snakebot.whole_files import write_all

    found, path = result.found, folder / "gait.yaml"
    text = dump_yaml(
        {
            "alpha_deg": round(found.alpha_deg, 2),
            "beta_deg": round(found.beta_deg, 2),
            "omega_rad_s": round(found.omega_rad_s, 4),
            **({"amplitudes": list(found.amplitudes)} if found.amplitudes else {}),
            "source": f"snakebot optimize {shlex.quote(robot_source)} --for {result.goal.aim}",
        }
    )
    write_all([(path, text)])
    return path


def show(result: Optimum, robot: Robot, which: str = "") -> None:
    """The choice beside others, the front, and what to know of them, on the terminal.

    Args:
        which: options of `snakebot run` that name the robot and what was added to it.
    """
    from snakebot.optimise.posterior import is_known

    head = ["", "alpha deg", "beta deg", "omega rad/s", "speed m/s", "95 %", "power W", "95 %", "cost of tr.",
            "torque N m", "limited by"]  # fmt: skip
    left = [0, len(head) - 1]
    marked = [_row(row) for row in (result.found, *result.others)]
    title = f"{robot.name}: best gait for {result.goal.aim}"
    if result.goal.speed_m_s is not None:
        title += f" of {result.goal.speed_m_s:g} m/s"
    effects = ", ".join(result.effects)
    click.echo(table_text(f"{title}{f', with {effects}' if effects else ''}", head, marked, left))
    front = [_row(row)[1:] for row in result.front]
    slim = [i for i in range(len(head) - 1) if head[1:][i] != "95 %"]
    click.echo(
        table_text(
            "Front: no other gait is faster and takes less power",
            [head[1:][i] for i in slim], [[row[i] for i in slim] for row in front], [len(slim) - 1],
        )
    )  # fmt: skip
    for line in _words(result, which, known=is_known(robot)):
        click.echo(line)


def _row(row: Promise) -> list[str]:
    return [
        row.what, f"{row.alpha_deg:.1f}", f"{row.beta_deg:.1f}", f"{row.omega_rad_s:.2f}", f"{row.speed_m_s:.4f}",
        _span(row.speed_ci95), f"{row.power_w:.3f}", _span(row.power_ci95), f"{row.cost_of_transport:.3f}",
        f"{row.torque_nm:.2f}", ", ".join(row.binds) or "nothing",
    ]  # fmt: skip


def _span(ends: tuple[float, float] | None) -> str:
    return "" if ends is None else f"{ends[0]:.3f} to {ends[1]:.3f}"


def _words(result: Optimum, which: str, *, known: bool) -> Iterator[str]:
    found = result.found
    if result.draws:
        yield (
            f"Over {result.draws} robots as the description may mean: at the worst {found.speed_worst_m_s:.4f} m/s, "
            f"{found.power_worst_w:.3f} W{'; the choice has the best worst case' if result.robust else ''}."
        )
    yield from beyond_words(found)
    if found.beyond:
        yield "Before you rely on it: record this gait and diagnose again, or choose with --within-recorded."
    if not known:
        yield "A fitted effect of this description has no interval: what it adds is not in the 95 %."
    if abs(found.turn_deg) > 1:
        yield f"This gait turns the robot by {found.turn_deg:.1f} deg a cycle."
    if found.amplitudes:
        each = ", ".join(f"{found.alpha_deg * share:.1f}" for share in found.amplitudes)
        yield f"Amplitudes of the joints, from the tail on: {each} deg; the front is that of equal ones."
    wave = f"--alpha {found.alpha_deg:.2f} --beta {found.beta_deg:.2f} --omega {found.omega_rad_s:.4f}"
    yield f"snakebot run {wave}{found.gait.shares_option}{which}"


def beyond_words(found: Promise) -> Iterator[str]:
    """What a gait asks for that the recordings do not tell, and what that may cost."""
    if not found.beyond:
        return
    asked = ", ".join(map(str, found.beyond))
    yield f"Beyond the recordings: {asked}. What shows only there is not in the 95 %."
    if found.speed_no_more_m_s is not None:
        yield f"If the servos can do no more than was recorded, it makes {found.speed_no_more_m_s:.4f} m/s."
