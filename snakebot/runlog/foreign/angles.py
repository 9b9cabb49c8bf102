"""Angles in the units that labs record: radians, degrees, encoder counts, per cent of a range."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError

T = TypeVar("T")
UNITS = ("rad", "deg", "counts", "percent")


@dataclass(frozen=True)
class AngleForm:
    """How a recording gives angles. A tuple has one value a joint, or one for all.

    Attributes:
        unit: one of ``UNITS``; None where it is not said.
        centre: what is recorded where a joint is straight, in that unit.
        direction: -1 where a larger number turns the joint to a smaller angle.
        range_deg: angles, degrees, at -100 and at +100 per cent.
    """

    unit: str | None = None
    centre: tuple[float, ...] = ()
    direction: tuple[float, ...] = ()
    range_deg: tuple[tuple[float, float], ...] = ()
    counts_per_rev: int | None = None

    def line(self, joints: int, unit: str | None = None) -> tuple[Floats, Floats]:
        """Factor and zero (k,): an angle in rad is ``factor * (recorded - zero)``.

        Raises:
            BadInputError: values for another number of joints; what the unit needs is not said, or said twice.
        """
        unit = unit or self.unit or "rad"
        if self.range_deg and unit != "percent":
            raise BadInputError("--range is for --units percent; say one or the other")
        factor, zero = np.ones(joints), np.zeros(joints)
        if unit == "percent":
            if not self.range_deg:
                raise BadInputError(
                    "--units percent: say which angles -100 and 100 are: --range LOW:HIGH in degrees, one for all "
                    "joints or one a joint with commas between"
                )
            spans = _each(self.range_deg, joints, "--range")
            low, high = (np.array([span[i] for span in spans]) for i in (0, 1))
            factor = np.radians(high - low) / 200
            zero = -np.radians(high + low) / 2 / factor
        elif unit == "deg":
            factor = factor * math.pi / 180
        elif unit == "counts":
            if self.counts_per_rev is None:
                raise BadInputError(
                    "angles in counts: say how many are a turn with --counts-per-rev (or --robot)"
                )
            factor = factor * 2 * math.pi / self.counts_per_rev
        if self.centre:
            if unit == "percent":
                raise BadInputError("--centre: --range says already where the middle is")
            zero = np.array(_each(self.centre, joints, "--centre"))
        if self.direction:
            factor = factor * np.array(_each(self.direction, joints, "--direction"))
        return factor, zero

    def to_rad(self, recorded: Floats) -> Floats:
        """Angles (N, k) in rad."""
        factor, zero = self.line(recorded.shape[1])
        return (recorded - zero) * factor


def _each(values: tuple[T, ...], joints: int, option: str) -> tuple[T, ...]:
    if len(values) == 1:
        return values * joints
    if len(values) != joints:
        raise BadInputError(f"{option}: {len(values)} values for {joints} joints; give one, or one a joint")
    return values
