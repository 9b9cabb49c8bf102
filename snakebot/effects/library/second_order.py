"""A servo with inertia."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from snakebot.arrays import Floats
from snakebot.effects.effect import Effect
from snakebot.effects.parameter import Parameter
from snakebot.physics import servo_layout as layout

if TYPE_CHECKING:
    from snakebot.effects.effect import Start, Usual
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


# Damping from which on the quick pole is 34 times as quick as the slow one, (z + sqrt(z^2 - 1))^2; chosen.
POLES_APART = 3.0


class SecondOrder(Effect):
    name = "second_order"
    example = "second_order:natural_freq_rad_s=12,damping_ratio=0.4"
    stage = "servo"
    covers = frozenset({"delay"})
    summary = "The servo answers as a second-order system instead of a first-order lag."
    title = "a servo that swings"
    sentence = (
        "{where} [answers|answer] with a swing at {natural_freq_rad_s} and a damping of {damping_ratio}"
    )
    look = "Look at the gains of the servo's position loop (P, D) and at the inertia that hangs on it."
    mark = "Overshoot and ringing where damping is below 0.7; phase lag beyond 90 degrees at high frequency."
    confused_with = (
        ("servo_lag", "at high damping it is a lag; a step or a chirp tells"),
        ("command_delay", "at low frequencies: 2 zeta / omega_n of delay"),
    )
    parameters = (
        Parameter(
            "natural_freq_rad_s",
            "rad/s",
            2.0,
            500.0,
            "undamped",
            typical=30.0,
            spread=0.8,
            scale="log",
            words="natural frequency",
            in_mjcf="natural_freq_rad_s of numeric servo_{j}",
        ),
        Parameter(
            "damping_ratio",
            "",
            0.02,
            5.0,
            "1: critical",
            typical=0.8,
            spread=0.5,
            scale="log",
            words="damping ratio",
            in_mjcf="damping_ratio of numeric servo_{j}",
        ),
    )

    def said(self, values: Mapping[str, float | tuple[float, ...]]) -> str:
        """Without overshoot it is just slow."""
        damping = values.get("damping_ratio", 1.0)
        if isinstance(damping, tuple) or damping < 0.7:
            return self.sentence
        return (
            "{where} [answers|answer] slowly and without a swing: natural frequency {natural_freq_rad_s}, "
            "damping {damping_ratio}"
        )

    def plainer(self, values: Mapping[str, float], usual: Usual) -> tuple[str, Start] | None:
        """Two poles far apart are a lag with the time constant of the slow one: of the quick one nothing is seen."""
        damping = values["damping_ratio"]
        if damping < POLES_APART:
            return None
        return "servo_lag", {"time_constant_s": 2 * damping / values["natural_freq_rad_s"]}

    def write_servo(self, rows: Floats, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
        # A servo_lag given as well is applied after this one, and is then a filter in front of it.
        rows[joints, layout.TIME_CONSTANT_S] = 0.0
        rows[joints, layout.NATURAL_FREQ_RAD_S] = spec.value("natural_freq_rad_s")
        rows[joints, layout.DAMPING_RATIO] = spec.value("damping_ratio")

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        lag = max(observed.over(observed.lag_s, joints, 0.03), 0.01)
        frequency, _ = self.parameters
        return [
            {"natural_freq_rad_s": frequency.clip(2 * damping / lag), "damping_ratio": damping}
            for damping in (0.8, 0.3)
        ]


EFFECT = SecondOrder()
