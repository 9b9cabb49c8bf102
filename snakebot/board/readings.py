"""What a board says, in units: who it is, where its joints are, where the robot is."""

from __future__ import annotations

from dataclasses import dataclass

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


@dataclass(frozen=True, slots=True)
class Pose:
    """Centre of mass, mean heading and speed, as the board (or a tracking system behind it) knows them."""

    sample: int
    x_m: float
    y_m: float
    heading_rad: float
    speed_m_s: float


Received = Reading | Pose | Supply | JointSupply | Counters | FaultEvent
