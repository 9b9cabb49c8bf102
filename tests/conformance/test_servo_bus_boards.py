"""The same cases on the board in software in front of emulated bus servos: what stands above them is proved again.

A servo bus can do all that the protocol asks for, but for the cases named here.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import ExitStack

import boards
import pytest
from lagging_plant import LaggingPlant
from rigs import Rig, bench, emulated, on_a_pty

import snakebot
from firmware_protocol.catalogue import Fault
from snakebot.clock import MonotonicClock
from snakebot.conformance import Bench, Case, Lab, Plate, Verdict, cases, run_case
from snakebot.links import open_link
from snakebot.softboard.hardware import HardwareFault

LEFT_ALONE = "it writes trims or zeros that a real robot's owner has set, and cannot read what to put back"
SILENT = (
    "a servo whose encoder gives no reading is silent: that is a fault of its own, tried in tests/servobus"
)
CANNOT = {
    "trims_the_servo": LEFT_ALONE,
    "slews_to_a_new_trim": LEFT_ALONE,
    "limits_the_sum": LEFT_ALONE,
    "trims_rigid_joints": LEFT_ALONE,
    "rigid_joints_take_their_own_trims": LEFT_ALONE,
    "forgets_impossible_trims": "the board in software keeps its trims in memory: nothing stored can be damaged",
    "each_joint_has_its_trim": LEFT_ALONE,
    "a_reset_brings_trims_into_force": LEFT_ALONE,
    "each_joint_has_its_zero": LEFT_ALONE,
    "trims_and_zeros_are_two_things": LEFT_ALONE,
    "trims_wait_for_their_joints_power": LEFT_ALONE,
    "reports_no_count_beyond_16_bits": LEFT_ALONE,
    "unread_joints_get_no_power": SILENT,
    "lost_encoders_are_told": SILENT,
    "unread_joints_stand_at_nought": SILENT,
    "tells_angles_beyond_the_wire": "a real joint is not turned that far by a test",
    "keeps_its_built_in_limits": "a robot of bus servos is nobody's simulated board: it is not driven to its limits",
    "power_lasts_until_it_is_taken": "how soon a real servo follows is not known to the suite",
    "reads_at_the_moment_of_the_setpoint": "how soon a real servo follows is not known to the suite",
    "tells_its_supply": "servos resolve 0.1 V and 1 degC, and each has a current of its own; tried in tests/servobus",
}
WITHOUT_HANDS = {  # of a process: nobody resets it, sets its clock, breaks its hardware or reads its plate
    "arms_no_faulty_hardware",
    "draws_another_boot_id",
    "forgets_at_a_reset",
    "has_credit_at_a_reset",
    "limits_across_the_wrap",
    "says_what_it_is",
    "starts_again_at_a_reset",
}
SERVOS = ["sts3215", pytest.param("xl330", marks=pytest.mark.slow)]  # one of each maker
OTHERS = ["scs0009", "xl430"]


class HeldJoints(LaggingPlant):
    """Joints behind emulated servos that hands can turn."""

    def __init__(self, joints: int) -> None:
        super().__init__(joints, 4096)
        self.joint_torque_nm = [0.0] * joints


def with_hands(rig: Rig, joints: HeldJoints) -> Bench:
    """Raw bytes reach the board, it can be reset and broken, and its joints be turned."""
    raw: list[bytes] = []
    rig.link._to_board = lambda data: raw.pop() if raw else data

    def send_bytes(data: bytes) -> None:
        raw.append(data)
        rig.link.send([])

    def fail(fault: Fault, joint: int, detail: int) -> None:
        rig.board.fail(HardwareFault(fault, joint, detail), rig.clock.now_s())

    def turn(joint: int, angle_rad: float) -> None:
        """Its servo's sensors know at once, though no time passes."""
        joints.turn(joint, angle_rad)
        chain = rig.bus.chain
        assert chain is not None
        chain._measure(chain._t_s)
        chain.servos[joint - 1].show()

    robot = rig.board.robot
    major, minor, patch = (int(part) for part in snakebot.__version__.split(".")[:3])
    rig.bench.send_bytes = send_bytes
    rig.bench.reset = lambda: rig.board.reset(rig.clock.now_s())
    rig.bench.lab = Lab(
        reset_at=lambda clock_us: rig.board.reset(rig.clock.now_s(), clock_us),
        turn_joint=turn,
        fail=fail,
        draw=lambda numbers: boards.draw_next(rig.board, numbers),
        plate=Plate(
            robot.joints,
            robot.encoder_counts_per_rev,
            rig.board.serial_number,
            (major, minor, patch),
            simulated=False,
            pose=False,
            limits=boards.built_in(robot),
        ),
        encoder_rad=rig.servos[0].model.rad_per_count,
    )
    return rig.bench


