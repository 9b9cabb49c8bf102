"""How much of a search a suite has time for: of the same seeds, ``make thorough`` tries more than ``make slow``."""

from __future__ import annotations

import os

THOROUGH = os.environ.get("SNAKEBOT_TESTS") == "thorough"


def sample(thorough: int, in_ci: int) -> int:
    """How many random cases a search tries. A case that has a name is asked whatever the size."""
    return thorough if THOROUGH else in_ci
