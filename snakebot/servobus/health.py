"""How the servos on a bus are: errors, torque, supply, temperature, and whether one has lost its supply.

They are asked in time that nobody waits for, many times a second. That is also what feeds their bus watchdogs while the
board holds.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from firmware_protocol.catalogue import Fault
from firmware_protocol.servo_trouble import ServoTrouble
from snakebot.servobus.joints import Joint
from snakebot.servobus.master import BusMaster
from snakebot.servobus.settings import MARKS, Settings
from snakebot.servobus.troubles import hardware_fault
from snakebot.softboard.hardware import HardwareFault, Health

HEALTH_S = 0.04  # between looks: a bus watchdog of 100 ms is fed although one is lost
_OF_POWER = (
    *(ServoTrouble.TORQUE_OFF, ServoTrouble.POWER_CYCLED),
    *(ServoTrouble.BUS_WATCHDOG, ServoTrouble.REFUSES),
)  # what can only be wrong with a joint that is to have power
_BLOCKS = {
    "feetech": (("torque_enable", "present_current"),),
    "dynamixel": (("torque_enable", "bus_watchdog"), ("present_current", "present_temperature")),
}


class HealthWatch:
    """What is known of the servos' health, and what is wrong with them.

    Attributes:
        due_s: when to look again, on the clock of the bus.
    """

    def __init__(self, joints: Sequence[Joint], master: BusMaster, settings: Settings) -> None:
        self.due_s = float("-inf")
        self._joints = tuple(joints)
        self._by_id = {joint.id: joint for joint in joints}
        self._master = master
        self._settings = settings
        self._model = joints[0].model
        self._block = 0
        self._powered: Collection[int] = ()
        self._troubles: dict[int, HardwareFault] = {}
        self._sensors: dict[int, dict[str, int]] = {}  # joint -> register -> value, of the last looks

    def first(self) -> HardwareFault | None:
        """What is wrong with the first joint that has something; None: nothing."""
        return self._troubles[min(self._troubles)] if self._troubles else None

    def trouble(self, joint: Joint, trouble: ServoTrouble) -> None:
        """Somebody else has seen that something is wrong."""
        self._troubles[joint.number] = HardwareFault(Fault.SERVO, joint.number, trouble)

    def heard(self, joint: Joint) -> None:
        """It has answered: it is not silent."""
        known = self._troubles.get(joint.number)
        if known is not None and (known.code, known.detail) == (Fault.SERVO, ServoTrouble.SILENT):
            del self._troubles[joint.number]

    def relaxed(self, joints: Collection[int]) -> None:
        """They have confirmed that they have no torque: what was wrong with having it is over, before the next look."""
        for number in joints:
            known = self._troubles.get(number)
            if known is not None and known.code is Fault.SERVO and known.detail in _OF_POWER:
                del self._troubles[number]

    def look(self, now_s: float, powered: Collection[int]) -> None:
        """Ask all servos about themselves; Dynamixel in two halves, in turn, both where one is in trouble.

        Args:
            powered: joints that should have torque.
        """
        self.due_s = now_s + HEALTH_S
        self._powered = powered
        blocks = _BLOCKS[self._model.family]
        heard = self._look(blocks[self._block % len(blocks)], self._joints)
        self._block += 1
        for joint in heard:
            trouble = self._trouble(joint)
            if trouble is not None and joint.number not in self._troubles:
                trouble = self._said_again(joint, trouble)
            self._judge(joint, trouble)
            if trouble is None and joint.number in powered and not self._has_its_settings(joint):
                # a damaged write has passed the servo's check
                self._settings.mend(self._master, joint.number)

    def _said_again(self, joint: Joint, trouble: HardwareFault) -> HardwareFault | None:
        """What a servo says of its trouble when it is asked once more; None: something else, or nothing.

        A damaged answer passes Feetech's check once in 256: nothing is believed before it is said twice.
        """
        self._sensors[
            joint.number
        ].clear()  # where the second answer is lost, the first must not stand for it
        for block in _BLOCKS[self._model.family]:
            self._look(block, [joint])
        again = self._trouble(joint)
        return again if again is not None and again.code is trouble.code else None

    def _look(self, block: tuple[str, str], joints: Sequence[Joint]) -> list[Joint]:
        """Read a span of registers of servos; the joints that answered and said whether they have an error."""
        model = self._model
        start, end = model[self._known(block[0])].address, model[self._known(block[1])].end
        heard = self._master.sync_read(
            [joint.id for joint in joints],
            start,
            end - start,
            in_turn=len(joints) == 1 or not model.sync_read,
            tries=1,
        )
        names = [name for name, r in model.registers.items() if start <= r.address and r.end <= end]
        for servo, data in heard.items():
            sensors = self._sensors.setdefault(self._by_id[servo].number, {})
            sensors |= {name: model.part(name, start, data) for name in names}
        return [self._by_id[servo] for servo in heard] if "hardware_error" in names else []

    def _known(self, name: str) -> str:
        """The register, or what the model has in its place."""
        if name in self._model:
            return name
        return {"present_current": "present_load" if self._model.family == "dynamixel" else "moving"}[name]

    def _judge(self, joint: Joint, trouble: HardwareFault | None) -> None:
        known = self._troubles.get(joint.number)
        if trouble is not None:
            self._troubles[joint.number] = trouble
        elif known is not None and known.detail != ServoTrouble.SILENT:
            del self._troubles[joint.number]

    def _trouble(self, joint: Joint) -> HardwareFault | None:
        number, sensors = joint.number, self._sensors[joint.number]
        errors = sensors.get("hardware_error", 0)
        if errors:
            return hardware_fault(
                joint.model,
                number,
                errors,
                load_share=self._load_share(sensors),
                temperature_c=sensors.get("present_temperature", 0),
                voltage_v=sensors.get("present_voltage", 0) * joint.model["present_voltage"].unit,
            )
        if number not in self._powered:
            return None
        if sensors.get("bus_watchdog") == -1:
            return HardwareFault(Fault.SERVO, number, ServoTrouble.BUS_WATCHDOG)
        if sensors.get("torque_enable") == 0:
            own = ServoTrouble.TORQUE_OFF if self._has_its_settings(joint) else ServoTrouble.POWER_CYCLED
            return HardwareFault(Fault.SERVO, number, own)
        return None

    def _has_its_settings(self, joint: Joint) -> bool:
        """It holds what it was set to: it has not lost its supply since."""
        sensors = self._sensors[joint.number]
        marks = {name: self._settings.wanted(joint.number, name) for name in MARKS if name in sensors}
        return all(wanted is None or sensors[name] == wanted for name, wanted in marks.items())

    def _load_share(self, sensors: dict[str, int]) -> float:
        model = self._model
        if "present_load" in sensors:
            return sensors["present_load"] * model["present_load"].unit
        if "present_current" in sensors:
            return sensors["present_current"] * model["present_current"].unit / model.stall_current_a
        return 0.0

    def _warmth(self, sensors: dict[str, int]) -> tuple[float, float] | None:
        """Current (where only load is measured: its share of the stall current) and temperature."""
        if "present_temperature" not in sensors:
            return None
        model = self._model
        current_a = (
            sensors["present_current"] * model["present_current"].unit
            if "present_current" in sensors
            else self._load_share(sensors) * model.stall_current_a
        )
        return current_a, float(sensors["present_temperature"])

    def health(self) -> Health | None:
        """For the log; None before the first look."""
        readings = [self._sensors.get(joint.number, {}) for joint in self._joints]
        volts = [reading["present_voltage"] for reading in readings if "present_voltage" in reading]
        if not volts:
            return None
        return Health(
            min(volts) * self._model["present_voltage"].unit,
            tuple(self._warmth(reading) for reading in readings),
        )
