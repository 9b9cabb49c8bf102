"""Unmodelled effects, each once: the simulated board injects them, the diagnosis fits them, a robot may have them.

``parse_effect`` and ``EffectSpec`` are the words, ``Plant`` is the robot in real time, ``predict`` and ``assemble``
are whole runs for a fit. Names load on first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from snakebot.lazy import names_from

if TYPE_CHECKING:
    from snakebot.effects.effect import Effect, LinkFilter, SensorFilter, ServoFilter, Stage, Track
    from snakebot.effects.observed import Observed
    from snakebot.effects.parameter import Parameter
    from snakebot.effects.plant import Plant, Pose
    from snakebot.effects.prediction import PredictedRun, predict
    from snakebot.effects.registry import effects, find_effect
    from snakebot.effects.spec import (
        EffectSpec,
        fault_spec,
        load_effect_set,
        parse_effect,
        parse_effects,
        robot_effects,
    )
    from snakebot.effects.stages import Stages, assemble, with_unit_arm

_HOME = {
    "Effect": "effect",
    "EffectSpec": "spec",
    "LinkFilter": "effect",
    "Observed": "observed",
    "Parameter": "parameter",
    "Plant": "plant",
    "Pose": "plant",
    "PredictedRun": "prediction",
    "SensorFilter": "effect",
    "ServoFilter": "effect",
    "Stage": "effect",
    "Stages": "stages",
    "Track": "effect",
    "assemble": "stages",
    "effects": "registry",
    "fault_spec": "spec",
    "find_effect": "registry",
    "load_effect_set": "spec",
    "parse_effect": "spec",
    "parse_effects": "spec",
    "predict": "prediction",
    "robot_effects": "spec",
    "with_unit_arm": "stages",
}

__all__ = [
    "Effect",
    "EffectSpec",
    "LinkFilter",
    "Observed",
    "Parameter",
    "Plant",
    "Pose",
    "PredictedRun",
    "SensorFilter",
    "ServoFilter",
    "Stage",
    "Stages",
    "Track",
    "assemble",
    "effects",
    "fault_spec",
    "find_effect",
    "load_effect_set",
    "parse_effect",
    "parse_effects",
    "predict",
    "robot_effects",
    "with_unit_arm",
]

__getattr__ = names_from(__name__, _HOME)
