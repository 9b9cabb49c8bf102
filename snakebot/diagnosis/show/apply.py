"""A robot description with the found effects in it: the simulation with the gap closed, and how well it is known."""

from __future__ import annotations

from collections.abc import Iterable
from statistics import fmean
from typing import TYPE_CHECKING

from snakebot.calibrated.recorded import reached
from snakebot.diagnosis.result import Cause, Closure, Diagnosis
from snakebot.effects.spec import parse_effect
from snakebot.errors import BadInputError
from snakebot.robot import SERVO_LAG, Interval, Provenance, Robot, Tolerance

if TYPE_CHECKING:
    from snakebot.runlog import Run

LAG_DIGITS = 5  # decimals of a lag in seconds: a hundredth of a millisecond, below what any runs tell; chosen


def calibrated(robot: Robot, diagnosis: Diagnosis, recordings: Iterable[Run] = ()) -> Robot:
    """``robot`` with the causes of a gap, wholly or partly explained, added to its own effects, and their source.

    The lag of the servos becomes the mean of those that the runs tell, where nothing but noise is left beside it. The
    intervals of the causes' parameters go along, and as the tolerance of its speed the error that is left on runs that
    nothing was fitted to. Of a robot without a gap that is all that is added: how far its speed is known.

    Args:
        recordings: those behind the diagnosis: how far they went is written down, too.

    Raises:
        BadInputError: the diagnosis says nothing that could be added.
    """
    causes = diagnosis.causes if diagnosis.verdict in ("explained", "partly") else ()
    tolerance = _tolerance_of_speed(robot.tolerance, diagnosis.closure)
    if not causes and (diagnosis.verdict != "no_gap" or tolerance is None):
        raise BadInputError(
            f"--apply: the verdict is {diagnosis.verdict}: there is no effect to add to the robot's description"
        )
    effects = tuple(dict.fromkeys((*robot.effects, *(cause.specification for cause in causes))))
    runs = len(diagnosis.closure.held_out_runs)
    notes = {
        f"effects.{cause.effect}": Provenance(
            status="fitted",
            source=f"snakebot diagnose, {runs} held-out runs, probability {cause.probability:.2f}",
        )
        for cause in causes
    }
    found = [interval for cause in causes for interval in _intervals(cause)]
    lags_s = [
        n.estimate for n in diagnosis.nominal if n.number == SERVO_LAG and diagnosis.verdict == "explained"
    ]
    servo = robot.servo
    if lags_s:
        servo = servo.model_copy(update={"time_constant_s": round(fmean(lags_s), LAG_DIGITS)})
        notes[SERVO_LAG] = Provenance(
            status="fitted", source=f"snakebot diagnose: mean over {len(lags_s)} joints"
        )
    made = robot.model_copy(
        update={
            "servo": servo,
            "effects": effects,
            "intervals": (*robot.intervals, *found),
            "provenance": {**robot.provenance, **notes},
            "tolerance": tolerance or robot.tolerance,
        }
    )
    recorded = reached(made, recordings)
    return made if recorded is None else made.model_copy(update={"recorded": recorded})


def _tolerance_of_speed(stated: Tolerance, closure: Closure) -> Tolerance | None:
    """The stated tolerances, with that of the speed as it was measured; None where it was not."""
    speed = closure.forward_speed
    if speed is None or not closure.held_out_runs:
        return None
    share = speed.error_after / speed.rms_measured if speed.rms_measured else None
    return stated.model_copy(update={"speed_m_s": speed.error_after, "speed_share": share})


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
