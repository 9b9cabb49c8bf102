"""Explanations as data: which effects, on which joints, which of their parameters are open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from snakebot.arrays import Bools, Floats
from snakebot.effects.effect import Stage
from snakebot.effects.parameter import Parameter
from snakebot.effects.registry import find_effect
from snakebot.effects.spec import EffectSpec
from snakebot.in_words import listed

Joints = tuple[int, ...]  # 1-based
Fixed = tuple[tuple[str, float | tuple[float, ...]], ...]  # parameters that are not fitted, with their values


@dataclass(frozen=True)
class Term:
    """One effect in an explanation.

    Attributes:
        effect: its name.
        joints: 1-based, or None where the effect is of the whole robot.
        fixed: parameters that are not fitted, with their values.
        own: each of ``joints`` has values of its own, as servos of one make do; then ``joints`` are given.
    """

    effect: str
    joints: Joints | None
    fixed: Fixed = ()
    own: bool = False

    @property
    def stage(self) -> Stage:
        return find_effect(self.effect).stage

    @property
    def open_of_one(self) -> tuple[Parameter, ...]:
        """Parameters to be fitted: of one joint, where each has its own."""
        fixed = dict(self.fixed)
        return tuple(
            p
            for p in find_effect(self.effect).parameters
            if p.fitted and not p.integer and p.name not in fixed
        )

    @property
    def open(self) -> tuple[Parameter, ...]:
        """Parameters to be fitted, joint by joint where each has its own."""
        return self.open_of_one * len(self.alike)

    @property
    def alike(self) -> tuple[Joints | None, ...]:
        """Joints that share their values, set by set."""
        if not self.own:
            return (self.joints,)
        assert self.joints is not None
        return tuple((joint,) for joint in self.joints)

    def specs(self, values: Sequence[float]) -> tuple[EffectSpec, ...]:
        """The effect at ``values`` of ``open``, for each set of joints that share theirs; nan: it is absent there."""
        order, of_one = [p.name for p in find_effect(self.effect).parameters], self.open_of_one
        rows = np.reshape(np.asarray(values, dtype=np.float64), (len(self.alike), len(of_one)))
        found = []
        for joints, row in zip(self.alike, rows, strict=True):
            if np.isnan(row).any():
                continue
            numbers: dict[str, float | tuple[float, ...]] = dict(self.fixed)
            numbers |= {p.name: p.clip(float(v)) for p, v in zip(of_one, row, strict=True)}
            found.append(
                EffectSpec(self.effect, {name: numbers[name] for name in order if name in numbers}, joints)
            )
        return tuple(found)

    def told(self, values: Sequence[float]) -> EffectSpec:
        """The effect at ``values`` in one piece, with a value for each joint where they are the joints' own."""
        found = self.specs(values)
        if len(found) == 1:
            return found[0]
        names = found[0].values if found else dict(self.fixed)
        rows = {name: tuple(_one(spec.values[name]) for spec in found) for name in names}
        return EffectSpec(self.effect, rows, tuple(j for spec in found for j in spec.joints or ()))


def _one(value: float | tuple[float, ...]) -> float:
    assert not isinstance(value, tuple)
    return value


