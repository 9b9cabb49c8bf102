"""Reference motions and their limits: the serpentine wave (eq. 27), its ramps and changes, and what a joint may do."""

from __future__ import annotations

from snakebot.gait.limits import SlewLimiter, check_motion
from snakebot.gait.motion import GaitMotion, Motion, SampledMotion
from snakebot.gait.named import load_gait
from snakebot.gait.wave import Gait

__all__ = ["Gait", "GaitMotion", "Motion", "SampledMotion", "SlewLimiter", "check_motion", "load_gait"]
