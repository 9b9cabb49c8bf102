"""Gaits by name or from a file: ``configs/gaits/*.yaml``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from snakebot.errors import BadInputError
from snakebot.gait.wave import Gait
from snakebot.nearest import not_known
from snakebot.resources import config_path
from snakebot.safe_yaml import Lines, load_yaml

_NEEDED = ("alpha_deg", "beta_deg", "omega_rad_s")


def load_gait(source: str | Path) -> Gait:
    """A gait from a YAML file with alpha_deg, beta_deg, omega_rad_s and perhaps offset_deg, amplitudes (a share
    of alpha for each joint) and source.

    Raises:
        BadInputError: no such file or name, not YAML, or not a gait.
    """
    path = config_path("gaits", source)
    try:
        text = path.read_bytes()
    except OSError as error:
        raise BadInputError(f"{path}: cannot read the gait: {error.strerror}") from None
    data, lines = load_yaml(text, str(path)), Lines(text)
    numbers = gait_numbers(data, f"{path}: ", lines, ("amplitudes", "source"))
    shares: tuple[float, ...] = ()
    if "amplitudes" in data:
        shares = shares_of(data["amplitudes"], f"{path}: {lines.of('amplitudes')}")
    return Gait.from_degrees(*numbers, shares=shares)


def gait_numbers(
    data: object, where: str, lines: Lines, others: Sequence[str] = ()
) -> tuple[float, float, float, float]:
    """What files write of a gait: alpha_deg, beta_deg, omega_rad_s, and offset_deg, 0 where it is not given.

    Args:
        where: what a message begins with.
        lines: of the mapping, for a message.
        others: keys that may stand beside these; they are not looked at.

    Raises:
        BadInputError: not a mapping, a key that is not known, a value that is not a number, or one that is missing.
    """
    if not isinstance(data, dict):
        raise BadInputError(f"{where}{lines.of()}a gait is a mapping with {', '.join(_NEEDED)}")
    known = (*_NEEDED, "offset_deg", *others)
    for key, value in data.items():
        if key not in known:
            raise BadInputError(f"{where}{lines.of(key)}{not_known(key, known, 'a gait')}")
        if key not in others and not _is_number(value):
            raise BadInputError(f"{where}{lines.of(key)}{key} is {value!r}, not a number")
    missing = [key for key in _NEEDED if key not in data]
    if missing:
        raise BadInputError(f"{where}{lines.of()}{missing[0]} is missing")
    alpha_deg, beta_deg, omega_rad_s = (float(data[key]) for key in _NEEDED)
    return alpha_deg, beta_deg, omega_rad_s, float(data.get("offset_deg", 0.0))


def shares_of(value: object, where: str) -> tuple[float, ...]:
    """The list after ``amplitudes:``; of each joint a share of alpha.

    Raises:
        BadInputError: not a list of numbers.
    """
    given = value if isinstance(value, list | tuple) else (value,)
    if given is not value or not all(_is_number(number) for number in given):
        raise BadInputError(
            f"{where}amplitudes is {value!r}, not a list of numbers, a share of alpha a joint"
        )
    return tuple(float(number) for number in given)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
