"""What a board in software can be: within what the protocol can say."""

from __future__ import annotations

from collections.abc import Sequence

from firmware_protocol.catalogue import MAX_JOINTS
from snakebot.errors import BadInputError
from snakebot.robot import Robot

MAX_DRIFT_PPM = 100_000.0  # chosen: a tenth off, no clock is as bad
_MAX_COUNTS_PER_REV = 0xFFFF  # what InfoFirmware carries
MIN_WATCHDOG_MS, MAX_WATCHDOG_MS = 20, 255  # two ticks of 100 Hz; what InfoFirmware carries


def check_board(
    robot: Robot,
    drift_ppm: float,
    serial_number: int,
    start_rad: Sequence[float] | None,
    watchdog_ms: int,
) -> None:
    """Refuse a board that could not say what it is.

    Raises:
        BadInputError: more joints or counts a turn than the protocol carries, or a value that no board has.
    """
    if robot.joints > MAX_JOINTS:
        raise BadInputError(
            f"robot {robot.name!r} has {robot.joints} joints; a board has at most {MAX_JOINTS}"
        )
    if not abs(drift_ppm) <= MAX_DRIFT_PPM:
        raise BadInputError(
            f"a clock drift of {drift_ppm} ppm; a board's clock is at most {MAX_DRIFT_PPM} ppm off"
        )
    if not 0 <= serial_number < 1 << 64:
        raise BadInputError(f"serial number {serial_number}: it has 64 bits")
    if start_rad is not None and len(start_rad) != robot.joints:
        raise BadInputError(
            f"{len(start_rad)} start angles for robot {robot.name!r} with {robot.joints} joints"
        )
    if robot.encoder_counts_per_rev > _MAX_COUNTS_PER_REV:
        raise BadInputError(
            f"robot {robot.name!r}: {robot.encoder_counts_per_rev} encoder counts a turn; "
            f"the protocol reports at most {_MAX_COUNTS_PER_REV}"
        )
    if not MIN_WATCHDOG_MS <= watchdog_ms <= MAX_WATCHDOG_MS:
        raise BadInputError(
            f"a watchdog of {watchdog_ms} ms; a board's waits {MIN_WATCHDOG_MS} to {MAX_WATCHDOG_MS} ms"
        )
