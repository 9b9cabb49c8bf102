"""Results as plain JSON: SI units named in the keys, ``null`` for what is not known."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from snakebot.analysis.comparison import Comparison
from snakebot.analysis.conditions import condition
from snakebot.analysis.joints import JointAnalysis
from snakebot.analysis.run_analysis import RunAnalysis
from snakebot.analysis.sine import SineFit
from snakebot.analysis.tables import PaperTables

SCHEMA = "snakebot.analysis/1"
COMPARISON_SCHEMA = "snakebot.comparison/1"


def analysis_json(runs: Sequence[RunAnalysis], tables: PaperTables) -> dict[str, Any]:
    """What ``snakebot analyze --json`` prints."""
    return {"schema": SCHEMA, "runs": [run_json(run) for run in runs], "tables": plain(asdict(tables))}


def run_json(run: RunAnalysis) -> dict[str, Any]:
    gait = run.gait
    return {
        "name": run.name,
        "robot": run.robot.name,
        "samples": len(run.run),
        "duration_s": plain(run.run.duration_s),
        "ended": run.run.ended,
        "gait": None
        if gait is None
        else {
            "alpha_rad": gait.alpha_rad,
            "beta_rad": gait.beta_rad,
            "omega_rad_s": gait.omega_rad_s,
            "offset_rad": gait.offset_rad,
            **({"shares": list(gait.shares)} if gait.shares else {}),
        },
        "omega_rad_s": run.omega_rad_s,
        "omega_source": run.omega_source,
        "steady": plain(asdict(run.steady)),
        "te": plain(run.te),
        "speed_m_s": plain(run.speed_m_s),
        "speed_source": run.speed_source or None,
        "pose_speed": plain(asdict(run.pose_speed)) if run.pose_speed else None,
        "speed_error_percent": plain(run.speed_error_percent),
        "predictions": plain(asdict(run.predictions)),
        "power_in_w": plain(run.power_in_w),
        "power_dissipated_w": plain(run.power_dissipated_w),
        "power_electrical_w": plain(run.power_electrical_w),
        "link": plain(asdict(run.link)),
        "faults": {"free": list(run.faults.free), "rigid": list(run.faults.rigid)},
        "fault": condition(run, "fault") or None,
        "effect": condition(run, "effect") or None,
        "probe": condition(run, "probe") or None,
        "simulated": run.run.metadata.get("simulated") is True,
        "joints": [joint_json(joint) for joint in run.joints],
        "warnings": list(run.warnings),
    }


def joint_json(joint: JointAnalysis) -> dict[str, Any]:
    return {
        "joint": joint.joint,
        **plain(asdict(joint.tracking)),
        "command": _sine(joint.command),
        "measured": _sine(joint.measured),
        "gain": plain(joint.gain),
        "lag_rad": plain(joint.lag_rad),
        "lag_s": plain(joint.lag_s),
        "thd": plain(joint.thd),
        "thd_command": plain(joint.thd_command),
        "harmonics": _harmonics(joint),
        "sine_residual": plain(joint.sine_residual),
        "hysteresis": plain(asdict(joint.hysteresis)),
        "lost": plain(joint.lost),
    }


def _harmonics(joint: JointAnalysis) -> list[float]:
    """Amplitude of each harmonic over the fundamental's, from the first on."""
    fit = joint.harmonic_fit
    return (
        []
        if fit is None or not math.isfinite(joint.thd)
        else [float(a / fit.amplitude) for a in fit.amplitudes]
    )


def _sine(fit: SineFit | None) -> dict[str, Any] | None:
    if fit is None:
        return None
    return {
        "amplitude_rad": fit.amplitude,
        "phase_rad": fit.phase_rad,
        "offset_rad": fit.offset,
        "residual_rms_rad": fit.residual_rms,
    }


def plain(value: Any) -> Any:
    """The same with ``None`` for every number that is not one."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value


def comparison_json(found: Comparison) -> dict[str, Any]:
    """What ``snakebot compare --json`` prints."""
    alignment = plain(asdict(found.alignment))
    return {
        "schema": COMPARISON_SCHEMA,
        "real": run_json(found.real),
        "sim": run_json(found.sim),
        "sim_source": found.sim_source,
        "alignment": {**alignment, "by": found.aligned_by},
        "rms_rad": plain(found.rms_rad),
        "speed_error_percent": plain(found.speed_error_percent),
        "joints": [
            {
                "joint": j.joint,
                "rms_rad": plain(j.rms_rad),
                "max_rad": plain(j.max_rad),
                "mean_rad": plain(j.mean_rad),
                "correlation": plain(j.correlation),
                "share": plain(j.share),
                "real": joint_json(j.real),
                "sim": joint_json(j.sim),
            }
            for j in found.joints
        ],
        "warnings": list(found.warnings),
    }
