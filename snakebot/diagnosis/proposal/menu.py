"""What may be run next: gaits and probes that keep the robot's limits, on the ground or lifted off it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import degrees, radians

from snakebot.diagnosis.proposal.motions import DURATION_S, RAMP_S, known_motions
from snakebot.diagnosis.result import GaitDegrees, NextExperiment
from snakebot.errors import BadInputError
from snakebot.gait import Gait, GaitMotion, Motion, Probe, ProbeMotion, check_motion, parse_probe
from snakebot.in_words import numbered
from snakebot.robot import Robot

# Of all joints together, when a probe moves them alike: beyond it links meet; chosen.
WIDEST_CURL_RAD = radians(200)


@dataclass(frozen=True)
class MenuMotion:
    """A motion of the menu: either ``gait`` or ``probe``."""

    gait: Gait | None
    probe: Probe | None
    lifted: bool
    motion: Motion

    @property
    def duration_s(self) -> float:
        return self.motion.duration_s

    @property
    def shown_gait(self) -> GaitDegrees | None:
        if self.gait is None:
            return None
        return GaitDegrees(
            alpha_deg=round(degrees(self.gait.alpha_rad), 6),
            beta_deg=round(degrees(self.gait.beta_rad), 6),
            omega_rad_s=self.gait.omega_rad_s,
            offset_deg=round(degrees(self.gait.offset_rad), 6),
        )

    @property
    def command(self) -> str:
        """To run it, whole; only the port is left to the user."""
        gait = self.shown_gait
        if gait is None:
            words = f"--probe {self.probe}"
        else:
            offset = f" --offset {gait.offset_deg:g}" if gait.offset_deg else ""
            words = (
                f"--alpha {gait.alpha_deg:g} --beta {gait.beta_deg:g} --omega {gait.omega_rad_s:g}{offset}"
            )
        air = " --lifted" if self.lifted else ""
        return f"snakebot run {words} --duration {self.duration_s:g} --ramp {RAMP_S:g}{air}"

    def __str__(self) -> str:
        """In words, as part of a sentence."""
        air = "; lift the robot off the ground first" if self.lifted else ""
        return f"{self._words()}, {self.duration_s:g} s{air}"

    def _words(self) -> str:
        if self.probe is None:
            assert self.gait is not None
            return f"a {'small ' if degrees(self.gait.alpha_rad) < 10 else ''}gait, {self.gait}"
        probe = self.probe
        far = f"{degrees(probe.amplitude_rad):g} deg"
        which = "all joints" if probe.joints is None else f"{numbered('joint', probe.joints)} alone"
        if probe.kind == "triangle":
            return f"{which} back and forth by {far} at {degrees(probe.rate_rad_s):g} deg/s"
        if probe.kind == "steps":
            return f"steps of {which}, growing to {far}"
        return f"sines of {which}, {far} at {' and '.join(f'{omega:g}' for omega in probe.omega_rad_s)} rad/s"


def menu(robot: Robot, joints: Sequence[int], *, loads: bool) -> list[MenuMotion]:
    """All that is safe of the motions that come with snakebot, in their order.

    Args:
        joints: 1-based, that the explanations still open are about.
        loads: whether one of them feels what the servos bear: then motions in the air are on the menu too.

    Raises:
        BadInputError: the file of the motions is not sound.
    """
    known = known_motions()
    options: list[MenuMotion] = []
    for written in known.gaits:
        _add(options, robot, written.gait, None, duration_s=written.duration_s)
    groups: list[tuple[int, ...] | None] = [None if len(joints) in (0, robot.joints) else tuple(joints)]
    if len(joints) > 1:
        groups.append((joints[len(joints) // 2],))
    in_the_air = known.lifted if loads and robot.body is not None else ()
    for lifted, probes in ((False, known.probes), (True, in_the_air)):
        for probe in probes:
            for group in groups:
                _add(options, robot, None, replace(probe, joints=group), lifted=lifted)
    return options


def _add(
    options: list[MenuMotion],
    robot: Robot,
    gait: Gait | None,
    probe: Probe | None,
    *,
    lifted: bool = False,
    duration_s: float = DURATION_S,
) -> None:
    if probe is not None and probe.amplitude_rad * len(probe.joint_indices(robot.joints)) > WIDEST_CURL_RAD:
        return
    try:
        motion = _motion(gait, probe, robot, duration_s)
        check_motion(motion, robot)
    except BadInputError:
        return
    options.append(MenuMotion(gait, probe, lifted, motion))


def _motion(gait: Gait | None, probe: Probe | None, robot: Robot, duration_s: float) -> Motion:
    if probe is not None:
        return ProbeMotion(probe, robot.joints, duration_s, RAMP_S)
    assert gait is not None
    return GaitMotion(gait, robot.joints, duration_s, RAMP_S)


def motion_of(proposal: NextExperiment, robot: Robot) -> Motion:
    """The motion that ``proposal.command`` makes of this robot.

    Raises:
        BadInputError: the robot cannot make it.
    """
    probe = None if proposal.probe is None else parse_probe(proposal.probe)
    gait = None
    if proposal.gait is not None:
        g = proposal.gait
        gait = Gait.from_degrees(g.alpha_deg, g.beta_deg, g.omega_rad_s, g.offset_deg)
    return _motion(gait, probe, robot, proposal.duration_s)
