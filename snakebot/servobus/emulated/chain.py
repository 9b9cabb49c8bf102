"""The snake behind emulated servos: goal registers in, positions, loads and speeds out.

The servo's own motion profile acts here, everything else that a servo may do wrong is an effect of the plant.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from snakebot.servobus.emulated.servo import EmulatedServo

if TYPE_CHECKING:
    from snakebot.robot import Robot

_STEP_S = 0.001  # of a motion profile


class ServoChain:
    """Joints of a robot, one a servo, in the order of the chain.

    Args:
        robot: what the servos move.
        plant: ``snakebot.effects.Plant`` of it, whose time is ours.
        servos: one a joint.
        zero_counts: position of each servo at which its joint is straight.
        direction: +1, or -1 where a larger count turns the joint to a smaller angle.
    """

    def __init__(
        self,
        robot: Robot,
        plant: Any,
        servos: Sequence[EmulatedServo],
        zero_counts: Sequence[float] | None = None,
        direction: Sequence[int] | None = None,
    ) -> None:
        assert len(servos) == robot.joints
        self.robot = robot
        self.plant = plant
        self.servos = list(servos)
        middle = [(s.model.lowest + s.model.highest + 1) // 2 for s in servos]
        self._zero = list(zero_counts) if zero_counts is not None else [float(m) for m in middle]
        self._direction = list(direction) if direction is not None else [1] * len(servos)
        self._target_rad = [0.0] * len(servos)  # where the profile is
        self._speed_rad_s = [0.0] * len(servos)
        self._driving: list[bool | None] = [None] * len(servos)
        self._t_s = 0.0
        self._measured_s = 0.0
        self._measure(0.0)
        for servo in servos:
            servo.power_cycle()

    def advance(self, t_s: float) -> None:
        """Let servos and snake go on until ``t_s``; what was written since the last call acts from now on."""
        self._take_modes()
        if t_s <= self._t_s:
            return
        while self._t_s < t_s:
            on_the_way = self._profiles(min(_STEP_S, t_s - self._t_s))
            self._t_s = min(self._t_s + _STEP_S, t_s) if on_the_way else t_s
            self.plant.advance(self._t_s)
        self._measure(t_s)
        for servo in self.servos:
            servo.live(t_s)
        self._take_modes()

    # -- registers to the plant --------------------------------------------------------------------------------------

    def _take_modes(self) -> None:
        """Torque that was switched, goals that were written."""
        moved = False
        for j, servo in enumerate(self.servos):
            if not servo.changed:
                continue
            servo.changed = False
            driving = servo.driving
            if driving is not self._driving[j]:
                self._driving[j] = driving
                self.plant.set_joint_mode(j + 1, "active" if driving else "free")
                if driving:
                    self._target_rad[j] = self._angle_rad(j, servo.position_counts)
                    self._speed_rad_s[j] = 0.0
            if driving and not self._has_profile(servo):
                self._target_rad[j] = self._goal_rad(j)
            limit = getattr(self.plant, "set_torque_limit", None)
            if limit is not None:
                limit(j + 1, servo.torque_share * servo.model.stall_torque_nm)
            moved = True
        if moved:
            self.plant.command(self._t_s, self._target_rad)

    def _profiles(self, dt_s: float) -> bool:
        """Move the set-points of servos with a motion profile on; whether one is still on its way."""
        on_the_way = False
        for j, servo in enumerate(self.servos):
            if not (servo.driving and self._has_profile(servo)):
                continue
            error = self._goal_rad(j) - self._target_rad[j]
            if error == 0.0:
                self._speed_rad_s[j] = 0.0
                continue
            on_the_way = True
            model = servo.model
            top = model.si("profile_velocity", servo.get("profile_velocity")) or math.inf
            if "profile_acceleration" in model and servo.get("profile_acceleration"):
                gain = model.si("profile_acceleration", servo.get("profile_acceleration"))
                # as fast as it can still brake from
                top = min(top, math.sqrt(2 * gain * abs(error)), abs(self._speed_rad_s[j]) + gain * dt_s)
            step = min(top * dt_s, abs(error))
            self._target_rad[j] += math.copysign(step, error)
            self._speed_rad_s[j] = step / dt_s
        if on_the_way:
            self.plant.command(self._t_s, self._target_rad)
        return on_the_way

    @staticmethod
    def _has_profile(servo: EmulatedServo) -> bool:
        acceleration = "profile_acceleration" in servo.model and servo.get("profile_acceleration")
        return bool(servo.get("profile_velocity") or acceleration)

    def _angle_rad(self, j: int, counts: float) -> float:
        return self._direction[j] * (counts - self._zero[j]) * self.servos[j].model.rad_per_count

    def _goal_rad(self, j: int) -> float:
        servo = self.servos[j]
        return self._angle_rad(j, servo.get("goal_position") + servo.turn_counts)

    # -- plant to the registers --------------------------------------------------------------------------------------

    def _measure(self, t_s: float) -> None:
        angles = np.asarray(self.plant.encoder_counts()) * self.robot.rad_per_count
        torques = np.asarray(self.plant.joint_torque_nm)
        for j, servo in enumerate(self.servos):
            counts = self._direction[j] * float(angles[j]) / servo.model.rad_per_count + self._zero[j]
            if t_s > self._measured_s:
                speed = (counts - servo.position_counts) * servo.model.rad_per_count
                servo.velocity_rad_s = speed / (t_s - self._measured_s)
            servo.position_counts = counts
            if servo.held_load is not None:
                servo.load_share = servo.held_load
                continue
            share = float(torques[j]) / servo.model.stall_torque_nm if servo.driving else 0.0
            servo.load_share = min(max(self._direction[j] * share, -1.0), 1.0)
        self._measured_s = t_s
