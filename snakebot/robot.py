"""Robot description: what the simulation knows about one robot, loaded from YAML and checked.

A description is read from ``configs/robots/*.yaml`` or from the ``robot:`` part of a session folder. A robot without a
body (``joints: 5`` in place of ``links``, ``half_length_m``, ...) is a bench of servos: it has joints and encoders, but
no ground under it.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from snakebot.errors import BadInputError
from snakebot.nearest import misspelt, not_known
from snakebot.resources import DEFAULT_ROBOT, config_path, configs_root
from snakebot.safe_yaml import NO_LINES, Lines, dump_yaml, load_yaml

MAX_LINKS = 32  # of a chain; chosen: the protocol carries 16 joints
LAG_TOLERANCE = 0.06  # of the nominal time constant, where nothing is stated; chosen
ITS_FILE = "ROBOT.yaml"  # in commands, of a robot whose description only its owner has
# Name of the servos' lag wherever a number of a description is named: provenance, ``Diagnosis.nominal``, ranges.
SERVO_LAG = "servo.time_constant_s"

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
PerLink = tuple[NonNegative, ...]


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=False)


class Friction(_Model):
    """Ground friction coefficients of one link, in its own tangential (t) and normal (n) axes (eq. 25).

    ``contact`` is ``point`` for wheels (21)-(22) and ``distributed`` for a body that lies on the ground (11)-(12),
    which adds the friction torque -(cn J / m) theta_dot. Each coefficient is one number for all links or one a link.
    """

    ct: float | PerLink  # N s/m
    cn: float | PerLink  # N s/m
    ct0: float | PerLink = 0.0  # N
    cn0: float | PerLink = 0.0  # N
    contact: Literal["point", "distributed"] = "point"

    @field_validator("ct", "cn", "ct0", "cn0")
    @classmethod
    def _not_negative(cls, value: float | PerLink) -> float | PerLink:
        if isinstance(value, float) and not (0 <= value < math.inf):
            raise ValueError("must be a finite number, zero or more")
        return value


class Servo(BaseModel):
    """Nominal position servo of a joint. Keys that are not known here are kept (``extra``), not refused."""

    model_config = ConfigDict(frozen=True, extra="allow")

    time_constant_s: NonNegative = 0.03  # first-order lag from set-point to joint angle


class Limits(_Model):
    """What a joint may be asked to do. One number for all joints or one a joint."""

    angle_deg: Positive | tuple[Positive, ...] = 95.0
    speed_rad_s: Positive | tuple[Positive, ...] = 8.0
    acceleration_rad_s2: Positive | tuple[Positive, ...] = 60.0


class Tolerance(_Model):
    """How well the stated numbers are known: one standard deviation of each, of a normal distribution."""

    time_constant_s: NonNegative | None = None  # of each servo; None: ``LAG_TOLERANCE`` of it
    delay_s: NonNegative = 1e-3  # of the wire and of the two clocks; chosen
    friction: NonNegative = 0.05  # relative; chosen
    mass: NonNegative = 0.03  # relative; chosen
    # Of the simulated forward speed, m/s: what a calibration left on runs that it was not fitted to. None: not known.
    speed_m_s: NonNegative | None = None
    speed_share: NonNegative | None = (
        None  # the same over the speed that was measured: what a faster gait may be off
    )

    def left_of_speed_m_s(self, speed_m_s: float) -> float:
        """Standard deviation of the error of a simulated speed that a calibration left. A wrong friction is off by a
        share of the speed, a slip or a wrong pose by as much at any speed: whichever is more.
        """
        return max(self.speed_m_s or 0.0, (self.speed_share or 0.0) * abs(speed_m_s))


class JointServo(_Model):
    """The bus servo of one joint. Which models there are, and what each does by itself, is known to ``servobus``."""

    id: Annotated[int, Field(ge=0, le=252)]
    model: str | None = None  # None: whatever answers
    direction: Literal[1, -1] = 1  # -1: a larger count turns the joint to a smaller angle
    zero_counts: Annotated[int, Field(ge=-(1 << 20), le=1 << 20)] | None = (
        None  # joint straight; None: the middle
    )
    torque_limit: Annotated[float, Field(gt=0, le=1)] = 1.0  # share of what it can


class Provenance(_Model):
    """Where a number comes from, and how far it can be trusted.

    ``ci95``: of an effect's parameters, each with its 95 % interval; where each joint has a value, as many intervals,
    None for one that is not known.
    """

    status: Literal["measured", "paper", "inferred", "assumed", "fitted"]
    source: str


class Interval(_Model):
    """How well a fitted number is known: its 95 % interval, as ``snakebot diagnose --apply`` found it."""

    number: Annotated[str, Field(pattern=r"^effects\.\w+\.\w+$")]  # effects.rate_limit.limit_rad_s
    joints: tuple[
        Annotated[int, Field(ge=1, le=MAX_LINKS - 1)], ...
    ] = ()  # 1-based; none: all that it acts on
    estimate: Annotated[float, Field(allow_inf_nan=False)]
    ci95: tuple[float, float] | None  # None: the recordings do not constrain it

    @model_validator(mode="after")
    def _ends_in_order(self) -> Interval:
        if self.ci95 is not None and not -math.inf < self.ci95[0] <= self.estimate <= self.ci95[1] < math.inf:
            raise ValueError(
                f"ci95 {self.ci95} of {self.number} does not hold its estimate {self.estimate:g}"
            )
        return self


class Recorded(_Model):
    """How far the recordings went that the description was calibrated on: what a joint does beyond, nobody has seen.

    ``torque_nm`` is that of the calibrated simulation on these recordings, None without a body.
    """

    omega_rad_s: Positive | None = None  # of the fastest gait; None: there was none
    joint_speed_rad_s: tuple[NonNegative, ...]  # one a joint, asked for
    torque_nm: tuple[NonNegative, ...] | None = None  # one a joint


class Body(_Model):
    """The chain of rigid links: n links of half length l, mass m each, inertia J = m l^2 / 3 about the centre."""

    links: Annotated[int, Field(ge=2, le=MAX_LINKS, strict=True)]  # "08" in YAML is text
    half_length_m: Positive
    link_mass_kg: Positive | tuple[Positive, ...]
    friction: Friction
    slope_deg: Annotated[float, Field(ge=-45, le=45)] = 0.0  # ground rises along +x by this angle

    @model_validator(mode="after")
    def _one_a_link(self) -> Body:
        for name, value in (
            ("link_mass_kg", self.link_mass_kg),
            *((f"friction.{k}", getattr(self.friction, k)) for k in ("ct", "cn", "ct0", "cn0")),
        ):
            if isinstance(value, tuple) and len(value) != self.links:
                raise ValueError(f"{name} has {len(value)} values for {self.links} links")
        return self


_SERVO_KEYS = ("time_constant_s", "arm")  # those that something here reads
_MISSPELT = 0.85  # how like a known key one must be that is not kept as another program's: a letter or two
_BODY_KEYS = ("links", "half_length_m", "link_mass_kg", "friction", "slope_deg")


class Robot(_Model):
    """One robot. ``joints`` is ``body.links - 1``, or given for a bench without a body."""

    name: str = "robot"
    joints: Annotated[int, Field(ge=1, le=MAX_LINKS - 1)]
    body: Body | None = None
    servo: Servo = Servo()
    tolerance: Tolerance = Tolerance()
    encoder_counts_per_rev: Annotated[int, Field(ge=16, le=1 << 20)] = 8192
    limits: Limits = Limits()
    servos: tuple[JointServo, ...] | None = None  # one a joint, in the order of the chain
    effects: tuple[str, ...] = ()  # in the grammar of --effect; part of this robot's simulation
    intervals: tuple[Interval, ...] = ()  # of the numbers in ``effects``
    recorded: Recorded | None = None  # as ``snakebot diagnose --apply`` found it
    provenance: Mapping[str, Provenance] = {}

    @model_validator(mode="before")
    @classmethod
    def _gather_body(cls, data: Any) -> Any:
        """The file keeps the body's keys flat beside the others, as session.yaml does."""
        if not isinstance(data, Mapping) or "body" in data:
            return data
        data = dict(data)
        data.pop("schema", None)
        flat = {key: data.pop(key) for key in _BODY_KEYS if key in data}
        if flat:
            data["body"] = flat
            links = flat.get("links")
            if isinstance(links, int) and data.setdefault("joints", links - 1) != links - 1:
                raise ValueError(f"joints is {data['joints']}, but {links} links have {links - 1}")
            if not (isinstance(links, int) and 2 <= links <= MAX_LINKS):
                data["joints"] = 1  # the fault is the number of links: let that be the one that is reported
        elif "joints" not in data:
            raise ValueError("needs either 'links' with a body, or 'joints' for a bench without one")
        return data

    @model_validator(mode="after")
    def _one_a_joint(self) -> Robot:
        for key in ("angle_deg", "speed_rad_s", "acceleration_rad_s2"):
            value = getattr(self.limits, key)
            if isinstance(value, tuple) and len(value) != self.joints:
                raise ValueError(f"limits.{key} has {len(value)} values for {self.joints} joints")
        return self

    @model_validator(mode="after")
    def _one_servo_a_joint(self) -> Robot:
        if self.servos is not None:
            if len(self.servos) != self.joints:
                raise ValueError(f"servos has {len(self.servos)} entries for {self.joints} joints")
            ids = [servo.id for servo in self.servos]
            twice = sorted({number for number in ids if ids.count(number) > 1})
            if twice:
                raise ValueError(f"servos has the id {twice[0]} twice")
        return self

    @model_validator(mode="after")
    def _one_recorded_a_joint(self) -> Robot:
        for key in ("joint_speed_rad_s", "torque_nm"):
            value = None if self.recorded is None else getattr(self.recorded, key)
            if value is not None and len(value) != self.joints:
                raise ValueError(f"recorded.{key} has {len(value)} values for {self.joints} joints")
        return self

    @property
    def angle_limit_rad(self) -> tuple[float, ...]:
        """Largest angle either side of zero, a joint."""
        return tuple(math.radians(v) for v in _spread(self.limits.angle_deg, self.joints))

    @property
    def speed_limit_rad_s(self) -> tuple[float, ...]:
        return _spread(self.limits.speed_rad_s, self.joints)

    @property
    def acceleration_limit_rad_s2(self) -> tuple[float, ...]:
        return _spread(self.limits.acceleration_rad_s2, self.joints)

    @property
    def lag_spread_s(self) -> float:
        """Standard deviation of a servo's time constant about the stated one."""
        stated = self.tolerance.time_constant_s
        return LAG_TOLERANCE * self.servo.time_constant_s if stated is None else stated

    @property
    def rad_per_count(self) -> float:
        return 2 * math.pi / self.encoder_counts_per_rev

    def to_mapping(self) -> dict[str, Any]:
        """The description as it stands in a file: flat, plain types, ready for YAML or JSON."""
        data = self.model_dump(mode="json")
        body = data.pop("body")
        if data["servos"] is None:
            del data["servos"]
        for left in ("speed_m_s", "speed_share"):
            if data["tolerance"][left] is None:
                del data["tolerance"][left]
        if not data["intervals"]:
            del data["intervals"]
        if data["recorded"] is None:
            del data["recorded"]
        if body is not None:
            data.pop("joints")
            data.update(body)
        return {"schema": SCHEMA, **data}

    def to_yaml(self) -> str:
        return dump_yaml(self.to_mapping())


