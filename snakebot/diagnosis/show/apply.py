"""A robot description with the found effects in it: the simulation with the gap closed, and how well it is known."""

from __future__ import annotations

from typing import Any

from snakebot.diagnosis.result import Cause, Diagnosis
from snakebot.effects.spec import parse_effect
from snakebot.errors import BadInputError
from snakebot.robot import Interval, Provenance, Robot


def calibrated(robot: Robot, diagnosis: Diagnosis) -> Robot:
    """``robot`` with the causes of a gap, wholly or partly explained, added to its own effects, and their source.

    The intervals of their parameters go along, and as the tolerance of its speed the error that is left on runs that
    nothing was fitted to.

    Raises:
        BadInputError: the diagnosis explains nothing that could be added.
    """
    if diagnosis.verdict not in ("explained", "partly") or not diagnosis.causes:
        raise BadInputError(
            f"--apply: the verdict is {diagnosis.verdict}: there is no effect to add to the robot's description"
        )
    effects = tuple(dict.fromkeys((*robot.effects, *(cause.specification for cause in diagnosis.causes))))
    runs = len(diagnosis.closure.held_out_runs)
    notes = {
        f"effects.{cause.effect}": Provenance(
            status="fitted",
            source=f"snakebot diagnose, {runs} held-out runs, probability {cause.probability:.2f}",
        )
        for cause in diagnosis.causes
    }
    found = [interval for cause in diagnosis.causes for interval in _intervals(cause)]
    changed: dict[str, Any] = {
        "effects": effects,
        "intervals": (*robot.intervals, *found),
        "provenance": {**robot.provenance, **notes},
    }
    speed = diagnosis.closure.forward_speed
    if speed is not None and diagnosis.closure.held_out_runs:
        changed["tolerance"] = robot.tolerance.model_copy(update={"speed_m_s": speed.error_after})
    return robot.model_copy(update=changed)


def _intervals(cause: Cause) -> list[Interval]:
    """What the diagnosis says of the cause's fitted numbers, rounded as little as its specification."""
    spec = parse_effect(cause.specification)
    out = []
    for name, found in cause.parameters.items():
        if found.fixed:
            continue
        number = f"effects.{cause.effect}.{name}"
        if found.by_joint:
            out += [
                Interval(number=number, joints=(row.joint,), estimate=row.estimate, ci95=row.ci95)
                for row in found.by_joint
            ]
        else:
            out.append(
                Interval(number=number, joints=spec.joints or (), estimate=found.estimate, ci95=found.ci95)
            )
    return out
