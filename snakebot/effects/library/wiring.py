"""Servo leads in the wrong sockets."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from snakebot.effects.effect import Effect
from snakebot.effects.parameter import Parameter
from snakebot.errors import BadInputError
from snakebot.physics import servo_layout as layout

if TYPE_CHECKING:
    from snakebot.effects.effect import Start, Vector
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


class Wiring(Effect):
    name = "wiring"
    example = "wiring:permutation=3+2,signs=1+-1,joints=2+3"
    stage = "servo"
    summary = "Servos are plugged in the wrong order or turn the wrong way."
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
        ),
    )

    def write_servo(self, rows: Vector, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
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

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        """The pairing of joints and commands that correlates best, with its signs."""
        from scipy.optimize import linear_sum_assignment

        table = observed.correlation[np.ix_(joints, joints)]
        rows, columns = linear_sum_assignment(-np.abs(table))
        signs = np.where(table[rows, columns] < 0, -1.0, 1.0)
        sources = tuple(float(joints[c] + 1) for c in columns)
        return [{"permutation": sources, "signs": tuple(float(s) for s in signs)}]


EFFECT = Wiring()
