"""Speed and tracking error against omega, with servos that are not ideal (Table II's layout; Figs. 21 and 22)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from snakebot.analysis.prediction import AVERAGED_CYCLES, CYCLES
from snakebot.clock import RATE_HZ
from snakebot.errors import BadInputError
from snakebot.gait import Gait
from snakebot.robot import Robot


@dataclass(frozen=True)
class SimulatedSpeed:
    """One omega: what ideal joints, these servos, and sines fitted to these servos' angles make of the gait."""

    alpha_deg: float
    beta_deg: float
    omega_rad_s: float
    ideal_speed_m_s: float
    speed_m_s: float
    sine_replay_speed_m_s: float
    tracking_error: tuple[float, ...]  # (37), a joint
    speed_error_percent: float  # (36), of these servos against ideal tracking


def speed_study(
    robot: Robot,
    gaits: Sequence[Gait],
    effects: Sequence[str] = (),
    progress: Callable[[int, int], None] | None = None,
) -> list[SimulatedSpeed]:
    """The servo model is the robot's own lag and its effects, with ``effects`` (grammar of --effect) added.

    Raises:
        BadInputError: the robot has no body, a gait does not move, or an effect is unknown.
    """
    if robot.body is None:
        raise BadInputError(f"robot {robot.name!r} has no body: a bench of servos does not move over ground")
    rows = []
    for done, gait in enumerate(gaits):
        if progress is not None:
            progress(done, len(gaits))
        rows.append(_one(robot, gait, effects))
    if progress is not None:
        progress(len(gaits), len(gaits))
    return rows


def _one(robot: Robot, gait: Gait, effects: Sequence[str]) -> SimulatedSpeed:
    from snakebot.analysis.prediction import predict_fits, predict_gait
    from snakebot.analysis.sine import fit_sine
    from snakebot.analysis.speed import speed_error_percent
    from snakebot.analysis.tracking import tracking
    from snakebot.effects import parse_effects, predict
    from snakebot.gait.blend import blend
    from snakebot.physics import ChainModel

    assert robot.body is not None
    if not (gait.omega_rad_s > 0 and gait.alpha_rad > 0):
        raise BadInputError(f"{gait}: a gait of this study needs alpha and omega above zero")
    model = ChainModel.from_body(robot.body)
    t = np.arange(0.0, CYCLES * gait.period_s, 1.0 / RATE_HZ)
    ramp = np.array([blend(moment / gait.period_s) for moment in t])
    command = ramp[:, None] * gait.angles(t, robot.joints)
    found = predict(robot, parse_effects(effects), t, command)
    assert found.motion is not None
    start = (CYCLES - AVERAGED_CYCLES) * gait.period_s
    steady = t >= start
    fits = [fit_sine(t[steady], angle, gait.omega_rad_s) for angle in found.encoder_rad[steady].T]
    ideal = predict_gait(model, gait).speed_m_s
    speed = found.motion.forward_speed_m_s(start)
    replayed = predict_fits(model, [fit for fit in fits if fit is not None]).speed_m_s
    errors = tuple(
        tracking(found.encoder_rad[steady, joint], command[steady, joint], gait.alpha_rad).te
        for joint in range(robot.joints)
    )
    return SimulatedSpeed(
        alpha_deg=float(np.degrees(gait.alpha_rad)),
        beta_deg=float(np.degrees(gait.beta_rad)),
        omega_rad_s=gait.omega_rad_s,
        ideal_speed_m_s=ideal,
        speed_m_s=speed,
        sine_replay_speed_m_s=replayed,
        tracking_error=errors,
        speed_error_percent=speed_error_percent(speed, ideal),
    )


def summary(robot: Robot, effects: Sequence[str], rows: Sequence[SimulatedSpeed]) -> dict[str, Any]:
    """Plain values for ``--json``."""
    return {"robot": robot.name, "effects": list(effects), "rows": [asdict(row) for row in rows]}
