"""A number that an effect has: its unit, its bounds, what is believed about it before any data."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import numpy as np

Scale = Literal["linear", "log"]
# Standard deviation of what fits a real joint, as a share of the value's distance from neutral, because no real effect
# is quite the library's. Measured on the blind check's set for calibrating: with it, 95 % intervals held 86 %.
REAL_SHARE = 0.06
# Of a stiffness between motor and joint, which several effects have.
STIFFNESS_IN_MJCF = (
    "gainprm 0 and minus biasprm 1 of the actuator on joint_{j}; "
    "lead_s of numeric servo_{j} is minus biasprm 2 over it"
)


@dataclass(frozen=True)
class Parameter:
    """One parameter of an effect.

    Attributes:
        name: as it stands in ``--effect`` and in reports; ends in its unit.
        unit: for tables.
        lower, upper: bounds, both allowed.
        doc: half a sentence.
        typical: a middling value of the prior.
        spread: standard deviation of the prior: of the natural logarithm on a log scale, in the unit on a linear one.
        scale: on which scale to step, to fit and to believe. ``log`` needs ``lower`` above zero.
        default: value where none is given; None: one must be given.
        fitted: False for what a fit leaves at its default.
        integer: a count or an index.
        many: one value a joint, written ``2+1+3``; a single one holds for all.
        neutral: value from which the size of the effect is counted, where it does nothing or nearly so.
        words: what it is called in a lab, for tables and sentences.
        real_share: standard deviation of what fits a real joint, as a share of the distance from neutral; more than
            ``REAL_SHARE`` where the library's formula leaves out what every such joint has.
        stride: change, in ``unit``, over which a slope is taken where a small change shows nothing at all: set-points
            are held for a tick, so that a delay before a quick servo acts by whole ticks; 0: there is none.
        in_mjcf: where its number stands in an exported MuJoCo model, ``{j}`` the joints; empty: not by itself.
        shown: unit in which a lab says it, and how many of those are in one of ``unit``; None: ``unit`` itself.
    """

    name: str
    unit: str
    lower: float
    upper: float
    doc: str
    typical: float
    spread: float
    scale: Scale = "linear"
    default: float | None = None
    fitted: bool = True
    integer: bool = False
    many: bool = False
    neutral: float = 0.0
    words: str = ""
    real_share: float = REAL_SHARE
    stride: float = 0.0
    in_mjcf: str = ""
    shown: tuple[str, float] | None = None

    def __post_init__(self) -> None:
        """Numbers written as ``0`` or ``10`` are floats: arrays made of them would be of integers."""
        for name in ("lower", "upper", "typical", "spread", "neutral"):
            object.__setattr__(self, name, float(getattr(self, name)))

    def contains(self, value: float) -> bool:
        return self.lower <= value <= self.upper and (not self.integer or float(value).is_integer())

    def clip(self, value: float) -> float:
        """The nearest allowed value."""
        value = min(max(value, self.lower), self.upper)
        return float(round(value)) if self.integer else value

    def sample(self, rng: np.random.Generator) -> float:
        """A draw from the prior, inside the bounds."""
        if self.integer:
            return float(rng.integers(int(self.lower), int(self.upper), endpoint=True))
        for _ in range(1000):
            z = rng.normal()
            value = (
                self.typical * math.exp(self.spread * z)
                if self.scale == "log"
                else self.typical + self.spread * z
            )
            if self.contains(value):
                return float(value)
        return self.typical

    @property
    def called(self) -> str:
        """Its name in words."""
        return self.words or self.name.replace("_", " ")

    @property
    def shown_unit(self) -> str:
        return self.unit if self.shown is None else self.shown[0]

    def in_shown_unit(self, value: float) -> float:
        return value if self.shown is None else value * self.shown[1]

    @property
    def bounds_text(self) -> str:
        return f"{self.lower:g} to {self.upper:g}" + ("" if self.unit in ("", "1") else f" {self.unit}")


def switch(name: str, doc: str, words: str = "") -> Parameter:
    """A parameter that is on (1) or off (0), off unless told otherwise: a kind of the effect, tried and not fitted."""
    return Parameter(name, "", 0.0, 1.0, doc, typical=0.0, spread=1.0, default=0.0, integer=True, words=words)
