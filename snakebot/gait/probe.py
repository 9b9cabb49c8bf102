"""Probes: motions made to measure rather than to travel, as written after ``--probe``.

``triangle:amplitude_deg=5,rate_deg_s=10,joints=3`` goes back and forth at constant speed (dead band, play, friction),
``steps:amplitude_deg=20`` makes steps of growing size (delay, rate limit, a servo that rings), and
``sine:amplitude_deg=10,omega_rad_s=1+4`` is a sine, of several frequencies one after the other (delay against lag).
Joints that are not named stay straight.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from snakebot.errors import BadInputError
from snakebot.nearest import did_you_mean

MOST_STEPS = 20  # of a staircase; chosen
EXAMPLE = "triangle:amplitude_deg=5,rate_deg_s=10,joints=3"


@dataclass(frozen=True, slots=True)
class _Key:
    """A parameter as users write it. ``default`` None: must be given."""

    default: float | None
    least: float  # itself not allowed, unless ``or_least``
    or_least: bool = False
    many: bool = False


_ANY = -math.inf
_COMMON = {"amplitude_deg": _Key(None, 0), "offset_deg": _Key(0.0, _ANY)}
KINDS: dict[str, dict[str, _Key]] = {
    "triangle": {
        **_COMMON,
        "rate_deg_s": _Key(None, 0),
        "acceleration_rad_s2": _Key(20.0, 0),
    },
    "steps": {
        **_COMMON,
        "rate_deg_s": _Key(180.0, 0),
        "acceleration_rad_s2": _Key(40.0, 0),
        "hold_s": _Key(0.5, 0, or_least=True),
        "steps": _Key(4.0, 1, or_least=True),
    },
    "sine": {**_COMMON, "omega_rad_s": _Key(None, 0, many=True)},
}


@dataclass(frozen=True, slots=True)
class Probe:
    """What to do with which joints; ``ProbeMotion`` makes a motion of it.

    Attributes:
        kind: ``triangle``, ``steps`` or ``sine``.
        amplitude_rad: largest way from the middle.
        joints: 1-based, moved alike; None: all.
        offset_rad: the middle, of the joints that move.
        rate_rad_s, acceleration_rad_s2: of the way from turn to turn (triangle) or of a step.
        hold_s: rest after each step.
        steps: sizes, in equal parts up to the amplitude.
        omega_rad_s: frequencies of a sine, each for the same time.

    Raises:
        BadInputError: a number is out of bounds, or joints are no joint numbers.
    """

    kind: str
    amplitude_rad: float
    joints: tuple[int, ...] | None = None
    offset_rad: float = 0.0
    rate_rad_s: float = math.pi
    acceleration_rad_s2: float = 20.0
    hold_s: float = 0.5
    steps: int = 4
    omega_rad_s: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise BadInputError(
                f"--probe {self.kind}: no such probe; there are {', '.join(KINDS)}, as in {EXAMPLE}"
            )
        for key, values in self._given().items():
            rule = KINDS[self.kind][key]
            for value in values:
                if (
                    not math.isfinite(value)
                    or value < rule.least
                    or (value == rule.least and not rule.or_least)
                ):
                    wanted = "a finite number" if rule.least == _ANY else f"above {rule.least:g}"
                    wanted = f"{rule.least:g} or more" if rule.or_least else wanted
                    raise BadInputError(f"--probe {self.kind}: {key}={value:g}; it must be {wanted}")
        if self.kind == "sine" and not self.omega_rad_s:
            raise BadInputError(f"--probe sine: needs omega_rad_s; {usage('sine')}")
        if self.steps > MOST_STEPS:
            raise BadInputError(f"--probe {self.kind}: steps={self.steps}; at most {MOST_STEPS}")
        if self.joints is not None and (
            not self.joints or min(self.joints) < 1 or len(set(self.joints)) != len(self.joints)
        ):
            raise BadInputError(
                f"--probe {self.kind}: joints are numbered from 1, each once, as in joints=3+4"
            )

    def _given(self) -> dict[str, tuple[float, ...]]:
        """The parameters of this kind as users write them."""
        known: dict[str, tuple[float, ...]] = {
            "amplitude_deg": (math.degrees(self.amplitude_rad),),
            "offset_deg": (math.degrees(self.offset_rad),),
            "rate_deg_s": (math.degrees(self.rate_rad_s),),
            "acceleration_rad_s2": (self.acceleration_rad_s2,),
            "hold_s": (self.hold_s,),
            "steps": (float(self.steps),),
            "omega_rad_s": self.omega_rad_s,
        }
        return {key: known[key] for key in KINDS[self.kind]}

    def __str__(self) -> str:
        """The specification: ``parse_probe`` reads it again."""
        parts = []
        for key, values in self._given().items():
            if KINDS[self.kind][key].default is None or values != (KINDS[self.kind][key].default,):
                parts.append(f"{key}={'+'.join(f'{value:.9g}' for value in values)}")
        if self.joints is not None:
            parts.append("joints=" + "+".join(map(str, self.joints)))
        return f"{self.kind}:{','.join(parts)}"

    def joint_indices(self, joints: int) -> tuple[int, ...]:
        """0-based joints that move, of a robot with ``joints``.

        Raises:
            BadInputError: the robot does not have one of them.
        """
        if self.joints is None:
            return tuple(range(joints))
        if max(self.joints) > joints:
            raise BadInputError(
                f"--probe {self.kind}: joint {max(self.joints)} of a robot with {joints} joints"
            )
        return tuple(joint - 1 for joint in self.joints)


def usage(kind: str) -> str:
    """What a kind takes, in one line."""
    parts = [
        key if rule.default is None else f"[{key}={rule.default:g}]" for key, rule in KINDS[kind].items()
    ]
    return f"{kind} takes {', '.join(parts)}, [joints=1+2]"


def parse_probe(text: str) -> Probe:
    """Read ``KIND:parameter=value[,parameter=value...][,joints=3+4]``.

    Raises:
        BadInputError: one line that names the kinds, the parameters or the bounds.
    """
    kind, _, rest = (part.strip() for part in text.partition(":"))
    if kind not in KINDS:
        hint = did_you_mean(kind, KINDS) or f"; there are {', '.join(KINDS)}, as in {EXAMPLE}"
        raise BadInputError(f"--probe {text!r}: no such probe{hint}")
    keys = KINDS[kind]
    given: dict[str, tuple[float, ...]] = {}
    for part in filter(None, (part.strip() for part in rest.split(","))):
        key, equals, value = (piece.strip() for piece in part.partition("="))
        if not equals or (key != "joints" and key not in keys):
            hint = did_you_mean(key, [*keys, "joints"]) if equals and key not in keys else ""
            raise BadInputError(
                f"--probe {kind}: {part!r} is not understood{hint + ' ' if hint else '; '}{usage(kind)}"
            )
        if key in given:
            raise BadInputError(f"--probe {kind}: {key} is given twice")
        given[key] = _numbers(kind, key, value)
        if len(given[key]) > 1 and key != "joints" and not keys[key].many:
            raise BadInputError(f"--probe {kind}: {key} takes one number")
    missing = [key for key, rule in keys.items() if rule.default is None and key not in given]
    if missing:
        raise BadInputError(f"--probe {kind}: needs {' and '.join(missing)}; {usage(kind)}")
    joints = given.pop("joints", None)
    for key in ("joints", "steps"):
        row = joints if key == "joints" else given.get(key)
        if row is not None and not all(number.is_integer() for number in row):
            raise BadInputError(f"--probe {kind}: {key} takes whole numbers")
    values = {key: given.get(key, (rule.default or 0.0,)) for key, rule in keys.items()}
    one = {key: row[0] for key, row in values.items()}
    return Probe(
        kind=kind,
        amplitude_rad=math.radians(one["amplitude_deg"]),
        joints=None if joints is None else tuple(int(joint) for joint in joints),
        offset_rad=math.radians(one["offset_deg"]),
        rate_rad_s=math.radians(one.get("rate_deg_s", 180.0)),
        acceleration_rad_s2=one.get("acceleration_rad_s2", 20.0),
        hold_s=one.get("hold_s", 0.5),
        steps=int(one.get("steps", 4)),
        omega_rad_s=values.get("omega_rad_s", ()),
    )


def _numbers(kind: str, key: str, text: str) -> tuple[float, ...]:
    """``3+4`` as (3, 4); an exponent's sign is no separator."""
    try:
        numbers = tuple(float(piece) for piece in re.split(r"(?<![eE])\+", text))
    except ValueError:
        numbers = (math.nan,)
    if not all(map(math.isfinite, numbers)):
        raise BadInputError(f"--probe {kind}: {key}={text} is not a number; {usage(kind)}")
    return numbers
