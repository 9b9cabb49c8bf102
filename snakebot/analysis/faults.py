"""Joint faults that a run was made with, from what its log says."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from snakebot.effects.spec import EffectSpec, fault_spec, parse_effect
from snakebot.errors import BadInputError

# As on the command line: --fault free:3, rigid:2=30, rigid:4@12s.
_FAULT = re.compile(
    r"(?P<kind>free|rigid):(?P<joints>\d+(\+\d+)*)(=(?P<angle>[-+]?[\d.]+))?(@(?P<at>[\d.]+)s?)?"
)


@dataclass(frozen=True)
class JointFaults:
    """Joints (1-based) that were free or rigid from the start, and whether faults came or went in mid-run."""

    free: tuple[int, ...] = ()
    rigid: tuple[int, ...] = ()
    rigid_angle_rad: Mapping[int, float] = field(default_factory=dict)  # where a rigid joint is stuck
    changed: bool = False

    def __bool__(self) -> bool:
        return bool(self.free or self.rigid)

    @property
    def kind(self) -> str:
        if not self:
            return "none"
        return "free" if not self.rigid else "rigid" if not self.free else "free and rigid"

    @property
    def joints(self) -> str:
        """As in ``1 + 2``."""
        return " + ".join(str(joint) for joint in sorted((*self.free, *self.rigid)))

    @property
    def described(self) -> str:
        """The joints, with the angle where one is stuck off the middle: ``1 + 2 at 30°``."""

        def one(joint: int) -> str:
            angle = math.degrees(self.rigid_angle_rad.get(joint, 0.0)) if joint in self.rigid else 0.0
            return f"{joint} at {angle:g}°" if angle else str(joint)

        return " + ".join(one(joint) for joint in sorted((*self.free, *self.rigid)))

    def effects(self) -> tuple[str, ...]:
        """The same in the grammar of ``--effect``."""
        free = [fault_spec("free", self.free)] if self.free else []
        stuck = [fault_spec("rigid", (j,), self.rigid_angle_rad.get(j, 0.0)) for j in self.rigid]
        return tuple(map(str, (*free, *stuck)))


def joint_faults(metadata: Mapping[str, Any], joints: int) -> JointFaults:
    """Read the ``faults`` and ``effects`` that a run's metadata lists; what is no joint fault is passed over.

    A list that is not understood is no error: logs come from strangers. Joints beyond ``joints`` are left
    out.
    """
    free: set[int] = set()
    rigid: dict[int, float] = {}
    changed = False
    for text in (*_texts(metadata.get("faults")), *_texts(metadata.get("effects"))):
        fault = _FAULT.fullmatch(text)
        if fault is not None:
            kind, angle_rad = fault["kind"], math.radians(_number(fault["angle"]))
            numbers = [int(n) for n in re.findall(r"\d{1,4}", fault["joints"])]
            if _number(fault["at"]) > 0:
                changed = True
                continue
        elif (effect := _broken_by(text)) is not None:
            kind, angle_rad = effect.effect.fault, effect.effect.fault_angle_rad(effect)
            numbers = [joint + 1 for joint in effect.joint_indices(joints)]
        else:
            changed = changed or text.startswith("clear")
            continue
        chosen = [n for n in numbers if 1 <= n <= joints]
        if kind == "free":
            free.update(chosen)
        else:
            rigid.update(dict.fromkeys(chosen, angle_rad))
    for joint in free & rigid.keys():  # the later fault cannot be told: the joint was held by something
        free.discard(joint)
    return JointFaults(tuple(sorted(free)), tuple(sorted(rigid)), rigid, changed)


def other_effects(metadata: Mapping[str, Any]) -> tuple[str, ...]:
    """The effects that a run's metadata lists, without those that are joint faults."""
    return tuple(text for text in _texts(metadata.get("effects")) if _broken_by(text) is None)


def _broken_by(text: str) -> EffectSpec | None:
    """The effect that a log names, if it is a joint fault and can be read."""
    try:
        spec = parse_effect(text)
    except BadInputError:
        return None
    return spec if spec.effect.fault else None


def _texts(entries: object) -> list[str]:
    if isinstance(entries, str):
        return [entries.strip()]
    return [e.strip() for e in entries if isinstance(e, str)] if isinstance(entries, (list, tuple)) else []


def _number(text: str | None) -> float:
    try:
        return float(text) if text else 0.0
    except ValueError:
        return 0.0
