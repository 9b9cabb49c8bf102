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
    """Which of its parameters a cause has at the end of what they may be, as a warning; None if none.

    Where the interval of one is wide the data do not ask for the bound, they do not care (a damping of next to
    nothing). Unless there is nothing else to the effect: a dead band as wide as one may be is a joint that stands.
    """
    effect = find_effect(cause.effect)
    fitted = {effect.parameter(name): value for name, value in cause.parameters.items() if not value.fixed}
    ended = {parameter: value for parameter, value in fitted.items() if _is_at_bound(parameter, value)}
    for parameter, estimate in ended.items():
        if len(ended) == len(fitted) or _is_narrow(parameter, estimate):
            shown = f"{parameter.in_shown_unit(estimate.estimate):.3g} {parameter.shown_unit}".rstrip()
            return (
                f"{effect.title}: {parameter.called} is at the end of what it may be ({shown}), so this is likely "
                "to be another effect that it imitates"
            )
    return None


def held_back(cause: Cause) -> Cause:
    """The cause, with no more probability than one at its end may have."""
    return cause if at_end(cause) is None else at_most(cause, UNLIKELY)


def _is_at_bound(parameter: Parameter, estimate: Estimate) -> bool:
    """Whether an estimate stands at a bound that does not mean that the effect is absent: between them lies 0 % of the
    parameter's range, on its own scale.
    """
    value, absent = _on_scale(parameter, estimate.estimate), {parameter.neutral, parameter.default}
    ends = [_on_scale(parameter, end) for end in (parameter.lower, parameter.upper) if end not in absent]
    return any(abs(value - end) < NO_PERCENT * _range(parameter) for end in ends)


def _is_narrow(parameter: Parameter, estimate: Estimate) -> bool:
    """Whether there is an interval, and it spans less than half of all that the parameter may be."""
    if estimate.ci95 is None:
        return False
    low, high = (_on_scale(parameter, end) for end in estimate.ci95)
    return high - low < HALF * _range(parameter)


def _range(parameter: Parameter) -> float:
    return _on_scale(parameter, parameter.upper) - _on_scale(parameter, parameter.lower)


def _on_scale(parameter: Parameter, value: float) -> float:
    return math.log(value) if parameter.scale == "log" else value
