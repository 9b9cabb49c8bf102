"""Everything behind a board's set-point register, in real time: links' delays, servos, body, encoders."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from snakebot.effects.stages import assemble
from snakebot.errors import BadInputError
from snakebot.physics import servo_layout as layout

if TYPE_CHECKING:
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot

Vector = npt.NDArray[np.float64]
JointMode = Literal["active", "free", "rigid"]


class Pose(NamedTuple):
    """Centre of mass, mean link angle, and the speed of the centre of mass along it."""

    x_m: float
    y_m: float
    heading_rad: float
    speed_m_s: float


class Plant:
    """A simulated robot without its board.

    Set-points come by ``command``, time by ``advance``; both in seconds on one clock that starts at ``t_s``. All joints
    start active and hold the angle they start at. A set-point takes effect from the time of its ``command`` on, so call
    ``advance(t)`` to the time of a reading before or after ``command(t, ...)``: it makes no difference to that reading.

    Args:
        robot: its own effects are always part of it.
        specs: further effects, as specs or in the grammar of ``--effect``.
        seed: of all that is random.
        dt_s: step of the chain.
        initial_rad: set-point that the robot has stood at, one or (joints,).

    Raises:
        BadInputError: an effect that does not fit the robot.
    """

    def __init__(
        self,
        robot: Robot,
        specs: Iterable[EffectSpec | str] = (),
        seed: int = 0,
        dt_s: float = 1e-3,
        *,
        initial_rad: npt.ArrayLike = 0.0,
        t_s: float = 0.0,
    ) -> None:
        from snakebot.physics.servo_chain import DrivenChain

        if not (math.isfinite(dt_s) and dt_s > 0):
            raise BadInputError(f"the plant's step must be above zero, it is {dt_s} s")
        self.robot = robot
        self.stages = assemble(robot, specs)
        self._rng = np.random.default_rng(seed)
        self._link = self.stages.link_filters()
        self._sensors = self.stages.sensor_filters()
        rows = self.stages.servo_rows
        self._applied = np.broadcast_to(np.asarray(initial_rad, dtype=np.float64), (robot.joints,)).copy()
        model = self.stages.model
        self._chain = DrivenChain(
            rows,
            layout.rest_angle_rad(rows, self._applied),
            model=model,
            t_s=t_s,
            grid_s=dt_s,
            fine=layout.needs_fine_steps(rows),
        )
        self._rows = self._chain.params  # modes are written into it
        self._coming: deque[tuple[float, Vector]] = deque()
        self._free = np.zeros(robot.joints, dtype=bool)
        self._hold = np.full(robot.joints, np.nan)
        self._first_command_s: float | None = None
        self._torque_nm = np.zeros(robot.joints)
        self._power_w = np.zeros(2)

    @property
    def t_s(self) -> float:
        """The time that the plant has reached."""
        return self._chain.t_s

    def command(self, t_s: float, setpoint_rad: npt.ArrayLike) -> None:
        """A set-point for all joints (joints,) arrives at the register at ``t_s``; NaN: that servo is off."""
        setpoint = np.array(setpoint_rad, dtype=np.float64)
        if setpoint.shape != self._applied.shape:
            raise BadInputError(f"{setpoint.size} set-points for {self.robot.joints} joints")
        if self._first_command_s is None:
            self._first_command_s = t_s
        in_force = t_s
        for link_filter in self._link:
            passed = link_filter.online(in_force, setpoint, self._rng)
            if passed is None:
                return
            in_force, setpoint = max(passed[0], t_s), passed[1]
        later: list[tuple[float, Vector]] = []
        while self._coming and self._coming[-1][0] > in_force:
            later.append(self._coming.pop())
        self._coming.append((in_force, setpoint))
        self._coming.extend(reversed(later))

    def set_joint_mode(self, joint: int | None, mode: JointMode, hold_rad: float | None = None) -> None:
        """Change what drives a joint (1-based; None: all), from now on.

        ``free``: no torque. ``rigid``: its servo is given ``hold_rad`` and nothing else; without an angle the joint is
        locked where it is. ``active``: follows the set-points again, from where it stands. A joint that an effect has
        broken stays as the effect says.
        """
        for j in range(self.robot.joints) if joint is None else [joint - 1]:
            if not 0 <= j < self.robot.joints:
                raise BadInputError(f"joint {joint} of a robot with {self.robot.joints} joints")
            here = float(self._chain.angle_rad[j])
            stay = layout.holding_setpoint_rad(self._rows, self._chain.angle_rad)
            self._free[j] = mode == "free"
            self._hold[j] = hold_rad if mode == "rigid" and hold_rad is not None else np.nan
            if self.stages.servo_rows[j, layout.LOCKED] == layout.DRIVEN:
                locked = mode == "rigid" and hold_rad is None
                if self._rows[j, layout.LOCKED] == layout.RIGID_JOINT and not locked:
                    self._chain.state[j, layout.POWERED] = 0.0  # the servo wakes up where the joint is
                self._rows[j, layout.LOCKED] = layout.RIGID_JOINT if locked else layout.DRIVEN
                self._rows[j, layout.LOCK_RAD] = here if locked else 0.0
            if mode == "active":
                self._applied[j] = stay[j]
        self._chain.setpoint[:] = self._driven(self._applied)

    def advance(self, t_s: float) -> None:
        """Integrate up to ``t_s``; a time that has passed already changes nothing."""
        due: list[tuple[float, Vector]] = []
        while self._coming and self._coming[0][0] <= t_s:
            due.append(self._coming.popleft())
        times = np.array([time for time, _ in due])
        table = np.array([self._driven(setpoint) for _, setpoint in due]).reshape(len(due), self.robot.joints)
        since = self._first_command_s if self._first_command_s is not None else t_s
        out = self._chain.run(np.array([t_s]), times, table, since_s=since)
        if due:
            self._applied[:] = due[-1][1]
        self._torque_nm, self._power_w = out.torque[0], out.power[0]

    def _driven(self, setpoint: Vector) -> Vector:
        """What the servos are given for a set-point, joint modes obeyed."""
        held = np.where(np.isnan(self._hold), setpoint, self._hold)
        return np.where(self._free, np.nan, held)

    @property
    def applied_rad(self) -> Vector:
        """(joints,) set-point in force behind the link's effects; NaN: servo off."""
        return self._driven(self._applied)

    @property
    def joint_angle_rad(self) -> Vector:
        """(joints,) true joint angles."""
        return self._chain.angle_rad.copy()

    @property
    def joint_torque_nm(self) -> Vector:
        """(joints,) torques of the body's joints, mean over the last ``advance``; zeros on a bench."""
        return self._torque_nm

    @property
    def power_w(self) -> tuple[float, float]:
        """Put in by the joints, lost to the ground: means over the last ``advance``."""
        return float(self._power_w[0]), float(self._power_w[1])

    def encoder_counts(self) -> npt.NDArray[np.int64]:
        """(joints,) reading of the encoders, now; noise differs from call to call."""
        reading: Vector = self._chain.angle_rad.copy()
        for sensor in self._sensors:
            reading = sensor.online(self.t_s, reading, self._rng)
        return np.round(reading / self.robot.rad_per_count).astype(np.int64)

    def encoder_rad(self) -> Vector:
        """(joints,) reading of the encoders as angles, in whole counts."""
        return np.asarray(self.encoder_counts() * self.robot.rad_per_count, dtype=np.float64)

    def pose(self) -> Pose | None:
        """Where the robot is; None on a bench."""
        if self.stages.model is None:
            return None
        x, y, heading, vx, vy, _ = self._chain.base.tolist()
        return Pose(x, y, heading, vx * math.cos(heading) + vy * math.sin(heading))

    @property
    def clock_ppm(self) -> float:
        """Sum of the ``clock_drift`` effects: by how much the board's own clock is off."""
        return sum(spec.value("ppm") for spec in self.stages.specs if spec.name == "clock_drift")
