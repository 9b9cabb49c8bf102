"""What the servos usually bear and how fast the joints usually turn, in the runs that may be fitted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.simulator import Simulator
from snakebot.effects.effect import Usual


def usual_of(simulator: Simulator, runs: Sequence[int]) -> Usual:
    """Load of the joints in the nominal motion, speed in the measured one."""
    loads = [load for load in map(simulator.load, runs) if load is not None]
    times = [simulator.data.runs[i].t_s for i in runs]
    rates = [
        np.gradient(simulator.smooth[i], t, axis=0) for i, t in zip(runs, times, strict=True) if t.size > 1
    ]
    return Usual(_rms(loads), _rms(rates))


def _rms(tables: Sequence[Floats]) -> float:
    """Of all tables together, each as long as any other; 0 of none."""
    return float(np.sqrt(np.mean([np.mean(np.square(table)) for table in tables]))) if tables else 0.0
