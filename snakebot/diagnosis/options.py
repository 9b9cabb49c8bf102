"""What a user may ask of a diagnosis."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from snakebot.effects.registry import effects, find_effect
from snakebot.errors import BadInputError
from snakebot.nearest import did_you_mean

ProgressCallback = Callable[[str, float], None]  # what is being done, and the share that is done


@dataclass(frozen=True)
class Options:
    """The options of ``diagnose``.

    Attributes:
        exclude: effects that may not be named. Each may still be there: it has a part of the probability of what leaves
            nearly the same mark.
        absent: effects that the user knows are not there; they are not named, and nothing is doubted for their sake.
        only: effects that alone may be named; nothing is doubted for the sake of others.
        known: parameters that the user has measured, ``{"limit_rad_s": 1.6}`` or ``{"rate_limit.limit_rad_s": 1.6}``;
            they are not fitted.
        seed: of the bootstrap and of drawn noise.
        quick: at most two effects, no proposal, intervals from scatter alone.
    """

    exclude: tuple[str, ...] = ()
    absent: tuple[str, ...] = ()
    only: tuple[str, ...] = ()
    known: Mapping[str, float] = field(default_factory=dict)
    seed: int = 0
    quick: bool = False

    def may_name(self, effect: str) -> bool:
        """Whether this effect may be a cause."""
        return effect not in self.left_out and (not self.only or effect in self.only)

    @property
    def left_out(self) -> tuple[str, ...]:
        """Effects that are not searched for."""
        return (*self.exclude, *self.absent)

    def check(self) -> None:
        """
        Raises:
            BadInputError: an option names no effect or parameter, or nothing is left to try.
        """
        for name in (*self.left_out, *self.only):
            find_effect(name)
        if self.only and not set(self.only) - set(self.left_out):
            raise BadInputError("--only, --exclude and --absent leave no effect to try")
        for key, value in self.known.items():
            _check_known(key, value)


def _check_known(key: str, value: float) -> None:
    owner, dot, name = key.rpartition(".")
    owners = [find_effect(owner)] if dot else list(effects().values())
    names = sorted({parameter.name for effect in owners for parameter in effect.parameters})
    if name not in names:
        where = f"{owner} has no" if dot else "no effect has a"
        raise BadInputError(f"--known {key}: {where} parameter of that name{did_you_mean(name, names)}")
    for effect in owners:
        for parameter in effect.parameters:
            if parameter.name == name and dot and not parameter.contains(value):
                raise BadInputError(f"--known {key}={value:g}: out of bounds ({parameter.bounds_text})")