@pytest.fixture(
    scope="module", params=[*SERVOS, *(pytest.param(model, marks=pytest.mark.slow) for model in OTHERS)]
)
def servos(request: pytest.FixtureRequest) -> Iterator[Bench]:
    robot = bench()
    joints = HeldJoints(robot.joints)
    rig = Rig(emulated(request.param, robot=robot, plant=joints), robot)
    yield with_hands(rig, joints)
    rig.link.close()
    assert not any(servo.driving for servo in rig.servos)


@pytest.mark.parametrize(
    "case",
    [pytest.param(case, marks=[pytest.mark.slow] * case.long, id=case.name) for case in cases()],
)
def test_board_in_front_of_bus_servos(case: Case, servos: Bench) -> None:
    outcome = run_case(case, servos)
    if outcome.verdict is Verdict.SKIPPED:
        assert case.name in CANNOT, outcome.detail
        pytest.skip(CANNOT[case.name])
    assert outcome.verdict is Verdict.PASSED, "\n".join([f"{case.rule}\n{outcome.detail}", *outcome.traffic])
    assert case.name not in CANNOT, "it can"


@pytest.fixture(scope="module", params=SERVOS)
def served(request: pytest.FixtureRequest) -> Iterator[Bench]:
    """Emulated servos on one pseudo-terminal, `board serve` in a process of its own, the bench on another."""
    program = "from snakebot.cli.main import main; main()"
    with ExitStack() as stack:
        stack.enter_context(boards.ahead_of_others())
        end = stack.enter_context(on_a_pty(emulated(request.param)))
        words = [sys.executable, "-c", program, "board", "serve", end.port, "--serial", "--json"]
        _, line = stack.enter_context(boards._program(*words))
        link = stack.enter_context(open_link(json.loads(line)["port"]))
        yield Bench(link, MonotonicClock(), send_bytes=boards.bytes_of(link), tolerance_s=0.03)


def test_the_cases_that_need_hands_are_the_named_ones() -> None:
    """Raw bytes are all that the bench of a served board has besides the link."""
    need = {case.name for case in boards.about_wire_and_time() if set(case.needs) - {"send_bytes"}}
    assert need == WITHOUT_HANDS


@pytest.mark.slow
@pytest.mark.real_time
@pytest.mark.parametrize("case", boards.about_wire_and_time(), ids=lambda case: case.name)
def test_served_board_in_front_of_bus_servos(case: Case, served: Bench) -> None:
    """In real time; several tries where servos, board and bench share a machine that may stop each of them."""
    for _ in range(5):
        outcome = run_case(case, served)
        if outcome.verdict is Verdict.PASSED:
            return
    if outcome.verdict is Verdict.SKIPPED:
        known = case.name in CANNOT or case.name in WITHOUT_HANDS or "too busy" in outcome.detail
        assert known, outcome.detail
        pytest.skip(outcome.detail)
    assert outcome.verdict is Verdict.PASSED, "\n".join([f"{case.rule}\n{outcome.detail}", *outcome.traffic])
