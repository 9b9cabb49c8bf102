"""What a diagnosis says: the types behind schema ``snakebot.diagnosis/2``, which adds to ``snakebot.diagnosis/1``.

Beside the keys of the contract a few more are in the file (``motion`` of a proposed experiment, ``details`` of the
gap by joint and regime); readers may ignore them.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

SCHEMA, FIRST_SCHEMA = "snakebot.diagnosis/2", "snakebot.diagnosis/1"

Verdict = Literal["explained", "partly", "no_gap", "unexplained"]
GapStage = Literal["link", "servo", "sensor", "body", "none"]
Share = Annotated[float, Field(ge=0, le=1)]
ConfidenceInterval = tuple[float, float]
PerJoint = tuple[int, ...]  # 1-based


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", serialize_by_alias=True)


class StageShares(_Part):
    """Share of the gap that each stage of the signal path brings in; the four add up to one, or are all zero."""

    link: Share = 0.0
    servo: Share = 0.0
    sensor: Share = 0.0
    body: Share = 0.0

    def largest(self) -> GapStage:
        values = {"link": self.link, "servo": self.servo, "sensor": self.sensor, "body": self.body}
        name = max(values, key=lambda key: values[key])
        return name if values[name] > 0 else "none"  # type: ignore[return-value]


class RunEstimate(_Part):
    """A parameter as one run alone says it, everything else as all runs say."""

    run: str
    estimate: float
    ci95: ConfidenceInterval | None


class RunValues(_Part):
    """A parameter of an effect that differs from run to run.

    Attributes:
        unlike: the fewer runs, of those on either side of the clearest step from one value to the next.
        of_rest: share of the rest, on these joints, that goes with a value for each run.
    """

    effect: str
    parameter: str
    unit: str
    joints: PerJoint
    values: tuple[RunEstimate, ...]
    unlike: tuple[str, ...]
    of_rest: float


class Stretch(_Part):
    """A time in a run, from its first sample on, and the ``share`` of what is left of a joint that lies in it."""

    run: str
    joint: int  # 1-based
    begin_s: float
    end_s: float
    share: float


class Where(_Part):
    """Where the gap lies.

    Attributes:
        stage: the one that brings in most of it.
        stages: of all causes and of those that tie with them; ``stage`` alone where no cause is named.
        stages_in_words: "servo or sensor" where it is one of them, "servo and sensor" where it is both.
        runs: those that are unlike the others, see ``values``.
        values: what differs from run to run; null if nothing does.
        times: stretches of time that hold most of what is left over on a joint, if any do.
    """

    stage: GapStage
    stage_shares: StageShares
    joints: PerJoint
    joint_shares: tuple[Share, ...]
    regime: str
    stages: tuple[GapStage, ...] = ()
    stages_in_words: str = ""
    runs: tuple[str, ...] = ()
    values: RunValues | None = None
    times: tuple[Stretch, ...] = ()


class JointEstimate(_Part):
    """A parameter of one joint, where each has its own."""

    joint: int  # 1-based
    estimate: float
    ci95: ConfidenceInterval | None


class Estimate(_Part):
    """A parameter with its 95 % interval. ``fixed`` when the user gave it.

    Where each joint has its own, ``estimate`` is their mean, and ``by_joint`` has the values.
    """

    estimate: float
    ci95: ConfidenceInterval | None
    unit: str = ""
    fixed: bool = False
    reason: str | None = None  # why there is no interval
    by_joint: tuple[JointEstimate, ...] = ()


class Cause(_Part):
    """One effect that improves the prediction of data it was not fitted on.

    ``probability`` is that of the whole group: the effect named, or one of ``indistinguishable_from``.
    """

    effect: str
    joints: PerJoint
    stage: GapStage
    probability: Share
    parameters: dict[str, Estimate]
    indistinguishable_from: tuple[str, ...] = ()
    closure_alone: float | None = None
    specification: str  # in the grammar of --effect
    evidence: dict[str, float] = {}  # what the probability was made of, see ``probability``


class StatedNumber(_Part):
    """What the recordings say of a number that the robot's description states, with its tolerance (one standard
    deviation); ``joints`` is empty where it is of the whole robot.
    """

    number: str
    joints: PerJoint
    stated: float
    tolerance: float
    estimate: float
    ci95: ConfidenceInterval


class BudgetEntry(_Part):
    """What one cause carries of the gap ``of`` joint angles or motion over ground, by Shapley's value; with the rest
    all entries ``of`` one add up to one. null where a joint or a run has no gap.

    Attributes:
        cause: its place in ``causes``, from 0; null is the rest, which no cause accounts for.
    """

    cause: int | None
    of: Literal["joint_angle", "ground"]
    share: float
    ci95: ConfidenceInterval | None
    by_joint: tuple[float | None, ...] = ()
    by_run: dict[str, float | None] = {}


class RankingEntry(_Part):
    """One explanation that was tried. ``delta`` is its held-out score below the best one's, with standard error.

    Attributes:
        parameters: that were fitted.
        rms_after: rad, of the joint angles on the runs of ``closure``.
        worse_in: of those the runs in which it clearly does worse than the best one.
    """

    effects: tuple[str, ...]
    joints: PerJoint
    held_out_score: float
    delta: float
    delta_se: float
    probability: Share
    parameters: int | None = None
    rms_after: float | None = None
    worse_in: tuple[str, ...] = ()


class AngleClosure(_Part):
    """How far the gap shrinks on runs no parameter was fitted to: closed = (before^2 - after^2) / (before^2 -
    floor^2). Where no run is held out, ``closed`` is null and before and after are of the runs that were fitted.

    ``rms_within_tolerance`` is after, with the lags as far from those stated as is credible and the runs say;
    ``rms_before_within_tolerance`` is before, likewise. ``closed_beyond_tolerance`` is the same share of those two: of
    the gap that no tolerance accounts for, on which the verdict rests. null where ``closed`` is.
    """

    unit: Literal["rad"] = "rad"
    rms_before: float
    rms_after: float
    rms_before_within_tolerance: float | None = None
    rms_within_tolerance: float | None = None
    rms_floor: float | None
    closed: float | None
    closed_beyond_tolerance: float | None = None
    ci95: ConfidenceInterval | None = None
    reason: str | None = None  # why `closed` is null, or `floor` is


class JointClosure(_Part):
    """Before and after of one joint, on the same runs as ``AngleClosure``. rad. A joint that was not read has none."""

    joint: int  # 1-based
    rms_before: float
    rms_after: float
    rms_floor: float | None


class SpeedClosure(_Part):
    """The same for the forward speed, root mean square over runs."""

    unit: Literal["m/s"] = "m/s"
    error_before: float
    error_after: float
    rms_measured: float | None = None  # of the speed itself, on the same runs
    floor: float | None
    closed: float | None
    ci95: ConfidenceInterval | None = None
    reason: str | None = None


class GroundClosure(_Part):
    """The same for the motion over ground as a whole, forward, sideways and turning within a cycle, each against what
    noise and tolerance allow of it: of the gap beyond those, on which the verdict rests.
    """

    closed: float
    ci95: ConfidenceInterval | None = None


class ClosureStep(_Part):
    """Closure of the joint angle after this effect was added to the ones before it."""

    effect: str
    joints: PerJoint
    joint_angle_closed: float | None
    joint_angle_closed_beyond_tolerance: float | None = None
    forward_speed_closed: float | None


class Closure(_Part):
    held_out_runs: tuple[str, ...]
    joint_angle: AngleClosure
    forward_speed: SpeedClosure | None
    ground: GroundClosure | None = None
    by_joint: tuple[JointClosure, ...] = ()
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
    """A run, held out where any is, for pictures: at most a few hundred samples of the joint where ``cause`` (its place
    in ``causes``) shows best, or else of the worst joint. ``others_rad``: predicted with every cause but this one.
    """

    run: str
    joint: int
    t_s: tuple[float, ...]
    command_rad: tuple[float | None, ...]
    measured_rad: tuple[float | None, ...]
    before_rad: tuple[float | None, ...]
    after_rad: tuple[float | None, ...]
    cause: int | None = None
    others_rad: tuple[float | None, ...] = ()


class RunSpeed(_Part):
    """Steady forward speed of a run, m/s: measured, and simulated without and with the causes."""

    run: str
    measured: float
    before: float
    after: float


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
    speeds: tuple[RunSpeed, ...] = ()
    known: dict[str, float] = {}
    seed: int = 0
    timing_s: dict[str, float] = {}
    fits: tuple[FitEntry, ...] = ()
    slow_log: bool = False  # set-points between rows are guessed, and no cause is sure
    robot_option: str = (
        ""  # what commands need to be of this robot; empty for the one that they take by themselves
    )


class Diagnosis(_Part):
    """The verdict on a session."""

    schema_: Literal["snakebot.diagnosis/2"] = Field(default="snakebot.diagnosis/2", alias="schema")
    verdict: Verdict
    where: Where
    causes: tuple[Cause, ...]
    ranking: tuple[RankingEntry, ...]
    closure: Closure
    unexplained: Unexplained
    next_experiment: NextExperiment | None
    warnings: tuple[str, ...] = ()
    nominal: tuple[StatedNumber, ...] = ()
    budget: tuple[BudgetEntry, ...] = ()
    budget_rest: tuple[BudgetEntry, ...] = ()
    sentence: str = ""
    advice: str = ""
    details: Details | None = None

    def shares_of(self, of: str) -> tuple[BudgetEntry, ...]:
        """Of the gap of "joint_angle" or "ground": what each cause carries, then the rest."""
        return tuple(entry for entry in (*self.budget, *self.budget_rest) if entry.of == of)

    def to_mapping(self, *, first: bool = False) -> dict[str, Any]:
        """Plain types in the contract's order, ready for JSON. Timing is left out: same input, same file.

        Args:
            first: by schema 1: without ``partly`` (it says ``unexplained``) and all that schema 2 adds.
        """
        data: dict[str, Any] = self.model_dump(mode="json", by_alias=True)
        if data.get("details"):
            data["details"].pop("timing_s", None)
        if first:
            data["schema"] = FIRST_SCHEMA
            data["verdict"] = "unexplained" if self.verdict == "partly" else self.verdict
            for name in ("nominal", "budget", "budget_rest", "sentence", "advice"):
                del data[name]
            if data["closure"]["forward_speed"] is not None:
                del data["closure"]["forward_speed"]["rms_measured"]
            for name in ("rms_before_within_tolerance", "rms_within_tolerance", "closed_beyond_tolerance"):
                del data["closure"]["joint_angle"][name]
            for step in data["closure"]["steps"]:
                del step["joint_angle_closed_beyond_tolerance"]
            del data["closure"]["ground"]
            del data["closure"]["by_joint"]
            for name in ("stages", "stages_in_words", "runs", "values", "times"):
                del data["where"][name]
            for entry in data["ranking"]:
                del entry["parameters"], entry["rms_after"], entry["worse_in"]
            if data.get("details"):
                del data["details"]["slow_log"], data["details"]["robot_option"]
                for trace in data["details"]["traces"]:
                    del trace["cause"]
            for cause in data["causes"]:
                for estimate in cause["parameters"].values():
                    del estimate["by_joint"]
        return data


def json_schema() -> dict[str, Any]:
    """The JSON Schema of ``to_mapping()``; published as ``diagnosis-2.schema.json`` beside this file."""
    schema = Diagnosis.model_json_schema(by_alias=True, mode="serialization")
    schema["$id"] = SCHEMA
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    return schema
