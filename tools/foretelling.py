"""Whether another explanation foretells what a sealed robot does, where the true effect was taken out of the library.

A healthy robot is off the nominal one by a floor, which is no fault of an explanation: one that takes the place of a
stated number (another lag) has it in it, one that adds to the robot (an offset) has not. So what was said, on the
nominal robot, must come to the readings of the true robot, or change them as the true effect does. They must agree on
the motions of the session, and on the menu of those that the product may propose.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from blind.cases import Case, make_case, plan, rms, shares_of, ticks
from blind.robot import Robot as TrueRobot

from snakebot.arrays import Floats
from snakebot.clock import RATE_HZ
from snakebot.diagnosis.proposal.menu import menu
from snakebot.effects.prediction import predict
from snakebot.effects.spec import EffectSpec, parse_effect
from snakebot.robot import Robot

Commands = list[tuple[Floats, Floats]]  # of motions: times (T,), set-points (T, k)


def foretells_the_same(robot: Robot, case: Case, answer: dict[str, Any]) -> bool:
    """Whether what was said comes to the true readings, or changes them as the true effect does, within a floor of the
    case: root mean square over the joints that either acts on. ``robot``: the nominal one.
    """
    apart = differences_rad(robot, case, answer)
    return bool((apart.max(axis=0) <= case.label.floor_rad).any())


def differences_rad(robot: Robot, case: Case, answer: dict[str, Any]) -> Floats:
    """(2, 2) root mean square differences on the motions of the session, and on those of the menu: of the readings, and
    of how they are changed.
    """
    said = [parse_effect(cause["specification"]) for cause in answer["causes"]]
    every = range(1, robot.joints + 1)
    named = [spec.joints for spec in said if spec.effect.stage != "body"]
    acted = [joints or every for joints in (*(effect.joints for effect in case.label.effects), *named)]
    joints = sorted(set().union(*acted))
    at = [joint - 1 for joint in joints]

    t_s = ticks(case.build, case.records.duration_s)
    of_session = [(t_s, motion.command(t_s, robot.joints)) for motion in case.motions]
    of_menu = []
    for option in menu(robot, joints, loads=False):
        t_s = np.arange(round(option.duration_s * RATE_HZ)) / RATE_HZ
        of_menu.append((t_s, option.motion.sampled(t_s)))

    def apart(commands: Commands) -> tuple[float, float]:
        (faulty, sound), (told, nominal) = _true(case, commands), _foretold(robot, said, commands)
        off = (faulty - told)[:, at]
        return rms(off), rms(off - (sound - nominal)[:, at])

    return np.array([apart(of_session), apart(of_menu)])


def _true(case: Case, commands: Commands) -> tuple[Floats, Floats]:
    """(T, k) noiseless readings of the true robot, all motions below each other: as it is, and with nothing wrong."""
    assert case.sound is not None
    as_it_is, sound = (TrueRobot(parameters.noiseless()) for parameters in (case.parameters, case.sound))
    rng = np.random.default_rng(0)
    one, other = (
        np.concatenate([made.run(t_s, command, rng).encoder_rad for t_s, command in commands])
        for made in (as_it_is, sound)
    )
    return one, other


def _foretold(robot: Robot, said: Sequence[EffectSpec], commands: Commands) -> tuple[Floats, Floats]:
    """(T, k) the same of the nominal robot, with some effects and without."""

    def readings(specs: Sequence[EffectSpec]) -> Floats:
        made = (predict(robot, specs, t_s, command, body=False, quantise=False) for t_s, command in commands)
        return np.concatenate([run.encoder_rad for run in made])

    return readings(said), readings(())


def case_of(made: dict[str, Any], label: dict[str, Any]) -> Case:
    """The case of a set (its ``made`` record) with this label, drawn again.

    Raises:
        LookupError: there is none.
    """
    shares, (first,) = shares_of(made["set"]), (effect["name"] for effect in label["effects"])
    for number in range(made["cases"]):
        stratum, names = plan(number, made["cases"], np.random.default_rng(0), shares)
        if stratum == label["stratum"] and names == (first,):
            case = make_case(made["set"], made["seed"], number, made["cases"])
            if case.label.mapping() == label:
                return case
    raise LookupError(f"no case of the set has the label {label}")
