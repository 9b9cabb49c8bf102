"""A servo that can only turn so fast."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats
from snakebot.effects.effect import Effect
from snakebot.effects.parameter import Parameter
from snakebot.physics import servo_layout as layout

if TYPE_CHECKING:
    from collections.abc import Mapping

    from snakebot.effects.effect import Start
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Recorded, Robot


class RateLimit(Effect):
    name = "rate_limit"
    example = "rate_limit:limit_rad_s=1.6,joints=3+4"
    stage = "servo"
    summary = "The joint's speed is limited."
    title = "a limit of speed"
    sentence = "{where} cannot turn faster than {limit_rad_s}"
    look = (
        "Look at the speed setting of the servo (goal speed, profile), at its supply voltage in motion, and "
        "whether the joint rubs."
    )
    mark = (
        "Fast motions become triangles of one slope: amplitude falls as amplitude times "
        "frequency grows, slow gaits are untouched."
    )
    confused_with = (
        ("voltage_sag", "the limit falls through the run"),
        ("torque_limit", "the limit depends on load"),
    )
    parameters = (
        Parameter(
            "limit_rad_s",
            "rad/s",
            0.05,
            50.0,
            "either way",
            typical=2.0,
            spread=0.8,
            scale="log",
            words="fastest turn",
            in_mjcf="rate_limit_rad_s of numeric servo_{j}",
        ),
    )

    def write_servo(self, rows: Floats, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
        rows[joints, layout.RATE_LIMIT_RAD_S] = spec.value("limit_rad_s")

    def at_most(self, recorded: Recorded, rows: Floats) -> Mapping[str, Floats]:
        return {"limit_rad_s": np.minimum(recorded.joint_speed_rad_s, rows[:, layout.RATE_LIMIT_RAD_S])}

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        # above the fastest motion seen the objective is flat, and a fit would never move
        peak = observed.over(observed.peak_rate_rad_s, joints, 1.0)
        top = observed.over(observed.top_rate_rad_s, joints, 1.0)
        near = (0.6 * peak, 0.95 * peak, 0.93 * top, 0.97 * top, 1.01 * top)
        return [{"limit_rad_s": self.parameters[0].clip(limit)} for limit in near]


EFFECT = RateLimit()
