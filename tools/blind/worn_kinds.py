"""Effects that leave nearly the same mark in joint angles: shares of a gap are told, and scored, of a kind."""

from __future__ import annotations

TOLERANCE = "tolerance"  # what a healthy robot is off by: in joint angles, a lag other than the stated one
KINDS: dict[str, frozenset[str]] = {
    "late": frozenset({"command_delay", "servo_lag", "second_order", TOLERANCE}),
    "offset": frozenset({"servo_offset", "encoder_offset"}),
    "gain": frozenset({"command_gain", "encoder_gain"}),
    "play": frozenset({"backlash", "deadband", "joint_friction"}),
    "limit": frozenset({"rate_limit", "voltage_sag", "torque_speed", "torque_limit"}),
    "gives way": frozenset({"compliance"}),
}


def kind_of(name: str) -> str:
    """The kind of an effect; one that is in none is of its own."""
    return next((kind for kind, names in KINDS.items() if name in names), name)
