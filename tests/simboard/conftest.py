"""What a stream of set-points is held against is shared with the tests of the limiter itself."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "gait"))
