"""Gaits by name or from a file: ``configs/gaits/*.yaml``."""

from __future__ import annotations

from pathlib import Path

from snakebot.errors import BadInputError
from snakebot.gait.wave import Gait
from snakebot.nearest import not_known
from snakebot.resources import config_path
from snakebot.safe_yaml import Lines, load_yaml

_KEYS = ("alpha_deg", "beta_deg", "omega_rad_s", "offset_deg", "amplitudes")


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
    if not isinstance(data, dict):
        raise BadInputError(f"{path}: a gait is a mapping with {', '.join(_KEYS[:3])}")
    for key, value in data.items():
        if key == "source":
            continue
        if key not in _KEYS:
            raise BadInputError(f"{path}: {lines.of(key)}{not_known(key, (*_KEYS, 'source'), 'a gait')}")
        if key == "amplitudes":
            data[key] = shares_of(value, f"{path}: {lines.of(key)}")
        elif isinstance(value, bool) or not isinstance(value, (int, float)):
            raise BadInputError(f"{path}: {lines.of(key)}{key} is {value!r}, not a number")
    missing = [key for key in _KEYS[:3] if key not in data]
    if missing:
        raise BadInputError(f"{path}: {missing[0]} is missing")
    return Gait.from_degrees(
        data["alpha_deg"],
        data["beta_deg"],
        data["omega_rad_s"],
        data.get("offset_deg", 0.0),
        shares=data.get("amplitudes", ()),
    )


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
