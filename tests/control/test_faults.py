"""The grammar of --fault."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.catalogue import JointMode
from snakebot.control import JointFault, RunSettings, check_run, parse_fault, plan_run
from snakebot.errors import BadInputError
from snakebot.gait import Gait
from snakebot.robot import load_robot


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("free:3", JointFault(0, (3,), JointMode.FREE)),
        ("rigid:4+5", JointFault(0, (4, 5), JointMode.RIGID)),
        ("rigid:2=-30", JointFault(0, (2,), JointMode.RIGID, math.radians(-30))),
        ("rigid:4@12s", JointFault(12, (4,), JointMode.RIGID_HERE)),
        ("rigid:4=10@12.5", JointFault(12.5, (4,), JointMode.RIGID, math.radians(10))),
        ("clear@20s", JointFault(20, (1, 2, 3, 4, 5), JointMode.ACTIVE)),
        ("clear:2@20s", JointFault(20, (2,), JointMode.ACTIVE)),
    ],
)
def test_faults_are_understood(text: str, expected: JointFault) -> None:
    assert parse_fault(text, 5) == expected


@pytest.mark.parametrize(
    "text",
    ["", "free", "rigid", "free:0", "free:6", "free:3+", "stuck:3", "free:3=20", "rigid:3@-1", "rigid:3=400"],
)
def test_what_is_not_understood_is_named_with_an_example(text: str) -> None:
    with pytest.raises(BadInputError, match="--fault"):
        parse_fault(text, 5)


@given(st.text(max_size=30))
def test_nonsense_never_does_anything_but_the_documented_error(text: str) -> None:
    try:
        fault = parse_fault(text, 5)
    except BadInputError:
        return
    assert set(fault.joints) <= {1, 2, 3, 4, 5}
    assert fault.at_s >= 0


def test_a_misspelt_kind_names_the_nearest() -> None:
    with pytest.raises(BadInputError, match=r"not understood; did you mean free\? Give for example free:3"):
        parse_fault("fre:3", 5)
    with pytest.raises(BadInputError, match="not understood; give for example"):
        parse_fault("free", 5)


def test_a_fault_that_comes_after_the_end_of_the_run_is_refused() -> None:
    robot = load_robot("penn_state")
    plan = plan_run(Gait.from_degrees(10, 80, 1), robot.joints, duration_s=6)
    check_run(robot, plan, RunSettings(faults=[parse_fault("rigid:4@5.9s", 5)]))
    with pytest.raises(
        BadInputError, match=r"--fault rigid:4@6s: the run is over after 6 s; give an earlier time"
    ):
        check_run(robot, plan, RunSettings(faults=[parse_fault("rigid:4@6s", 5)]))
