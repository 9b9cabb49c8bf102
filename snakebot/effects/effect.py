"""What every effect is made of. An effect is one file: see docs/add-an-effect.md."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Literal, NamedTuple, Protocol

import numpy as np

from snakebot.arrays import Floats, Ints
from snakebot.effects.parameter import Parameter
from snakebot.errors import BadInputError
from snakebot.nearest import did_you_mean
from snakebot.physics.servo_layout import TIME_GRAIN_S

if TYPE_CHECKING:
    from snakebot.effects.ground import Ground
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Recorded, Robot

Stage = Literal["link", "servo", "sensor", "body"]
STAGES: tuple[Stage, ...] = ("link", "servo", "sensor", "body")
Start = dict[str, float | tuple[float, ...]]
Moment = Literal["mean", "scatter"]


# Share of the usual load (root mean square), below which a servo holds nothing; chosen: under a load that goes as a
# sine it is then at its limit for nine tenths of the time.
NO_TORQUE = 0.2


class Usual(NamedTuple):
    """What servos usually bear and how fast joints usually turn: root mean squares; 0 where that is not known."""

    load_nm: float
    rate_rad_s: float

    def is_no_torque(self, torque_nm: float) -> bool:
        """Whether a servo that gives so much at most holds next to nothing of what servos usually bear."""
        return torque_nm < NO_TORQUE * self.load_nm


class Setting(NamedTuple):
    """An effect as the data show it directly: 1-based joints, and the values of its parameters."""

    joints: tuple[int, ...]
    values: Start


@dataclass(frozen=True)
class Track:
    """Set-points and when each comes into force: what leaves the link and enters the servos.

    Attributes:
        time_s: (M,) not falling.
        setpoint_rad: (M, joints); NaN: servo off.
        variance_rad2: (M, joints), of a set-point that chance decides on (loss): ``setpoint_rad`` is then the mean.
        late_s: (joints,) how much later than ``time_s`` each joint gets it; None: all at once.
    """

    time_s: Floats
    setpoint_rad: Floats
    variance_rad2: Floats | None = None
    late_s: Floats | None = None

    def of_one_clock(self) -> Track:
        """The same with a row for every time at which some joint gets a set-point, so that no joint is late."""
        if self.late_s is None:
            return self
        times = np.unique((self.time_s[:, None] + self.late_s).ravel())
        rows = np.stack([self.rows_at(times, j) for j in range(self.late_s.size)], axis=1)
        columns = np.arange(self.late_s.size)
        variance = None if self.variance_rad2 is None else self.variance_rad2[rows, columns]
        return Track(times, self.setpoint_rad[rows, columns], variance)

    def rows_at(self, t_s: Floats, joint: int) -> Ints:
        """(T,) number of the set-point that is in force for a joint (0-based) from each time on."""
        late = 0.0 if self.late_s is None else self.late_s[joint]
        rows = np.searchsorted(self.time_s + late, t_s + TIME_GRAIN_S, side="right") - 1
        return np.asarray(np.maximum(rows, 0))


class LinkFilter(Protocol):
    """What becomes of set-points on their way. One object serves one board or one run; it may keep state."""

    def online(
        self, t_s: float, setpoint_rad: Floats, rng: np.random.Generator
    ) -> tuple[float, Floats] | None:
        """When and as what a set-point that arrives at ``t_s`` comes into force; None: never. Not before ``t_s``."""

    def batch(self, track: Track) -> Track:
        """The same for a whole run, in the mean over what chance decides."""


class ServoFilter(Protocol):
    """A state that a servo has beside those of the compiled kernel: what drives it lags, sticks or drifts.

    It stands between the set-points in force and the kernel. One object serves one board or one run.
    """

    def follow(self, t_s: Floats, setpoint_rad: Floats) -> Floats:
        """What drives the servos (N, joints) at times (N,) of set-points (N, joints) in force; NaN: servo off.

        Times are whole steps of ``stages.FILTER_STEP_S``, and go on where the call before ended: a board asks for some
        at a time, a whole run for all at once. At the first row of the first call the robot has been at rest for long.
        """


class SensorFilter(Protocol):
    """What becomes of joint angles on their way to the reading, before the encoder's counts."""

    def online(self, t_s: float, angle_rad: Floats, rng: np.random.Generator) -> Floats:
        """Reading (joints,) of joint angles (joints,) at one time; times do not fall from call to call."""

    def batch(self, t_s: Floats, angle_rad: Floats) -> Floats:
        """Mean reading (T, joints) of joint angles (T, joints)."""

    def variance_rad2(self, t_s: Floats) -> Floats | float:
        """Variance (T, joints) about that mean."""


