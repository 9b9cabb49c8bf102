"""A servo that ignores small errors."""

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


class Deadband(Effect):
    name = "deadband"
    example = "deadband:width_deg=3"
    stage = "servo"
    everyday = True
    summary = (
        "The servo does not move while its error is smaller than a half width, and stops that far short."
    )
    title = "a dead band"
    sentence = "{where} [stands|stand] still while the error is below {width_deg}"
    look = (
        "Look at the dead band setting of the servo, and turn the joint by steps of half a degree with "
        "`snakebot jog`."
    )
    mark = (
        "After each reversal the joint stands still until the set-point has moved on by twice "
        "the half width; steps end short."
    )
    confused_with = (
        ("backlash", "the same loop on command and angle; motor-side angle or small probes tell"),
        ("joint_friction", "the same loop; its width changes with load"),
    )
    parameters = (
        Parameter(
            "width_deg",
            "deg",
            0.0,
            30.0,
            "half width",
            typical=2.0,
            spread=2.0,
            scale="linear",
            words="half width of the dead band",
            in_mjcf="deadband_rad of numeric servo_{j}, in rad",
        ),
        switch(
            "hard",
            "1: outside the band the whole error drives; 0: what it exceeds the band by",
            words="kind of band",
        ),
    )

    def write_servo(self, rows: Floats, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
        rows[joints, layout.DEADBAND_RAD] = math.radians(spec.value("width_deg"))
        rows[joints, layout.DEADBAND_HARD] = spec.value("hard")

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        amplitude = math.degrees(observed.over(observed.amplitude_rad, joints, 0.1))
        rest = math.degrees(observed.over(observed.residual_rms_rad, joints, 0.02))
        return [{"width_deg": self.parameters[0].clip(min(max(rest, 0.3), 0.3 * max(amplitude, 0.3)))}]


EFFECT = Deadband()
