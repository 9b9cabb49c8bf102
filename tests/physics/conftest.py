"""The peers that the physics is tested against live beside the benchmark that measures them."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "tools"))
