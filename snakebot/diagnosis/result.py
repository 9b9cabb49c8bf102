"""What a diagnosis says: the types behind schema ``snakebot.diagnosis/1``.

Beside the keys of the contract a few more stand in the file (``motion`` of a proposed experiment, ``details`` of the
gap by joint and regime); readers may ignore them.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

SCHEMA = "snakebot.diagnosis/1"

Verdict = Literal["explained", "no_gap", "unexplained"]
Stage = Literal["link", "servo", "sensor", "body", "none"]
Share = Annotated[float, Field(ge=0, le=1)]
Interval = tuple[float, float]
PerJoint = tuple[int, ...]  # 1-based


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", serialize_by_alias=True)


class StageShares(_Part):
    """Share of the gap that each stage of the signal path brings in; the four add up to one, or are all zero."""

    link: Share = 0.0
    servo: Share = 0.0
    sensor: Share = 0.0
    body: Share = 0.0

    def largest(self) -> Stage:
        values = {"link": self.link, "servo": self.servo, "sensor": self.sensor, "body": self.body}
        name = max(values, key=lambda key: values[key])
        return name if values[name] > 0 else "none"  # type: ignore[return-value]


class Where(_Part):
    """Where the gap lies."""

    stage: Stage
    stage_shares: StageShares
    joints: PerJoint
    joint_shares: tuple[Share, ...]
    regime: str


class Estimate(_Part):
    """A parameter with its 95 % interval. ``fixed`` when the user gave it."""

    estimate: float
    ci95: Interval | None
    unit: str = ""
    fixed: bool = False
    reason: str | None = None  # why there is no interval


class Cause(_Part):
    """One effect that earns its place on data it was not fitted on.

    ``probability`` is that of the whole group: the effect named, or one of ``indistinguishable_from``.
    """

    effect: str
    joints: PerJoint
    stage: Stage
    probability: Share
    parameters: dict[str, Estimate]
    indistinguishable_from: tuple[str, ...] = ()
    closure_alone: float | None = None
    specification: str  # in the grammar of --effect
    evidence: dict[str, float] = {}  # what the probability was made of, see ``probability``


class RankingEntry(_Part):
    """One explanation that was tried. ``delta`` is its held-out score below the best one's, with standard error."""

    effects: tuple[str, ...]
    joints: PerJoint
    held_out_score: float
    delta: float
    delta_se: float
    probability: Share


class AngleClosure(_Part):
    """How far the gap shrinks on runs no parameter was fitted to: closed = (before^2 - after^2) / (before^2 -
    floor^2). Where no run is held out, ``closed`` is null and before and after are of the runs that were fitted.
    """

    unit: Literal["rad"] = "rad"
    rms_before: float
    rms_after: float
    rms_floor: float | None
    closed: float | None
    ci95: Interval | None = None
    reason: str | None = None  # why `closed` is null, or `floor` is


class SpeedClosure(_Part):
    """The same for the forward speed, root mean square over runs."""

    unit: Literal["m/s"] = "m/s"
    error_before: float
    error_after: float
    floor: float | None
    closed: float | None
    ci95: Interval | None = None
    reason: str | None = None


class ClosureStep(_Part):
    """Closure of the joint angle after this effect was added to the ones before it."""

    effect: str
    joints: PerJoint
    joint_angle_closed: float | None
    forward_speed_closed: float | None


class Closure(_Part):
    held_out_runs: tuple[str, ...]
    joint_angle: AngleClosure
    forward_speed: SpeedClosure | None
    steps: tuple[ClosureStep, ...] = ()


class Unexplained(_Part):
    """The rest after the best explanation, as a share of the gap (mean squares above the floor)."""

    share: float
    where: str
    significant: bool


class GaitDegrees(_Part):
    alpha_deg: float
    beta_deg: float
    omega_rad_s: float
    offset_deg: float = 0.0


class NextExperiment(_Part):
    """The motion that best separates what is still open: either ``gait`` or ``probe`` (as after ``--probe``).

    ``lifted``: off the ground. ``separates``: pairs that it tells apart.
    """

    gait: GaitDegrees | None
    probe: str | None = None
    lifted: bool = False
    duration_s: float
    ramp_s: float
    motion: str
    separates: tuple[tuple[str, ...], ...]
    expected_probability_after: Share
    reason: str
    command: str


class Regime(_Part):
    """The gap before and after in one regime (a bin of speed, load, time ...)."""

    axis: str
    bin: str
    rms_before_rad: float
    rms_after_rad: float
    samples: int


class Trace(_Part):
    """A run, held out where any is, for pictures: at most a few hundred samples of the worst joint."""

    run: str
    joint: int
    t_s: tuple[float, ...]
    command_rad: tuple[float | None, ...]
    measured_rad: tuple[float | None, ...]
    before_rad: tuple[float | None, ...]
    after_rad: tuple[float | None, ...]


class FitEntry(_Part):
    """One effect alone as fitted to all free runs: for those who would choose by other rules."""

    effects: tuple[str, ...]
    joints: tuple[int, ...]
    parameters: int
    cost: float  # sum over blocks of samples x 1/2 log(1 + mean square / allowed)
    samples: int


class Details(_Part):
    """Beyond the contract: what the report draws."""

    floor_rad: tuple[float | None, ...]  # a joint
    gap_rms_rad: tuple[float, ...]  # a joint, before
    rest_rms_rad: tuple[float, ...]  # a joint, after
    regimes: tuple[Regime, ...] = ()
    traces: tuple[Trace, ...] = ()
    known: dict[str, float] = {}
    seed: int = 0
    timing_s: dict[str, float] = {}
    fits: tuple[FitEntry, ...] = ()


class Diagnosis(_Part):
    """The verdict on a session."""

    schema_: Literal["snakebot.diagnosis/1"] = Field(default="snakebot.diagnosis/1", alias="schema")
    verdict: Verdict
    where: Where
    causes: tuple[Cause, ...]
    ranking: tuple[RankingEntry, ...]
    closure: Closure
    unexplained: Unexplained
    next_experiment: NextExperiment | None
    warnings: tuple[str, ...] = ()
    details: Details | None = None

    def to_mapping(self) -> dict[str, Any]:
        """Plain types in the contract's order, ready for JSON. Timing is left out: same input, same file."""
        data: dict[str, Any] = self.model_dump(mode="json", by_alias=True)
        if data.get("details"):
            data["details"].pop("timing_s", None)
        return data


def json_schema() -> dict[str, Any]:
    """The JSON Schema of ``to_mapping()``; published as ``diagnosis-1.schema.json`` beside this file."""
    schema = Diagnosis.model_json_schema(by_alias=True, mode="serialization")
    schema["$id"] = SCHEMA
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    return schema
