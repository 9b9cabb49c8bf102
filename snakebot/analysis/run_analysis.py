"""One run, all its figures."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from snakebot.analysis.channels import channel_doubts
from snakebot.analysis.faults import JointFaults, joint_faults
from snakebot.analysis.joints import JointAnalysis, analyze_joint
from snakebot.analysis.link_quality import LinkQuality, link_quality
from snakebot.analysis.power import dissipated_power, electrical_power, mean_power
from snakebot.analysis.prediction import (
    SteadyPrediction,
    fill_gaps,
    predict_angles,
    predict_fits,
    predict_gait,
)
from snakebot.analysis.sine import SineFit, estimate_omega
from snakebot.analysis.speed import Speed, forward_speed, speed_error_percent
from snakebot.analysis.steady import SteadyState, find_steady_state
from snakebot.arrays import Floats

if TYPE_CHECKING:
    from snakebot.gait import Gait
    from snakebot.physics.model import ChainModel
    from snakebot.robot import Robot
    from snakebot.runlog import Run

# Relative; chosen: the fitted frequency may differ so much from the stated one before it is told.
FREQUENCY_TOLERANCE = 0.02


@dataclass(frozen=True)
class Predictions:
    """What the nominal model says; ``None`` where it cannot say, with the reason in the run's warnings.

    ``ideal``: the gait (or the command's sines) tracked perfectly. ``sine_replay``: the least-squares sines
    of the measured angles. ``angle_replay``: the measured angles with their harmonics.
    ``angle_replay_speed_m_s``: for a motion that is not periodic, the measured angles sample by sample.
    """

    ideal: SteadyPrediction | None = None
    sine_replay: SteadyPrediction | None = None
    angle_replay: SteadyPrediction | None = None
    angle_replay_speed_m_s: float = math.nan


@dataclass(frozen=True)
class RunAnalysis:
    """Figures of one run. Angles in rad, speeds in m/s, powers in W; ``nan`` or ``None`` = not known.

    ``speed_m_s`` is the measured forward speed and ``speed_source`` where it is from: ``given`` (a number
    that came with the run: a treadmill, a stopwatch), ``pose`` (the recorded pose), or nothing.
    ``power_dissipated_w`` is from encoders and measured speed alone (Section IX); ``power_in_w`` that of
    the measured angles in the nominal model.
    """

    name: str
    run: Run
    robot: Robot
    omega_rad_s: float | None
    omega_source: str
    steady: SteadyState
    joints: tuple[JointAnalysis, ...]
    link: LinkQuality
    speed_m_s: float
    speed_source: str
    pose_speed: Speed | None
    predictions: Predictions
    power_in_w: float
    power_dissipated_w: float
    power_electrical_w: float
    faults: JointFaults
    warnings: tuple[str, ...] = field(default=())

    @property
    def gait(self) -> Gait | None:
        return self.run.gait

    @property
    def te(self) -> float:
        """TE of all joints together: root of the mean of their squares (37)."""
        values = np.array([joint.tracking.te for joint in self.joints])
        values = values[np.isfinite(values)]
        return float(np.sqrt(np.mean(values**2))) if len(values) else math.nan

    @property
    def speed_error_percent(self) -> float:
        """(36), against the ideal prediction."""
        ideal = self.predictions.ideal
        return speed_error_percent(self.speed_m_s, ideal.speed_m_s) if ideal else math.nan


def analyze_run(
    run: Run, robot: Robot, *, predict: bool = True, steady: SteadyState | None = None
) -> RunAnalysis:
    """Analyze one run of a robot; without a body all that needs the ground is left out.

    Args:
        predict: simulate the nominal robot too (a second or so for the first run, milliseconds for further
            ones).
    """
    warnings: list[str] = []
    if run.aborted:
        warnings.append(f"the run did not finish ({run.ended}): it enters no average")
    warnings += [doubt.text for doubt in channel_doubts(run, robot)]
    omega, source = _frequency(run, warnings)
    position = run.pose[:, :2] if run.pose is not None and np.isfinite(run.pose).any() else None
    steady = steady or find_steady_state(run.t_s, run.command_rad, run.measured_rad, omega, position)
    inside = steady.mask(run.t_s)
    amplitudes: list[float | None] = [None] * run.joints
    if run.gait is not None:
        amplitudes = [run.gait.alpha_rad * share for share in run.gait.of_joints(run.joints)]
    joints = tuple(
        analyze_joint(
            j + 1,
            run.t_s[inside],
            run.command_rad[inside, j],
            run.measured_rad[inside, j],
            omega,
            amplitudes[j],
        )
        for j in range(run.joints)
    )
    faults = joint_faults(run.metadata, run.joints)
    pose_speed = _pose_speed(run, steady, omega)
    speed, speed_source = math.nan, ""
    if run.forward_speed_m_s is not None:
        speed, speed_source = run.forward_speed_m_s, "given"
    elif pose_speed is not None:
        speed, speed_source = pose_speed.forward_m_s, "pose"
    predictions, dissipated = Predictions(), math.nan
    if predict and robot.body is not None:
        from snakebot.physics.model import ChainModel

        model = ChainModel.from_body(robot.body)
        predictions = _predict(run, model, omega, steady, joints, faults, warnings)
        dissipated = _dissipated(run, model, omega, steady, joints, speed)
    electrical = electrical_power(_floats(run.extra), run.joints)
    return RunAnalysis(
        name=run.name,
        run=run,
        robot=robot,
        omega_rad_s=omega,
        omega_source=source,
        steady=steady,
        joints=joints,
        link=link_quality(
            run.t_s,
            run.measured_rad,
            run.command_rad,
            run.applied_rad,
            run.extra.get("latency_s"),
            run.extra.get("late"),
        ),
        speed_m_s=speed,
        speed_source=speed_source,
        pose_speed=pose_speed,
        predictions=predictions,
        power_in_w=predictions.angle_replay.power_in_w if predictions.angle_replay else math.nan,
        power_dissipated_w=dissipated,
        power_electrical_w=mean_power(electrical[inside]) if electrical is not None else math.nan,
        faults=faults,
        warnings=tuple(warnings),
    )


def _frequency(run: Run, warnings: list[str]) -> tuple[float | None, str]:
    """The gait's frequency and where it is from; a gait that the command contradicts is not believed
    silently."""
    if len(run) < 2:
        return None, "unknown"
    found = estimate_omega(run.t_s, run.command_rad)
    if run.gait is None or not run.gait.omega_rad_s > 0:
        return found, "estimated from the command" if found is not None else "not periodic"
    stated = run.gait.omega_rad_s
    if found is not None and abs(found / stated - 1) > FREQUENCY_TOLERANCE:
        warnings.append(
            f"the gait says omega = {stated:.4g} rad/s, the command moves at {found:.4g} rad/s: the gait's is used"
        )
    return stated, "gait"


def _pose_speed(run: Run, steady: SteadyState, omega: float | None) -> Speed | None:
    if run.pose is None:
        return None
    period = 2 * math.pi / omega if omega else None
    return forward_speed(run.t_s, run.pose, steady.start_s, steady.end_s, period)


def _predict(
    run: Run,
    model: ChainModel,
    omega: float | None,
    steady: SteadyState,
    joints: tuple[JointAnalysis, ...],
    faults: JointFaults,
    warnings: list[str],
) -> Predictions:
    from snakebot.errors import BadInputError

    if faults.changed:
        warnings.append(
            "joint faults came or went in mid-run: the ideal prediction knows those from the start only"
        )
    try:
        if omega is None:
            return Predictions(
                angle_replay_speed_m_s=predict_angles(
                    model, run.t_s, run.measured_rad, steady.start_s, steady.end_s
                )
            )
        ideal = sine = rich = None
        commands = [joint.command for joint in joints]
        if run.gait is not None and run.gait.omega_rad_s > 0:
            ideal = predict_gait(model, run.gait, faults.free, faults.rigid_angle_rad)
        elif None not in commands:
            ideal = predict_fits(model, [fit for fit in commands if fit])
        measured = [joint.measured for joint in joints]
        if None not in measured:
            sine = predict_fits(model, [fit for fit in measured if fit])
            rich = predict_fits(model, _harmonic_fits(joints))
        else:
            lost = [joint.joint for joint in joints if joint.measured is None]
            warnings.append(f"no replay of the measured angles: joint {lost[0]} has too few samples")
        return Predictions(ideal, sine, rich)
    except BadInputError as error:
        warnings.append(f"no prediction: {error}")
        return Predictions()


def _harmonic_fits(joints: Sequence[JointAnalysis]) -> list[SineFit]:
    """The fit with harmonics of every joint, that of the sine alone where harmonics cannot be told; [] if any has
    none."""
    fits = [joint.harmonic_fit or joint.measured for joint in joints]
    return [fit for fit in fits if fit] if None not in fits else []


def _dissipated(
    run: Run,
    model: ChainModel,
    omega: float | None,
    steady: SteadyState,
    joints: Sequence[JointAnalysis],
    speed: float,
) -> float:
    """Mean over whole cycles; from the harmonics of the measured angles, so that encoder noise makes no
    velocity."""
    if not math.isfinite(speed):
        return math.nan
    if omega is None:
        inside = steady.mask(run.t_s)
        angle = fill_gaps(run.t_s[inside], run.measured_rad[inside])
        return (
            mean_power(dissipated_power(model, run.t_s[inside], angle, speed))
            if angle is not None
            else math.nan
        )
    fits = _harmonic_fits(joints)
    if not fits:
        return math.nan
    t = np.linspace(0, 4 * math.pi / omega, 401)
    angle = np.stack([fit.evaluate(t) for fit in fits], axis=1)
    return float(np.mean(dissipated_power(model, t, angle, speed)[:-1]))


def _floats(extra: Mapping[str, Any]) -> dict[str, Floats]:
    return {k: v.astype(np.float64) for k, v in extra.items() if np.issubdtype(v.dtype, np.number)}
