"""The joints as a board drives them: which have power, what their encoders say, what their servos are told."""

from __future__ import annotations

from firmware_protocol.catalogue import JointMode
from snakebot.robot import Robot
from snakebot.softboard.plant import JointPlant
from snakebot.softboard.register import SetpointRegister


class DrivenJoints:
    """A plant behind its board's pulses and power switches. Whoever calls has brought it to the moment of the call.

    Attributes:
        trim_rad, zero_counts: (joints,); a reset keeps them.
    """

    def __init__(self, plant: JointPlant, robot: Robot) -> None:
        self.trim_rad = [0.0] * robot.joints
        self.zero_counts = [0] * robot.joints
        self._plant = plant
        self._rad_per_count = robot.rad_per_count
        self._free: list[bool | None] = [None] * robot.joints  # as the plant was told
        self.reset()

    def reset(self) -> None:
        """What was read is forgotten; the plant stays as it is."""
        self._known = [False] * len(self.trim_rad)  # read since the reset

    def read(self, register: SetpointRegister) -> list[int | None]:
        """Encoder counts from their zeros; the register follows those of joints without power."""
        counts = [
            None if raw is None else int(raw) - zero
            for raw, zero in zip(self._plant.encoder_counts(), self.zero_counts, strict=True)
        ]
        if any(self._free) or not all(self._known):
            for index, count in enumerate(counts):
                self._known[index] |= count is not None
                if self._free[index] and count is not None:
                    register.follow(index, count * self._rad_per_count)
        return counts

    def command(self, register: SetpointRegister, plant_s: float) -> None:
        """The servo pulses: what the register holds, from this time of the plant on."""
        self._plant.command(plant_s, register.servo_rad)

    def power(self, register: SetpointRegister, plant_s: float, *, powered: bool) -> None:
        """Tell the plant which joints have power, where that has changed.

        A joint that gets power is told to stay where it is: nothing jumps. One that has never been read gets none.

        Args:
            powered: whether the board's mode gives power at all.
        """
        free = [not powered or mode is JointMode.FREE for mode in register.joint_modes]
        switched_on = any(was and not now for was, now in zip(self._free, free, strict=True))
        if switched_on:
            self.read(register)
            free = [unpowered or not known for unpowered, known in zip(free, self._known, strict=True)]
        if free == self._free:
            return
        for index, (was, now) in enumerate(zip(self._free, free, strict=True)):
            if was is not now:
                self._plant.set_joint_mode(index + 1, "free" if now else "active")
                if not now:
                    register.put_trim_in_force(index, self.trim_rad[index])
        self._free = [*free]
        if switched_on:
            self.command(register, plant_s)
