"""An offset and a gain that leave a curve behind are likely to be a code wheel off its centre."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sessions import bench, make_session

from snakebot.diagnosis import diagnose
from snakebot.diagnosis.result import Diagnosis
from snakebot.diagnosis.show.certainty import why
from snakebot.diagnosis.sizes import UNLIKELY
from snakebot.runlog import Session

QUICK_LIBRARY = (
    "servo_offset",
    "command_gain",
    "encoder_offset",
    "encoder_gain",
    "command_delay",
    "servo_lag",
)


def off_centre(session: Session, amplitude_rad: float, phase_rad: float) -> Session:
    """The same runs, read by code wheels that sit off their centre on every joint."""
    runs = [
        replace(run, measured_rad=run.measured_rad + amplitude_rad * np.sin(run.measured_rad + phase_rad))
        for run in session.runs
    ]
    return replace(session, runs=tuple(runs))


def told(session: Session) -> Diagnosis:
    return diagnose(session, only=QUICK_LIBRARY, quick=True)


@pytest.mark.parametrize("phase_rad", [1.0, 2.2, -1.2])
def test_a_code_wheel_off_its_centre_is_no_sure_offset(phase_rad: float) -> None:
    found = told(off_centre(make_session(bench()), 0.05, phase_rad))
    assert found.causes
    assert all(cause.probability <= UNLIKELY for cause in found.causes)
    assert any("bends with the angle" in text for text in found.warnings)
    assert found.verdict in ("partly", "unexplained")  # a rest that follows another law is no noise
    assert found.unexplained.significant
    assert "bends with the angle" in found.unexplained.where
    assert "what is left bends with the angle" in why(found).lower()


@pytest.mark.parametrize(
    "effects",
    [
        ("servo_offset:offset_deg=3",),
        ("encoder_gain:gain=0.93",),
        ("encoder_offset:offset_deg=-2", "command_gain:gain=1.05"),
        ("servo_offset:offset_deg=2", "backlash:width_deg=1.5"),
        ("servo_offset:offset_deg=2", "servo_lag:time_constant_s=0.06"),
    ],
)
def test_straight_effects_bend_nothing(effects: tuple[str, ...]) -> None:
    found = told(make_session(bench(), effects))
    assert found.causes[0].probability > 0.5
    assert not any("bends" in text for text in found.warnings)
    assert all("bend" not in cause.evidence for cause in found.causes)


def test_one_motion_alone_tells_no_bend() -> None:
    session = off_centre(make_session(bench(), gaits=((66, 80, 2.0),)), 0.05, 1.0)
    assert not any("bends" in text for text in told(session).warnings)
