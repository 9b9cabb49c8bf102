"""A servo that is not strong enough."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats
from snakebot.effects.effect import Effect, knows_load
from snakebot.effects.parameter import Parameter
from snakebot.physics import servo_layout as layout

if TYPE_CHECKING:
    from collections.abc import Mapping

    from snakebot.effects.effect import Start, Usual
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Recorded, Robot


class TorqueLimit(Effect):
    name = "torque_limit"
    example = "torque_limit:limit_nm=0.3"
    stage = "servo"
    summary = "The servo's torque is limited: under more load than that the joint falls behind."
    title = "a limit of torque"
    sentence = "{where} cannot give more than {limit_nm}"
    look = (
        "Look at the torque or current limit of the servo, at its supply, and at what makes the joint heavy "
        "to turn; lift the robot and try again."
    )
    mark = (
        "The joint lags where load and acceleration are high and follows where they are low; "
        "lifted off the ground it is gone."
    )
    confused_with = (
        ("rate_limit", "depends on speed, not on load: lift the robot, or load it"),
        ("voltage_sag", "load slows the motion below the limit too"),
    )
    parameters = (
        Parameter(
            "limit_nm",
            "N m",
            0.005,
            500.0,
            "either way",
            typical=0.5,
            spread=1.0,
            scale="log",
            words="most torque",
            in_mjcf="forcerange of the actuator on joint_{j}: -value value",
        ),
    )

    def write_servo(self, rows: Floats, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
        rows[joints, layout.TORQUE_LIMIT_NM] = spec.value("limit_nm")

    def at_most(self, recorded: Recorded, rows: Floats) -> Mapping[str, Floats]:
        if recorded.torque_nm is None:
            return {}
        return {"limit_nm": np.minimum(recorded.torque_nm, rows[:, layout.TORQUE_LIMIT_NM])}

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        """What no servo bore more than, by the measured motion, is the limit, where there is one."""
        top = observed.most(observed.top_load_nm, joints, 1.0)
        return [{"limit_nm": self.parameters[0].clip(share * top)} for share in (1.0, 0.9)]

    def plainer(self, values: Mapping[str, float], usual: Usual) -> tuple[str, Start] | None:
        """A servo that holds next to nothing is dead."""
        return ("joint_free", {}) if usual.is_no_torque(values["limit_nm"]) else None

    def applies_to(self, robot: Robot) -> bool:
        return knows_load(robot)


EFFECT = TorqueLimit()
