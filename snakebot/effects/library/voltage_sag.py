"""A supply that gives way."""

from __future__ import annotations

from typing import TYPE_CHECKING

from snakebot.arrays import Floats
from snakebot.effects.effect import Effect
from snakebot.effects.parameter import Parameter
from snakebot.physics import servo_layout as layout

if TYPE_CHECKING:
    from collections.abc import Mapping

    from snakebot.effects.effect import Start, Usual
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot

NO_DROP_PER_S = 1e-3  # 1 % in ten seconds, below which a limit is taken to be constant; chosen


class VoltageSag(Effect):
    name = "voltage_sag"
    example = "voltage_sag:initial_rad_s=2,drop_per_s=0.04"
    stage = "servo"
    summary = "The servo's speed limit falls as the run goes on, or as load rises."
    title = "a limit of speed that falls"
    sentence = (
        "{where} cannot turn faster than {initial_rad_s} at the start of a run, and [loses|lose] "
        "{drop_per_s} of that each second"
    )
    look = (
        "Measure the supply voltage at the servo through a run: battery charge, thin wires, plugs; feel "
        "whether the servo gets hot."
    )
    mark = (
        "As a rate limit, but later cycles are slower than earlier ones, or motion against the "
        "load slower than with it."
    )
    confused_with = (
        ("rate_limit", "nothing changes through the run"),
        ("torque_limit", "below the limit the load does not show"),
    )
    parameters = (
        Parameter(
            "initial_rad_s",
            "rad/s",
            0.05,
            50.0,
            "limit at the start",
            typical=3.0,
            spread=0.8,
            scale="log",
            words="fastest turn at the start",
            in_mjcf="rate_limit_rad_s of numeric servo_{j}",
        ),
        Parameter(
            "drop_per_s",
            "1/s",
            0.0,
            1.0,
            "share of the limit lost a second: limit = initial exp(-drop t)",
            0.02,
            0.03,
            words="loss each second",
            shown=("%", 100.0),
            in_mjcf="rate_drop_per_s of numeric servo_{j}",
        ),
        Parameter(
            "drop_per_nm",
            "1/(N m)",
            0.0,
            100.0,
            "share lost for each N m that opposes the motion",
            0.1,
            0.5,
            default=0.0,
            fitted=False,
            words="loss for each N m",
            shown=("%/(N m)", 100.0),
        ),
    )

    def write_servo(self, rows: Floats, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
        rows[joints, layout.RATE_LIMIT_RAD_S] = spec.value("initial_rad_s")
        rows[joints, layout.RATE_DROP_PER_S] = spec.value("drop_per_s")
        rows[joints, layout.RATE_DROP_PER_NM] = spec.value("drop_per_nm")

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        peak = observed.over(observed.peak_rate_rad_s, joints, 1.0)
        top = observed.over(observed.top_rate_rad_s, joints, 1.0)
        limit, drop, _ = self.parameters
        # Limits that fall to half in the longest run, or to four fifths; then those that pass the fastest motion seen
        # half-way through it.
        begin = ((0.9 * peak, 0.7), (0.7 * peak, 0.2), (1.2 * top, 0.4), (1.35 * top, 0.6))
        return [
            {"initial_rad_s": limit.clip(first), "drop_per_s": drop.clip(fall / observed.duration_s)}
            for first, fall in begin
        ]

    def plainer(self, values: Mapping[str, float], usual: Usual) -> tuple[str, Start] | None:
        """A limit that does not fall is a constant one."""
        if values["drop_per_s"] > NO_DROP_PER_S:
            return None
        return "rate_limit", {"limit_rad_s": values["initial_rad_s"]}


EFFECT = VoltageSag()
