"""The known effects: those of the library, in the order of the signal, then those of installed packages.

A package adds its own through the entry point group ``snakebot.effects``: each entry names an ``Effect`` instance.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING

from snakebot.errors import BadInputError
from snakebot.nearest import did_you_mean

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from snakebot.effects.effect import Effect

ENTRY_POINT_GROUP = "snakebot.effects"

# The order of the signal, which is also the order in which effects are applied.
LIBRARY = (
    "command_delay",
    "command_loss",
    "clock_drift",
    "wiring",
    "command_gain",
    "servo_offset",
    "deadband",
    "second_order",
    "position_loop",
    "arm_payload",
    "servo_lag",
    "rate_limit",
    "voltage_sag",
    "torque_speed",
    "torque_limit",
    "joint_friction",
    "compliance",
    "backlash",
    "joint_free",
    "joint_rigid",
    "encoder_gain",
    "encoder_offset",
    "encoder_noise",
    "ground_friction",
    "wheel_drag",
    "payload",
    "slope",
)

_NAME = re.compile(r"[a-z][a-z0-9_]*")
# What an entry may name: a module and an object in it, perhaps with extras.
_OBJECT = re.compile(r"[^\W\d]\w*(\.[^\W\d]\w*)* *: *[^\W\d]\w*(\.[^\W\d]\w*)*( *\[[\w ,.-]*\])?")


@cache
def effects() -> dict[str, Effect]:
    """All effects by name, in the order in which they are applied within a stage."""
    found: dict[str, Effect] = {}
    for name in LIBRARY:
        found[name] = import_module(f"snakebot.effects.library.{name}").EFFECT
    for entry_name, effect in _installed():
        if effect.name in found:
            warnings.warn(
                f"effect {effect.name} of {entry_name} is left out: the name is taken", stacklevel=2
            )
        else:
            found[effect.name] = effect
    return found


def find_effect(name: str, sets: Iterable[str] = ()) -> Effect:
    """
    Args:
        sets: what else could have been meant.

    Raises:
        BadInputError: there is no such effect; the line names the nearest and all that are known.
    """
    known = effects()
    if name in known:
        return known[name]
    hint = did_you_mean(name, [*known, *sets]) or "."
    raise BadInputError(f"no effect is called {name!r}{hint} Known: {', '.join(known)}")


def _installed() -> list[tuple[str, Effect]]:
    """Effects of other packages. One that cannot be loaded is warned about and left out: it must not stop a robot."""
    from snakebot.effects.effect import STAGES, Effect

    loaded: list[tuple[str, Effect]] = []
    for entry in _entry_points():
        if not (_NAME.fullmatch(entry.name) and _OBJECT.fullmatch(entry.value)):
            said = f"{entry.name!r} = {entry.value!r}"
            warnings.warn(f'effect {said} is left out: not NAME = "module:OBJECT"', stacklevel=2)
            continue
        try:
            effect = entry.load()
        except (Exception, SystemExit) as error:  # foreign code: anything can happen
            why = " ".join(str(error).split())
            warnings.warn(f"effect {entry.name} cannot be loaded: {why}", stacklevel=2)
            continue
        sound = isinstance(effect, Effect) and _NAME.fullmatch(effect.name) and effect.stage in STAGES
        if not sound:
            warnings.warn(f"effect {entry.name}: {entry.value} is not a sound Effect instance", stacklevel=2)
            continue
        loaded.append((entry.name, effect))
    return loaded


def _entry_points() -> list[EntryPoint]:
    """Those of our group. A package whose list is broken, in whatever group, is passed over with a warning."""
    from importlib.metadata import distributions, entry_points

    try:
        return list(entry_points(group=ENTRY_POINT_GROUP))
    except Exception:  # one list that cannot be read makes all of them fail
        found: dict[str, list[EntryPoint]] = {}
    for package in distributions():
        name = "of unknown name"
        try:
            name = str(package.metadata["Name"])
            found.setdefault(name, list(package.entry_points.select(group=ENTRY_POINT_GROUP)))
        except Exception:  # a stranger's file: neither text nor a list, or not there any more
            warnings.warn(f"package {name!r}: its entry points cannot be read; left out", stacklevel=2)
    return [entry for entries in found.values() for entry in entries]


def look_alikes(name: str) -> dict[str, str]:
    """Effects that leave nearly the same mark, whichever of the two says so, and what tells them apart."""
    others = {
        other: tells
        for other, effect in effects().items()
        for alike, tells in effect.confused_with
        if alike == name
    }
    return others | dict(find_effect(name).confused_with)
