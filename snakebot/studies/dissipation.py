"""Power lost on the ground, from encoders and a forward speed alone (Section IX)."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

from snakebot.errors import BadInputError


def dissipation(path: Path, speed_m_s: float | None = None) -> dict[str, Any]:
    """Mean power over the steady cycles of a run, beside what the nominal model puts in for the same angles.

    Args:
        path: a run log, or a session folder with one run.
        speed_m_s: measured forward speed; without it the run's own.

    Raises:
        BadInputError: the robot has no body, no speed is known, or the motion is no gait.
    """
    from snakebot.analysis.run_analysis import analyze_run
    from snakebot.runlog import open_session

    session = open_session(path)
    if len(session.runs) != 1:
        raise BadInputError(f"{path}: holds {len(session.runs)} runs; name one of them")
    run, robot = session.runs[0], session.robot
    if robot.body is None:
        raise BadInputError(f"{path}: robot {robot.name!r} has no body: nothing is lost on the ground")
    if speed_m_s is not None:
        if not math.isfinite(speed_m_s):
            raise BadInputError(f"--speed {speed_m_s}: must be a finite number")
        run = replace(run, forward_speed_m_s=speed_m_s)
    found = analyze_run(run, robot)
    if not math.isfinite(found.speed_m_s):
        raise BadInputError(f"{path}: no forward speed is known: give --speed, or `snakebot log merge-speed`")
    if not math.isfinite(found.power_dissipated_w):
        raise BadInputError(f"{path}: the joints' motion is too broken or too short for a power")
    return {
        "run": run.name,
        "speed_m_s": found.speed_m_s,
        "speed_source": found.speed_source,
        "power_dissipated_w": found.power_dissipated_w,
        "power_in_model_w": found.power_in_w if math.isfinite(found.power_in_w) else None,
    }
