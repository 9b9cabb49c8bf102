"""A robot as MJCF: chain or bench, actuators, sensors, and the numbers that the callbacks beside it read.

The chain is planar: link 1 slides and turns freely, each further link hangs on the one before by a hinge. Links do not
touch each other nor the floor: the ground's forces come from the callbacks.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats
from snakebot.calibrated.mujoco_servos import NONE, ExportedServo, not_expressed, servos_of
from snakebot.effects.stages import assemble
from snakebot.errors import BadInputError
from snakebot.physics import servo_layout as layout
from snakebot.physics.inertia import felt_inertia_kg_m2
from snakebot.physics.model import STANDARD_GRAVITY_M_S2, ChainModel
from snakebot.physics.servo_grip import SMOOTHING_S

if TYPE_CHECKING:
    from snakebot.effects.stages import Stages
    from snakebot.robot import Robot

STEP_S = 5e-4  # of the simulation; chosen: a stiff servo turns by less than half a radian of its phase
BARE_INERTIA_KG_M2 = 1e-4  # of a bench's joint that carries nothing that is described; chosen
BARE_ARM_M = 0.05  # length of what is drawn there; chosen
_BASE = (("x", "slide", "1 0 0"), ("y", "slide", "0 1 0"), ("heading", "hinge", "0 0 1"))  # joints of link 1
CALLBACKS = Path(__file__).with_name("mujoco_callbacks.py")  # copied, never imported here: it needs MuJoCo
# Dry friction as a constraint is soft by default, and lets a joint creep; this is as hard as the step allows.
HARD_FRICTION = 'solreffriction="0.002 1" solimpfriction="0.9999 0.9999 0.001"'
UNEXPRESSED = "Not expressed, or otherwise than snakebot does it:"


@dataclass(frozen=True)
class MujocoModel:
    """What is written: the XML, the callbacks beside it, and what neither says, a sentence each."""

    xml: str
    callbacks: str
    not_expressed: tuple[str, ...]


def callbacks_name(xml: Path) -> Path:
    """The Python file beside an XML: a name that can be imported.

    Raises:
        BadInputError: no such name can be made of it.
    """
    stem = re.sub(r"\W", "_", xml.stem, flags=re.ASCII)
    if not stem.isidentifier() or stem in ("mujoco", "numpy", "math", "typing"):
        raise BadInputError(
            f"--mujoco {xml}: the callbacks beside it would be {stem}.py, which Python cannot import; give a name"
        )
    return xml.with_name(f"{stem}.py")


def mujoco_model(robot: Robot, xml_path: Path) -> MujocoModel:
    """The robot with the effects in its description.

    Raises:
        BadInputError: an effect does not fit the robot, or the file has no name that Python can import.
    """
    stages = assemble(robot)
    said = [*not_expressed(stages), *_differences(stages)]
    name = callbacks_name(xml_path).stem
    source = CALLBACKS.read_text(encoding="utf-8")
    return MujocoModel(_xml(stages, said, name), source.replace("MODEL", name), tuple(said))


def _differences(stages: Stages) -> list[str]:
    said = ["links pass through each other, and through anything else"]
    if stages.model is not None and not _smooth(stages):
        said.append(
            "the chain follows its motors at once; snakebot smooths their steps over 10 ms for the motion over ground"
        )
    elif stages.model is not None:
        said.append(
            "the chain follows its motors 20 ms late, as in snakebot: compare encoders(), not qpos, with readings"
        )
    elif stages.feels_load:
        said.append("a joint that gives way swings on its spring; snakebot lets it sag without delay")
    return said


def _xml(stages: Stages, said: Sequence[str], name: str) -> str:
    robot, model = stages.robot, stages.model
    inertia = _bench_inertia(stages.servo_rows) if model is None else felt_inertia_kg_m2(model)
    servos = servos_of(stages, inertia, smooth=_smooth(stages))
    by_joint = sorted(servos, key=lambda servo: servo.joint)
    slope = 0.0 if model is None else model.slope_rad
    down, back = (STANDARD_GRAVITY_M_S2 * f(slope) for f in (math.cos, math.sin))
    kept = 1 + max(round(servo.numbers["delay_s"] / STEP_S) for servo in servos)
    world = _bench(stages, by_joint) if model is None else _chain(model, by_joint)
    about = [
        "snakebot: a calibrated robot, written by `snakebot robot export`. Angles in rad, SI units.",
        f"Its callbacks are in {name}.py: see there. Without them there is no ground, and what is",
        'dyntype="user" does not move.',
        "Effects: " + (", ".join(map(str, stages.specs)) or "none"),
        UNEXPRESSED,
        *(f"* {sentence}" for sentence in said),
    ]
    return "\n".join(
        [
            "<!-- " + "\n     ".join(_plain(line) for line in about) + " -->",
            f'<mujoco model="{_plain(robot.name)}">',
            '  <compiler angle="radian"/>',
            f'  <option timestep="{STEP_S!r}" integrator="implicitfast" gravity="{-back!r} 0 {-down!r}">',
            '    <flag contact="disable"/>',
            "  </option>",
            *([f'  <size nuserdata="{kept * robot.joints}"/>'] if kept > 1 else []),
            "  <custom>",
            *_custom(stages, by_joint),
            "  </custom>",
            "  <worldbody>",
            '    <light pos="0 0 2"/>',
            *world,
            "  </worldbody>",
            "  <actuator>",
            *(_actuator(servo) for servo in servos),
            "  </actuator>",
            "  <sensor>",
            *(f'    <jointpos name="angle_{j}" joint="joint_{j}"/>' for j in range(1, robot.joints + 1)),
            "  </sensor>",
            "</mujoco>",
            "",
        ]
    )


def _smooth(stages: Stages) -> bool:
    """Whether the chain follows its motors smoothed: where a joint goes where the load takes it."""
    return stages.model is not None and (stages.feels_load or stages.broken[0])


def _plain(text: str) -> str:
    """Text that is safe in a comment and in an attribute, whoever wrote it."""
    kept = "".join(c if c.isprintable() else " " for c in text)
    return re.sub("-{2,}", "-", kept).translate(str.maketrans("<>&", "   ")).replace('"', "'").rstrip("-")


def _chain(model: ChainModel, servos: Sequence[ExportedServo]) -> list[str]:
    out = ['    <geom type="plane" size="5 5 0.1" pos="0 0 -0.03" rgba=".9 .9 .9 1"/>']
    for i in range(model.links):
        half = float(model.half_length[i])
        pad = "    " + "  " * i
        if i == 0:
            out.append(f'{pad}<body name="link_1">')
            out += [
                f'{pad}  <joint name="base_{word}" type="{kind}" axis="{axis}"/>'
                for word, kind, axis in _BASE
            ]
        else:
            before = float(model.half_length[i - 1]) * (1 if i == 1 else 2)
            out.append(f'{pad}<body name="link_{i + 1}" pos="{before!r} 0 0">')
            out.append(f"{pad}  {_hinge(servos[i - 1], '0 0 1')}")
        centre, mass, turn = (0.0 if i == 0 else half), float(model.mass[i]), float(model.inertia[i])
        out.append(
            f'{pad}  <inertial pos="{centre!r} 0 0" mass="{mass!r}" diaginertia="{turn!r} {turn!r} {turn!r}"/>'
        )
        ends = f"{centre - 0.9 * half!r} 0 0 {centre + 0.9 * half!r} 0 0"
        out.append(f'{pad}  <geom type="capsule" fromto="{ends}" size="{0.2 * half!r}"/>')
    return out + ["    " + "  " * i + "</body>" for i in reversed(range(model.links))]


def _bench(stages: Stages, servos: Sequence[ExportedServo]) -> list[str]:
    """Each joint on a stand of its own, with the arm that is described; angle ``down`` is straight down."""
    out = []
    for servo, row, turn in zip(
        servos, stages.servo_rows, _bench_inertia(stages.servo_rows, rotor=False), strict=True
    ):
        weight, down, turn = float(row[layout.ARM_GRAVITY_NM]), float(row[layout.ARM_DOWN_RAD]), float(turn)
        length = turn * STANDARD_GRAVITY_M_S2 / weight if weight else 0.0
        mass = weight / (STANDARD_GRAVITY_M_S2 * length) if weight else 1e-3
        x, z = length * math.sin(down), -length * math.cos(down)
        own = 1e-9 if weight else turn  # a point mass brings the rest
        drawn = length or BARE_ARM_M
        out += [
            f'    <body name="arm_{servo.joint + 1}" pos="0 {0.3 * servo.joint!r} 0">',
            f"      {_hinge(servo, '0 1 0', float(row[layout.ARMATURE_KG_M2]))}",
            f'      <inertial pos="{x!r} 0 {z!r}" mass="{mass!r}" diaginertia="{own!r} {own!r} {own!r}"/>',
            f'      <geom type="capsule" fromto="0 0 0 {drawn * math.sin(down)!r} 0 {-drawn * math.cos(down)!r}"'
            ' size="0.005"/>',
            "    </body>",
        ]
    return out


def _bench_inertia(rows: Floats, *, rotor: bool = True) -> Floats:
    """(joints,) of the arms, at the joints; with what turns in the servos."""
    arm = rows[:, layout.ARM_INERTIA_KG_M2]
    weight = rows[:, layout.ARM_GRAVITY_NM] / STANDARD_GRAVITY_M_S2
    bare = np.where(weight > 0, weight * BARE_ARM_M, BARE_INERTIA_KG_M2)
    inertia = np.where(arm > 0, arm, bare)
    return np.asarray(inertia + rows[:, layout.ARMATURE_KG_M2] if rotor else inertia)


def _hinge(servo: ExportedServo, axis: str, armature: float = 0.0) -> str:
    more = [
        f'{name}="{value!r}"'
        for name, value in (
            ("damping", servo.brake_nm_s_rad),
            ("frictionloss", servo.coulomb_nm),
            ("armature", armature),
        )
        if value
    ]
    more += [HARD_FRICTION] * (servo.coulomb_nm > 0)
    return " ".join([f'<joint name="joint_{servo.joint + 1}" type="hinge" axis="{axis}"', *more]) + "/>"


def _actuator(servo: ExportedServo) -> str:
    """Set-point in, torque out: spring and damper between joint and motor, the motor an activation."""
    k, d = servo.stiffness_nm_rad, servo.damping_nm_s_rad
    gain, offset, limit = (servo.numbers[key] for key in ("gain", "offset_rad", "torque_limit_nm"))
    if servo.broken:
        dynamics, k, d, gain, offset = 'dyntype="none"', 0.0, 0.0, 0.0, 0.0
    elif servo.stuck_rad is not None:
        dynamics, gain, offset = 'dyntype="none"', 0.0, servo.stuck_rad
    elif servo.native and servo.numbers["time_constant_s"] > servo.numbers["lead_s"]:
        lag = servo.numbers["time_constant_s"] - servo.numbers["lead_s"]  # the damper is late by the rest
        dynamics = f'dyntype="filterexact" dynprm="{lag!r}"'
    elif servo.native:
        dynamics = 'dyntype="none"'
    else:
        dynamics, gain, offset = 'dyntype="user" actdim="8"', 1.0, 0.0
    force = f' forcelimited="true" forcerange="{-limit!r} {limit!r}"' if limit < NONE else ""
    stall = servo.numbers["stall_nm"]
    if stall < NONE and not force:
        force = f' forcelimited="true" forcerange="{-stall!r} {stall!r}"'
    return (
        f'    <general name="servo_{servo.source + 1}" joint="joint_{servo.joint + 1}" {dynamics} gaintype="fixed" '
        f'gainprm="{k * gain!r}" biastype="affine" biasprm="{k * offset!r} {-k!r} {-d!r}"{force}/>'
    )


def _custom(stages: Stages, servos: Sequence[ExportedServo]) -> list[str]:
    """Numbers by name, as the callbacks read them."""
    joints, model = stages.robot.joints, stages.model
    at = np.zeros(1)
    zero = stages.reading(at, np.zeros((1, joints)))[0]
    one = stages.reading(at, np.ones((1, joints)))[0]
    variance = stages.reading_variance_rad2(at, (1, joints))[0] - stages.robot.rad_per_count**2 / 12
    rows: list[tuple[str, Sequence[float]]] = [
        ("eps_m_s", [1.0 if model is None else model.eps]),
        ("smoothing_s", [SMOOTHING_S if _smooth(stages) else 0.0]),
        ("rad_per_count", [stages.robot.rad_per_count]),
        ("encoder_gain", (one - zero).tolist()),
        ("encoder_offset_rad", zero.tolist()),
        ("encoder_noise_rad", np.sqrt(np.maximum(variance, 0.0)).tolist()),
    ]
    if model is not None:
        for key in ("ct", "cn", "ct0", "cn0", "rotational_drag"):
            rows += [(f"{key}_{i + 1}", [float(v)]) for i, v in enumerate(getattr(model, key))]
    rows += [(f"servo_{servo.joint + 1}", list(servo.numbers.values())) for servo in servos]
    return [
        f'    <numeric name="{name}" data="{" ".join(repr(float(v)) for v in values)}"/>'
        for name, values in rows
    ]
