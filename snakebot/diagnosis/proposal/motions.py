"""The motions that a diagnosis asks for: read from ``configs/motions/menu.yaml``, which a lab may change."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from snakebot.errors import BadInputError
from snakebot.gait import Gait, Probe, parse_probe
from snakebot.gait.named import gait_numbers
from snakebot.nearest import not_known
from snakebot.resources import configs_root
from snakebot.safe_yaml import Lines, load_yaml

DURATION_S = 12.0  # of a motion, s; chosen
RAMP_S = 2.0  # from rest to the full motion, s; chosen
MOST_S = 600.0  # of a gait of the file, s; chosen: each is simulated once for every explanation
SECTIONS = ("start", "gaits", "probes", "lifted")


@dataclass(frozen=True)
class WrittenGait:
    """A gait as the file has it; ``duration_s``: with its ramps."""

    alpha_deg: float
    beta_deg: float
    omega_rad_s: float
    offset_deg: float = 0.0
    duration_s: float = DURATION_S

    @property
    def gait(self) -> Gait:
        """
        Raises:
            BadInputError: a number is out of bounds.
        """
        return Gait.from_degrees(self.alpha_deg, self.beta_deg, self.omega_rad_s, self.offset_deg)


@dataclass(frozen=True)
class Motions:
    """What the file has, in its order.

    Attributes:
        start: what a live diagnosis begins with; at least one.
        gaits, probes: what may be run next; ``lifted``: likewise, off the ground. Probes move all joints.
    """

    start: tuple[WrittenGait, ...]
    gaits: tuple[WrittenGait, ...]
    probes: tuple[Probe, ...]
    lifted: tuple[Probe, ...]


@cache
def known_motions() -> Motions:
    """Those of the file that comes with snakebot.

    Raises:
        BadInputError: as ``load_motions``.
    """
    return load_motions(configs_root() / "motions" / "menu.yaml")


def load_motions(path: Path) -> Motions:
    """The motions of a file with the lists ``start``, ``gaits``, ``probes`` and ``lifted``.

    Raises:
        BadInputError: one line that names the file and the first fault: no such file, not YAML, a key that is not
            known, a list that is missing, or a motion that is none.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise BadInputError(f"{path}: cannot read the motions: {error.strerror}") from None
    data, lines = load_yaml(content, str(path)), Lines(content)
    if not isinstance(data, dict):
        raise BadInputError(f"{path}: the motions are a mapping with {', '.join(SECTIONS)}")
    for key in data:
        if key not in SECTIONS:
            raise BadInputError(f"{path}: {lines.of(key)}{not_known(key, SECTIONS, 'the menu')}")
    file = _File(f"{path}: ", data, lines)
    return Motions(
        start=file.gaits("start"),
        gaits=file.gaits("gaits", timed=True),
        probes=file.probes("probes"),
        lifted=file.probes("lifted"),
    )


@dataclass(frozen=True)
class _File:
    """What was read; ``where``: what a message begins with."""

    where: str
    data: Mapping[str, Any]
    lines: Lines

    def gaits(self, section: str, *, timed: bool = False) -> tuple[WrittenGait, ...]:
        """``timed``: whether each may have a duration of its own."""
        more = ("duration_s",) if timed else ()
        found = []
        for index, entry in enumerate(self._listed(section)):
            numbers = gait_numbers(entry, self.where, self.lines.under(section, index), more)
            try:
                Gait.from_degrees(*numbers)
            except BadInputError as error:
                raise self._fault(str(error), section, index) from None
            length = entry.get("duration_s", DURATION_S)
            if not _is_duration(length):
                wanted = f"{2 * RAMP_S:g} to {MOST_S:g} s"
                raise self._fault(f"duration_s is {length!r}, not {wanted}", section, index, "duration_s")
            found.append(WrittenGait(*numbers, float(length)))
        return tuple(found)

    def probes(self, section: str) -> tuple[Probe, ...]:
        found = []
        for index, text in enumerate(self._listed(section)):
            if not isinstance(text, str):
                raise self._fault(f"{text!r} is no probe; write it as after --probe", section, index)
            try:
                probe = parse_probe(text)
            except BadInputError as error:
                raise self._fault(str(error), section, index) from None
            if probe.joints is not None:
                fault = f"{text}: leave joints= out; which of them move follows from the explanations"
                raise self._fault(fault, section, index)
            found.append(probe)
        return tuple(found)

    def _listed(self, section: str) -> list[Any]:
        listed = self.data.get(section)
        if isinstance(listed, list) and (listed or section != "start"):
            return listed
        fault = "is missing" if section not in self.data else "is no list" if listed != [] else "is empty"
        wanted = "at least one gait" if section == "start" else "motions, [] for none"
        raise self._fault(f"{section} {fault}; it takes a list of {wanted}", section)

    def _fault(self, told: str, *place: str | int) -> BadInputError:
        return BadInputError(f"{self.where}{self.lines.of(*place)}{told}")


def _is_duration(value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return 2 * RAMP_S <= value <= MOST_S
