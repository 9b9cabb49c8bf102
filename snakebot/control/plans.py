"""What a run is to do, before it is known where the joints stand: a gait, a probe, or a recorded run again."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.arrays import Floats
    from snakebot.gait import Gait, Motion, Probe
    from snakebot.runlog import RunLog

RAMP_S = 2.0  # of a smooth start and of a smooth end, where nothing else is asked for
GAIT_CYCLES = 8  # between the ramps: Table II's runs have about as many
PROBE_CYCLES = {"triangle": 4, "steps": 1, "sine": 4}
MOST_CYCLES_ASKED = 10_000  # of a probe


@dataclass(frozen=True)
class RunPlan:
    """A motion that begins wherever the robot is found.

    Attributes:
        motion_from: gives the motion that begins in a posture (rad a joint).
        joints: of the robot.
        title: what is done, in words.
        label: part of a new log's name.
        amplitude_rad: what tracking error is divided by (37).
        ramp_s: smooth start and end of the motion, each.
        settle_s: from its start until the steady part begins; as long before its end that part ends.
        gait: the gait that is commanded, if it is one.
        lifted: the robot is off the ground.
        about: further metadata of the log.
    """

    motion_from: Callable[[Sequence[float]], Motion]
    joints: int
    title: str
    label: str
    amplitude_rad: float
    ramp_s: float
    settle_s: float
    gait: Gait | None = None
    lifted: bool = False
    about: Mapping[str, object] = field(default_factory=dict)

    def from_straight(self) -> Motion:
        """The motion of a robot that lies straight: to look at, and to check before anything is opened.

        Raises:
            BadInputError: there is no such motion.
        """
        return self.motion_from([0.0] * self.joints)


def plan_run(
    what: Gait | Probe,
    joints: int,
    *,
    duration_s: float | None = None,
    cycles: float | None = None,
    ramp_s: float = RAMP_S,
    lifted: bool = False,
) -> RunPlan:
    """Plan a gait or a probe.

    Args:
        joints: of the robot.
        duration_s: of the run with its ramps; else ``cycles`` count.
        cycles: whole ones between the ramps; 8 of a gait, 4 of a triangle or a sine, 1 of steps if not given.
        ramp_s: smooth start and end, each.
        lifted: the robot is off the ground: no load. Stored with the log.

    Raises:
        BadInputError: a length that is none, both kinds of length, or a probe of joints that the robot does not have.
    """
    from snakebot.gait import Gait, GaitMotion, ProbeMotion
    from snakebot.runlog.naming import gait_label

    if duration_s is not None and cycles is not None:
        raise BadInputError("give --duration or --cycles, not both")
    if duration_s is None:
        duration_s = _span_s(what, cycles) + 2 * ramp_s
    elif not (math.isfinite(duration_s) and duration_s > 0):
        raise BadInputError(f"--duration {duration_s:g}: must be a positive number of seconds")
    length_s = float(duration_s)

    def motion_from(start_rad: Sequence[float]) -> Motion:
        motion = GaitMotion if isinstance(what, Gait) else ProbeMotion
        return motion(what, joints, length_s, ramp_s, start_rad)  # type: ignore[arg-type]

    is_gait = isinstance(what, Gait)
    return RunPlan(
        motion_from,
        joints,
        title=f"{what}{', lifted off the ground' if lifted else ''}",
        label=gait_label(what) if isinstance(what, Gait) else f"probe_{what}",
        amplitude_rad=what.alpha_rad if isinstance(what, Gait) else what.amplitude_rad,
        ramp_s=ramp_s,
        settle_s=ramp_s,
        gait=what if isinstance(what, Gait) else None,
        lifted=lifted,
        about={} if is_gait else {"probe": str(what)},
    )


def _span_s(what: Gait | Probe, cycles: float | None) -> float:
    """Time between the ramps."""
    from snakebot.gait import Gait, probe_span_s

    if cycles is None:
        cycles = GAIT_CYCLES if isinstance(what, Gait) else PROBE_CYCLES[what.kind]
    if not (math.isfinite(cycles) and cycles > 0):
        raise BadInputError(f"--cycles {cycles:g}: must be a positive number")
    if not isinstance(what, Gait):
        if cycles < 1 or cycles > MOST_CYCLES_ASKED or (what.kind != "sine" and cycles != int(cycles)):
            raise BadInputError(f"--cycles {cycles:g}: a probe makes whole cycles, 1 to {MOST_CYCLES_ASKED}")
        return probe_span_s(what, cycles)
    if not math.isfinite(what.period_s):
        raise BadInputError(f"--omega {what.omega_rad_s:g} has no cycle that ends: give --duration")
    return float(cycles * what.period_s)


def plan_replay(recorded: RunLog, *, ramp_s: float = RAMP_S) -> RunPlan:
    """Plan to send the set-points of a recorded run again.

    Args:
        ramp_s: to the first recorded posture, and from the last one to straight, each.

    Raises:
        BadInputError: the ramp is none, or the set-points cannot be sent again.
    """
    from snakebot.gait import SampledMotion
    from snakebot.runlog.naming import gait_label
    from snakebot.runlog.replaying import recorded_setpoints

    if not (math.isfinite(ramp_s) and ramp_s > 0):
        raise BadInputError(f"--ramp {ramp_s:g}: must be a positive number of seconds")
    t_s, angles_rad = recorded_setpoints(recorded)
    gait = recorded.gait
    return RunPlan(
        lambda start_rad: SampledMotion(t_s, angles_rad, ramp_s, start_rad),
        recorded.joints,
        title=f"the recorded set-points of {recorded.name}",
        label=f"{gait_label(gait)}_replay" if gait is not None else "replay",
        amplitude_rad=gait.alpha_rad if gait is not None else _half_travel_rad(angles_rad),
        ramp_s=ramp_s,
        settle_s=ramp_s + settle_s(recorded.metadata),  # the recorded ramp comes after ours
        gait=gait,
        about={"replay_of": recorded.name},
    )


def _half_travel_rad(angles_rad: Floats) -> float:
    """Half of the way of the joint that goes farthest; infinite where that is beyond all numbers."""
    import numpy as np

    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.ptp(angles_rad, axis=0).max() / 2)


def settle_s(metadata: Mapping[str, object]) -> float:
    """How long after its start the steady part of a recorded run begins, as its metadata say; 0 where they do not."""
    for key in ("settle_s", "ramp_s"):
        value = metadata.get(key)
        if (
            isinstance(value, int | float)
            and not isinstance(value, bool)
            and math.isfinite(value)
            and value >= 0
        ):
            return float(value)
    return 0.0
