"""What may be run next: gaits and probes that keep the robot's limits, on the ground or lifted off it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees, radians

from snakebot.diagnosis.result import GaitDegrees, NextExperiment
from snakebot.errors import BadInputError
from snakebot.gait import Gait, GaitMotion, Motion, Probe, ProbeMotion, check_motion, parse_probe
from snakebot.robot import Robot

DURATION_S = 12.0  # of a motion, s; chosen
LONG_S = 60.0  # of a motion for what comes with time (a battery that runs down, clocks that part), s; chosen
RAMP_S = 2.0  # from rest to the full motion, s; chosen
# Of all joints together, when a probe moves them alike: beyond it links meet; chosen.
WIDEST_CURL_RAD = radians(200)

# The menu: alpha deg and omega rad/s of gaits; and probes in the grammar of `--probe`. Chosen to cover small and large,
# slow and fast; `tools/bench_experiments` shows what they separate.
STRAIGHT = (
    *((2, 0.5), (2, 3.0), (6, 0.5), (6, 3.0), (15, 1.0), (15, 5.0)),
    *((30, 0.5), (30, 4.0), (50, 1.0), (50, 3.0), (66, 2.0)),
)
CURVED = ((15, 1.0), (30, 4.0), (50, 2.0))  # likewise, with ``OFFSET_DEG``; chosen
LONG = ((50, 3.0),)  # likewise, for ``LONG_S``; chosen
BETA_DEG, OFFSET_DEG = 80, 15  # of these gaits, of the curved ones; chosen
PROBES = (
    "triangle:amplitude_deg=2,rate_deg_s=4",
    "triangle:amplitude_deg=6,rate_deg_s=6",
    "triangle:amplitude_deg=20,rate_deg_s=30",
    "triangle:amplitude_deg=40,rate_deg_s=100",
    "steps:amplitude_deg=4,rate_deg_s=60,hold_s=0.4,steps=3",
    "steps:amplitude_deg=20,rate_deg_s=200,hold_s=0.4,steps=3",
    "steps:amplitude_deg=60,rate_deg_s=300,hold_s=0.4,steps=2",
    "sine:amplitude_deg=3,omega_rad_s=1.6+6",
    "sine:amplitude_deg=12,omega_rad_s=2+9",
    "sine:amplitude_deg=45,omega_rad_s=1.6+4",
)
LIFTED = (
    "triangle:amplitude_deg=20,rate_deg_s=30",
    "steps:amplitude_deg=20,rate_deg_s=200,hold_s=0.4,steps=3",
    "sine:amplitude_deg=45,omega_rad_s=1.6+4",
)


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
        if probe.joints is None:
            which = "all joints"
        else:
            which = f"joint{'s' if len(probe.joints) > 1 else ''} {', '.join(map(str, probe.joints))} alone"
        if probe.kind == "triangle":
            return f"{which} back and forth by {far} at {degrees(probe.rate_rad_s):g} deg/s"
        if probe.kind == "steps":
            return f"steps of {which}, growing to {far}"
        return f"sines of {which}, {far} at {' and '.join(f'{omega:g}' for omega in probe.omega_rad_s)} rad/s"


def menu(robot: Robot, joints: Sequence[int], *, loads: bool) -> list[MenuMotion]:
    """All that is safe.

    Args:
        joints: 1-based, that the explanations still open are about.
        loads: whether one of them feels what the servos bear: then motions in the air are on the menu too.
    """
    options: list[MenuMotion] = []
    for gaits, offset, duration_s in (
        (STRAIGHT, 0, DURATION_S),
        (CURVED, OFFSET_DEG, DURATION_S),
        (LONG, 0, LONG_S),
    ):
        for alpha, omega in gaits:
            wave = Gait(radians(alpha), radians(BETA_DEG), omega, radians(offset))
            _add(options, robot, wave, None, duration_s=duration_s)
    groups: list[tuple[int, ...] | None] = [None if len(joints) in (0, robot.joints) else tuple(joints)]
    if len(joints) > 1:
        groups.append((joints[len(joints) // 2],))
    for lifted, texts in ((False, PROBES), (True, LIFTED if loads and robot.body is not None else ())):
        for text in texts:
            for group in groups:
                where = "" if group is None else ",joints=" + "+".join(map(str, group))
                _add(options, robot, None, parse_probe(text + where), lifted=lifted)
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
