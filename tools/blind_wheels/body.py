"""The body in MuJoCo: boxes on pairs of wheels that spin freely and touch a floor; nothing pushes it but contacts.

Each joint is a hinge with the reflected inertia of its rotor. Where a horn is loose or a tooth is worn, a second hinge
lies between servo and link; its limits are the play, and MuJoCo's constraint solver makes the impacts.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

DT_S = 1e-3  # half of it moves the path of a gait by 0.1 %
WHEEL_RADIUS_M = 0.025
TRACK_M = 0.07  # between the wheels of a link
WHEEL_KG = 0.015
HORN_KG_M2 = 2e-5  # of what turns between gear and link where a horn has play
TIGHT_RAD = 1e-5  # the play of a hinge that is there but has none yet
FLOOR_HALF_M, FLOOR_CELLS = 6.0, 240  # of an uneven floor


@dataclass
class Body:
    """What a robot is built of; one number a link, wheel (link, side) or joint."""

    half_length_m: float
    mass_kg: Floats  # (n,) wheels and all
    grip: Floats  # (n, 2) coefficient of friction of each tyre
    grease_nm_s: Floats  # (n, 2) drag of each bearing that grows with its speed; dry friction: ``drive``
    rotor_kg_m2: Floats  # (k,) as the joint feels it
    gear_nm: Floats  # (k,) dry friction of motor and gear
    cable_nm_rad: Floats  # (k,) the harness between two links, a soft spring
    second_hinge: frozenset[int] = frozenset()  # 0-based joints whose horn or teeth have play
    pulling: dict[int, tuple[float, float]] = field(
        default_factory=dict
    )  # joint: N/m, share of its length at rest
    floor_m: Floats | None = None  # (cells, cells) heights; None: flat

    @property
    def links(self) -> int:
        return int(self.mass_kg.size)


def _wheel(body: Body, i: int, side: int) -> str:
    r, y = WHEEL_RADIUS_M, TRACK_M / 2 * (1 if side else -1)
    grip, grease = float(body.grip[i, side]), float(body.grease_nm_s[i, side])
    spin, across = WHEEL_KG * r * r / 2, WHEEL_KG * r * r / 4
    return (
        f'<body name="wheel_{i}_{side}" pos="0 {y!r} 0"><joint name="spin_{i}_{side}" type="hinge" axis="0 1 0" '
        f'damping="{grease!r}"/>'
        f'<inertial pos="0 0 0" mass="{WHEEL_KG!r}" diaginertia="{across!r} {spin!r} {across!r}"/>'
        f'<geom type="sphere" size="{r!r}" friction="{grip!r} 0 0" priority="1" condim="3" '
        f'contype="1" conaffinity="2"/></body>'
    )


def _link(body: Body, i: int) -> str:
    """Inertial part, wheels, and the points that cables are tied to; the frame is the link's centre."""
    half, mass = body.half_length_m, float(body.mass_kg[i]) - 2 * WHEEL_KG
    a, b, c = 0.8 * half, 0.025, 0.02  # half sizes of the box that holds servo and board
    inertia = [mass / 3 * (u * u + v * v) for u, v in ((b, c), (a, c), (a, b))]
    diagonal = " ".join(repr(v) for v in inertia)
    points = "".join(
        f'<site name="{end}_{i}" pos="{x!r} 0.02 0"/>'
        for end, x in (("rear", -0.5 * half), ("front", 0.5 * half))
    )
    return (
        f'<inertial pos="0 0 0.005" mass="{mass!r}" diaginertia="{diagonal}"/>'
        + points
        + "".join(_wheel(body, i, s) for s in (0, 1))
    )


def _joint(body: Body, j: int) -> tuple[str, str]:
    """What opens and closes around link j + 1: the servo's hinge, and the one with play where there is one."""
    half = body.half_length_m
    hinge = (
        f'<joint name="servo_{j}" type="hinge" axis="0 0 1" pos="{-half!r} 0 0" '
        f'armature="{float(body.rotor_kg_m2[j])!r}" frictionloss="{float(body.gear_nm[j])!r}" '
        f'stiffness="{float(body.cable_nm_rad[j])!r}"/>'
    )
    at = f'pos="{2 * half!r} 0 0"'
    if j not in body.second_hinge:
        return f"<body {at}>{hinge}", "</body>"
    horn = f'<inertial pos="{-half!r} 0 0" mass="1e-3" diaginertia="{HORN_KG_M2!r} {HORN_KG_M2!r} {HORN_KG_M2!r}"/>'
    play = (
        f'<joint name="play_{j}" type="hinge" axis="0 0 1" pos="{-half!r} 0 0" limited="true" '
        f'range="{-TIGHT_RAD!r} {TIGHT_RAD!r}" damping="1e-4" solreflimit="0.002 0.6" solimplimit="0.95 0.99 0.001"/>'
    )
    return f"<body {at}>{hinge}{horn}<body>{play}", "</body></body>"


def mjcf(body: Body) -> str:
    """The model as text. Angles in rad."""
    floor, asset = '<geom type="plane" size="0 0 1" contype="2" conaffinity="1"/>', ""
    if body.floor_m is not None:
        top = max(float(np.max(body.floor_m)), 1e-6)
        size = f"{FLOOR_HALF_M!r} {FLOOR_HALF_M!r} {top!r} 0.1"
        asset = (
            f'<asset><hfield name="floor" nrow="{FLOOR_CELLS}" ncol="{FLOOR_CELLS}" size="{size}"/></asset>'
        )
        floor = '<geom type="hfield" hfield="floor" contype="2" conaffinity="1"/>'
    height = WHEEL_RADIUS_M + (0.0 if body.floor_m is None else float(np.max(body.floor_m)))
    out = [
        '<mujoco><compiler angle="radian" inertiafromgeom="false"/>'
        f'<option timestep="{DT_S!r}" integrator="implicitfast" cone="elliptic" impratio="10" iterations="30" '
        f'tolerance="1e-6" jacobian="sparse" gravity="0 0 -9.80665"><flag autoreset="disable"/></option>'
        f'<default><geom solref="0.01 1"/></default>{asset}<worldbody>{floor}'
        f'<body name="head" pos="0 0 {height!r}"><freejoint/>{_link(body, 0)}'
    ]
    ends: list[str] = []
    for j in range(body.links - 1):
        begin, end = _joint(body, j)
        out.append(begin + _link(body, j + 1))
        ends.append(end)
    out += [*reversed(ends), "</body></worldbody><tendon>"]
    for j, (stiffness, share) in body.pulling.items():
        rest = body.half_length_m * share  # the tied points are one half length apart in the straight pose
        out.append(
            f'<spatial stiffness="{stiffness!r}" springlength="0 {rest!r}"><site site="front_{j}"/>'
            f'<site site="rear_{j + 1}"/></spatial>'
        )
    return "".join([*out, "</tendon></mujoco>"])
