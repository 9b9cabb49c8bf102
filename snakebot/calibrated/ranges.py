"""Ranges for domain randomisation, as YAML: what is not known of a robot, and where each number stands in the MJCF."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from snakebot.calibrated.spread import Known, known_numbers
from snakebot.effects.registry import find_effect
from snakebot.robot import SERVO_LAG
from snakebot.safe_yaml import dump_yaml

if TYPE_CHECKING:
    from snakebot.robot import Robot

SCHEMA = "snakebot.ranges/1"
_STATED_IN_MJCF = {
    "friction.ct": "numeric ct_* and ct0_*: times value / estimate",
    "friction.cn": "numeric cn_*, cn0_* and rotational_drag_*: times value / estimate",
    "link_mass_kg": "inertial of each link: mass and diaginertia times value / estimate",
    SERVO_LAG: "servo_*: dynprm (less lead_s), and time_constant_s of numeric servo_*",
}


def ranges_yaml(robot: Robot) -> str:
    """The ranges of a robot's numbers.

    Raises:
        BadInputError: an interval is of a number that the robot does not have.
    """
    return dump_yaml(
        {
            "schema": SCHEMA,
            "robot": robot.name,
            "about": "95 % ranges. distribution: of the value (normal) or of its natural logarithm (lognormal), with "
            "sigma; numbers are drawn apart from each other. mjcf: where it stands in the exported model.",
            "ranges": [_entry(known) for known in known_numbers(robot)],
        }
    )


def _entry(known: Known) -> dict[str, Any]:
    low, high = known.ci95
    return {
        "number": known.number,
        **({"joints": list(known.joints)} if known.joints else {}),
        **({"unit": known.unit} if known.unit else {}),
        "estimate": known.estimate,
        "range": [low, high],
        "distribution": "lognormal" if known.log else "normal",
        "sigma": known.sigma,
        "source": known.source,
        "mjcf": _where(known),
    }


def _where(known: Known) -> str:
    if known.number in _STATED_IN_MJCF:
        return _STATED_IN_MJCF[known.number]
    _, effect, parameter = known.number.split(".")
    joints = "+".join(map(str, known.joints)) or "*"
    found = find_effect(effect).parameter(parameter).in_mjcf
    if not found:
        return "write the value into the robot's description and export it again"
    return found.replace("{j}", joints)
