"""``record``: one call makes a run and its log, from Python as from the command line."""

from __future__ import annotations

import math
import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.catalogue import JointMode, Mode
from snakebot.control import (
    Attendant,
    JointFault,
    RunLoop,
    RunSettings,
    open_board,
    parse_fault,
    plan_replay,
    plan_run,
    record,
    registry,
)
from snakebot.control.making import Ready
from snakebot.control.plans import settle_s
from snakebot.errors import BadInputError, BoardFaultError, LogError, NoBoardError
from snakebot.gait import Gait, parse_probe
from snakebot.robot import load_robot
from snakebot.runlog import RunWriter, read_log

ROBOT = load_robot("penn_state")
WAVE = Gait.from_degrees(40, 80, 2)


def test_a_run_is_made_and_its_log_says_all_of_it(tmp_path: Path) -> None:
    settings = RunSettings(
        log_path=tmp_path / "a.mcap",
        faults=[parse_fault("free:3@4s", 5)],
        forward_speed_m_s=0.12,
        notes="carpet",
        about={"arena": "hall"},
    )
    with open_board("sim:", ROBOT, effects=["backlash:width_deg=2"], seed=7, virtual=True) as board:
        recorded = record(board, ROBOT, plan_run(WAVE, 5, duration_s=12), settings)
    assert recorded.ended == "finished"
    assert recorded.progress.ticks == 1201
    assert recorded.forward_speed_m_s is not None
    log = read_log(recorded.log_path)
    wanted = {
        "ramp_s": 2.0,
        "rate_hz": 100.0,
        "port": "sim:",
        "faults": ["free:3@4s"],
        "effects": ["backlash:width_deg=2"],
        "seed": 7,
        "simulated": True,
        "virtual_time": True,
        "forward_speed_m_s": 0.12,
        "notes": "carpet",
        "arena": "hall",
        "ended": "finished",
        "steady_speed_m_s": recorded.forward_speed_m_s,
    }
    assert {key: log.metadata[key] for key in wanted} == wanted
    assert log.gait == WAVE
    np.testing.assert_array_equal(recorded.read().measured_rad, log.measured_rad)


