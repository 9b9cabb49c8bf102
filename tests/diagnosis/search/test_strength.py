"""Effects made stronger or weaker, and twins beside another effect: where pairs and rivals start."""

from __future__ import annotations

import numpy as np
import pytest
from sessions import bench, make_session

from snakebot.diagnosis.engine import diagnose
from snakebot.diagnosis.fit.hypothesis import Term
from snakebot.diagnosis.search.candidate import scaled


@pytest.mark.parametrize(
    ("effect", "value", "half"),
    [
        ("backlash", [4.0], [2.0]),
        ("command_gain", [1.2], [1.1]),
        ("rate_limit", [3.0], [6.0]),  # half as strong is a limit twice as high
        ("second_order", [20.0, 0.4], [40.0, 0.4]),
        ("compliance", [50.0], [100.0]),
    ],
)
def test_half_as_strong(effect: str, value: list[float], half: list[float]) -> None:
    term = Term(effect, None, (("loaded", 0.0),) if effect == "backlash" else ())
    assert scaled(term, np.array(value), 0.5) == pytest.approx(half)
    assert scaled(term, scaled(term, np.array(value), 0.5), 2.0) == pytest.approx(value)


def test_twins_are_told_beside_another_effect_too() -> None:
    """On a bench no reading tells a scale of the motion from one of the encoder, whatever else is there."""
    session = make_session(
        bench(2), ["second_order:natural_freq_rad_s=25,damping_ratio=0.4", "encoder_gain:gain=1.05"]
    )
    found = diagnose(session, quick=True)
    groups = [{cause.effect, *cause.indistinguishable_from} for cause in found.causes]
    assert any({"encoder_gain", "command_gain"} <= group for group in groups)
    assert any("second_order" in group for group in groups)
