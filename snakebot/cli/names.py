"""What a shell completes after an option: names of robots, gaits and effects, joints, ports."""

from __future__ import annotations

from typing import TYPE_CHECKING

from click.shell_completion import CompletionItem

from snakebot.resources import DEFAULT_ROBOT

if TYPE_CHECKING:
    import click

_FILES = [CompletionItem("", type="file")]


def robots(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Descriptions that come with snakebot; files where a path is being written."""
    return _configs("robots", incomplete)


def gaits(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """The same of gaits."""
    return _configs("gaits", incomplete)


def _configs(kind: str, incomplete: str) -> list[CompletionItem]:
    from snakebot.resources import configs_root

    names = sorted(path.stem for path in (configs_root() / kind).glob("*.yaml"))
    found = [CompletionItem(name) for name in names if name.startswith(incomplete)]
    return found or [CompletionItem(incomplete, type="file")]


def effects(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Effects and sets of them; after ``NAME:`` the parameters that are not there yet."""
    from snakebot.effects.registry import effects as known
    from snakebot.effects.telling import title
    from snakebot.resources import configs_root

    name, colon, rest = incomplete.partition(":")
    if not colon:
        sets = sorted(path.stem for path in (configs_root() / "effects").glob("*.yaml"))
        items = [CompletionItem(n, help=title(effect)) for n, effect in known().items()]
        items += [CompletionItem(n, help="several effects") for n in sets]
        return [item for item in items if item.value.startswith(incomplete)] or _FILES
    if name not in known():
        return []
    effect = known()[name]
    done, comma, last = rest.rpartition(",")
    given = {part.partition("=")[0] for part in done.split(",")}
    wanted = [p.name for p in effect.parameters] + ["joints"] * effect.per_joint
    start = f"{name}:{done}{comma}"
    return [CompletionItem(f"{start}{w}=") for w in wanted if w not in given and w.startswith(last)]


def effect_names(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Effects, by name alone."""
    from snakebot.effects.registry import effects as known
    from snakebot.effects.telling import title

    return [CompletionItem(n, help=title(e)) for n, e in known().items() if n.startswith(incomplete)]


def joints(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Joints of the robot that the command line names, or of the one that it is by default."""
    from snakebot.errors import BadInputError
    from snakebot.robot import load_robot

    try:
        count = load_robot(ctx.params.get("robot_source") or DEFAULT_ROBOT).joints
    except BadInputError:
        return []
    return [CompletionItem(str(j)) for j in range(1, count + 1) if str(j).startswith(incomplete)]


def ports(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """The simulated board, and the ports that this computer has."""
    from snakebot.links.discover import can_ports, serial_ports

    found = [CompletionItem("sim:", help="a board in software")]
    found += [CompletionItem(port.port, help=port.what) for port in (*serial_ports(), *can_ports())]
    return [item for item in found if item.value.startswith(incomplete)]
