"""Set-points that come into force late."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from snakebot.arrays import Floats
from snakebot.effects.effect import Effect
from snakebot.effects.parameter import Parameter

if TYPE_CHECKING:
    import numpy as np

    from snakebot.effects.effect import Start, Track
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


@dataclass(frozen=True)
class Delay:
    """A link filter that holds every set-point back; fractions of a tick are meant."""

    delay_s: float

    def online(self, t_s: float, setpoint_rad: Floats, rng: np.random.Generator) -> tuple[float, Floats]:
        return t_s + self.delay_s, setpoint_rad

    def batch(self, track: Track) -> Track:
        return replace(track, time_s=track.time_s + self.delay_s)


class CommandDelay(Effect):
    name = "command_delay"
    example = "command_delay:delay_s=0.0337"
    stage = "link"
    covers = frozenset({"delay"})
    everyday = True
    summary = "Every set-point comes into force a fixed time after it was sent, on all joints or on some."
    title = "a delay of the commands"
    sentence = "{where} [gets|get] [its|their] commands {delay_s} late"
    look = (
        "Look at the way from the computer to the servos: USB latency setting, buffers, other traffic on the "
        "bus, the servo's own update rate."
    )
    mark = (
        "The joints follow the same curve, shifted in time: the phase lag grows in proportion to "
        "the frequency, the amplitude does not fall, and a step starts late but is as steep as "
        "ever."
    )
    confused_with = (
        (
            "servo_lag",
            "at one frequency the same phase lag; a second frequency, a step or the amplitude tells",
        ),
        ("clock_drift", "a delay that grows as the run goes on"),
    )
    parameters = (
        Parameter(
            "delay_s",
            "s",
            0.0,
            0.5,
            "from sending to effect",
            typical=0.03,
            spread=0.05,
            scale="linear",
            words="delay",
            stride=0.02,  # a tick of 50 Hz, the slowest that servos are commanded at
            shown=("ms", 1000.0),
            in_mjcf="delay_s of numeric servo_{j}; at most what is in the file, which has kept room",
        ),
    )

    def link_filter(self, spec: EffectSpec, robot: Robot) -> Delay | None:
        return Delay(spec.value("delay_s")) if spec.joints is None else None

    def late_s(self, spec: EffectSpec) -> float:
        return 0.0 if spec.joints is None else spec.value("delay_s")

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        nominal = observed.robot.servo.time_constant_s
        beyond = observed.over(observed.lag_s, joints, nominal) - nominal
        delay = self.parameters[0]
        return [{"delay_s": delay.clip(max(beyond, 0.3 * observed.sample_s))}]


EFFECT = CommandDelay()