class Effect:
    """Base of every effect: override what the effect touches, and nothing else.

    Attributes:
        name: as in ``--effect``, reports and file names.
        example: after ``--effect``, clearly visible on the six-link robot.
        example_robot: the description (YAML) of another robot, where the six-link one cannot have the example.
        stage: where in the signal it sits.
        summary: one sentence: what is different from the nominal robot.
        title: what it is called in a lab: "play in the gear".
        sentence: what is said of a robot that has it, see ``telling``.
        look: what to look at on the robot, for somebody with a screwdriver.
        mark: what it leaves in the data, so that a user can recognise it.
        confused_with: effects that leave nearly the same mark, and what tells each apart.
        parameters: in the order in which they are written.
        per_joint: whether it may hold for some joints only.
        covers: of the nominal robot's "delay" and "friction", what it sets itself, so that a fit needs no tolerance.
        shows_in: where a fit can see it: in the mean of the readings, in how they scatter, or in both.
        everyday: every real joint has a little of it, so that it may be one of many small causes at once.
        followed: how many of its ``starts`` a fit follows to the end. More than one where there are side valleys: then
            all are followed for some steps, and none are added.
        is_read_off: nothing is fitted; ``read_off`` says what the data show.
        fault: what ``--fault`` calls a joint with it, that follows no set-point any more: free, rigid; empty: it can.
    """

    name: ClassVar[str]
    example: ClassVar[str]
    example_robot: ClassVar[str] = ""
    stage: ClassVar[Stage]
    summary: ClassVar[str]
    title: ClassVar[str] = ""
    sentence: ClassVar[str] = ""
    look: ClassVar[str] = ""
    mark: ClassVar[str]
    confused_with: ClassVar[tuple[tuple[str, str], ...]] = ()
    parameters: ClassVar[tuple[Parameter, ...]] = ()
    per_joint: ClassVar[bool] = True
    covers: ClassVar[frozenset[str]] = frozenset()
    shows_in: ClassVar[frozenset[Moment]] = frozenset({"mean"})
    everyday: ClassVar[bool] = False
    followed: ClassVar[int] = 1
    is_read_off: ClassVar[bool] = False
    fault: ClassVar[str] = ""

    def write_servo(self, rows: Floats, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
        """Write into the servo's rows (joints, PARAMETERS) of ``physics.servo_layout``, for the 0-based ``joints``."""

    def link_filter(self, spec: EffectSpec, robot: Robot) -> LinkFilter | None:
        """A filter on set-points, for one run."""
        return None

    def late_s(self, spec: EffectSpec) -> float:
        """How much later than the others the joints that it holds for get their set-points."""
        return 0.0

    def servo_filter(self, spec: EffectSpec, robot: Robot) -> ServoFilter | None:
        """A state of its own in front of the servo's kernel, for one run."""
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

    def variants(self, start: Start) -> list[Start]:
        """Parameters that a fit holds while it fits the others: each a way in which the effect may be there.

        By default the whole numbers of a start (which link), as they stand there. For effects of the body.
        """
        whole = {p.name for p in self.parameters if p.integer}
        return [{name: value for name, value in start.items() if name in whole}]

    def held(self, observed: Observed) -> Start:
        """Parameters that a fit leaves at these values: no fit could tell of them, or the data show them directly."""
        return {}

    def lacks(self, robot: Robot) -> str | None:
        """What the robot's description lacks for the values of this effect to be in their units, for a warning."""
        return None

    def read_off(self, observed: Observed) -> Setting | None:
        """The effect as the data show it without a fit; None where they show none. Only asked if ``is_read_off``."""
        return None

    def can_explain(self, observed: Observed) -> bool:
        """Whether a diagnosis of these data should try it, where the robot can show it at all."""
        return True

    def plainer(self, values: Mapping[str, float], usual: Usual) -> tuple[str, Start] | None:
        """The plainer effect that this one, with these values, is just another word for, and where to start its fit;
        or None.

        Args:
            values: of its parameters, fitted or known.
            usual: load and speed of the robot's joints in these data.
        """
        return None

    def said(self, values: Mapping[str, float | tuple[float, ...]]) -> str:
        """``sentence`` as it suits these values of the parameters, see ``telling``."""
        return self.sentence

    def shown_on(self, values: Mapping[str, float | tuple[float, ...]]) -> tuple[int, ...]:
        """Links of the body (1-based, from the tail) that it sits on, to be marked in a drawing."""
        link = values.get("link") if self.stage == "body" else None
        return () if link is None or isinstance(link, tuple) else (round(link),)

    def clock_ppm(self, spec: EffectSpec) -> float:
        """By how much the board's own clock is off under it."""
        return 0.0

    def fault_values(self, angle_rad: float) -> dict[str, float]:
        """Its parameters where a joint has its ``fault`` at an angle. Only asked if it is one."""
        return {}

    def fault_angle_rad(self, spec: EffectSpec) -> float:
        """The angle at which a joint has its ``fault``; 0 where no angle belongs to it."""
        return 0.0

    def at_most(self, recorded: Recorded, rows: Floats) -> Mapping[str, Floats]:
        """Its parameters (joints,) on servos that can do no more than was recorded of them; empty: it bounds nothing.

        Args:
            rows: of ``physics.servo_layout``, as the robot has them.
        """
        return {}

    def outside_mjcf(self, spec: EffectSpec) -> str:
        """What whoever steps an exported MuJoCo model does, where a filter of this effect is more than a delay, a gain,
        an offset or noise, and MJCF cannot say it.
        """
        return "a filter that is written in Python"

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
        names = [p.name for p in self.parameters] + ["joints"] * self.per_joint
        hint = did_you_mean(name, names)
        raise BadInputError(
            f"effect {self.name}: has no parameter {name!r}{hint + ' ' if hint else '; '}{self.usage}"
        )

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

    gain: Floats = field(default_factory=lambda: np.ones(1))
    offset_rad: Floats = field(default_factory=lambda: np.zeros(1))

    def online(self, t_s: float, angle_rad: Floats, rng: np.random.Generator) -> Floats:
        return self.gain * angle_rad + self.offset_rad

    def batch(self, t_s: Floats, angle_rad: Floats) -> Floats:
        return self.gain * angle_rad + self.offset_rad

    def variance_rad2(self, t_s: Floats) -> Floats | float:
        return 0.0


def on_joints(
    values: float | tuple[float, ...], joints: tuple[int, ...], count: int, neutral: float
) -> Floats:
    """(count,) array that is ``values`` on ``joints`` and ``neutral`` elsewhere."""
    row = np.full(count, neutral)
    row[list(joints)] = values
    return row
