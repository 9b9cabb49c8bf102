"""Reference motions: the serpentine wave (eq. 27), probes, ramps and changes; and what a joint may do."""

from __future__ import annotations

from snakebot.gait.limits import SlewLimiter, check_motion
from snakebot.gait.motion import GaitMotion, Motion, SampledMotion
from snakebot.gait.named import load_gait
from snakebot.gait.offset_track import OffsetTrack
from snakebot.gait.probe import Probe, parse_probe
from snakebot.gait.probe_motion import ProbeMotion, probe_span_s
from snakebot.gait.wave import Gait

__all__ = [
    "Gait",
    "GaitMotion",
    "Motion",
    "OffsetTrack",
    "Probe",
    "ProbeMotion",
    "SampledMotion",
    "SlewLimiter",
    "check_motion",
    "load_gait",
    "parse_probe",
    "probe_span_s",
]
