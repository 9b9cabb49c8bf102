"""Explanations as data: which effects, on which joints, which of their parameters are open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isnan

import numpy as np
from numpy.typing import NDArray

from snakebot.effects.effect import Stage
from snakebot.effects.parameter import Parameter
from snakebot.effects.registry import find_effect
from snakebot.effects.spec import EffectSpec

Floats = NDArray[np.float64]
Joints = tuple[int, ...]  # 1-based


@dataclass(frozen=True)
class Term:
    """One effect in an explanation.

    Attributes:
        effect: its name.
        joints: 1-based, or None where the effect is of the whole robot.
        fixed: parameters that are not fitted, with their values.
    """

    effect: str
    joints: Joints | None
    fixed: tuple[tuple[str, float | tuple[float, ...]], ...] = ()

    @property
    def stage(self) -> Stage:
        return find_effect(self.effect).stage

    @property
    def open(self) -> tuple[Parameter, ...]:
        """Parameters to be fitted."""
        fixed = dict(self.fixed)
        return tuple(
            p
            for p in find_effect(self.effect).parameters
            if p.fitted and not p.integer and p.name not in fixed
        )

    def spec(self, values: Sequence[float]) -> EffectSpec:
        numbers: dict[str, float | tuple[float, ...]] = dict(self.fixed)
        for parameter, value in zip(self.open, values, strict=True):
            numbers[parameter.name] = parameter.clip(float(value))
        order = [p.name for p in find_effect(self.effect).parameters]
        return EffectSpec(
            self.effect, {name: numbers[name] for name in order if name in numbers}, self.joints
        )


@dataclass(frozen=True)
class Hypothesis:
    """Effects that act together; none at all is the nominal robot."""

    terms: tuple[Term, ...] = ()

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(p for term in self.terms for p in term.open)

    @property
    def names(self) -> tuple[str, ...]:
        """Distinct effects in the order of the terms."""
        return tuple(dict.fromkeys(term.effect for term in self.terms))

    def specs(self, theta: Sequence[float] | Floats) -> tuple[EffectSpec, ...]:
        """The effects at ``theta`` (p,); a term with nan among its parameters is absent."""
        out, at = [], 0
        for term in self.terms:
            count = len(term.open)
            values = [float(v) for v in theta[at : at + count]]
            if not any(map(isnan, values)):
                out.append(term.spec(values))
            at += count
        return tuple(out)

    def split(self, theta: Floats) -> list[Floats]:
        """The part of ``theta`` that belongs to each term."""
        ends = np.cumsum([len(term.open) for term in self.terms])
        return np.split(np.asarray(theta), ends[:-1]) if self.terms else []

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

    def __str__(self) -> str:
        def one(term: Term) -> str:
            where = "" if term.joints is None else "@" + "+".join(map(str, term.joints))
            return term.effect + where

        return " & ".join(one(t) for t in self.terms) or "nominal"


def bounds(parameters: Sequence[Parameter]) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Lower, upper, and which are fitted on a logarithmic scale."""
    lower = np.array([p.lower for p in parameters], dtype=np.float64)
    upper = np.array([p.upper for p in parameters], dtype=np.float64)
    log = np.array([p.scale == "log" and p.lower > 0 for p in parameters], dtype=bool)
    return lower, upper, log


def fixed_by(known: Mapping[str, float], effect: str) -> tuple[tuple[str, float], ...]:
    """What the user has measured and fixes: keys ``parameter`` or ``effect.parameter``."""
    names = {p.name for p in find_effect(effect).parameters}
    out = []
    for key, value in known.items():
        owner, dot, name = key.rpartition(".")
        if name in names and (not dot or owner == effect):
            out.append((name, float(value)))
    return tuple(out)