SCHEMA = "snakebot.robot/1"


def _spread(value: float | tuple[float, ...], count: int) -> tuple[float, ...]:
    return value if isinstance(value, tuple) else (value,) * count


def robot_from_mapping(data: object, where: str, lines: Lines = NO_LINES) -> Robot:
    """Check a parsed description.

    Args:
        lines: of the document that it stands in.

    Raises:
        BadInputError: one line that names ``where``, the key and what is wrong with it.
    """
    if not isinstance(data, Mapping):
        raise BadInputError(f"{where}: a robot description is a mapping of keys to values")
    _check_keys(data, where, lines)
    schema = data.get("schema", SCHEMA)
    if schema != SCHEMA:
        raise BadInputError(f"{where}: schema is {schema!r}, this version reads {SCHEMA!r}")
    try:
        return Robot.model_validate(data)
    except ValidationError as error:
        raise BadInputError(f"{where}: {_first_fault(error, data, lines)}") from None


def _check_keys(data: Mapping[Any, Any], where: str, lines: Lines) -> None:
    """A misspelt key is the fault to tell, before those that come of it.

    Raises:
        BadInputError: a key that is not known; of the servo, which may have more, one that is nearly a known one.
    """
    parts: list[tuple[tuple[str, ...], Any, tuple[str, ...]]] = [
        ((), data, ("schema", *_BODY_KEYS, *Robot.model_fields)),
        (("friction",), data.get("friction"), tuple(Friction.model_fields)),
        (("limits",), data.get("limits"), tuple(Limits.model_fields)),
        (("recorded",), data.get("recorded"), tuple(Recorded.model_fields)),
        (("tolerance",), data.get("tolerance"), tuple(Tolerance.model_fields)),
    ]
    provenance = data.get("provenance")
    if isinstance(provenance, Mapping):
        known = tuple(Provenance.model_fields)
        parts += [(("provenance", str(name)), entry, known) for name, entry in provenance.items()]
    for path, part, known in parts:
        for key in part if isinstance(part, Mapping) else ():
            if key not in known:
                shown, owner = [name for name in known if name != "body"], ".".join(path) or "a robot"
                fault = not_known(key, shown, owner, above="".join(f"{name}." for name in path))
                raise BadInputError(f"{where}: {lines.of(*path, key)}{fault}")
    servo = data.get("servo")
    found = misspelt(servo, _SERVO_KEYS, _SERVO_KEYS, _MISSPELT) if isinstance(servo, Mapping) else None
    if found is not None:
        fault = not_known(found[0], _SERVO_KEYS, "servo", above="servo.")
        raise BadInputError(f"{where}: {lines.of('servo', found[0])}{fault}")


