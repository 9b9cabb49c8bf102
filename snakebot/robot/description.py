"""What the simulation knows about one robot.

A robot without a body (``joints: 5`` in place of ``links``, ``half_length_m``, ...) is a bench of servos: it has joints
and encoders, but no ground under it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from snakebot.safe_yaml import dump_yaml

SCHEMA = "snakebot.robot/1"
MAX_LINKS = 32  # of a chain; chosen: the protocol carries 16 joints
LAG_TOLERANCE = 0.06  # of the nominal time constant, where nothing is stated; chosen
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
    # Of what a lag changes, the share by which no servo is quite the first-order one that it is taken for; chosen.
    lag_shape: NonNegative = 0.02
    sag_rad_per_nm: NonNegative = 2e-3  # by which a sound servo gives way under load; chosen
    scatter_rad: NonNegative = 3.5e-3  # of a sound encoder's readings: 0.2 deg; chosen
    # Of a measured pose at best: of a camera above the robot; chosen. A treadmill's speed is no better known than by
    # how far such a pose goes in a second.
    pose_m: NonNegative = 1e-3
    heading_rad: NonNegative = 3e-3
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


BODY_KEYS = ("links", "half_length_m", "link_mass_kg", "friction", "slope_deg")


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
        flat = {key: data.pop(key) for key in BODY_KEYS if key in data}
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


def _spread(value: float | tuple[float, ...], count: int) -> tuple[float, ...]:
    return value if isinstance(value, tuple) else (value,) * count
