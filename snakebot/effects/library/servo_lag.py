"""A servo slower or faster than nominal."""

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


class ServoLag(Effect):
    name = "servo_lag"
    example = "servo_lag:time_constant_s=0.1"
    stage = "servo"
    covers = frozenset({"delay"})
    everyday = True
    summary = "The servo is a first-order lag with another time constant than the nominal one."
    title = "another servo lag"
    sentence = "{where} [follows|follow] with a lag of {time_constant_s}, other than stated"
    look = (
        "Look at the servo's gains and acceleration setting, at its supply, and at whether it is the model "
        "that the description names."
    )
    mark = "Phase lag and loss of amplitude that grow with frequency together: tan(lag) = omega tau."
    confused_with = (
        ("command_delay", "at one frequency; the amplitude or a second frequency tells"),
        ("rate_limit", "loss of amplitude that depends on amplitude, not only on frequency"),
    )
    parameters = (
        Parameter(
            "time_constant_s",
            "s",
            0.0,
            2.0,
            "of the lag",
            typical=0.05,
            spread=0.08,
            words="lag",
            shown=("ms", 1000.0),
        ),
    )

    def write_servo(self, rows: Floats, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
        rows[joints, layout.TIME_CONSTANT_S] = spec.value("time_constant_s")

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        nominal = observed.robot.servo.time_constant_s
        lag = observed.over(observed.lag_s, joints, 2 * nominal)
        return [{"time_constant_s": self.parameters[0].clip(max(lag, 0.25 * observed.sample_s))}]


EFFECT = ServoLag()
