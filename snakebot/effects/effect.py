"""What every effect is made of. An effect is one file: see docs/add-an-effect.md."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Literal, Protocol

import numpy as np
import numpy.typing as npt

from snakebot.effects.parameter import Parameter
from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.effects.ground import Ground
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot

Vector = npt.NDArray[np.float64]
Stage = Literal["link", "servo", "sensor", "body"]
STAGES: tuple[Stage, ...] = ("link", "servo", "sensor", "body")
Start = dict[str, float | tuple[float, ...]]


@dataclass(frozen=True)
class Track:
    """Set-points and when each comes into force: what leaves the link and enters the servos.

    Attributes:
        time_s: (M,) not falling.
        setpoint_rad: (M, joints); NaN: servo off.
        variance_rad2: (M, joints), of a set-point that chance decides on (loss): ``setpoint_rad`` is then the mean.
    """

    time_s: Vector
    setpoint_rad: Vector
    variance_rad2: Vector | None = None


class LinkFilter(Protocol):
    """What becomes of set-points on their way. One object serves one board or one run; it may keep state."""

    def online(
        self, t_s: float, setpoint_rad: Vector, rng: np.random.Generator
    ) -> tuple[float, Vector] | None:
        """When and as what a set-point that arrives at ``t_s`` comes into force; None: never. Not before ``t_s``."""

    def batch(self, track: Track) -> Track:
        """The same for a whole run, in the mean over what chance decides."""


class SensorFilter(Protocol):
    """What becomes of joint angles on their way to the reading, before the encoder's counts."""

    def online(self, t_s: float, angle_rad: Vector, rng: np.random.Generator) -> Vector:
        """Reading (joints,) of joint angles (joints,) at one time; times do not fall from call to call."""

    def batch(self, t_s: Vector, angle_rad: Vector) -> Vector:
        """Mean reading (T, joints) of joint angles (T, joints)."""

    def variance_rad2(self, t_s: Vector) -> Vector | float:
        """Variance (T, joints) about that mean."""


class Effect:
    """Base of every effect: override what the effect touches, and nothing else.

    Attributes:
        name: as in ``--effect``, reports and file names.
        example: after ``--effect``, clearly visible on the six-link robot.
        stage: where in the signal it sits.
        summary: one sentence: what is different from the nominal robot.
        mark: what it leaves in the data, so that a user can recognise it.
        confused_with: effects that leave nearly the same mark, and what tells each apart.
        parameters: in the order in which they are written.
        per_joint: whether it may hold for some joints only.
        covers: of the nominal robot's "delay" and "friction", what it sets itself, so that a fit needs no tolerance.
    """

    name: ClassVar[str]
    example: ClassVar[str]
    stage: ClassVar[Stage]
    summary: ClassVar[str]
    mark: ClassVar[str]
    confused_with: ClassVar[tuple[tuple[str, str], ...]] = ()
    parameters: ClassVar[tuple[Parameter, ...]] = ()
    per_joint: ClassVar[bool] = True
    covers: ClassVar[frozenset[str]] = frozenset()

    def write_servo(self, rows: Vector, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
        """Write into the servo's rows (joints, PARAMETERS) of ``physics.servo_layout``, for the 0-based ``joints``."""

    def link_filter(self, spec: EffectSpec, robot: Robot) -> LinkFilter | None:
        """A filter on set-points, for one run."""
        return None

    def sensor_filter(self, spec: EffectSpec, robot: Robot) -> SensorFilter | None:
        """A filter on readings, for one run."""
        return None

    def write_ground(self, ground: Ground, spec: EffectSpec, robot: Robot) -> None:
        """Change what the body weighs and rolls on."""

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        """Values to start a fit from, best first, each inside the range where the objective is not flat.

        Several: discrete alternatives (which link) or valleys that one descent would not leave.

        Args:
            observed: what the data look like.
            joints: 0-based joints that the effect is tried on.
        """
        return [{p.name: p.clip(p.typical) for p in self.parameters if p.fitted}]

    def check(self, spec: EffectSpec, robot: Robot) -> None:
        """Raise BadInputError where the values do not fit this robot."""
        if self.stage == "body" and robot.body is None:
            raise BadInputError(f"effect {self.name}: robot {robot.name} has no body")

    def applies_to(self, robot: Robot) -> bool:
        """Whether this robot can show it at all."""
        return self.stage != "body" or robot.body is not None

    def parameter(self, name: str) -> Parameter:
        """
        Raises:
            BadInputError: it has no such parameter; the line lists those it has.
        """
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise BadInputError(f"effect {self.name}: has no parameter {name!r}; {self.usage}")

    @property
    def usage(self) -> str:
        """Its parameters and bounds, for an error line."""
        shown = [f"{p.name} ({p.bounds_text})" for p in self.parameters]
        if self.per_joint:
            shown.append("joints (as in 3+4)")
        return "it takes " + ", ".join(shown) if shown else "it takes no parameters"


def knows_load(robot: Robot) -> bool:
    """Whether the torque on the servos can be computed: there is a body, or an arm on the bench."""
    return robot.body is not None or "arm" in (robot.servo.model_extra or {})


@dataclass(frozen=True)
class Affine:
    """A sensor filter that reads ``gain * angle + offset_rad``, (joints,) each."""

    gain: Vector = field(default_factory=lambda: np.ones(1))
    offset_rad: Vector = field(default_factory=lambda: np.zeros(1))

    def online(self, t_s: float, angle_rad: Vector, rng: np.random.Generator) -> Vector:
        return self.gain * angle_rad + self.offset_rad

    def batch(self, t_s: Vector, angle_rad: Vector) -> Vector:
        return self.gain * angle_rad + self.offset_rad

    def variance_rad2(self, t_s: Vector) -> Vector | float:
        return 0.0


def on_joints(
    values: float | tuple[float, ...], joints: tuple[int, ...], count: int, neutral: float
) -> Vector:
    """(count,) array that is ``values`` on ``joints`` and ``neutral`` elsewhere."""
    row = np.full(count, neutral)
    row[list(joints)] = values
    return row
