"""Callbacks of a snakebot model for MuJoCo: the ground under the links, and what MJCF has no word for in a servo.

Needs ``mujoco`` (3.2 or newer) and ``numpy``, nothing else. ``MODEL`` is the XML that this file was written beside::

    import mujoco, MODEL as snake

    model = mujoco.MjModel.from_xml_path("MODEL.xml")
    data = mujoco.MjData(model)
    robot = snake.install(model)  # callbacks of MuJoCo are global: one model at a time
    robot.put_down(data)
    data.ctrl[:] = 0.3  # set-points, rad, one a joint
    mujoco.mj_step(model, data)
    print(robot.encoders(data))
    snake.remove()

All numbers are in the XML, under ``<custom>``: change them there, or in ``model.numeric_data`` before ``install``, to
randomise them.

Ground. Each link feels, along (t) and across (n) itself, from the velocity v of its centre

    force = -c v - c0 tanh(v / eps)         torque = -rotational_drag omega

Servo. An actuator with ``dyntype="user"`` moves a motor towards its set-point: delay, gain and offset, dead band, lag
or second order, rate limit, play. The joint hangs on the motor by the actuator's spring (gainprm) and damper (biasprm);
the last activation is the motor's angle, put forward by damper over spring times its rate, so that the damper works
against the motor's speed and not against rest.

A motor with a limit of torque, or a line, drives a stiff joint until it meets it. Then the joint hangs on a softer
spring (weak_nm_rad, weak_nm_s_rad) that knows what the joint had to bear, until it has caught up. For that the
callbacks set gainprm, biasprm and forcerange of its actuator at each step.

Smoothing. Where a joint feels its load, or has no power, the chain follows its motors through a critically damped
filter (twice ``smoothing_s`` behind them), as in snakebot, which the stiffnesses were fitted with. ``encoders`` puts
the readings forward by as much as that moves the motors. 0: the chain follows at once.
"""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np

SERVO_NUMBERS = (  # of each joint, in <numeric name="servo_j">
    "delay_s",
    "gain",
    "offset_rad",
    "deadband_rad",
    "deadband_hard",
    "time_constant_s",
    "natural_freq_rad_s",
    "damping_ratio",
    "rate_limit_rad_s",
    "rate_drop_per_s",
    "backlash_rad",
    "lead_s",
    "torque_limit_nm",
    "stall_nm",
    "no_load_rad_s",
    "stiff_nm_rad",
    "weak_nm_rad",
    "weak_nm_s_rad",
)
# Activations of an actuator with dyntype="user": what the joint bears, whether its motor is overtaxed, the motor,
# behind its play, what the chain follows, the spring's end.
LOAD, WEAK, RATE, MOTOR, OUTPUT, SMOOTH_RATE, SMOOTH, DRIVE = range(8)
STATES = 8
LOAD_FILTER_S = 0.02  # first order, on the torque of an overtaxed motor
CAUGHT_UP_RAD, CAUGHT_UP_RAD_S = 3e-4, 0.01  # within which it is stiff again
NONE = 1e9  # a limit that there is not
LEAST_RATE_SHARE = 0.02  # a fading rate limit never quite reaches zero


def install(model: Any) -> Snake:
    """Let MuJoCo call back for this model, in place of whatever it called before."""
    snake = Snake(model)
    mujoco.set_mjcb_passive(snake.ground)
    mujoco.set_mjcb_control(snake.remember)
    mujoco.set_mjcb_act_dyn(snake.servo)
    return snake


def remove() -> None:
    """Let MuJoCo call nothing back."""
    mujoco.set_mjcb_passive(None)
    mujoco.set_mjcb_control(None)
    mujoco.set_mjcb_act_dyn(None)


