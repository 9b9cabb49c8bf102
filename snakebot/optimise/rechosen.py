"""What another gait would have given where the paper's robot fell short (Mehta, Brennan & Gandhi 2008, Section IX).

The robot is the description with the effects that explain the published speeds. At the same omega, three gaits on it:
the paper's, the fastest of the description without the effects, and the fastest of the robot with them. What the third
gains over the second is the benefit of knowing the effects, as far as the explanation is right.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from snakebot.optimise.goal import Goal
from snakebot.optimise.optimum import optimise
from snakebot.optimise.promise import OptimiseOptions, Promise, promises, row_of

if TYPE_CHECKING:
    from snakebot.gait import Gait
    from snakebot.robot import Robot

SHORT_AT = (4.0, 5.0)  # rad/s, where the robot fell short
_PAPER, _PLAIN = "paper", "without the effects"
CAVEATS = (
    "The effects were fitted to the published speeds themselves; other effects fit nearly as well and may choose "
    "another gait.",
    "The friction is the inferred one, under which the paper's gaits are not the optimal ones even with ideal servos: "
    "only the gain over the gait chosen without the effects is due to knowing them.",
    "No such run was made: simulated, not measured.",
)


@dataclass(frozen=True)
class Rechosen:
    """Gaits of one omega on the explained robot; ``ideal_speed_m_s``: of the paper's gait without the effects."""

    omega_rad_s: float
    ideal_speed_m_s: float
    paper: Promise
    plain: Promise
    found: Promise

    @property
    def gain(self) -> float:
        """Speed of the re-chosen gait over that of the paper's, less one."""
        return self.found.speed_m_s / self.paper.speed_m_s - 1

    @property
    def gain_of_knowing(self) -> float:
        """The same over the gait chosen without the effects."""
        return self.found.speed_m_s / self.plain.speed_m_s - 1

    def summary(self) -> dict[str, Any]:
        """Plain values for ``--json``."""
        return {**asdict(self), "gain": self.gain, "gain_of_knowing": self.gain_of_knowing}


def rechosen(
    robot: Robot,
    effects: Sequence[str],
    paper_gait: Callable[[float], Gait],
    omegas_rad_s: Sequence[float] = SHORT_AT,
    grid: tuple[int, int, int] = (10, 10, 2),
) -> list[Rechosen]:
    """Choose for speed at each omega.

    Raises:
        BadInputError: the robot's limits leave no gait there.
    """
    explained = robot.model_copy(update={"effects": (*robot.effects, *effects)})
    rows = []
    for omega in omegas_rad_s:
        gait = paper_gait(omega)
        options = OptimiseOptions(within={"omega": (omega, omega)}, margin=0.0, draws=0, grid=grid)
        known = optimise(explained, Goal("speed"), options, beside={_PAPER: gait})
        others = {row.what: row for row in known.others}
        (ideal,) = promises(robot, [(_PAPER, row_of(gait))], options)
        rows.append(Rechosen(omega, ideal.speed_m_s, others[_PAPER], others[_PLAIN], known.found))
    return rows
