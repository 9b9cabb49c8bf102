"""What a run log holds, one small class a kind of record. ``t_s`` is host time since the run's start."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from snakebot.arrays import Floats

PerJoint = Floats | Sequence[float]  # one number a joint; nan = none


@dataclass(slots=True)
class Tick:
    """One tick of the run loop: what was wanted, what went out, what came back.

    ``None`` in place of a vector: the board did not report it on this tick. nan in one of its places: that
    joint is missing (a set-point of nan = servo off, a measured angle of nan = sample lost).
    """

    sequence: int
    t_s: float  # host time since the run's start
    host_time_ns: int  # wall clock, since the epoch
    setpoint_rad: PerJoint  # (k,) what the gait asked for
    sent_rad: PerJoint  # (k,) what was sent after the limits
    applied_rad: PerJoint | None = None  # (k,) the set-point that the board says it executes
    measured_rad: PerJoint | None = None  # (k,) encoders
    board_time_us: int | None = None  # the board's clock, unwrapped
    latency_s: float | None = None  # from sending to the answer
    late: bool = False  # the tick missed its deadline


@dataclass(frozen=True, slots=True)
class PoseRecord:
    """Centre of mass and mean heading on the ground."""

    t_s: float
    x_m: float
    y_m: float
    heading_rad: float
    speed_m_s: float = float("nan")


@dataclass(frozen=True, slots=True)
class SteeringRecord:
    """One decision of a run that holds a course, or the offset's way back to straight where poses are stale.

    Pose: mean over the last cycle. ``None``: nothing was decided; ``cross_track_m`` is also ``None`` without a line.
    """

    t_s: float
    x_m: float
    y_m: float
    heading_rad: float
    wanted_heading_rad: float | None
    heading_error_rad: float | None
    cross_track_m: float | None  # positive: left of the line
    offset_rad: float  # that the joints get beside the gait's own
    wanted_offset_rad: float | None  # before limits
    saturated: bool
    stale: bool


Level = Literal["debug", "info", "warning", "error", "fatal"]


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened once: a mode change, a fault, a limit that was reached, an emergency stop."""

    t_s: float
    kind: str  # short and stable, for programs: "armed", "fault", "link_lost"
    message: str  # for people
    level: Level = "info"
    data: Mapping[str, object] = field(default_factory=dict)  # anything JSON can carry


@dataclass(frozen=True, slots=True)
class LinkRecord:
    """Counters of the link so far, by name (``sent``, ``received``, ``corrupt``, ``bytes_sent``, ...)."""

    t_s: float
    counters: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Telemetry:
    """Further readings at one time, by the names of session columns: ``supply_v``, ``current_1_a``, ..."""

    t_s: float
    values: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class RawFrame:
    """One frame as it was on the wire."""

    t_s: float
    direction: Literal["sent", "received"]
    id: int
    data: bytes
