"""Robot description: what the simulation knows about one robot, loaded from YAML and checked.

A description is read from ``configs/robots/*.yaml`` or from the ``robot:`` part of a session folder. A robot without a
body (``joints: 5`` in place of ``links``, ``half_length_m``, ...) is a bench of servos: it has joints and encoders, but
no ground under it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from snakebot.errors import BadInputError
from snakebot.resources import config_path
from snakebot.safe_yaml import dump_yaml, load_yaml

MAX_LINKS = 32
MAX_WIRE_JOINTS = 16  # more joints can be simulated, but not driven over the protocol

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


class Provenance(_Model):
    """Where a number comes from, and how far it can be trusted."""

    status: Literal["measured", "paper", "inferred", "assumed", "fitted"]
    source: str


class Body(_Model):
    """The chain of rigid links: n links of half length l, mass m each, inertia J = m l^2 / 3 about the centre."""

    links: Annotated[int, Field(ge=2, le=MAX_LINKS)]
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


_BODY_KEYS = ("links", "half_length_m", "link_mass_kg", "friction", "slope_deg")


class Robot(_Model):
    """One robot. ``joints`` is ``body.links - 1``, or given for a bench without a body."""

    name: str = "robot"
    joints: Annotated[int, Field(ge=1, le=MAX_LINKS - 1)]
    body: Body | None = None
    servo: Servo = Servo()
    encoder_counts_per_rev: Annotated[int, Field(ge=16, le=1 << 20)] = 8192
    limits: Limits = Limits()
    effects: tuple[str, ...] = ()  # in the grammar of --effect; part of this robot's simulation
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
    def rad_per_count(self) -> float:
        return 2 * math.pi / self.encoder_counts_per_rev

    def to_mapping(self) -> dict[str, Any]:
        """The description as it stands in a file: flat, plain types, ready for YAML or JSON."""
        data = self.model_dump(mode="json")
        body = data.pop("body")
        if body is not None:
            data.pop("joints")
            data.update(body)
        return {"schema": SCHEMA, **data}

    def to_yaml(self) -> str:
        return dump_yaml(self.to_mapping())


SCHEMA = "snakebot.robot/1"


def _spread(value: float | tuple[float, ...], count: int) -> tuple[float, ...]:
    return value if isinstance(value, tuple) else (value,) * count


def robot_from_mapping(data: object, where: str) -> Robot:
    """Check a parsed description.

    Raises:
        BadInputError: one line that names ``where``, the key and what is wrong with it.
    """
    if not isinstance(data, Mapping):
        raise BadInputError(f"{where}: a robot description is a mapping of keys to values")
    schema = data.get("schema", SCHEMA)
    if schema != SCHEMA:
        raise BadInputError(f"{where}: schema is {schema!r}, this version reads {SCHEMA!r}")
    try:
        return Robot.model_validate(data)
    except ValidationError as error:
        raise BadInputError(f"{where}: {_first_fault(error)}") from None


def _first_fault(error: ValidationError) -> str:
    fault = error.errors()[0]
    key = ".".join(str(part) for part in fault["loc"] if part != "body") or "description"
    given = fault.get("input")
    shown = f" (found {given!r})" if isinstance(given, (int, float, str, bool)) else ""
    more = f"; and {error.error_count() - 1} more" if error.error_count() > 1 else ""
    return f"{key}: {fault['msg'].removeprefix('Value error, ')}{shown}{more}"


def load_robot(source: str | Path) -> Robot:
    """Load a description from a YAML file, or by the bare name of one that comes with snakebot (``penn_state``).

    Raises:
        BadInputError: the file is missing, is not YAML, or describes no possible robot.
    """
    path = config_path("robots", source)
    try:
        data = load_yaml(path.read_bytes(), str(path))
    except OSError as error:
        raise BadInputError(f"{path}: cannot read the robot description: {error.strerror}") from None
    return robot_from_mapping(data, str(path))
