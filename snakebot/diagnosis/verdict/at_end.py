"""Causes whose fit ends where the effect itself ends: a limit of speed that wants to be zero is a joint that stands.

The data then ask for more than the effect can be, so that it more likely imitates another one.
"""

from __future__ import annotations

import math

from snakebot.diagnosis.result import Cause, Estimate
from snakebot.diagnosis.sizes import HALF, NO_PERCENT, UNLIKELY
from snakebot.diagnosis.verdict.probability import at_most
from snakebot.effects.parameter import Parameter
from snakebot.effects.registry import find_effect


def at_end(cause: Cause) -> str | None:
    """Which of its parameters a cause has at the end of what they may be, as a warning; None if none."""
    effect = find_effect(cause.effect)
    for name, estimate in cause.parameters.items():
        parameter = effect.parameter(name)
        if _asks_for_more(parameter, estimate):
            shown = f"{parameter.in_shown_unit(estimate.estimate):.3g} {parameter.shown_unit}".rstrip()
            return (
                f"{effect.title}: {parameter.called} is at the end of what it may be ({shown}), so this is likely "
                "to be another effect that it imitates"
            )
    return None


def held_back(cause: Cause) -> Cause:
    """The cause, with no more probability than one at its end may have."""
    return cause if at_end(cause) is None else at_most(cause, UNLIKELY)


def _asks_for_more(parameter: Parameter, estimate: Estimate) -> bool:
    """Whether a fitted parameter stands, clearly, at a bound that does not mean that the effect is absent.

    Between them lies 0 % of its range, on its own scale. Where its interval is wide the data do not ask for the bound,
    they do not care (a damping of next to nothing): it then spans half of all that the parameter may be, or more.
    """
    if estimate.fixed or estimate.ci95 is None:
        return False
    lower, upper = _on_scale(parameter, parameter.lower), _on_scale(parameter, parameter.upper)
    value, span = _on_scale(parameter, estimate.estimate), upper - lower
    low, high = (_on_scale(parameter, end) for end in estimate.ci95)
    absent = {parameter.neutral, parameter.default}
    near = [
        bound
        for bound, on_scale in ((parameter.lower, lower), (parameter.upper, upper))
        if abs(value - on_scale) < NO_PERCENT * span and bound not in absent
    ]
    return bool(near) and high - low < HALF * span


def _on_scale(parameter: Parameter, value: float) -> float:
    return math.log(value) if parameter.scale == "log" else value
