"""Joints that have a little of everything: effects that only help together, joints with values of their own."""

from __future__ import annotations

import numpy as np
import pytest
from sessions import bench, make_session

from snakebot.diagnosis import Diagnosis, diagnose

GAITS = ((66, 80, 2.0), (30, 80, 4.0), (50, 60, 1.0), (20, 80, 6.0))
OFFSETS_DEG, PLAYS_DEG = (1.5, -2.0, 0.8), (2.0, 1.2, 3.0)
WORN = (
    "servo_lag:time_constant_s=0.05+0.065+0.042,joints=1+2+3",
    f"servo_offset:offset_deg={'+'.join(map(str, OFFSETS_DEG))},joints=1+2+3",
    f"backlash:width_deg={'+'.join(map(str, PLAYS_DEG))},joints=1+2+3",
)


def values(found: Diagnosis, effect: str, parameter: str) -> list[float]:
    (cause,) = [c for c in found.causes if c.effect == effect]
    assert cause.joints == (1, 2, 3)
    return [joint.estimate for joint in cause.parameters[parameter].by_joint]


@pytest.mark.slow
def test_three_effects_that_differ_from_joint_to_joint_are_three_causes() -> None:
    found = diagnose(make_session(bench(3), WORN, gaits=GAITS), quick=True)
    assert found.verdict == "explained"
    assert {c.effect for c in found.causes} == {"servo_lag", "servo_offset", "backlash"}
    assert np.allclose(values(found, "servo_lag", "time_constant_s"), (0.05, 0.065, 0.042), rtol=0.05)
    assert np.allclose(values(found, "servo_offset", "offset_deg"), OFFSETS_DEG, atol=0.1)
    assert np.allclose(values(found, "backlash", "width_deg"), PLAYS_DEG, rtol=0.1)
    (offset,) = [c for c in found.causes if c.effect == "servo_offset"]
    assert offset.specification.endswith(",joints=1+2+3")
    closed = found.closure.joint_angle.closed
    assert closed is not None
    assert closed > 0.95


@pytest.mark.slow
def test_a_fault_beside_the_wear_is_found() -> None:
    fault = "rate_limit:limit_rad_s=1.2,joints=2"
    found = diagnose(make_session(bench(3), (*WORN, fault), gaits=GAITS), quick=True)
    (limit,) = [c for c in found.causes if c.effect == "rate_limit"]
    assert limit.joints == (2,)
    assert abs(limit.parameters["limit_rad_s"].estimate - 1.2) < 0.1
    assert found.verdict in ("explained", "partly")