class Snake:
    """The callbacks of one model. They keep nothing: all state is in the data (``act``, ``userdata``, ``time``)."""

    def __init__(self, model: Any) -> None:
        self.model, self.joints = model, model.nu
        self.step_s = float(model.opt.timestep)
        self.dof = np.array([model.joint(f"joint_{j + 1}").dofadr[0] for j in range(self.joints)])
        self.place = np.array([model.joint(f"joint_{j + 1}").qposadr[0] for j in range(self.joints)])
        numbers = {model.numeric(i).name: np.array(model.numeric(i).data) for i in range(model.nnumeric)}
        links = 1
        while f"ct_{links + 1}" in numbers:
            links += 1
        self.links = links if "ct_1" in numbers else 0
        self.bodies = [model.body(f"link_{i + 1}").id for i in range(self.links)]
        self.friction = [
            [float(numbers[f"{name}_{i + 1}"][0]) for name in ("ct", "cn", "ct0", "cn0", "rotational_drag")]
            for i in range(self.links)
        ]
        self.eps = float(numbers["eps_m_s"][0])
        # by actuator: the set-point i drives the joint that the actuator i is on
        driven = [model.joint(model.actuator(i).trnid[0]).name for i in range(self.joints)]
        self.numbers = [
            dict(zip(SERVO_NUMBERS, map(float, numbers[name.replace("joint", "servo")]), strict=True))
            for name in driven
        ]
        self.driven = [int(name.removeprefix("joint_")) - 1 for name in driven]
        self.late = [round(row["delay_s"] / self.step_s) for row in self.numbers]
        self.kept = model.nuserdata // max(self.joints, 1)
        self.sensor = numbers["encoder_gain"], numbers["encoder_offset_rad"], numbers["encoder_noise_rad"]
        self.smoothing_s = float(numbers["smoothing_s"][0])
        self.count_rad = float(numbers["rad_per_count"][0])
        self._velocity, self._force = np.zeros(6), np.zeros(self.joints)

    def put_down(self, data: Any, joint_angle_rad: Any = 0.0) -> None:
        """At rest, with these joint angles (joints,), time zero; link 1 in the origin."""
        mujoco.mj_resetData(self.model, data)
        angle = np.broadcast_to(np.asarray(joint_angle_rad, dtype=float), (self.joints,))
        data.qpos[self.place] = angle
        for i, row in enumerate(self.numbers):
            holding = (angle[self.driven[i]] - row["offset_rad"]) / (row["gain"] or 1.0)
            first, count = self.model.actuator_actadr[i], self.model.actuator_actnum[i]
            if count == STATES:
                here = angle[self.driven[i]]
                data.act[first : first + STATES] = (0.0, 0.0, 0.0, here, here, 0.0, here, here)
            elif count == 1:
                data.act[first] = holding
            data.ctrl[i] = holding
        if self.kept:
            data.userdata[:] = np.tile(data.ctrl, self.kept)
        mujoco.mj_forward(self.model, data)

    def encoders(self, data: Any, rng: np.random.Generator | None = None) -> Any:
        """(joints,) readings of the joint angles, rad: gain, offset, noise (with a generator), counts."""
        gain, offset, noise = self.sensor
        angle = data.qpos[self.place].copy()
        for i, j in enumerate(self.driven):
            if self.model.actuator_actnum[i] == STATES:
                first = self.model.actuator_actadr[i]
                angle[j] += data.act[first + OUTPUT] - data.act[first + SMOOTH]
        reading = gain * angle + offset
        if rng is not None:
            reading = reading + noise * rng.normal(size=self.joints)
        return np.round(reading / self.count_rad) * self.count_rad

    def ground(self, model: Any, data: Any) -> None:
        """mjcb_passive: friction on each link."""
        for body, (ct, cn, ct0, cn0, drag) in zip(self.bodies, self.friction, strict=True):
            mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, body, self._velocity, 1)
            turn, along, across = (float(self._velocity[k]) for k in (2, 3, 4))
            force_t = -ct * along - ct0 * math.tanh(along / self.eps)
            force_n = -cn * across - cn0 * math.tanh(across / self.eps)
            c, s = (float(data.xmat[body, k]) for k in (0, 3))
            force = np.array([c * force_t - s * force_n, s * force_t + c * force_n, 0.0])
            torque = np.array([0.0, 0.0, -drag * turn])
            mujoco.mj_applyFT(model, data, force, torque, data.xipos[body], body, data.qfrc_passive)

    def remember(self, model: Any, data: Any) -> None:
        """mjcb_control: keep the set-points that are on their way; cut torques off at the motors' lines."""
        self._force[:] = data.actuator_force  # of the step before: gone when ``servo`` is called
        for i, p in enumerate(self.numbers):
            if p["stall_nm"] < NONE:
                speed = float(data.qvel[self.dof[self.driven[i]]]) / p["no_load_rad_s"]
                speed *= math.exp(p["rate_drop_per_s"] * float(data.time))
                limit = p["torque_limit_nm"]
                model.actuator_forcerange[i] = (
                    -min(max(p["stall_nm"] * (1.0 + speed), -limit), limit),
                    min(max(p["stall_nm"] * (1.0 - speed), -limit), limit),
                )
        if self.kept:
            row = round(data.time / self.step_s) % self.kept
            data.userdata[row * self.joints : (row + 1) * self.joints] = data.ctrl

    def servo(self, model: Any, data: Any, i: int) -> float:
        """mjcb_act_dyn: what actuator ``i`` makes of its set-point over a step."""
        p, h = self.numbers[i], self.step_s
        setpoint = float(data.ctrl[i])
        if self.late[i]:
            row = (round(data.time / h) - self.late[i]) % self.kept
            setpoint = float(data.userdata[row * self.joints + i])
        first = model.actuator_actadr[i]
        state = [float(v) for v in data.act[first : first + STATES]]
        target = p["gain"] * setpoint + p["offset_rad"]
        new = list(state)
        new[MOTOR], new[RATE] = self._motor(p, state[MOTOR], state[RATE], target, float(data.time))
        play = 0.5 * p["backlash_rad"]
        new[OUTPUT] = min(max(state[OUTPUT], new[MOTOR] - play), new[MOTOR] + play)
        if self.smoothing_s > 0.0:
            fade, off = math.exp(-h / self.smoothing_s), state[SMOOTH] - new[OUTPUT]
            gone = state[SMOOTH_RATE] + off / self.smoothing_s
            new[SMOOTH] = new[OUTPUT] + fade * (off + gone * h)
            new[SMOOTH_RATE] = fade * (state[SMOOTH_RATE] - gone * h / self.smoothing_s)
        else:
            new[SMOOTH], new[SMOOTH_RATE] = new[OUTPUT], (new[OUTPUT] - state[OUTPUT]) / h
        new[DRIVE] = new[SMOOTH] + p["lead_s"] * new[SMOOTH_RATE]
        if p["weak_nm_rad"] > 0.0:
            self._overtax(data, i, p, state, new)
        dots = [(after - before) / h for after, before in zip(new, state, strict=True)]
        data.act_dot[first : first + STATES] = dots
        return dots[DRIVE]

    def _overtax(self, data: Any, i: int, p: dict[str, float], state: list[float], new: list[float]) -> None:
        """A stiff motor that meets its limit gives way: its joint then hangs on a softer spring, which knows what the
        joint had to bear, until it has caught up.
        """
        model, h, j = self.model, self.step_s, self.driven[i]
        force, (least, most) = float(self._force[i]), model.actuator_forcerange[i]
        new[LOAD] = force + math.exp(-h / LOAD_FILTER_S) * (state[LOAD] - force)
        k, d = p["weak_nm_rad"], p["weak_nm_s_rad"]
        twist = state[SMOOTH] - float(data.qpos[self.place[j]])
        slip = state[SMOOTH_RATE] - float(data.qvel[self.dof[j]])
        if state[WEAK] < 0.5:
            new[WEAK] = 0.0 if least < force < most else 1.0
        else:
            near = abs(twist) < CAUGHT_UP_RAD and abs(slip) < CAUGHT_UP_RAD_S
            new[WEAK] = 0.0 if near and least < k * twist + d * slip + new[LOAD] < most else 1.0
        if new[WEAK] < 0.5:
            spring = p["stiff_nm_rad"]
            model.actuator_gainprm[i, 0] = spring
            model.actuator_biasprm[i, :3] = (0.0, -spring, -spring * p["lead_s"])
        else:
            model.actuator_gainprm[i, 0] = 0.0
            aim = k * state[SMOOTH] + d * state[SMOOTH_RATE] + new[LOAD]
            model.actuator_biasprm[i, :3] = (aim, -k, -d)

    def _motor(self, p: dict[str, float], x: float, v: float, target: float, t: float) -> tuple[float, float]:
        """Angle and rate of a motor after a step towards ``target``."""
        h, error, band = self.step_s, target - x, p["deadband_rad"]
        idle = abs(error) <= band and band > 0.0
        hard = p["deadband_hard"] > 0.0
        goal = x if idle else target - math.copysign(0.0 if hard else band, error)
        limit = p["rate_limit_rad_s"] * max(LEAST_RATE_SHARE, math.exp(-p["rate_drop_per_s"] * (t + 0.5 * h)))
        tau = p["time_constant_s"]
        if p["natural_freq_rad_s"] > 0.0:  # semi-implicit: the step is short against any servo
            wn, zeta = p["natural_freq_rad_s"], p["damping_ratio"]
            push = 0.0 if idle else wn * wn * (goal - x)
            new_v = (v + h * push) / (1.0 + 2.0 * zeta * wn * h)
            new_v = min(max(new_v, -limit), limit)
            return x + h * new_v, new_v
        way = goal - x
        step = way if tau <= 0.0 else way * -math.expm1(-h / tau)
        step = min(max(step, -limit * h), limit * h)
        if hard and not idle and abs(way - step) < band:
            step = way - math.copysign(band, error)  # at the edge of the band the drive goes off
        return x + step, step / h
