"""A robot description with the found effects in it: the simulation with the gap closed."""

from __future__ import annotations

from snakebot.diagnosis.result import Diagnosis
from snakebot.errors import BadInputError
from snakebot.robot import Provenance, Robot


def calibrated(robot: Robot, diagnosis: Diagnosis) -> Robot:
    """``robot`` with the causes of an explained gap added to its own effects, and where they come from.

    Raises:
        BadInputError: the diagnosis explains nothing that could be added.
    """
    if diagnosis.verdict != "explained" or not diagnosis.causes:
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
    return robot.model_copy(update={"effects": effects, "provenance": {**robot.provenance, **notes}})