def _first_fault(error: ValidationError, data: Mapping[Any, Any], lines: Lines) -> str:
    faults = [(_place(fault["loc"], data), fault) for fault in error.errors()]
    places = [place for place, _ in faults]
    # A list that is no number, and one item of it that is none either: the item is the fault.
    told = [(p, fault) for p, fault in faults if not any(o[: len(p)] == p and o != p for o in places)]
    path, fault = told[0]
    key = ".".join(str(part) for part in path) or "description"
    given = fault.get("input")
    shown = f" (found {given!r})" if isinstance(given, (int, float, str, bool)) else ""
    others = len({place for place, _ in told}) - 1
    more = f"; and {others} more" if others else ""
    return f"{lines.of(*path)}{key}: {fault['msg'].removeprefix('Value error, ')}{shown}{more}"


def _place(location: tuple[int | str, ...], data: object) -> tuple[int | str, ...]:
    """Where a fault is, as the file has it: pydantic adds ``body``, and what kind of value it tried ("float")."""
    place: list[int | str] = []
    for part in location[location[:1] == ("body",) :]:
        if isinstance(data, Mapping):
            data = data.get(part)
        elif isinstance(data, Sequence) and not isinstance(data, str) and isinstance(part, int):
            data = data[part] if part < len(data) else None
        else:
            continue
        place.append(part)
    return tuple(place)