def test_runs_follow_each_other_on_one_board(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    probe = parse_probe("triangle:amplitude_deg=5,rate_deg_s=20,joints=3")
    with open_board("sim:", ROBOT, virtual=True, lifted=True) as board:
        runs = [
            record(board, ROBOT, plan_run(what, 5, cycles=1, lifted=True)) for what in (WAVE, probe, probe)
        ]
    assert len({run.log_path for run in runs}) == 3
    logs = [read_log(run.log_path) for run in runs]
    assert [log.metadata.get("probe") for log in logs] == [None, str(probe), str(probe)]
    assert all(log.metadata["lifted"] is True for log in logs)
    assert [run.log_path.name.split("_", 1)[1][:6] for run in runs] == ["a40_b8", "probe_", "probe_"]


def test_a_replay_says_its_own_ramp_and_when_it_settles(tmp_path: Path) -> None:
    """The ramp of a replay leads to the first recorded posture; the recorded ramp comes after it."""

    def steady_ms(log_path: Path) -> float:
        return float(read_log(log_path).metadata["steady_speed_m_s"])

    with open_board("sim:", ROBOT, virtual=True) as board:
        first = record(
            board, ROBOT, plan_run(WAVE, 5, cycles=4, ramp_s=3), RunSettings(log_path=tmp_path / "a")
        )
        plan = plan_replay(read_log(first.log_path), ramp_s=1.5)
        assert (plan.ramp_s, plan.settle_s) == (1.5, 4.5)
        second = record(board, ROBOT, plan, RunSettings(log_path=tmp_path / "b"))
    about = read_log(second.log_path).metadata
    assert (about["ramp_s"], about["settle_s"]) == (1.5, 4.5)
    assert about["replay_of"] == "a"
    assert steady_ms(second.log_path) == pytest.approx(steady_ms(first.log_path), rel=0.02)
    again = plan_replay(read_log(second.log_path), ramp_s=1.0)
    assert (again.ramp_s, again.settle_s) == (1.0, 5.5)


@pytest.mark.parametrize("nonsense", [None, "3", True, math.nan, -1.0])
def test_a_settle_time_that_is_none_counts_as_zero(nonsense: object) -> None:
    assert settle_s({"ramp_s": nonsense}) == 0.0


def test_what_would_be_refused_is_refused_before_anything_moves(tmp_path: Path) -> None:
    wild = plan_run(Gait.from_degrees(80, 80, 20), 5, duration_s=8)
    with open_board("sim:", ROBOT, virtual=True) as board:
        with pytest.raises(BadInputError, match="speed"):
            record(board, ROBOT, wild, RunSettings(log_path=tmp_path / "a"))
        with pytest.raises(BadInputError, match="motion is one of 3 joints"):
            record(board, ROBOT, plan_run(WAVE, 3))
        for fault in (JointFault(0, (7,), JointMode.FREE), JointFault(0, (2,), JointMode.RIGID, 3.0)):
            with pytest.raises(BadInputError, match="--fault"):
                record(board, ROBOT, plan_run(WAVE, 5), RunSettings(log_path=tmp_path / "a", faults=[fault]))
        (tmp_path / "taken.mcap").touch()
        with pytest.raises(LogError, match="exists already"):
            record(board, ROBOT, plan_run(WAVE, 5), RunSettings(log_path=tmp_path / "taken"))
    assert [path.name for path in tmp_path.iterdir()] == ["taken.mcap"]


@pytest.mark.parametrize(
    "text",
    ["free:3", "rigid:4+5", "rigid:2=30", "rigid:4@12s", "rigid:4=0@12s", "clear:1+2@20s", "free:1@0.5s"],
)
def test_a_fault_is_written_as_it_is_read(text: str) -> None:
    fault = parse_fault(text, 5)
    assert str(fault) == text
    assert parse_fault(str(fault), 5) == fault


def test_an_attendant_sees_the_run_from_before_it_moves_until_its_log_is_whole(tmp_path: Path) -> None:
    seen: list[str] = []

    class Watching(Attendant):
        tap = staticmethod(lambda channel, time_ns, data: seen.append("record"))

        @contextmanager
        def until_logged(self, loop: RunLoop) -> Iterator[None]:
            with super().until_logged(loop):
                seen.append("begin")
                yield
                seen.append("whole" if (tmp_path / "a.mcap").exists() else "not yet")

        @contextmanager
        def while_running(self, loop: RunLoop, log: RunWriter) -> Iterator[None]:
            with super().while_running(loop, log):
                assert not loop.progress.ticks
                (found,) = registry.running()
                assert found.port == "sim:"
                assert signal.getsignal(registry.STOP_SIGNAL) is not signal.SIG_DFL
                yield
                seen.append("relaxed")

    with open_board("sim:", ROBOT, virtual=True) as board:
        settings = RunSettings(log_path=tmp_path / "a.mcap")
        record(board, ROBOT, plan_run(WAVE, 5, duration_s=5), settings, Watching("sim:"))
    steps = [step for step in seen if step != "record"]
    assert steps == ["begin", "relaxed", "whole"]
    assert seen.count("record") > 500
    assert signal.getsignal(registry.STOP_SIGNAL) is signal.SIG_DFL


class _Meddling(Attendant):
    """Does something to the loop once it streams."""

    def __init__(self, at_tick: int, deed: str, argument: object = None) -> None:
        super().__init__("sim:")
        self.at_tick, self.deed, self.argument = at_tick, deed, argument
        self.raised: list[str] = []

    @contextmanager
    def while_running(self, loop: RunLoop, log: RunWriter) -> Iterator[None]:
        send = loop._send

        def meddle(ready: object, t_s: float) -> None:
            if loop.progress.ticks == self.at_tick:
                try:
                    getattr(loop, self.deed)(*([] if self.argument is None else [self.argument]))
                except BadInputError as error:
                    self.raised.append(str(error))
            send(ready, t_s)  # type: ignore[arg-type]

        loop._send = meddle  # type: ignore[method-assign]
        with super().while_running(loop, log):
            yield


def test_a_failed_run_keeps_the_last_traffic_decoded_in_its_log_and_with_the_error(tmp_path: Path) -> None:
    with open_board("sim:", ROBOT, virtual=True) as board, pytest.raises(BoardFaultError) as failed:
        settings = RunSettings(log_path=tmp_path / "a.mcap")
        record(board, ROBOT, plan_run(WAVE, 5), settings, _Meddling(200, "request_emergency_stop"))
    log = read_log(tmp_path / "a.mcap")
    assert log.complete
    assert log.metadata["ended"].startswith("error: sim: emergency stop")
    (traffic,) = [event for event in log.events if event.kind == "traffic"]
    frames = traffic.data["frames"]
    assert isinstance(frames, list)
    assert tuple(frames) == failed.value.traffic
    assert len(frames) == 40
    assert any("tx" in line and "Setpoint" in line for line in frames)
    assert any("EmergencyStop" in line for line in frames)


def test_a_board_that_does_not_answer_leaves_what_was_sent_to_it(tmp_path: Path) -> None:
    with pytest.raises(NoBoardError) as silent, open_board("serial:loop://", ROBOT):
        pass
    assert any("tx" in line and "InfoRequest" in line for line in silent.value.traffic)


def test_a_fault_that_a_page_asks_for_is_checked_as_one_of_the_command_line(tmp_path: Path) -> None:
    wrong = parse_fault("rigid:2=170", 5)
    meddling = _Meddling(100, "request_fault", wrong)
    with open_board("sim:", ROBOT, virtual=True) as board:
        settings = RunSettings(log_path=tmp_path / "a.mcap")
        recorded = record(board, ROBOT, plan_run(WAVE, 5, duration_s=6), settings, meddling)
    assert recorded.ended == "finished"
    assert meddling.raised == ["--fault rigid:2=170: robot 'penn_state' allows 95 deg"]


def test_a_run_in_a_thread_touches_no_signal(tmp_path: Path) -> None:
    ended: list[str] = []

    def elsewhere() -> None:
        with open_board("sim:", ROBOT, virtual=True) as board:
            plan = plan_run(WAVE, 5, duration_s=4.5)
            ended.append(record(board, ROBOT, plan, RunSettings(log_path=tmp_path / "a")).ended)

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert ended == ["finished"]


def test_ctrl_c_in_a_notebook_relaxes_the_joints_and_closes_the_log(tmp_path: Path) -> None:
    """Python's own handler raises in the middle of the loop."""

    class Interrupting(Attendant):
        @contextmanager
        def while_running(self, loop: RunLoop, log: RunWriter) -> Iterator[None]:
            send = loop._send

            def interrupted(ready: Ready, t_s: float) -> None:
                if loop.progress.ticks == 150:
                    os.kill(os.getpid(), signal.SIGINT)
                send(ready, t_s)

            loop._send = interrupted  # type: ignore[method-assign]
            with super().while_running(loop, log):
                yield

    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # who runs the tests may ignore it
    try:
        with open_board("sim:", ROBOT, virtual=True) as board:
            with pytest.raises(KeyboardInterrupt):
                record(
                    board,
                    ROBOT,
                    plan_run(WAVE, 5),
                    RunSettings(log_path=tmp_path / "a.mcap"),
                    Interrupting("sim:"),
                )
            assert board.mode is Mode.DISARMED
    finally:
        signal.signal(signal.SIGINT, before)
    log = read_log(tmp_path / "a.mcap")
    assert log.complete
    assert log.metadata["ended"] == "error: KeyboardInterrupt"
    assert not registry.running()


class AskedLate(Attendant):
    """Asks for something when the motion is over, while the panel closes or the log is closed."""

    def __init__(self, ask: Callable[[RunLoop], None]) -> None:
        super().__init__("sim:")
        self.ask = ask

    @contextmanager
    def while_running(self, loop: RunLoop, log: RunWriter) -> Iterator[None]:
        with super().while_running(loop, log):
            yield
            assert registry.running(), "`snakebot stop` must find what it is to stop"
            self.ask(loop)


@pytest.mark.parametrize("asked", [True, False])
def test_an_end_that_is_asked_for_when_the_motion_is_over_is_told(asked: bool, tmp_path: Path) -> None:
    """Only whoever would make another run can still obey it."""
    attendant = AskedLate(RunLoop.interrupt if asked else lambda loop: None)
    settings = RunSettings(log_path=tmp_path / "a.mcap")
    with open_board("sim:", ROBOT, virtual=True) as board:
        recorded = record(board, ROBOT, plan_run(WAVE, 5, duration_s=5), settings, attendant)
    assert recorded.ended == "finished"
    assert recorded.asked_late == asked


def test_a_stop_that_is_asked_for_when_the_motion_is_over_stays(tmp_path: Path) -> None:
    """Whoever asked is told that the run has stopped: nothing may move until the stop is cleared."""
    attendant = AskedLate(lambda loop: signal.raise_signal(registry.STOP_SIGNAL))
    settings = RunSettings(log_path=tmp_path / "a.mcap")
    with open_board("sim:", ROBOT, virtual=True) as board:
        with pytest.raises(BoardFaultError, match=r"emergency stop.*the motion was over.*a\.mcap"):
            record(board, ROBOT, plan_run(WAVE, 5, duration_s=5), settings, attendant)
        assert read_log(settings.log_path).complete  # type: ignore[arg-type]
        kept = RunSettings(log_path=tmp_path / "b.mcap", keep_stop=True)
        with pytest.raises(BoardFaultError):
            record(board, ROBOT, plan_run(WAVE, 5, duration_s=5), kept)
    assert not (tmp_path / "b.mcap").exists()


def test_runs_of_one_second_are_numbered_in_a_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("snakebot.control.recording.stamped_path", lambda label: Path("runs/now.mcap"))
    for _ in range(4):
        with open_board("sim:", ROBOT, virtual=True) as board:
            record(board, ROBOT, plan_run(WAVE, 5, duration_s=2, ramp_s=1))
    names = {"now.mcap", "now-2.mcap", "now-3.mcap", "now-4.mcap"}
    assert {path.name for path in Path("runs").iterdir()} == names
