"""One emulated servo: its memory, what a write does to it, and what it does by itself.

It knows no packets and no dynamics: ``bus`` hands it reads and writes, ``chain`` moves it.
"""

from __future__ import annotations

import math

from snakebot.servobus import dynamixel
from snakebot.servobus.registers import ServoModel

_MEMORY = 256  # bytes of the register table: addresses have 8 bits in the older models
_ROOM_C = 30  # deg C; chosen
_SUPPLY_V = {"sts3215": 12.0, "scs0009": 6.0, "xl330": 5.0}
_FIRMWARE = {"feetech": 0x0903, "dynamixel": 45}  # STS: 3.9
_GOALS = ("goal_position", "goal_pwm", "goal_current")
# Bits of the hardware error register and of Feetech's error byte.
_OVERLOAD = 1 << 5
_OVERHEAT = 1 << 2
_VOLTAGE = 1 << 0
_X_OVERLOAD_SHARE, _X_OVERLOAD_S = 0.9, 1.0  # ours: the e-Manual gives no figure

# What a servo has as it is delivered; the rest is zero.
_DELIVERED = {
    "feetech": {
        "return_delay": 250,
        "status_return_level": 1,
        "temperature_limit": 70,
        "max_torque": 1000,
        "unloading_condition": 44,
        "position_p_gain": 32,
        "position_d_gain": 32,
        "protective_torque": 20,
        "protection_time": 200,
        "overload_torque": 80,
        "lock": 1,
    },
    "dynamixel": {
        "return_delay": 250,
        "operating_mode": 3,
        "temperature_limit": 80,
        "max_voltage": 140,
        "min_voltage": 35,
        "pwm_limit": 885,
        "velocity_limit": 265,
        "current_limit": 1750,
        "max_position": 4095,
        "shutdown": 52,
        "status_return_level": 2,
        "position_p_gain": 800,
        "goal_current": 1750,
        "goal_pwm": 885,
    },
}