_RECORDINGS = (".mcap", ".mcap.part", ".csv", ".csv.gz", ".parquet")


def load_robot(source: str | Path) -> Robot:
    """Load a description from a YAML file, or by the bare name of one that comes with snakebot (``penn_state``).

    Raises:
        BadInputError: the file is missing, is not YAML, or describes no possible robot.
    """
    try:
        path = config_path("robots", source)
    except BadInputError:
        if os.path.isdir(source):
            raise _recordings(Path(source)) from None
        raise
    if path.name == "session.yaml" or path.name.endswith(_RECORDINGS):
        raise _recordings(path)
    try:
        text = path.read_bytes()
    except OSError as error:
        raise BadInputError(f"{path}: cannot read the robot description: {error.strerror}") from None
    return robot_from_mapping(load_yaml(text, str(path)), str(path), Lines(text))


def shipped_name(robot: Robot) -> str | None:
    """By which name commands know this description; None of one that does not come with snakebot."""
    for path in (configs_root() / "robots").glob("*.yaml"):
        if path.stem == robot.name:
            ours = load_robot(path).model_copy(update={"provenance": robot.provenance})
            return robot.name if ours == robot else None
    return None


def robot_option(robot: Robot) -> str:
    """What `snakebot run` needs to be of this robot, a space before it; nothing for the one that it takes by itself."""
    name = shipped_name(robot) or ITS_FILE
    return "" if name == DEFAULT_ROBOT else f" --robot {name}"


def _recordings(path: Path) -> BadInputError:
    return BadInputError(
        f"{path}: recordings, no robot description; `snakebot diagnose {path} --apply robot.yaml` writes one"
    )
