"""Before the first set-point: is every servo one that may be driven, where is it, and how fast is the bus?

Nothing moves here, and nothing is changed in a servo.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from snakebot.errors import BadInputError, BoardFaultError, NoBoardError
from snakebot.robot import Robot
from snakebot.servobus.joints import Joint, crosses_the_wrap
from snakebot.servobus.master import BusMaster
from snakebot.servobus.plant import BEYOND_RAD
from snakebot.servobus.settings import described, read_found
from snakebot.servobus.troubles import hardware_fault, words

_PINGS = 20  # of which the median counts; chosen
_CYCLES = 20  # of which the median counts; chosen
# Bounds of the patience with an answer; chosen: two USB frames, nearly two latency timers of 16 ms.
_LEAST_LATENCY_S, _MOST_LATENCY_S = 0.002, 0.03
_HEADROOM = 1.25  # a run needs time for more than the bus

RegisterValues = Mapping[int, Mapping[str, int]]  # joint -> register -> value


@dataclass(frozen=True, slots=True)
class Start:
    """What was found: registers of each joint, and how fast the bus is."""

    found: RegisterValues
    cycle_s: float  # one sync read and one sync write, median
    watchdog: bool  # every servo will stop by itself when the bus falls silent

    @property
    def max_rate_hz(self) -> float:
        return 1.0 / (_HEADROOM * self.cycle_s)

    def about(self, joints: Sequence[Joint]) -> dict[str, Any]:
        """For the log."""
        return {
            "servos": [described(joint, self.found[joint.number]) for joint in joints],
            "cycle_s": round(self.cycle_s, 6),
            "bus_watchdog": self.watchdog,
        }


def prepare(master: BusMaster, robot: Robot, joints: Sequence[Joint], *, watchdog: bool = True) -> Start:
    """Look at everything.

    Raises:
        BadInputError: a servo's settings do not let it do what the description asks for, or it lacks a bus watchdog.
        BoardFaultError: a servo reports an error, or a joint stands beyond its limit.
        NoBoardError: one does not answer any more.
    """
    measure_latency(master, joints)
    found = {}
    for joint in joints:
        before = master.statistics.corrupt
        registers = read_found(master, joint)
        if registers is None:
            damaged = master.statistics.corrupt > before
            why = ": only damaged answers came: two servos of this id, or a bad cable?" if damaged else ""
            raise NoBoardError(f"{master.where}: {joint.what} stopped answering while it was being read{why}")
        found[joint.number] = registers
    watched = _watched(master, joints) if watchdog else False
    for joint, limit_rad in zip(joints, robot.angle_limit_rad, strict=True):
        _check_health(master, joint, found[joint.number])
        check_settings(master, joint, found[joint.number], limit_rad)
        _check_place(master, joint, found[joint.number], limit_rad)
    return Start(found, measure_cycle(master, joints), watched)


def measure_latency(master: BusMaster, joints: Sequence[Joint]) -> None:
    """How long an answer takes on this computer with this adapter: from now on nobody waits much longer."""
    waits = []
    for index in range(_PINGS):
        start_s = master.now_s()
        if master.ping(joints[index % len(joints)].id, tries=1) is not None:
            waits.append(master.now_s() - start_s)
    # the median: asking again costs less than waiting long for an answer that does not come
    median_s = sorted(waits)[len(waits) // 2] if waits else _MOST_LATENCY_S
    master.latency_s = min(max(3 * median_s, _LEAST_LATENCY_S), _MOST_LATENCY_S)


def measure_cycle(master: BusMaster, joints: Sequence[Joint]) -> float:
    """Seconds of one cycle: a sync read, and the bytes of a sync write."""
    model = joints[0].model
    position, goal = model["present_position"], model["goal_position"]
    ids = [joint.id for joint in joints]
    if model.sync_read:
        master.try_fast(ids, position.address, position.size)
    waits = []
    for _ in range(_CYCLES):
        start_s = master.now_s()
        heard = master.sync_read(ids, position.address, position.size, in_turn=not model.sync_read)
        if len(heard) == len(ids):
            waits.append(master.now_s() - start_s)
    if not waits:
        raise NoBoardError(
            f"{master.where}: in none of {_CYCLES} cycles all servos answered: "
            "two of one id, a bad cable, or a weak supply?"
        )
    written = len(master.dialect.sync_write(goal.address, dict.fromkeys(ids, bytes(goal.size))))
    median_s = sorted(waits)[len(waits) // 2]
    return max(median_s, _wire_s(master, joints)) + 10 * written / master.baud


def _wire_s(master: BusMaster, joints: Sequence[Joint]) -> float:
    """What the bits alone take on a real line; a pseudo-terminal is faster."""
    size = joints[0].model["present_position"].size
    return len(joints) * master.dialect.answer_bytes(size) * 10 / master.baud


def _watched(master: BusMaster, joints: Sequence[Joint]) -> bool:
    lacking = [
        joint
        for joint in joints
        if joint.model.family == "dynamixel"
        and (joint.model.watchdog_firmware is None or joint.servo.firmware < joint.model.watchdog_firmware)
    ]
    if lacking:
        raise BadInputError(
            f"{master.where}: {', '.join(each.what for each in lacking)} ({lacking[0].model.name}, firmware "
            f"{lacking[0].servo.firmware}) has no bus watchdog that works: update the firmware "
            f"to {lacking[0].model.watchdog_firmware} or later, or accept it with --no-servo-watchdog"
        )
    return joints[0].model.family == "dynamixel"


def _check_health(master: BusMaster, joint: Joint, found: Mapping[str, int]) -> None:
    fault = hardware_fault(
        joint.model,
        joint.number,
        found["hardware_error"],
        load_share=0.0,
        temperature_c=found["present_temperature"],
        voltage_v=found["present_voltage"] * joint.model["present_voltage"].unit,
    )
    if fault is not None:
        raise BoardFaultError(
            f"{master.where}: {words(fault)} (servo {joint.id}): mend that, then switch its supply off and on"
        )


def check_settings(master: BusMaster, joint: Joint, found: Mapping[str, int], limit_rad: float) -> None:
    """Mode and angle limits of a servo against what the joint is to do.

    Raises:
        BadInputError: they do not fit; what to change is named.
    """
    where = f"{master.where}: {joint.what}"
    modes = joint.model.position_modes
    mode = found.get("operating_mode")
    if mode is not None and mode not in modes:
        known = " or ".join(f"{value} ({name})" for value, name in modes.items())
        raise BadInputError(
            f"{where} is in operating mode {mode}: set it to {known} with the vendor's program"
        )
    limit_deg = math.degrees(limit_rad)
    if counts_on(joint, found):
        return
    if crosses_the_wrap(joint, limit_rad):
        raise BadInputError(
            f"{where}: its range of +-{limit_deg:.0f} deg about {joint.zero_counts} counts crosses the end of the "
            f"servo's turn ({joint.model.lowest}/{joint.model.highest}): turn the horn, or set the servo's homing "
            "offset, so that straight is near the middle; then `snakebot robot calibrate`"
        )
    ends = sorted((joint.counts(-limit_rad), joint.counts(limit_rad)))
    lowest, highest = found["min_position"], found["max_position"]
    if ends[0] < lowest - 1 or ends[1] > highest + 1:
        raise BadInputError(
            f"{where}: its own angle limits are {lowest} to {highest} counts, the description's +-{limit_deg:.0f} deg "
            f"need {ends[0]:.0f} to {ends[1]:.0f}: it would refuse goals; change one of the two"
        )


def counts_on(joint: Joint, found: Mapping[str, int]) -> bool:
    """The servo counts on beyond one turn, and takes goals there."""
    if joint.model.family == "dynamixel":
        return found["operating_mode"] in joint.model.multi_turn_modes
    return bool(joint.model.multi_turn_modes) and found["min_position"] == found["max_position"] == 0


def _check_place(master: BusMaster, joint: Joint, found: Mapping[str, int], limit_rad: float) -> None:
    angle_rad = joint.angle_rad(found["present_position"])
    if abs(angle_rad) > limit_rad + BEYOND_RAD:
        raise BoardFaultError(
            f"{master.where}: {joint.what} stands at {math.degrees(angle_rad):.1f} deg, beyond its limit of "
            f"{math.degrees(limit_rad):.1f} deg: turn it back by hand"
            ", or store its zero with `snakebot robot calibrate`"
        )
