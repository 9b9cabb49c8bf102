"""Servo leads in the wrong sockets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats
from snakebot.effects.effect import Effect, Setting
from snakebot.effects.parameter import Parameter
from snakebot.errors import BadInputError
from snakebot.physics import servo_layout as layout

if TYPE_CHECKING:
    from snakebot.effects.effect import Start
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


class Wiring(Effect):
    name = "wiring"
    example = "wiring:permutation=3+2,signs=1+-1,joints=2+3"
    stage = "servo"
    is_read_off = True
    summary = "Servos are plugged in the wrong order or turn the wrong way."
    title = "swapped or reversed servos"
    sentence = "{where} [is|are] wired wrongly"
    look = (
        "Look at which servo is in which socket, at servo numbers, and at the direction setting of each; "
        "move one joint at a time with `snakebot jog`."
    )
    mark = "A joint follows the set-point of another, or its own with the sign reversed, exactly."
    parameters = (
        Parameter(
            "permutation",
            "",
            1,
            31,
            "joint whose set-point each listed joint gets",
            1,
            1,
            default=0,
            fitted=False,
            integer=True,
            many=True,
            words="joint that it follows",
        ),
        Parameter(
            "signs",
            "",
            -1,
            1,
            "1 or -1 for each listed joint",
            1,
            1,
            default=1,
            fitted=False,
            integer=True,
            many=True,
            words="direction",
        ),
    )

    def said(self, values: Mapping[str, float | tuple[float, ...]]) -> str:
        signs = values.get("signs", 1.0)
        turned = any(sign < 0 for sign in (signs if isinstance(signs, tuple) else (signs,)))
        swapped = "permutation" in values
        ways = ["[follows|follow] the [command|commands] of [joint|joints] {permutation}"] * swapped
        ways += ["[turns|turn] the wrong way"] * (turned and not swapped)
        ways += ["some of them the wrong way"] * (turned and swapped)
        return "{where} " + (" and ".join(ways) if ways else "[is|are] wired wrongly")

    def write_servo(self, rows: Floats, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
        if "permutation" in spec.values:
            rows[joints, layout.SOURCE] = np.array(spec.listed("permutation", len(joints))) - 1
        rows[joints, layout.SIGN] = spec.listed("signs", len(joints))

    def check(self, spec: EffectSpec, robot: Robot) -> None:
        joints = spec.joint_indices(robot.joints)
        if "permutation" in spec.values:
            sources = spec.listed("permutation", len(joints))
            if sorted(int(s) - 1 for s in sources) != sorted(joints):
                listed = "+".join(str(j + 1) for j in joints)
                raise BadInputError(f"effect wiring: permutation must name each of the joints {listed} once")
        if 0 in spec.listed("signs", len(joints)):
            raise BadInputError("effect wiring: signs are 1 or -1")

    def can_explain(self, observed: Observed) -> bool:
        """A single joint that follows its set-point is wired right."""
        return observed.robot.joints > 1 or not observed.correlation[0, 0] > 0

    def read_off(self, observed: Observed) -> Setting | None:
        (start,) = self.starts(observed, tuple(range(observed.robot.joints)))
        order, signs = start["permutation"], start["signs"]
        assert isinstance(order, tuple)
        assert isinstance(signs, tuple)
        wrong = [j for j, source in enumerate(order) if int(source) != j + 1 or signs[j] < 0]
        if not wrong:
            return None
        values: Start = {}
        if any(int(order[j]) != j + 1 for j in wrong):
            values["permutation"] = tuple(order[j] for j in wrong)
        values["signs"] = tuple(signs[j] for j in wrong)
        return Setting(tuple(j + 1 for j in wrong), values)

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        """The pairing of joints and commands that correlates best, with its signs."""
        from scipy.optimize import linear_sum_assignment

        table = observed.correlation[np.ix_(joints, joints)]
        rows, columns = linear_sum_assignment(-np.abs(table))
        signs = np.where(table[rows, columns] < 0, -1.0, 1.0)
        sources = tuple(float(joints[c] + 1) for c in columns)
        return [{"permutation": sources, "signs": tuple(float(s) for s in signs)}]


EFFECT = Wiring()