class EmulatedServo:
    """Registers of one servo, as delivered.

    Args:
        model: what it is.
        servo: its id.
        baud: at which it listens.
        firmware: as it reports it.

    Attributes:
        position_counts: where the output is, whole turns included; ``chain`` moves it.
        turn_counts: the whole turns that the servo does not know of: what it says is so much less.
        load_share: of the stall torque, with its sign.
        held_load: stands in for the load that the chain's torque is, where somebody holds the joint.
        temperature_c, supply_v: what its sensors measure.
        powered: False: it has no supply and says nothing.
        changed: a write came that ``chain`` has to look at.
    """

    def __init__(
        self, model: ServoModel, servo: int, *, baud: int = 1_000_000, firmware: int | None = None
    ) -> None:
        self.model = model
        self.memory = bytearray(_MEMORY)
        self.position_counts = float((model.lowest + model.highest + 1) // 2)
        self.turn_counts = 0.0
        self.velocity_rad_s = 0.0
        self.load_share = 0.0
        self.held_load: float | None = None
        self.temperature_c = float(_ROOM_C)
        self.supply_v = _SUPPLY_V.get(model.name, 12.0)
        self.powered = True
        self.changed = True
        self._fed_s = -math.inf
        self._strained_s: float | None = None
        self._stored: dict[str, int] = {}
        for name, value in _DELIVERED[model.family].items():
            if name in model:
                self.set(name, value)
        if model.family == "feetech":
            self.set("max_position", model.highest)
            self.set("max_voltage", 140)
            self.set("min_voltage", 40)
        self.set("id", servo)
        self.set("model_number", model.numbers[0])
        self.set("firmware", _FIRMWARE[model.family] if firmware is None else firmware)
        self.set("baud_rate", model.baud_code(baud))
        self._start()

    # -- for those who may look behind the scenes --------------------------------------------------------------------

    def get(self, name: str) -> int:
        """The value of a register."""
        register = self.model.registers[name]
        return self.model.unpack(name, self.memory[register.address : register.end])

    def set(self, name: str, value: int) -> None:
        """Put a value into a register, whatever the servo would say to that."""
        register = self.model[name]
        self.memory[register.address : register.end] = self.model.pack(name, value)
        if register.stored:
            self._stored[name] = value

    @property
    def id(self) -> int:
        return self.get("id")

    @property
    def baud(self) -> int:
        return self.model.baud[self.get("baud_rate")]

    @property
    def driving(self) -> bool:
        """It exerts torque."""
        return self.powered and self.get("torque_enable") != 0

    @property
    def torque_share(self) -> float:
        """How much of its torque it may use."""
        if "torque_limit" not in self.model:
            return 1.0
        share = self.get("torque_limit") / 1000
        if self.get("hardware_error") & _OVERLOAD:
            share = min(share, self.get("protective_torque") / 100)
        return share

    def power_cycle(self) -> None:
        """Take its supply away and give it back: what is not stored is forgotten, torque is off."""
        self._start()

    def _start(self) -> None:
        for register in self.model.registers.values():
            if not register.stored:
                self.memory[register.address : register.end] = bytes(register.size)
        for name, value in self._stored.items():
            self.set(name, value)
        for name, value in _DELIVERED[self.model.family].items():
            if name in self.model and not self.model[name].stored:
                self.set(name, value)
        if "torque_limit" in self.model:
            self.set("torque_limit", self.get("max_torque"))
        self._strained_s = None
        self._in_one_turn()
        self.show()
        self.set("goal_position", self.get("present_position"))
        self.changed = True

    # -- what the bus asks -------------------------------------------------------------------------------------------

    @property
    def error(self) -> int:
        """The error byte of an answer that went well."""
        error = self.get("hardware_error")
        if self.model.family == "dynamixel":
            return dynamixel.ALERT if error else 0
        return error

    def read(self, address: int, length: int) -> bytes:
        """Bytes of the memory; zeros where there is none."""
        return bytes(self.memory[address : address + length]).ljust(length, b"\0")

    def write(self, address: int, data: bytes) -> int:
        """Take a write; returns the error byte of its answer."""
        if self.model.family == "dynamixel":
            refused = self._x_refuses(address, data)
            if refused:
                return refused | self.error
        before = bytes(self.memory)
        end = address + len(data)
        self.memory[address:end] = data
        del self.memory[_MEMORY:]
        for name, register in self.model.registers.items():
            if not (register.address < end and address < register.end):
                continue
            touched = before[register.address : register.end] != self.memory[register.address : register.end]
            if touched or name == "torque_enable":
                self._written(name, before)
        self.changed = True
        return self.error

    def _x_refuses(self, address: int, data: bytes) -> int:
        end = address + len(data)
        for name, register in self.model.registers.items():
            if not (address <= register.address and register.end <= end):
                continue
            value = self.model.part(name, address, data)
            if name.startswith(("present_", "moving", "hardware", "model", "firmware")):
                return dynamixel.ERROR_ACCESS
            if register.stored and self.get("torque_enable"):
                return dynamixel.ERROR_ACCESS
            if name in _GOALS and self.get("bus_watchdog") == -1:
                return dynamixel.ERROR_RANGE
            if name == "goal_position" and not self._may_go_to(value):
                return dynamixel.ERROR_LIMIT
            if name == "torque_enable" and value and self.get("hardware_error"):
                return dynamixel.ERROR_ACCESS
        return 0

    def _may_go_to(self, goal: int) -> bool:
        return self.multi_turn or self.get("min_position") <= goal <= self.get("max_position")

    def _written(self, name: str, before: bytes) -> None:
        model = self.model
        register = model[name]
        value = self.get(name)
        if register.stored and (model.family == "dynamixel" or not self.get("lock")):
            self._stored[name] = value
        if name == "torque_enable":
            was = model.part(name, 0, before)
            if model.family == "feetech":
                self.set("hardware_error", 0)
            elif value and not was:
                if self.get("operating_mode") == 3:
                    self._in_one_turn()
                self.show()
                self.set("goal_position", self.get("present_position"))
        elif name == "goal_position" and model.family == "feetech" and self.get("max_position"):
            inside = min(max(value, self.get("min_position")), self.get("max_position"))
            self.set("goal_position", inside)

    # -- what it does by itself --------------------------------------------------------------------------------------

    def fed(self, t_s: float) -> None:
        """An instruction has been seen on the bus."""
        self._fed_s = t_s

    def live(self, t_s: float) -> None:
        """Watch temperature, voltage, load and the bus until ``t_s``; show the sensors in the registers."""
        self._watch_bus(t_s)
        error = 0
        if self.temperature_c > self.get("temperature_limit"):
            error |= _OVERHEAT
        if not self.get("min_voltage") / 10 <= self.supply_v <= self.get("max_voltage") / 10:
            error |= _VOLTAGE
        if self._overloaded(t_s):
            error |= _OVERLOAD
        mask = "shutdown" if self.model.family == "dynamixel" else "unloading_condition"
        if self.model.family == "feetech":
            latched = self.get("hardware_error") & _OVERLOAD
            self.set("hardware_error", error | latched)
            error &= ~_OVERLOAD  # it goes on with less torque
        else:
            self.set("hardware_error", error | self.get("hardware_error"))
        if error & self.get(mask) and self.get("torque_enable"):
            self.set("torque_enable", 0)
            self.changed = True
        self.show()

    def _overloaded(self, t_s: float) -> bool:
        if self.model.family == "dynamixel":
            share, patience_s = _X_OVERLOAD_SHARE, _X_OVERLOAD_S
        else:
            share, patience_s = self.get("overload_torque") / 100, self.get("protection_time") / 100
        if not self.driving or abs(self.load_share) <= share:
            self._strained_s = None
            return False
        if self._strained_s is None:
            self._strained_s = t_s
        return t_s - self._strained_s >= patience_s

    def _watch_bus(self, t_s: float) -> None:
        if "bus_watchdog" not in self.model:
            return
        patience = self.get("bus_watchdog")
        if patience > 0 and self.driving and t_s - self._fed_s > patience * self.model["bus_watchdog"].unit:
            self.set("bus_watchdog", -1)
            self.show()
            self.set("goal_position", self.get("present_position"))  # it brakes where it is
            self.changed = True

    @property
    def multi_turn(self) -> bool:
        """Positions count on beyond a turn."""
        if self.model.family == "dynamixel":
            return self.get("operating_mode") in self.model.multi_turn_modes
        return self.get("max_position") == 0

    def _in_one_turn(self) -> None:
        """The encoder knows the angle, not the turn."""
        turn = self.model.counts_per_rev
        self.turn_counts = turn * math.floor(self.position_counts / turn)

    def show(self) -> None:
        """What the sensors say, in the registers."""
        model = self.model
        if model.family == "feetech" and not self.multi_turn:
            self._in_one_turn()
        position = round(self.position_counts - self.turn_counts)
        if model.family == "feetech" and not self.multi_turn:
            position = min(position, round(model.counts_per_rev) - 1)
        _put(self, "present_position", position)
        _put(self, "present_velocity", round(self.velocity_rad_s / model["present_velocity"].unit))
        if "present_load" in model:
            _put(self, "present_load", round(1000 * self.load_share))
        if "present_current" in model:
            current_a = self.load_share * model.stall_current_a
            _put(self, "present_current", round(current_a / model["present_current"].unit))
        _put(self, "present_voltage", round(10 * self.supply_v))
        _put(self, "present_temperature", round(self.temperature_c))


def _put(servo: EmulatedServo, name: str, value: int) -> None:
    """A reading as far as its register goes."""
    register = servo.model[name]
    bits = register.sign_bit if register.sign_bit is not None else 8 * register.size - register.signed
    most = (1 << bits) - 1
    lowest = -most if register.sign_bit is not None or register.signed else 0
    servo.set(name, min(max(value, lowest), most))
