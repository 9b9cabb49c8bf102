"""Gaits by name or from a file: ``configs/gaits/*.yaml``."""

from __future__ import annotations

from pathlib import Path

from snakebot.errors import BadInputError
from snakebot.gait.wave import Gait
from snakebot.resources import config_path
from snakebot.safe_yaml import load_yaml

_KEYS = ("alpha_deg", "beta_deg", "omega_rad_s", "offset_deg")


def load_gait(source: str | Path) -> Gait:
    """A gait from a YAML file with alpha_deg, beta_deg, omega_rad_s and perhaps offset_deg and source.

    Raises:
        BadInputError: no such file or name, not YAML, or not a gait.
    """
    path = config_path("gaits", source)
    try:
        data = load_yaml(path.read_bytes(), str(path))
    except OSError as error:
        raise BadInputError(f"{path}: cannot read the gait: {error.strerror}") from None
    if not isinstance(data, dict):
        raise BadInputError(f"{path}: a gait is a mapping with {', '.join(_KEYS[:3])}")
    for key, value in data.items():
        if key == "source":
            continue
        if key not in _KEYS:
            raise BadInputError(f"{path}: {key} is not known; a gait has {', '.join(_KEYS)} and source")
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise BadInputError(f"{path}: {key} is {value!r}, not a number")
    missing = [key for key in _KEYS[:3] if key not in data]
    if missing:
        raise BadInputError(f"{path}: {missing[0]} is missing")
    return Gait.from_degrees(
        data["alpha_deg"], data["beta_deg"], data["omega_rad_s"], data.get("offset_deg", 0.0)
    )
