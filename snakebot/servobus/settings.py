"""Registers that are set while the joints have power, and put back afterwards.

A servo's own motion profile would be diagnosed as a rate limit of the joint: it is set to "none". So that a servo that
has lost its supply can be told from one that has not, its settings are such that none of them is what it wakes up with.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from snakebot.servobus.joints import Joint
from snakebot.servobus.master import PATIENT_TRIES, BusMaster

WATCHDOG_COUNTS = 5  # of 20 ms
MARKS = ("bus_watchdog", "torque_limit")  # a servo wakes up with other values than it is set to
_PROFILE = ("profile_acceleration", "profile_velocity", "goal_time")
_GAINS = ("position_p_gain", "position_i_gain", "position_d_gain")
_ALSO_LOGGED = ("return_delay", "operating_mode", "homing_offset", "min_position", "max_position")


@dataclass(frozen=True, slots=True)
class Change:
    """One register of one servo: what it held, and what it is set to."""

    joint: int
    register: str
    before: int
    now: int

    def __str__(self) -> str:
        return f"joint {self.joint}: {self.register} {self.before} -> {self.now}"


def read_register(master: BusMaster, joint: Joint, name: str) -> int | None:
    """One register of one servo; None: no answer."""
    register = joint.model[name]
    data = master.read(joint.id, register.address, register.size)
    return None if data is None else joint.model.unpack(name, data)


def write_register(master: BusMaster, joint: Joint, name: str, value: int) -> bool:
    """Write one register of one servo; whether it was acknowledged."""
    return master.write(joint.id, joint.model[name].address, joint.model.pack(name, value))


class Settings:
    """What is changed in the servos of these joints, and what stood there before.

    Args:
        found: joint -> register -> value, as they were before anybody changed them.
        watchdog: set the bus watchdog of servos that have one.
    """

    def __init__(
        self, joints: Sequence[Joint], found: Mapping[int, Mapping[str, int]], *, watchdog: bool
    ) -> None:
        self._joints = {joint.number: joint for joint in joints}
        self._set_to: list[Change] = []
        for joint in joints:
            for name, value in self._wanted(joint, found[joint.number], watchdog).items():
                before = found[joint.number][name]
                if before != value or name in MARKS:  # a host that was killed leaves marks behind
                    self._set_to.append(Change(joint.number, name, before, value))
        self.changes = [change for change in self._set_to if change.before != change.now]

    @staticmethod
    def _wanted(joint: Joint, found: Mapping[str, int], watchdog: bool) -> dict[str, int]:
        model = joint.model
        wanted = {name: 0 for name in _PROFILE if name in model}
        if "torque_limit" in model:
            # one less than it wakes up with: the mark of a servo that has not lost its supply
            most = found.get("max_torque", 1000)
            wanted["torque_limit"] = max(1, round(joint.torque_limit * most) - 1)
        elif joint.torque_limit < 1.0 and "goal_pwm" in model:
            wanted["goal_pwm"] = round(joint.torque_limit * found["pwm_limit"])
        if watchdog and "bus_watchdog" in model:
            wanted["bus_watchdog"] = WATCHDOG_COUNTS
        return wanted

    def wanted(self, joint: int, register: str) -> int | None:
        """What a register is set to while the joint has power; None: it is left alone."""
        for change in self._set_to:
            if (change.joint, change.register) == (joint, register):
                return change.now
        return None

    def apply(self, master: BusMaster, joints: Sequence[int]) -> list[int]:
        """Set everything for these joints but the watchdog, which bites at once; who did not take it."""
        return self._set(
            master, [c for c in self._set_to if c.joint in joints and c.register != "bus_watchdog"]
        )

    def watch(self, master: BusMaster, joints: Sequence[int]) -> list[int]:
        """Set the bus watchdogs; who did not take it."""
        return self._set(
            master, [c for c in self._set_to if c.joint in joints and c.register == "bus_watchdog"]
        )

    def mend(self, master: BusMaster, joint: int) -> None:
        """Set everything once more for a joint that has power."""
        for change in self._set_to:
            if change.joint == joint:
                register = self._joints[joint].model[change.register]
                data = self._joints[joint].model.pack(change.register, change.now)
                master.sync_write(register.address, {self._joints[joint].id: data})

    def unwatch(self, master: BusMaster, joints: Sequence[int]) -> None:
        """Clear bus watchdogs, tripped ones too: until then a servo refuses goals."""
        for change in self._set_to:
            if change.joint in joints and change.register == "bus_watchdog":
                write_register(master, self._joints[change.joint], "bus_watchdog", 0)

    def restore(self, master: BusMaster, joints: Sequence[int]) -> None:
        """Put everything back for these joints, as far as they answer."""
        self.unwatch(master, joints)
        for change in self.changes:
            if change.joint in joints and change.register != "bus_watchdog":
                write_register(master, self._joints[change.joint], change.register, change.before)

    def _set(self, master: BusMaster, changes: Sequence[Change]) -> list[int]:
        """By one sync write a register and one sync read that sees whether it was taken; repeated for who has not."""
        failed: set[int] = set()
        for name in sorted({change.register for change in changes}):
            left = {change.joint: change.now for change in changes if change.register == name}
            for _ in range(PATIENT_TRIES):
                of = [self._joints[number] for number in left]
                model = of[0].model
                register = model[name]
                master.sync_write(register.address, {j.id: j.model.pack(name, left[j.number]) for j in of})
                heard = master.sync_read(
                    [j.id for j in of], register.address, register.size, in_turn=not model.sync_read
                )
                for joint in of:
                    taken = (
                        joint.id in heard and joint.model.unpack(name, heard[joint.id]) == left[joint.number]
                    )
                    if taken:
                        del left[joint.number]
                if not left:
                    break
            failed |= set(left)
        return sorted(failed)


def read_found(master: BusMaster, joint: Joint) -> dict[str, int] | None:
    """All registers of a servo by name, by one read of its memory; None: it does not answer."""
    registers = joint.model.registers
    found: dict[str, int] = {}
    for names in _spans(joint):
        start = registers[names[0]].address
        data = master.read(joint.id, start, registers[names[-1]].end - start)
        if data is None:
            return None
        found |= {name: joint.model.part(name, start, data) for name in names}
    return found


_MOST_AT_ONCE = 60  # bytes of one answer


def _spans(joint: Joint) -> list[list[str]]:
    """The registers in the order of their addresses, cut into pieces that one answer can carry."""
    registers = joint.model.registers
    spans: list[list[str]] = [[]]
    for name in sorted(registers, key=lambda name: registers[name].address):
        span = spans[-1]
        if span and registers[name].end - registers[span[0]].address > _MOST_AT_ONCE:
            span = []
            spans.append(span)
        span.append(name)
    return spans


def described(joint: Joint, found: Mapping[str, int]) -> dict[str, Any]:
    """What the log keeps of a servo: who it is, its gains, delay and limits."""
    return {
        "joint": joint.number,
        "id": joint.id,
        "model": joint.model.name,
        "firmware": joint.servo.firmware_text,
        "direction": joint.direction,
        "zero_counts": joint.zero_counts,
        **{name: found[name] for name in (*_GAINS, *_ALSO_LOGGED) if name in found},
    }
