"""The held-out rms of every joint of a session, under the nominal prediction and under a composite servo."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from composite_servo import Composite, JointRun, fit, mean_square

from snakebot.diagnosis.evidence.blocks import block_map
from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.folds import Fold, split_of
from snakebot.diagnosis.evidence.simulator import Simulator
from snakebot.errors import BadInputError
from snakebot.runlog import Session


@dataclass(frozen=True)
class JointLine:
    """One joint. None where no sample of it is held out, or none may be fitted."""

    joint: int  # 1-based
    before_rad: float | None
    after_rad: float | None
    servo: Composite | None


@dataclass(frozen=True)
class Table:
    """All joints, and in words what was held out."""

    how: str
    lines: tuple[JointLine, ...]

    def mapping(self) -> dict[str, Any]:
        return asdict(self)


def baseline(session: Session) -> Table:
    """Fit every joint, and compare on the runs that it was not fitted to.

    Raises:
        BadInputError: no run of the session is long enough to be used.
    """
    data = prepare(session)
    if not data.runs:
        raise BadInputError("no run is long enough to be compared")
    simulator = Simulator(data)
    nominal = [made.reading_rad for made in simulator.predict(())]
    blocks = block_map(data)
    split = split_of(data)
    if split.held_out:
        folds: tuple[Fold, ...] = (Fold(split.free, split.held_out),)
        how = f"fitted to {len(split.free)} runs, held out {len(split.held_out)}"
    elif split.folds:
        folds = split.folds
        how = f"{len(split.free)} runs, predicted in {len(folds)} groups of motions, each from the others"
    else:
        folds = (Fold(split.free, split.free),)
        how = "one motion alone: NOT held out, before and after are of the runs that were fitted"
    lines = []
    for joint in range(data.joints):
        used = [of_sample[:, joint] >= 0 for of_sample in blocks.of_sample]
        runs = [_joint_run(simulator, i, joint, use) for i, use in enumerate(used)]
        before = after = 0.0
        count = fitted = 0
        for fold in folds:
            servo = fit([runs[i] for i in fold.fit])
            for i in fold.score:
                residual = (nominal[i][:, joint] - runs[i].measured_rad)[runs[i].use]
                before, count = before + float(residual @ residual), count + residual.size
            if servo is not None:
                square, size = mean_square([runs[i] for i in fold.score], servo)
                after, fitted = after + square, fitted + size
        lines.append(
            JointLine(
                joint + 1,
                float(np.sqrt(before / count)) if count else None,
                float(np.sqrt(after / fitted)) if fitted and fitted == count else None,
                fit([runs[i] for i in split.free]) if len(folds) > 1 else servo,
            )
        )
    return Table(how, tuple(lines))


def _joint_run(simulator: Simulator, index: int, joint: int, use: np.ndarray) -> JointRun:
    run = simulator.data.runs[index]
    set_s, set_rad = simulator.set_points[index]
    told = np.ascontiguousarray(set_rad[:, joint])
    return JointRun(
        set_s=set_s,
        set_rad=np.nan_to_num(told),
        off=~np.isfinite(told),
        t_s=run.t_s,
        measured_rad=np.ascontiguousarray(simulator.measured[index][:, joint]),
        use=use & np.isfinite(simulator.measured[index][:, joint]),
    )
