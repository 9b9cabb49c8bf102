"""What no robot does: numbers that would take analysis and diagnosis out of memory, or out of what a float can hold."""

from __future__ import annotations

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.runlog.run import Run

MAX_MAGNITUDE = 1e6  # rad, m
MAX_SPAN_S = 1e8  # three years
MIN_STEP_S = 1e-6  # of a time column, in the median; chosen: 1 MHz
MAX_GAPS = 2_000_000  # samples that would be missing in a run sampled throughout as it is for the most part


def plausible(run: Run, where: str) -> Run:
    """The run itself.

    Raises:
        BadInputError: one line that names ``where``: times too close, too far apart or with gaps that are too long,
            angles or positions that no robot reaches.
    """
    _check_times(where, run.t_s)
    for name, values in (
        ("commanded angle", run.command_rad),
        ("measured angle", run.measured_rad),
        ("applied angle", run.applied_rad),
        ("pose", run.pose),
    ):
        if values is not None and np.any(np.abs(values) > MAX_MAGNITUDE):
            raise BadInputError(f"{where}: a {name} is {np.nanmax(np.abs(values)):g}; no robot gets there")
    return run


def _check_times(where: str, t_s: Floats) -> None:
    if len(t_s) < 2:
        return
    span, step = float(t_s[-1] - t_s[0]), float(np.median(np.diff(t_s)))
    if not span <= MAX_SPAN_S:
        raise BadInputError(f"{where}: column t_s: goes over {span:g} s; are these seconds?")
    if not step >= MIN_STEP_S:
        raise BadInputError(f"{where}: column t_s: samples are {step:g} s apart; are these seconds?")
    if span / step > MAX_GAPS + 4 * len(t_s):
        raise BadInputError(
            f"{where}: column t_s: {len(t_s)} samples {step:g} s apart over {span:g} s: cut the run at its gaps"
        )
