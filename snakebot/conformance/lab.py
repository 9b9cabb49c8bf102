"""What a lab can do to a board besides talking to it. Each is None where nobody can."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from firmware_protocol.catalogue import Fault


@dataclass(frozen=True, slots=True)
class Plate:
    """What is known of a board from its builder, not from itself."""

    joints: int
    counts_per_rev: int
    serial_number: int
    firmware: tuple[int, int, int]
    simulated: bool
    pose: bool  # it tells where the robot is
    limits: tuple[tuple[float, float, float], ...]  # built in, each joint's: rad, rad/s, rad/s^2


@dataclass(frozen=True, slots=True)
class Lab:
    """Hands at a board.

    Attributes:
        reset_at: switches it off and on; its clock then starts at these microseconds.
        turn_joint: turns a joint (from 1) by hand to an angle (rad). A servo that has power turns it back.
        lose_encoder: an encoder (joint from 1) gives no reading from now on, or gives one again.
        fail: a fault of the hardware (code, joint, detail) begins, or with ``Fault.NONE`` ends.
        supply: what the supply's sensors measure from now on: mV, mA, tenths of a degree Celsius; None: no sensors.
            Joint j's (from 1) measure j mA and 2 j tenths of a degree more.
        supply_is_of_joints: the supply's own sensors are its joints': their currents added up, the highest temperature.
        draw: what the board's source of random numbers gives next, before others.
        store_trim: what is stored of a joint's trim (from 1; steps of the wire), as a damaged memory may leave it.
        plate: what should be written on the board.
        encoder_rad: one count of the joints' own encoders, where it is coarser than a count that the board reports.
    """

    reset_at: Callable[[int], None] | None = None
    turn_joint: Callable[[int, float], None] | None = None
    lose_encoder: Callable[[int, bool], None] | None = None
    fail: Callable[[Fault, int, int], None] | None = None
    supply: Callable[[tuple[int, int, int] | None], None] | None = None
    supply_is_of_joints: bool = False
    draw: Callable[[Sequence[int]], None] | None = None
    store_trim: Callable[[int, int], None] | None = None
    plate: Plate | None = None
    encoder_rad: float = 0.0
