"""Boards in front of emulated servos whose joints stand somewhere, in virtual time: for tests of the plant."""

from __future__ import annotations

from typing import Any

import pytest
from rigs import Rig, bench, emulated

both = pytest.mark.parametrize("model", ["sts3215", "xl330"])
AT = [0.3, -0.2, 0.1, 0.0, -0.4]  # rad


def rig_of(model: str, *, watchdog: bool = True, **more: Any) -> Rig:
    """Five servos of a model, at ``AT``."""
    robot = bench()
    return Rig(emulated(model, robot=robot, start_rad=AT, **more), robot, watchdog=watchdog)


def arm(rig: Rig) -> list[float]:
    """Arm a board that nobody holds; where its joints are."""
    rig.bench.fresh()
    return rig.bench.arm()
