"""Simulated sessions with a known cause, for tuning, calibrating and timing the diagnosis.

The robot that is measured is never the nominal one: lag, mass and friction are off by a few per cent and its
encoders are noisy, with a cause or without. Sets are told apart by their seeds: see ``SETS``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import radians

import numpy as np

from snakebot.effects import EffectSpec, Plant
from snakebot.gait import Gait, GaitMotion, Motion
from snakebot.robot import Body, Friction, Robot, Servo, load_robot
from snakebot.runlog import Run, Session

SETS = {"tune": 10_000_000, "calibrate": 20_000_000, "test": 30_000_000}  # first seed of each; a million each
GAITS = (
    (66, 80, 2.0),
    (45, 80, 3.0),
    (30, 80, 4.0),
    (50, 60, 1.0),
    (25, 100, 5.0),
    (60, 70, 1.5),
    (35, 90, 2.5),
)


@dataclass(frozen=True)
class Case:
    """A session and the truth about it: no effects means no gap beyond the background."""

    session: Session
    truth: tuple[EffectSpec, ...]
    channel: str  # encoders | speed | pose


def draw_effect(name: str, rng: np.random.Generator, joints: int, strength: float) -> EffectSpec:
    """An effect of a strength: 1 is plain to see, 0.3 is hard."""
    s = strength * rng.uniform(0.8, 1.25)
    sign = rng.choice([-1.0, 1.0])
    where: tuple[int, ...] | None = None
    if rng.random() < 0.5:
        count = int(rng.integers(1, 3)) if joints > 2 else 1
        where = tuple(sorted(int(j) + 1 for j in rng.choice(joints, count, replace=False)))
    one = (int(rng.integers(1, joints + 1)),)
    values: dict[str, float | tuple[float, ...]]
    match name:
        case "command_delay":
            return EffectSpec(name, {"delay_s": 0.05 * s})
        case "command_loss":
            return EffectSpec(name, {"probability": min(0.85, 0.5 * s)})
        case "clock_drift":
            return EffectSpec(name, {"ppm": 4000 * s})
        case "servo_lag":
            values = {"time_constant_s": 0.03 + 0.05 * s}
        case "second_order":
            values = {"natural_freq_rad_s": 22 / s**0.5, "damping_ratio": float(rng.uniform(0.25, 0.8))}
        case "rate_limit":
            values = {"limit_rad_s": 1.3 / s**0.5}
        case "torque_limit":
            values = {"limit_nm": 0.35 / s**0.5}
        case "voltage_sag":
            values = {"initial_rad_s": 2.0 / s**0.3, "drop_per_s": 0.04 * s**0.5}
        case "deadband":
            values = {"width_deg": 3 * s}
        case "backlash":
            values = {"width_deg": 6 * s}
        case "joint_friction":
            values = {"coulomb_nm": 0.4 * s, "stiffness_nm_rad": 8.0}
        case "compliance":
            values = {"stiffness_nm_rad": 8.0 / s}
        case "servo_offset" | "encoder_offset":
            values = {"offset_deg": sign * 4 * s}
        case "command_gain" | "encoder_gain":
            values = {"gain": 1 + sign * 0.12 * s}
        case "joint_free":
            return EffectSpec(name, {}, one)
        case "joint_rigid":
            return EffectSpec(name, {"angle_deg": float(rng.uniform(-15, 15))}, one)
        case "wiring":
            if joints >= 2 and rng.random() < 0.5:
                a = int(rng.integers(1, joints))
                return EffectSpec(name, {"permutation": (float(a + 1), float(a))}, (a, a + 1))
            return EffectSpec(name, {"signs": -1.0}, one)
        case "encoder_noise":
            values = {"std_deg": 0.8 * s}
        case "ground_friction":
            key = str(rng.choice(["ct_scale", "cn_scale", "ct0_scale"]))
            return EffectSpec(name, {key: float(np.exp(sign * 0.8 * s))})
        case "wheel_drag":
            return EffectSpec(name, {"link": float(rng.integers(1, joints + 2)), "extra_n": 0.8 * s})
        case "payload":
            return EffectSpec(name, {"link": float(rng.integers(1, joints + 2)), "mass_kg": 1.5 * s})
        case "slope":
            return EffectSpec(name, {"angle_deg": sign * 1.2 * s})
        case _:
            raise ValueError(name)
    return EffectSpec(name, values, where)


def background(robot: Robot, rng: np.random.Generator, size: float = 0.03) -> Robot:
    """The robot as it really is: everything a few per cent off."""

    def off(value: float) -> float:
        return float(value * np.exp(size * rng.normal()))

    body = robot.body
    if body is not None:
        f = body.friction
        body = Body(
            links=body.links,
            half_length_m=body.half_length_m,
            link_mass_kg=off(float(np.mean(body.link_mass_kg))),
            friction=Friction(
                ct=off(float(np.mean(f.ct))),
                cn=off(float(np.mean(f.cn))),
                ct0=off(float(np.mean(f.ct0))),
                cn0=off(float(np.mean(f.cn0))),
                contact=f.contact,
            ),
        )
    servo = Servo(time_constant_s=off(robot.servo.time_constant_s))
    return robot.model_copy(update={"body": body, "servo": servo})


def simulate_run(
    robot: Robot,
    specs: tuple[EffectSpec, ...],
    gait: Gait,
    name: str,
    rng: np.random.Generator,
    duration_s: float = 20.0,
    rate_hz: float = 100.0,
    noise_deg: float = 0.05,
) -> Run:
    """One run of the simulated robot, commands and encoders at every tick, pose included."""
    motion = GaitMotion(gait, robot.joints, duration_s, ramp_s=1.0)
    return replace(simulate_motion(robot, specs, motion, name, rng, rate_hz, noise_deg), gait=gait)


def simulate_motion(
    robot: Robot,
    specs: tuple[EffectSpec, ...],
    motion: Motion,
    name: str,
    rng: np.random.Generator,
    rate_hz: float = 100.0,
    noise_deg: float = 0.05,
) -> Run:
    """The same for any motion."""
    plant = Plant(
        robot,
        (*specs, EffectSpec("encoder_noise", {"std_deg": noise_deg}))
        if not any(s.name == "encoder_noise" for s in specs)
        else specs,
        seed=int(rng.integers(1 << 31)),
    )
    jitter = rng.uniform(-0.05, 0.05)
    t = np.arange(int(motion.duration_s * rate_hz)) / rate_hz
    t = t + jitter / rate_hz * np.sin(t)
    t -= t[0]
    command = motion.sampled(t)
    measured = np.empty_like(command)
    pose = np.empty((t.size, 3))
    for i, now in enumerate(t):
        plant.advance(float(now))
        measured[i] = plant.encoder_rad()
        here = plant.pose()
        pose[i] = (0, 0, 0) if here is None else (here.x_m, here.y_m, here.heading_rad)
        plant.command(float(now), command[i])
    return Run(name, t, command, measured, pose=pose if robot.body is not None else None)


def record_gaits(
    robot: Robot,
    specs: tuple[EffectSpec, ...],
    gaits: Sequence[Gait],
    rng: np.random.Generator,
    duration_s: float,
    *,
    repeat: bool = True,
) -> list[Run]:
    """A run a gait; ``repeat``: and the first gait again, marked so."""
    made = [
        simulate_run(robot, specs, gait, f"run_{number:02d}", rng, duration_s)
        for number, gait in enumerate(gaits, start=1)
    ]
    if repeat:
        again = simulate_run(robot, specs, gaits[0], f"run_{len(made) + 1:02d}", rng, duration_s)
        made.append(replace(again, repeat_of=made[0].name))
    return made


def make_case(
    effects: tuple[str, ...],
    seed: int,
    *,
    strength: float = 1.0,
    channel: str = "pose",
    runs: int = 5,
    duration_s: float = 12.0,
    repeat: bool = True,
    robot: str = "penn_state",
) -> Case:
    """A session under ``effects`` (none: no gap)."""
    rng = np.random.default_rng(seed)
    nominal = load_robot(robot)
    real = background(nominal, rng)
    truth = tuple(draw_effect(name, rng, nominal.joints, strength) for name in effects)
    picked = [GAITS[i] for i in rng.permutation(len(GAITS))[:runs]]
    gaits = [Gait(radians(alpha), radians(beta), omega) for alpha, beta, omega in picked]
    made = record_gaits(real, truth, gaits, rng, duration_s, repeat=repeat)
    if channel == "speed":
        made = [replace(run, pose=None, forward_speed_m_s=_speed(run, rng)) for run in made]
    elif channel == "encoders":
        made = [replace(run, pose=None) for run in made]
    elif channel == "pose":
        made = [
            replace(run, pose=None if run.pose is None else run.pose + rng.normal(0, 0.001, run.pose.shape))
            for run in made
        ]
    return Case(Session(nominal, tuple(made)), truth, channel)


def _speed(run: Run, rng: np.random.Generator) -> float:
    assert run.pose is not None
    half = run.t_s > run.t_s[-1] / 2
    x, y, heading = run.pose[half].T
    c, s = np.cos(heading.mean()), np.sin(heading.mean())
    span = run.t_s[half][-1] - run.t_s[half][0]
    speed = (c * (x[-1] - x[0]) + s * (y[-1] - y[0])) / span
    return float(speed * (1 + rng.normal(0, 0.01)) + rng.normal(0, 0.001))
