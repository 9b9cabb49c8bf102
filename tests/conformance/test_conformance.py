"""The same cases, unchanged, on every board of the project.

Boards on a virtual clock take all cases in the default suite; boards on a real wire take time, and are slow tests.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import boards
import pytest

from snakebot.conformance import Bench, Case, Verdict, cases, run_case

QUICK = [case for case in cases() if not case.long]
REAL_TIME = [
    "simulated-pty",
    "simulated-slcan",
    "host-pty",
    "host-slcan",
    "host-16-joints",
    "host-1-joint-across-the-wrap-of-its-clock",
    "cortex-m-qemu",
]
CANNOT_BE_TOLD = ("too busy", "encoders are too fine", "coasts when it loses its power")
OF_SIMULATIONS_ONLY = (
    "on a real robot it is left alone", "a real joint is not turned that far", "how soon a real servo follows",
)  # fmt: skip


def ask(case: Case, bench: Bench, tries: int = 1, excuses: tuple[str, ...] = CANNOT_BE_TOLD) -> None:
    """One case; several tries where board and test share a machine that may stop either for a tenth of a second."""
    for _ in range(tries):
        outcome = run_case(case, bench)
        if outcome.verdict is Verdict.PASSED:
            return
    if outcome.verdict is Verdict.SKIPPED:
        missing = any(not bench.can(need) for need in case.needs)
        assert missing or any(reason in outcome.detail for reason in excuses), outcome.detail
        pytest.skip(outcome.detail)
    assert outcome.verdict is Verdict.PASSED, "\n".join([f"{case.rule}\n{outcome.detail}", *outcome.traffic])


@pytest.fixture(scope="module")
def sim() -> Iterator[Bench]:
    with boards.sim_in_process() as bench:
        yield bench


@pytest.fixture(
    scope="module", params=[5, *(pytest.param(joints, marks=pytest.mark.slow) for joints in (1, 16))]
)
def sim_with_hands(request: pytest.FixtureRequest) -> Iterator[Bench]:
    with boards.sim_with_hands(request.param) as bench:
        yield bench


@pytest.mark.parametrize(
    "case",
    [pytest.param(case, marks=[pytest.mark.slow] * case.long, id=case.name) for case in cases()],
)
def test_simulated_board(case: Case, sim: Bench) -> None:
    ask(case, sim)


@pytest.mark.parametrize("case", QUICK, ids=lambda case: case.name)
def test_simulated_joints_in_hands(case: Case, sim_with_hands: Bench) -> None:
    ask(case, sim_with_hands)


@pytest.mark.parametrize("case", QUICK, ids=lambda case: case.name)
def test_simulated_board_before_hardware(case: Case) -> None:
    with boards.sim_with_hardware() as bench:
        ask(case, bench, excuses=(*CANNOT_BE_TOLD, *OF_SIMULATIONS_ONLY))


@pytest.mark.parametrize("case", cases(), ids=lambda case: case.name)
def test_core(case: Case, core_library: Any) -> None:
    with boards.core_in_process(core_library) as bench:
        ask(case, bench)


@pytest.mark.parametrize("case", QUICK, ids=lambda case: case.name)
def test_core_over_can(case: Case, core_library: Any) -> None:
    with boards.core_in_process(core_library, can=True, joints=6) as bench:
        ask(case, bench)


@pytest.mark.slow
@pytest.mark.parametrize("joints", [1, 16])
@pytest.mark.parametrize("case", QUICK, ids=lambda case: case.name)
def test_core_across_the_wrap_of_its_clock(case: Case, joints: int, core_library: Any) -> None:
    """The clock wraps within the case, at another moment for each number of joints."""
    start_us = (1 << 32) - 170_000 - 30_000 * joints
    with boards.core_in_process(core_library, start_us=start_us, joints=joints) as bench:
        ask(case, bench)


@pytest.fixture(scope="module")
def real_board(request: pytest.FixtureRequest) -> Iterator[Bench]:
    name: str = request.param

    program: Path | None = request.getfixturevalue("host_program") if name.startswith("host") else None
    image: Path | None = request.getfixturevalue("cortex_m_image") if name.startswith("cortex") else None

    def host(*options: str) -> Any:
        assert program is not None
        return boards.host_firmware(program, *options)

    with ExitStack() as stack:
        stack.enter_context(boards.ahead_of_others())
        if name == "simulated-pty":
            made = boards.sim_program("--serial")
        elif name == "simulated-slcan":
            made = boards.sim_program("--can", "slcan")
        elif name == "host-pty":
            made = host()
        elif name == "host-slcan":
            made = host("--slcan")
        elif name == "host-16-joints":
            made = host("--joints", "16", "--counts", "65535")
        elif name == "host-1-joint-across-the-wrap-of-its-clock":
            made = host("--joints", "1", "--clock-offset", str((1 << 32) - 15_000_000), "--start", "25")
        else:
            assert image is not None
            made = boards.cortex_m(image)
        yield stack.enter_context(made)


ON_EVERY_WIRE = boards.about_wire_and_time()
ON_ONE_WIRE = [case for case in QUICK if case not in ON_EVERY_WIRE]


@pytest.mark.slow
@pytest.mark.real_time
@pytest.mark.parametrize("case", ON_EVERY_WIRE, ids=lambda case: case.name)
@pytest.mark.parametrize("real_board", REAL_TIME, indirect=True)
def test_real_time(case: Case, real_board: Bench) -> None:
    ask(case, real_board, tries=4)


@pytest.mark.slow
@pytest.mark.real_time
@pytest.mark.parametrize("case", ON_ONE_WIRE, ids=lambda case: case.name)
@pytest.mark.parametrize("real_board", ["host-pty"], indirect=True)
def test_real_time_on_one_wire(case: Case, real_board: Bench) -> None:
    ask(case, real_board, tries=4)


@pytest.mark.slow
@pytest.mark.real_time
@pytest.mark.timeout(600)
@pytest.mark.parametrize("case", [case for case in cases() if case.long], ids=lambda case: case.name)
@pytest.mark.parametrize("real_board", ["host-pty", "host-slcan", "cortex-m-qemu"], indirect=True)
def test_real_time_long(case: Case, real_board: Bench) -> None:
    ask(case, real_board, tries=4)


IN_BRIEF = ["identifies_itself", "takes_golden_frames", "answers_each_setpoint", "faults_without_a_setpoint"]


@pytest.mark.parametrize("name", IN_BRIEF)
@pytest.mark.parametrize("real_board", ["host-pty", "host-slcan", "cortex-m-qemu"], indirect=True)
def test_real_time_in_brief(name: str, real_board: Bench) -> None:
    """What the default suite has time for on a real wire."""
    (case,) = (case for case in cases() if case.name == name)
    ask(case, real_board, tries=4)
