"""The joints of which something is claimed: those that were read."""

from __future__ import annotations

import numpy as np

from snakebot.diagnosis.evidence.angles import AngleEvidence
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term


def joints_of(angles: AngleEvidence, said: Term | Hypothesis) -> tuple[int, ...]:
    """1-based joints that an effect, or an explanation, acts on and that were read in some run; none for the body."""
    whole = Hypothesis((said,)) if isinstance(said, Term) else said
    read = {int(j) + 1 for j in np.unique(angles.blocks.joint)}
    return tuple(j for j in whole.joints(angles.data.joints) if j in read)
