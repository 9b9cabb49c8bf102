"""A run beside its simulation: brought onto one clock, then taken apart joint by joint."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from snakebot.analysis.bodies import headed_pose
from snakebot.analysis.faults import joint_faults
from snakebot.analysis.joints import JointAnalysis
from snakebot.analysis.loading import Loaded
from snakebot.analysis.run_analysis import RunAnalysis, analyze_run
from snakebot.analysis.speed import speed_error_percent
from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.runlog.matching.shift import Shift, find_shift, shifted

if TYPE_CHECKING:
    from snakebot.robot import Robot
    from snakebot.runlog import Run

DIFFERENT_MOTION = 0.2  # misfit of the commands above which two runs are not one motion
OTHER_MOTION = 0.6  # of the commands: nothing can be compared
SAME_CLOCK = Shift(0.0, 0.0, 0.0, math.nan)


@dataclass(frozen=True)
class JointComparison:
    """Measured angle of the real joint minus that of the simulated one, over the common window.

    ``share`` is this joint's part of the summed squared difference. ``real`` and ``sim`` are the joint's figures in
    each, over the same window.
    """

    joint: int
    rms_rad: float
    max_rad: float
    mean_rad: float
    correlation: float
    share: float
    real: JointAnalysis
    sim: JointAnalysis


@dataclass(frozen=True)
class Comparison:
    """``sim`` is on the clock of ``real``: samples of ``real.run``, ``nan`` where the simulation has none."""

    real: RunAnalysis
    sim: RunAnalysis
    sim_source: str
    alignment: Shift
    aligned_by: str
    joints: tuple[JointComparison, ...]
    rms_rad: float
    speed_error_percent: float  # (36), the simulation is the prediction
    warnings: tuple[str, ...]


def compare(real: Loaded, sim: Loaded | None = None) -> Comparison:
    """Set a run beside a simulated one; without that, the nominal simulation is made from the run's own robot.

    Raises:
        BadInputError: the two have different numbers of joints, or nothing in them moves that could be aligned.
    """
    warnings: list[str] = []
    if sim is None:
        sim_run = simulate_nominal(real.run, real.robot)
        source, alignment, aligned_by = (
            "nominal simulation",
            SAME_CLOCK,
            "the simulation runs on the log's own times",
        )
    else:
        if sim.run.joints != real.run.joints:
            raise BadInputError(
                f"{sim.source}: has {sim.run.joints} joints, {real.source} has {real.run.joints}: not one robot"
            )
        alignment, aligned_by = _align(real, sim)
        if alignment.misfit > OTHER_MOTION and aligned_by == "commands":
            raise BadInputError(
                f"{real.source} and {sim.source} were told different motions: wherever they are aligned, "
                f"{100 * alignment.misfit:.0f} % of the commands' rms is left. Give two runs of one motion"
            )
        if alignment.misfit > DIFFERENT_MOTION:
            warnings.append(
                f"the two do not show one motion: after alignment by {aligned_by} "
                f"{100 * alignment.misfit:.0f} % of the rms is left"
            )
        sim_run, source = _on_clock_of(real.run, sim.run, alignment.shift_s), sim.run.name
    a = analyze_run(real.run, real.robot)
    b = analyze_run(sim_run, real.robot if sim is None else sim.robot, predict=False, steady=a.steady)
    inside = a.steady.mask(real.run.t_s)
    difference = real.run.measured_rad[inside] - sim_run.measured_rad[inside]
    squares = np.nansum(difference**2, axis=0)
    joints = tuple(
        _joint(j, difference, squares, real.run.measured_rad[inside], sim_run.measured_rad[inside], a, b)
        for j in range(real.run.joints)
    )
    known = np.isfinite(difference)
    if not known.any():
        raise BadInputError(f"{real.source}: run and simulation have no sample in common after alignment")
    return Comparison(
        real=a,
        sim=b,
        sim_source=source,
        alignment=alignment,
        aligned_by=aligned_by,
        joints=joints,
        rms_rad=float(np.sqrt(np.mean(difference[known] ** 2))),
        speed_error_percent=speed_error_percent(a.speed_m_s, b.speed_m_s),
        warnings=tuple(warnings),
    )


def simulate_nominal(run: Run, robot: Robot) -> Run:
    """The same commands at the same times, given to the robot's own description: its servos, its effects, and the joint
    faults that the run was made with from its start.
    """
    from snakebot.effects import predict

    pose = _first_pose(run)
    found = predict(
        robot,
        joint_faults(run.metadata, run.joints).effects(),
        run.t_s,
        run.command_rad,
        measured_rad=run.measured_rad,
        pose=pose,
        body=robot.body is not None,
    )
    motion = found.motion
    return replace(
        run,
        name=f"{run.name} (simulated)",
        measured_rad=np.asarray(found.encoder_rad, dtype=np.float64),
        applied_rad=None,
        pose=None if motion is None else np.column_stack([motion.com_m, motion.heading_rad]),
        forward_speed_m_s=None,
        extra={},
    )


def _align(real: Loaded, sim: Loaded) -> tuple[Shift, str]:
    for name in ("command", "measured"):
        a, b = (getattr(item.run, f"{name}_rad") for item in (real, sim))
        found = find_shift(real.run.t_s, a, sim.run.t_s, b)
        if found is not None:
            return found, "commands" if name == "command" else "measured angles"
    raise BadInputError(
        f"{real.source} and {sim.source}: no joint moves in both, so they cannot be aligned in time"
    )


def _on_clock_of(real: Run, sim: Run, shift_s: float) -> Run:
    """The simulated run, resampled at the real run's times."""

    def at(values: Floats) -> Floats:
        return shifted(real.t_s, sim.t_s, values, shift_s)

    return replace(
        sim,
        t_s=real.t_s,
        command_rad=at(sim.command_rad),
        measured_rad=at(sim.measured_rad),
        applied_rad=at(sim.applied_rad) if sim.applied_rad is not None else None,
        pose=at(sim.pose) if sim.pose is not None else None,
        extra={},
    )


def _joint(
    j: int, difference: Floats, squares: Floats, real: Floats, sim: Floats, a: RunAnalysis, b: RunAnalysis
) -> JointComparison:
    d = difference[:, j]
    known = np.isfinite(d)
    d, x, y = d[known], real[known, j], sim[known, j]
    spread = float(np.std(x) * np.std(y)) if len(d) else 0.0
    return JointComparison(
        joint=j + 1,
        rms_rad=float(np.sqrt(np.mean(d**2))) if len(d) else math.nan,
        max_rad=float(np.max(np.abs(d))) if len(d) else math.nan,
        mean_rad=float(np.mean(d)) if len(d) else math.nan,
        correlation=float(np.mean((x - x.mean()) * (y - y.mean())) / spread) if spread > 1e-12 else math.nan,
        share=float(squares[j] / squares.sum()) if squares.sum() > 0 else math.nan,
        real=a.joints[j],
        sim=b.joints[j],
    )


def _first_pose(run: Run) -> Floats:
    pose = headed_pose(run)
    if pose is None:
        return np.zeros(3)
    return np.asarray(pose[np.flatnonzero(np.isfinite(pose).all(axis=1))[0]])
