"""Joint faults that a run was made with, from what its log says."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

_FAULT = re.compile(r"joint_(free|rigid)(?::(?P<rest>.*))?$")


@dataclass(frozen=True)
class JointFaults:
    """Joints (1-based) that were free or rigid throughout a run."""

    free: tuple[int, ...] = ()
    rigid: tuple[int, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.free or self.rigid)

    @property
    def kind(self) -> str:
        if not self:
            return "none"
        return "free" if not self.rigid else "rigid" if not self.free else "free and rigid"

    @property
    def joints(self) -> str:
        """As in Table IV: ``1 + 2``."""
        return " + ".join(str(joint) for joint in sorted((*self.free, *self.rigid)))


def joint_faults(metadata: Mapping[str, Any]) -> JointFaults:
    """Read ``faults`` (and ``effects``) of a run's metadata: texts such as ``joint_free:joints=3+4``, or
    mappings with ``joints`` and ``mode``. What is no joint fault is passed over.
    """
    free: set[int] = set()
    rigid: set[int] = set()
    for key in ("faults", "effects"):
        entries = metadata.get(key) or ()
        for entry in [entries] if isinstance(entries, (str, Mapping)) else entries:
            mode, joints = _read(entry)
            if mode in ("free", "rigid"):
                (free if mode == "free" else rigid).update(joints)
    return JointFaults(tuple(sorted(free)), tuple(sorted(rigid)))


def _read(entry: object) -> tuple[str, list[int]]:
    if isinstance(entry, Mapping):
        mode = str(entry.get("mode", entry.get("name", entry.get("effect", "")))).removeprefix("joint_")
        joints = entry.get("joints", entry.get("joint", ()))
        return mode, _numbers(joints if isinstance(joints, str) else repr(joints))
    found = _FAULT.match(str(entry).strip())
    if not found:
        return "", []
    given = re.search(r"joints?=([0-9+ ]+)", found["rest"] or "")
    return found[1], _numbers(given[1]) if given else []


def _numbers(text: str) -> list[int]:
    return [int(number) for number in re.findall(r"\d+", text)]
