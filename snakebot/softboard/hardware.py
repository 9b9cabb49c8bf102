"""What a plant may be besides joints: hardware, which can fail, and which measures itself."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from firmware_protocol.catalogue import Fault, JointSupply, Message, Supply
from snakebot.softboard.plant import JointPlant


@dataclass(frozen=True, slots=True)
class HardwareFault:
    """What is wrong with the hardware: the fields of a ``FaultEvent``."""

    code: Fault
    joint: int = 0  # from 1; 0: not one joint's
    detail: int = 0


@dataclass(frozen=True, slots=True)
class Health:
    """What the hardware measures of itself; (current A, temperature degC) a joint, None where it is not known."""

    voltage_v: float
    joints: tuple[tuple[float, float] | None, ...]


@runtime_checkable
class HardwarePlant(JointPlant, Protocol):
    """Joints that are there: they can fail, and they want to be looked at although no host asks."""

    @property
    def due_s(self) -> float:
        """When it next wants ``advance``, in its own time."""
        ...

    def fault(self) -> HardwareFault | None:
        """What is wrong now; None: nothing. It lasts until the hardware is well again."""
        ...

    def health(self) -> Health | None:
        """The last readings; None before the first."""
        ...


class Hardware:
    """A plant's hardware as the board looks at it; a simulated plant has none, and only what is simulated is wrong."""

    def __init__(self, plant: JointPlant) -> None:
        self._plant = plant if isinstance(plant, HardwarePlant) else None
        self.simulated_fault = HardwareFault(Fault.NONE)
        self.latched = HardwareFault(Fault.NONE)  # what the board's last fault was about

    @property
    def simulated(self) -> bool:
        return self._plant is None

    @property
    def due_s(self) -> float:
        return math.inf if self._plant is None else self._plant.due_s

    @property
    def button_is_pressed(self) -> bool:
        return self.simulated_fault.code is Fault.EMERGENCY_STOP

    def fault(self) -> HardwareFault | None:
        """What is wrong now, of the joints that are there first; None: nothing."""
        fault = None if self._plant is None else self._plant.fault()
        return fault if fault is not None or self.simulated_fault.code is Fault.NONE else self.simulated_fault

    def about(self, code: Fault) -> HardwareFault:
        """Joint and value of the latched fault, where that is the one of this code."""
        return self.latched if self.latched.code is code else HardwareFault(code)

    def supply(self) -> list[Message]:
        """What the hardware measures of itself, as messages."""
        health = None if self._plant is None else self._plant.health()
        if health is None:
            return []
        known = [(number, reading) for number, reading in enumerate(health.joints, 1) if reading is not None]
        messages: list[Message] = [JointSupply(number, *reading) for number, reading in known]
        if known:
            total_a = sum(abs(current_a) for _, (current_a, _) in known)
            messages.append(Supply(health.voltage_v, total_a, max(warm_c for _, (_, warm_c) in known)))
        return messages
