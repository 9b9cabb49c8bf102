"""Two clocks that do not agree."""

from __future__ import annotations

from dataclasses import replace
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


class Drift:
    """A link filter whose delay grows from the first set-point on; in a log, unlike on a board, it can be negative."""

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._start_s: float | None = None

    def online(self, t_s: float, setpoint_rad: Floats, rng: np.random.Generator) -> tuple[float, Floats]:
        if self._start_s is None:
            self._start_s = t_s
        return t_s + self._rate * (t_s - self._start_s), setpoint_rad

    def batch(self, track: Track) -> Track:
        return replace(track, time_s=track.time_s + self._rate * (track.time_s - track.time_s[0]))


class ClockDrift(Effect):
    name = "clock_drift"
    example = "clock_drift:ppm=2000"
    stage = "link"
    summary = "The clocks of host and board drift apart: by the host's clock the robot is later and later."
    title = "clocks that drift apart"
    sentence = "The clocks of computer and board drift apart, by {ppm}"
    look = "Look at the board's clock source: a crystal is good to 0.1 ms in a second, a bare RC oscillator is not."
    mark = (
        "A delay that is nothing at the start and grows steadily through the run, the same in "
        "seconds on all joints."
    )
    confused_with = (("command_delay", "a run that is longer, or its first and last seconds apart"),)
    per_joint = False
    parameters = (
        Parameter(
            "ppm",
            "ppm",
            -20000.0,
            20000.0,
            "delay gained a second, in us",
            typical=0.0,
            spread=2000.0,
            words="drift",
            shown=("ms in each second", 0.001),
        ),
    )

    def link_filter(self, spec: EffectSpec, robot: Robot) -> Drift:
        return Drift(spec.value("ppm") * 1e-6)

    def outside_mjcf(self, spec: EffectSpec) -> str:
        return "set-points come when your own loop writes them"

    def clock_ppm(self, spec: EffectSpec) -> float:
        return spec.value("ppm")

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        # half a sample at the end of the longest run: less would be lost in the noise
        late = 0.5e6 * observed.sample_s / observed.duration_s
        return [{"ppm": self.parameters[0].clip(late)}, {"ppm": self.parameters[0].clip(-late)}]


EFFECT = ClockDrift()
