"""A joint that moves more or less than it is told."""

from __future__ import annotations

from typing import TYPE_CHECKING

from snakebot.arrays import Floats
from snakebot.effects.effect import Effect
from snakebot.effects.parameter import Parameter
from snakebot.physics import servo_layout as layout

if TYPE_CHECKING:
    from snakebot.effects.effect import Start
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


class CommandGain(Effect):
    name = "command_gain"
    example = "command_gain:gain=0.8,joints=2"
    stage = "servo"
    everyday = True
    summary = "The joint really moves gain times its set-point."
    title = "a wrong scale of the motion"
    sentence = "{where} [turns|turn] {gain} times the angle that [it is|they are] told"
    look = (
        "Look at the servo's travel and scale settings and at the horn; measure a turn of 45 deg with a "
        "protractor."
    )
    mark = (
        "Amplitude off by the same factor at all frequencies, no phase lag; with a pose or speed "
        "the body shows it too."
    )
    confused_with = (
        ("encoder_gain", "only the reading is off: the motion over ground tells"),
        ("servo_lag", "at one frequency; a slower gait tells"),
    )
    parameters = (
        Parameter(
            "gain",
            "",
            0.2,
            3.0,
            "joint angle over set-point",
            typical=1.0,
            spread=0.1,
            scale="log",
            neutral=1.0,
            words="turned over told",
        ),
    )

    def write_servo(self, rows: Floats, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
        rows[joints, layout.GAIN] = spec.value("gain")

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        gain = self.parameters[0].clip(observed.over(observed.gain, joints, 1.0))
        return [{"gain": gain if abs(gain - 1) > 0.02 else 0.95}]


EFFECT = CommandGain()
