"""What a board says, in units: who it is, where its joints are, where the robot is."""

from __future__ import annotations

import math
from dataclasses import dataclass

from firmware_protocol.assembly import Sample
from firmware_protocol.catalogue import Counters, FaultEvent, JointSupply, Mode, Supply


@dataclass(frozen=True, slots=True)
class BoardInfo:
    """What a board says it is."""

    protocol: str
    catalogue_hash: int
    firmware: str
    serial_number: int
    joints: int
    counts_per_rev: int
    watchdog_ms: int
    simulated: bool
    boot_id: int


@dataclass(frozen=True, slots=True)
class Reading:
    """One sample of all joints, in units. ``measured_rad`` is NaN where an encoder gave no reading."""

    sequence: int
    sample: int
    mode: Mode
    received_s: float  # host clock
    board_time_us: int  # unwrapped
    measured_rad: tuple[float, ...]
    applied_rad: tuple[float, ...]


def reading_of(sample: Sample, counts_per_rev: int, board_time_us: int, received_s: float) -> Reading:
    """A sample in units; ``board_time_us`` is unwrapped."""
    rad_per_count = 2 * math.pi / counts_per_rev
    return Reading(
        sequence=sample.state.sequence,
        sample=sample.state.sample,
        mode=sample.state.mode,
        received_s=received_s,
        board_time_us=board_time_us,
        measured_rad=tuple([math.nan if c is None else c * rad_per_count for c in sample.measured_counts]),
        applied_rad=sample.applied_rad,
    )


@dataclass(frozen=True, slots=True)
class PoseReading:
    """Centre of mass, mean heading and speed, as the board (or a tracking system behind it) knows them."""

    sample: int
    x_m: float
    y_m: float
    heading_rad: float
    speed_m_s: float


def telemetry_of(item: Supply | JointSupply) -> dict[str, float]:
    """What a board tells of its supply or of a joint's, by the names that logs and sessions use."""
    if isinstance(item, Supply):
        return {
            "supply_v": item.voltage_v,
            "supply_a": item.current_a,
            "supply_temperature_c": item.temperature_c,
        }
    return {f"current_{item.joint}_a": item.current_a, f"temperature_{item.joint}_c": item.temperature_c}


@dataclass(frozen=True, slots=True)
class OtherHost:
    """A host that is not this one has been heard on the line, for the first time."""

    host: int


Received = Reading | PoseReading | Supply | JointSupply | Counters | FaultEvent | OtherHost
