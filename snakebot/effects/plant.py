"""Everything behind a board's set-point register, in real time: links' delays, servos, body, encoders."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from snakebot.arrays import Bools, Floats
from snakebot.effects.stages import FILTER_STEP_S, assemble
from snakebot.errors import BadInputError
from snakebot.physics import servo_layout as layout

if TYPE_CHECKING:
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot

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
        pose: x, y (m) of the centre of mass and mean link angle (rad) at the start.

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
        pose: npt.ArrayLike = (0.0, 0.0, 0.0),
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
            pose=pose,
            t_s=t_s,
            grid_s=dt_s,
            fine=layout.needs_fine_steps(rows),
        )
        self._rows = self._chain.params  # modes are written into it
        late = self.stages.late_s
        self._late: list[tuple[float, Bools | slice]] = [  # joints that are late alike
            (float(by_s), slice(None) if (late == by_s).all() else late == by_s) for by_s in np.unique(late)
        ]
        self._servos = self.stages.servo_filters()
        self._step = math.ceil(t_s / FILTER_STEP_S) - 1  # the last one that the servo filters have seen
        self._coming: deque[tuple[float, Floats, Bools | slice]] = deque()
        self._free = np.zeros(robot.joints, dtype=bool)
        self._hold = np.full(robot.joints, np.nan)
        self._all_follow = True  # no joint is free or held
        self._one_switch_s = np.zeros(1)
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
        for late_s, joints in self._late:
            self._queue(in_force + late_s, setpoint, joints)

    def _queue(self, in_force_s: float, setpoint_rad: Floats, joints: Bools | slice) -> None:
        """What some joints will get, in the order of time; what came first goes first."""
        later: list[tuple[float, Floats, Bools | slice]] = []
        while self._coming and self._coming[-1][0] > in_force_s:
            later.append(self._coming.pop())
        self._coming.append((in_force_s, setpoint_rad, joints))
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
        self._all_follow = not self._free.any() and bool(np.isnan(self._hold).all())
        self._chain.setpoint[:] = self._driven(self._applied)

    def set_torque_limit(self, joint: int, limit_nm: float) -> None:
        """Let a joint (1-based) exert at most so much, from now on; never more than its effect ``torque_limit`` says.

        A joint without that effect has no limit, and keeps none: its steps are too coarse for one.
        """
        most = self.stages.servo_rows[joint - 1, layout.TORQUE_LIMIT_NM]
        if math.isfinite(most):
            self._rows[joint - 1, layout.TORQUE_LIMIT_NM] = min(limit_nm, most)

    def advance(self, t_s: float) -> None:
        """Integrate up to ``t_s``; a time that has passed already changes nothing."""
        since = self._first_command_s if self._first_command_s is not None else t_s
        times: list[float] = []
        table = [self._driven(self._applied)] if self._servos else []
        while self._coming and self._coming[0][0] <= t_s:
            time_s, setpoint, joints = self._coming.popleft()
            self._applied[joints] = setpoint[joints]
            times.append(time_s)
            table.append(self._driven(self._applied))
        if self._servos:
            out = self._chain.go_to(
                t_s, *self._followed(t_s, np.array(times), np.vstack(table)), since_s=since
            )
        elif len(times) == 1:
            self._one_switch_s[0] = times[0]
            out = self._chain.go_to(t_s, self._one_switch_s, table[0].reshape(1, -1), since_s=since)
        elif times:
            out = self._chain.go_to(t_s, np.array(times), np.array(table), since_s=since)
        else:
            out = self._chain.go_to(t_s, since_s=since)
        self._torque_nm, self._power_w = out.torque[0], out.power[0]

    def _followed(self, t_s: float, times: Floats, table: Floats) -> tuple[Floats, Floats]:
        """Steps of the servo filters before ``t_s`` and what drives the servos; at ``t_s`` a set-point may still come.

        ``table``: the set-points before the first of ``times`` (N,), and those from each of them on: (N + 1, joints).
        """
        last = math.ceil(t_s / FILTER_STEP_S - 1e-9) - 1
        steps: Floats = FILTER_STEP_S * np.arange(self._step + 1, last + 1, dtype=np.float64)
        self._step = max(self._step, last)
        if not steps.size:
            return steps, table[:0]
        driven = table[np.searchsorted(times, steps + 1e-9, side="right")]
        for servo_filter in self._servos:
            driven = servo_filter.follow(steps, driven)
        return steps, driven

    def _driven(self, setpoint: Floats) -> Floats:
        """What the servos are given for a set-point, joint modes obeyed."""
        if self._all_follow:
            return setpoint.copy()
        held = np.where(np.isnan(self._hold), setpoint, self._hold)
        return np.where(self._free, np.nan, held)

    @property
    def applied_rad(self) -> Floats:
        """(joints,) set-point in force behind the link's effects; NaN: servo off."""
        return self._driven(self._applied)

    @property
    def joint_angle_rad(self) -> Floats:
        """(joints,) true joint angles."""
        return self._chain.angle_rad.copy()

    @property
    def joint_torque_nm(self) -> Floats:
        """(joints,) torques of the body's joints, mean over the last ``advance``; zeros on a bench."""
        return self._torque_nm.copy()

    @property
    def power_w(self) -> tuple[float, float]:
        """Put in by the joints, lost to the ground: means over the last ``advance``."""
        return float(self._power_w[0]), float(self._power_w[1])

    def encoder_counts(self) -> list[int]:
        """Reading of each encoder, now; noise differs from call to call."""
        reading: Floats = self._chain.angle_rad
        if self._sensors:
            reading = reading.copy()
            for sensor in self._sensors:
                reading = sensor.online(self.t_s, reading, self._rng)
        rad_per_count = self.robot.rad_per_count
        return [round(angle / rad_per_count) for angle in reading.tolist()]

    def encoder_rad(self) -> Floats:
        """(joints,) reading of the encoders as angles, in whole counts."""
        return np.array(self.encoder_counts()) * self.robot.rad_per_count

    def pose(self) -> Pose | None:
        """Where the robot is; None on a bench."""
        if self.stages.model is None:
            return None
        x, y, heading, vx, vy, _ = self._chain.base.tolist()
        return Pose(x, y, heading, vx * math.cos(heading) + vy * math.sin(heading))

    @property
    def clock_ppm(self) -> float:
        """By how much the board's own clock is off: the sum over the effects."""
        return sum(spec.effect.clock_ppm(spec) for spec in self.stages.specs)
