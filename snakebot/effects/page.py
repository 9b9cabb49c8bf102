"""One page of documentation for each effect, made from the effect itself."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from snakebot.effects.effect import STAGES
from snakebot.effects.registry import LIBRARY, find_effect
from snakebot.effects.telling import title

if TYPE_CHECKING:
    from snakebot.effects.effect import Effect
    from snakebot.effects.parameter import Parameter

STAGE_TITLES = {
    "link": "Link: from command to set-point",
    "servo": "Servo: from set-point to joint angle",
    "sensor": "Sensor: from joint angle to reading",
    "body": "Body: from joint angles to motion over ground",
}
MADE = "<!-- Made by: python -m snakebot.effects.page docs/effects -->\n"


def example_options(effect: Effect) -> str:
    """Of ``snakebot run``, for the example."""
    return ("--robot bench.yaml " if effect.example_robot else "") + f"--effect {effect.example}"


def effect_page(effect: Effect) -> str:
    """Markdown page of one effect."""
    lines = [MADE, f"# {effect.name}: {title(effect)}", "", effect.summary, "", f"Stage: {effect.stage}."]
    lines[-1] += (
        " It may hold for all joints or for some." if effect.per_joint else " It holds for the whole robot."
    )
    lines += ["", "## Its mark", "", effect.mark]
    if effect.look:
        lines += ["", "## What to look at on the robot", "", effect.look]
    lines += ["", "## Parameters", ""]
    if effect.parameters:
        lines += [
            "| name | unit | bounds | default | fitted | prior | meaning |",
            "|---|---|---|---|---|---|---|",
        ]
        lines += [_row(parameter) for parameter in effect.parameters]
    else:
        lines += ["None."]
    lines += [
        "",
        "## Try it",
        "",
    ]
    if effect.example_robot:
        lines += ["On this robot, as `bench.yaml`:", "", "```yaml", effect.example_robot.rstrip(), "```", ""]
    lines += ["```sh", f"snakebot run --alpha 66 --beta 80 --omega 2 {example_options(effect)}", "```"]
    if effect.confused_with:
        lines += ["", "## What leaves nearly the same mark", ""]
        lines += [f"* [{name}]({name}.md): {text}." for name, text in effect.confused_with]
    return "\n".join(lines) + "\n"


def _row(p: Parameter) -> str:
    default = "must be given" if p.default is None else f"{p.default:g}"
    if p.many:
        default = "none" if p.default == 0 else f"{p.default:g} each"
    if p.many or p.integer:
        prior = "each alike"
    elif p.scale == "log":
        prior = f"log-normal about {p.typical:g}, factor {2.718281828459045**p.spread:.2g}"
    else:
        prior = f"normal about {p.typical:g}, spread {p.spread:g}"
    unit = p.unit or "1"
    bounds = f"{p.lower:g} to {p.upper:g}"
    return (
        f"| `{p.name}` | {unit} | {bounds} | {default} | {'yes' if p.fitted else 'no'} | {prior} | {p.doc} |"
    )


def index_page() -> str:
    """Markdown page that lists them all, in the order of the signal."""
    lines = [
        MADE,
        "# Unmodelled effects",
        "",
        "What may lie between the nominal simulation and a real robot. The simulated board injects them",
        "(`--effect NAME:parameter=value,joints=3+4`), a robot description may have them (`effects: [...]`), and",
        "`snakebot diagnose` fits them. Any set of them works together, in the order of the signal.",
        "Your own: [add an effect](../add-an-effect.md).",
    ]
    for stage in STAGES:
        lines += ["", f"## {STAGE_TITLES[stage]}", "", "| effect | what is different |", "|---|---|"]
        for name in LIBRARY:
            effect = find_effect(name)
            if effect.stage == stage:
                lines.append(f"| [{name}]({name}.md) | {effect.summary} |")
    return "\n".join([*lines, "", HOW.strip()]) + "\n"


HOW = """
## How they are computed

* One compiled kernel serves the simulated board and the fit, so what is injected is what is fitted.
* Set-points are held until the next one. First-order lag, dead band and rate limit are then exact whatever the step;
  the second-order response is exact while no limit bites.
* What is left to chance (lost set-points, noise) is in a prediction as its mean, and as a variance beside it.
* `torque_limit`, `torque_speed`, `compliance` and `joint_friction` depend on the torque that a joint bears. With a body
  that comes from the chain's dynamics, all joints together. On a bench it comes from the arm, if the robot's
  description has one, and is quasi-static; without an arm these effects do nothing, but for the loop of
  `joint_friction`:

```yaml
joints: 1
servo:
  time_constant_s: 0.03
  arm: {mass_kg: 0.25, length_m: 0.15, down_deg: -90}   # also drag_nm_s, coulomb_nm: friction while the servo is off
```

* With a body the motor of `torque_speed` gives what its line says at the joint's speed of that instant, and brakes
  beyond the no-load speed; `torque_limit` cuts the line off: the lesser of both holds. The loop before it, first or
  second order, keeps its shape within that torque. On a bench the line is a limit on speed under the arm's load.
* A servo without a set-point lets its joint swing: with the body, or on a bench with its arm as a pendulum.
* Servos do not jump in speed: the body follows its joints through a smoothing of 10 ms, and its pose is carried on by
  as much. In a run at an even 100 Hz, speed and power are those of smooth joint motion within 1 %.
"""


def pages() -> dict[str, str]:
    """File name to content, of everything in docs/effects."""
    return {"README.md": index_page(), **{f"{name}.md": effect_page(find_effect(name)) for name in LIBRARY}}


def write_pages(folder: Path) -> list[Path]:
    """Write all pages and take away those of effects that are no more."""
    folder.mkdir(parents=True, exist_ok=True)
    made = pages()
    for old in folder.glob("*.md"):
        if old.name not in made and old.read_text(encoding="utf-8").startswith(MADE):
            old.unlink()
    for name, text in made.items():
        (folder / name).write_text(text, encoding="utf-8")
    return [folder / name for name in made]


if __name__ == "__main__":
    import sys

    target = Path(sys.argv[1] if len(sys.argv) > 1 else "docs/effects")
    print(f"{len(write_pages(target))} pages written to {target}")