@dataclass(frozen=True)
class Hypothesis:
    """Effects that act together; none at all is the nominal robot."""

    terms: tuple[Term, ...] = ()

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(p for term in self.terms for p in term.open)

    @property
    def side_by_side(self) -> list[list[int]]:
        """Places of all parameters; those together that are the same of joints that each have their own."""
        found, first = [], 0
        for term in self.terms:
            count = len(term.open_of_one)
            found += [list(range(first + k, first + len(term.open), count)) for k in range(count)]
            first += len(term.open)
        return found

    @property
    def names(self) -> tuple[str, ...]:
        """Distinct effects in the order of the terms."""
        return tuple(dict.fromkeys(term.effect for term in self.terms))

    @property
    def followed(self) -> int:
        """How many starts a fit follows to the end."""
        return max((find_effect(term.effect).followed for term in self.terms), default=1)

    def specs(self, theta: Sequence[float] | Floats) -> tuple[EffectSpec, ...]:
        """The effects at ``theta`` (p,); a term with nan among its parameters is absent."""
        parts = zip(self.terms, self.split(np.asarray(theta, dtype=np.float64)), strict=True)
        return tuple(spec for term, values in parts for spec in term.specs(values.tolist()))

    def split(self, theta: Floats) -> list[Floats]:
        """The part of ``theta`` that belongs to each term."""
        ends = np.cumsum([len(term.open) for term in self.terms])
        return np.split(np.asarray(theta), ends[:-1]) if self.terms else []

    @property
    def alike(self) -> list[slice]:
        """Which parameters belong together: those of one term, and of one joint where its joints have their own."""
        sizes = [len(t.open_of_one) for t in self.terms for _ in t.alike if t.open_of_one]
        ends = np.cumsum(sizes, dtype=np.int64).tolist()
        return [slice(end - size, end) for end, size in zip(ends, sizes, strict=True)]

    def rest(self, theta: Floats, index: int) -> Floats:
        """The part of ``theta`` that belongs to all terms but one."""
        parts = self.split(theta)
        return np.concatenate([np.zeros(0), *parts[:index], *parts[index + 1 :]])

    def plus(self, term: Term) -> Hypothesis:
        return Hypothesis((*self.terms, term))

    def without(self, index: int) -> Hypothesis:
        return Hypothesis(self.terms[:index] + self.terms[index + 1 :])

    def joints(self, count: int) -> Joints:
        """1-based joints that any servo or sensor term acts on; all where one is of the whole robot."""
        found: set[int] = set()
        for term in self.terms:
            if term.stage != "body":
                found |= set(range(1, count + 1) if term.joints is None else term.joints)
        return tuple(sorted(found))

    def touches(self, count: int) -> Bools:
        """(p, count) which joints each parameter acts on, if joints do not disturb each other."""
        found = [
            np.isin(np.arange(1, count + 1), joints) if joints is not None else np.ones(count, dtype=bool)
            for term in self.terms
            for joints in term.alike
            for _ in term.open_of_one
        ]
        return np.array(found, dtype=bool).reshape(-1, count)

    def sets(self, what: str, count: int) -> list[list[int]]:
        """0-based joints, of ``count``, for which an effect sets this number of the nominal robot itself (``covers``):
        those for which it does so together.
        """
        return [
            list(range(count)) if joints is None else [j - 1 for j in joints]
            for term in self.terms
            if what in find_effect(term.effect).covers
            for joints in term.alike
        ]

    @property
    def in_words(self) -> str:
        """ "rate_limit on joint 3 and servo_lag"."""
        parts = []
        for term in self.terms:
            joints = () if term.joints is None else term.joints
            which = f" on joint{'s' * (len(joints) > 1)} {listed(joints)}" if joints else ""
            parts.append(term.effect + which)
        return listed(parts)

    def __str__(self) -> str:
        def one(term: Term) -> str:
            where = (
                "" if term.joints is None else "@" + ("," if term.own else "+").join(map(str, term.joints))
            )
            return term.effect + where

        return " & ".join(one(t) for t in self.terms) or "nominal"


class Box(NamedTuple):
    """What some parameters may be, (p,) each: ``lower`` and ``upper``, which are fitted on a ``logarithmic`` scale, and
    the ``stride`` over which slopes are taken where a small change shows nothing.
    """

    lower: Floats
    upper: Floats
    logarithmic: Bools
    stride: Floats

    @staticmethod
    def of(parameters: Sequence[Parameter]) -> Box:
        return Box(
            np.array([p.lower for p in parameters], dtype=np.float64),
            np.array([p.upper for p in parameters], dtype=np.float64),
            np.array([p.scale == "log" and p.lower > 0 for p in parameters], dtype=bool),
            np.array([p.stride for p in parameters], dtype=np.float64),
        )

    def among(self, wanted: Bools) -> Box:
        """Of the parameters that are ``wanted`` (p,)."""
        return Box(self.lower[wanted], self.upper[wanted], self.logarithmic[wanted], self.stride[wanted])


def fixed_by(known: Mapping[str, float], effect: str) -> tuple[tuple[str, float], ...]:
    """What the user has measured and fixes: keys ``parameter`` or ``effect.parameter``."""
    names = {p.name for p in find_effect(effect).parameters}
    out = []
    for key, value in known.items():
        owner, dot, name = key.rpartition(".")
        if name in names and (not dot or owner == effect):
            out.append((name, float(value)))
    return tuple(out)
