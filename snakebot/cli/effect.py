"""``snakebot effect``: the known effects, and what each is."""

from __future__ import annotations

import json
import textwrap
from typing import TYPE_CHECKING, Any

import click

from snakebot.cli.names import effect_names

if TYPE_CHECKING:
    from snakebot.effects.effect import Effect


@click.group(
    name="effect",
    epilog="""\b
Examples:
  snakebot effect list
  snakebot effect show backlash
""",
)
def command() -> None:
    """What a nominal simulation leaves out: list the known effects, show one."""


@command.command(
    name="list",
    epilog="""\b
Examples:
  snakebot effect list
  snakebot effect list --stage servo
  snakebot effect list --json
""",
)
@click.option("--stage", type=click.Choice(["link", "servo", "sensor", "body"]), help="Of this stage only.")
@click.option("--json", "as_json", is_flag=True, help="Print a JSON array.")
def list_(stage: str | None, as_json: bool) -> None:
    """All effects, in the order of the signal."""
    from snakebot.effects.effect import STAGES
    from snakebot.effects.registry import effects

    known = effects()
    found = [e for s in STAGES if stage in (None, s) for e in known.values() if e.stage == s]
    if as_json:
        click.echo(json.dumps([_told(effect) for effect in found]))
        return
    from snakebot.effects.telling import title

    name, words = (
        max(len(text) for text in texts) for texts in ([e.name for e in found], [title(e) for e in found])
    )
    for effect in found:
        click.echo(f"{effect.name:{name}}  {effect.stage:6}  {title(effect):{words}}")


@command.command(
    name="show",
    epilog="""\b
Examples:
  snakebot effect show backlash
  snakebot effect show rate_limit --json
""",
)
@click.argument("name", shell_complete=effect_names)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def show(name: str, as_json: bool) -> None:
    """What an effect is, what it leaves in the data, what to look at, how to have it on the simulated board."""
    from snakebot.effects.page import example_options
    from snakebot.effects.registry import find_effect
    from snakebot.effects.telling import title

    effect = find_effect(name)
    if as_json:
        click.echo(json.dumps(_told(effect)))
        return
    click.echo(f"{effect.name}: {title(effect)} ({effect.stage})")
    click.echo(effect.summary)
    click.echo(f"Its mark: {effect.mark}")
    for other, tells in effect.confused_with:
        click.echo(f"Like {other}: {tells}.")
    if effect.look:
        click.echo(effect.look)
    for p in effect.parameters:
        default = "" if p.default is None else f", {p.default:g} if not given"
        click.echo(f"  {p.name}: {p.called}, {p.bounds_text}{default} ({p.doc})")
    if effect.per_joint:
        click.echo("  joints: as in 3+4, all if not given")
    if effect.example_robot:
        click.echo("Try it on this robot, as bench.yaml:")
        click.echo(textwrap.indent(effect.example_robot.rstrip(), "  "))
    click.echo(f"Try it: snakebot run --alpha 66 --beta 80 --omega 2 {example_options(effect)}")


def _told(effect: Effect) -> dict[str, Any]:
    from snakebot.effects.telling import title

    return {
        "name": effect.name,
        "title": title(effect),
        "stage": effect.stage,
        "summary": effect.summary,
        "mark": effect.mark,
        "look": effect.look,
        "confused_with": dict(effect.confused_with),
        "per_joint": effect.per_joint,
        "parameters": [
            {
                "name": p.name,
                "words": p.called,
                "unit": p.unit,
                "lower": p.lower,
                "upper": p.upper,
                "default": p.default,
                "doc": p.doc,
            }
            for p in effect.parameters
        ],
        "example": effect.example,
    }
