"""What docs/safety.md says of bus servos, seen in the registers of emulated ones, with real processes on real wires."""

from __future__ import annotations

import contextlib
import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from rigs import emulated, on_a_pty

from snakebot.clock import MonotonicClock
from snakebot.servobus.emulated import EmulatedBus, EmulatedServo
from snakebot.servobus.emulated.end import ServoBusEnd
from snakebot.softboard.disturbance import BadPackets, Rates

PROGRAM = [sys.executable, "-c", "from snakebot.cli.main import main; main()"]
GAIT = ["--alpha", "30", "--beta", "80", "--omega", "2", "--ramp", "1"]
both = pytest.mark.parametrize("model", ["sts3215", "xl330"])


def until(what: Callable[[], bool], within_s: float = 15.0) -> bool:
    end_s = time.monotonic() + within_s
    while time.monotonic() < end_s:
        if what():
            return True
        time.sleep(0.005)
    return what()


def moving(bus: EmulatedBus) -> bool:
    return abs(bus.servos[2].get("present_position") - 2048) > 40


@contextlib.contextmanager
def started(*words: str) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen([*PROGRAM, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def run(port: str, tmp_path: Path, duration_s: float = 30.0) -> list[str]:
    log = str(tmp_path / "run.mcap")
    return ["run", *GAIT, "--duration", str(duration_s), "--port", port, "--yes", "--log", log]


@contextlib.contextmanager
def going(
    bus: EmulatedBus, port: str, tmp_path: Path, duration_s: float = 30.0
) -> Iterator[subprocess.Popen[str]]:
    """A run that moves the joints.

    Raises:
        AssertionError: it has ended before, and what it said; or it does not move them.
    """
    with started(*run(port, tmp_path, duration_s)) as host:
        until(lambda: moving(bus) or host.poll() is not None, 60.0)
        if host.poll() is not None:
            raise AssertionError(host.communicate()[1])
        assert moving(bus)
        yield host


@contextlib.contextmanager
def served(end: ServoBusEnd) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """A board in a process of its own in front of the servos."""
    with started("board", "serve", end.port, "--tcp", "--json") as process:
        assert process.stdout is not None
        yield json.loads(process.stdout.readline())["port"], process


def holding(servo: EmulatedServo) -> bool:
    return servo.driving


@pytest.mark.slow
@pytest.mark.real_time
@both
def test_a_killed_host_without_board_serve(model: str, tmp_path: Path) -> None:
    """Feetech: they hold the last goal with torque. Dynamixel: stopped by the bus watchdog, holding."""
    bus = emulated(model)
    with on_a_pty(bus) as end, going(bus, end.port, tmp_path) as host:
        host.send_signal(signal.SIGKILL)
        host.wait()
        goals = [servo.get("goal_position") for servo in bus.servos]
        time.sleep(0.4)
        assert all(holding(servo) for servo in bus.servos)
        if model == "xl330":
            assert until(lambda: {s.get("bus_watchdog") for s in bus.servos} == {-1}, 2.0)
        else:
            assert [servo.get("goal_position") for servo in bus.servos] == goals
        time.sleep(2.5)
        assert all(holding(servo) for servo in bus.servos), "nobody relaxes them: this is what the page says"


@pytest.mark.slow
@pytest.mark.real_time
@both
def test_a_killed_host_with_board_serve(model: str, tmp_path: Path) -> None:
    """The board's watchdog outlives the host: frozen, and relaxed after two seconds."""
    bus = emulated(model)
    with on_a_pty(bus) as end, served(end) as (port, _), going(bus, port, tmp_path) as host:
        host.send_signal(signal.SIGKILL)
        host.wait()
        time.sleep(0.3)
        goals = [servo.get("goal_position") for servo in bus.servos]
        assert all(holding(servo) for servo in bus.servos)
        time.sleep(0.5)
        assert [servo.get("goal_position") for servo in bus.servos] == goals, "frozen"
        assert until(lambda: not any(servo.driving for servo in bus.servos), 5.0)
        if model == "xl330":
            assert until(lambda: {s.get("bus_watchdog") for s in bus.servos} == {0}, 2.0), "cleared"


@pytest.mark.slow
@pytest.mark.real_time
@both
def test_a_killed_board_serve(model: str, tmp_path: Path) -> None:
    """With the last watchdog gone: Dynamixel stop by themselves, Feetech hold; the host ends with status 4."""
    bus = emulated(model)
    with on_a_pty(bus) as end, served(end) as (port, board), going(bus, port, tmp_path) as host:
        board.send_signal(signal.SIGKILL)
        _, told = host.communicate(timeout=30)
        assert host.returncode == 4, told
        assert all(holding(servo) for servo in bus.servos)
        if model == "xl330":
            assert until(lambda: {s.get("bus_watchdog") for s in bus.servos} == {-1}, 2.0)


@pytest.mark.slow
@pytest.mark.real_time
@both
def test_a_terminated_board_serve_relaxes_the_servos(model: str, tmp_path: Path) -> None:
    bus = emulated(model)
    with on_a_pty(bus) as end, served(end) as (port, board), going(bus, port, tmp_path) as host:
        board.send_signal(signal.SIGTERM)
        _, told = board.communicate(timeout=20)
        assert board.returncode == 0, told
        assert "on the bus: " in told
        assert not any(servo.driving for servo in bus.servos)
        host.communicate(timeout=30)
        # the board says that it has stopped, or is gone before that is heard
        assert host.returncode in (4, 5)


@pytest.mark.slow
@pytest.mark.real_time
@both
def test_a_servo_that_loses_its_supply_in_mid_run(model: str, tmp_path: Path) -> None:
    """Silent, or back without torque: a fault in words, status 5, all frozen and relaxed."""
    bus = emulated(model)
    with on_a_pty(bus) as end, going(bus, end.port, tmp_path) as host:
        bus.servos[3].powered = False
        time.sleep(0.5)
        bus.servos[3].power_cycle()
        bus.servos[3].powered = True
        _, told = host.communicate(timeout=30)
        assert host.returncode == 5, told
        assert "joint 4: the servo has" in told
        assert until(lambda: not any(servo.driving for servo in bus.servos), 5.0)


@pytest.mark.slow
@pytest.mark.real_time
@both
def test_the_adapter_is_unplugged_in_mid_run(model: str, tmp_path: Path) -> None:
    bus = emulated(model)
    clock = MonotonicClock()
    start_s = clock.now_s()
    with on_a_pty(bus) as end, going(bus, end.port, tmp_path) as host:
        end.unplug()  # type: ignore[attr-defined]
        _, told = host.communicate(timeout=30)
        assert host.returncode == 4, told
        assert "the line was lost" in told
    bus.advance(clock.now_s() - start_s + 0.5)  # the servos live on
    assert all(holding(servo) for servo in bus.servos)
    if model == "xl330":
        assert {servo.get("bus_watchdog") for servo in bus.servos} == {-1}


@pytest.mark.slow
@pytest.mark.real_time
@both
def test_a_run_on_a_bad_line(model: str, tmp_path: Path) -> None:
    """1 % of the bytes damaged and 5 % of the packets lost, in both directions: the run goes on to its end."""
    bus = emulated(model)
    with on_a_pty(bus) as end, going(bus, end.port, tmp_path, 8.0) as host:
        rates = Rates(flip=0.01, drop=0.05)
        bus.to_servos = BadPackets(rates, 1, time.monotonic)
        bus.to_host = BadPackets(rates, 2, time.monotonic)
        _, told = host.communicate(timeout=60)
    assert host.returncode == 0, told


def test_an_adapter_that_is_plugged_in_again_finds_the_servos_relaxed() -> None:
    """What `board serve` does, in virtual time."""
    from rigs import MemoryLine, Rig, bench

    robot = bench()
    bus = emulated("sts3215", robot=robot)
    rig = Rig(bus, robot, reopen=True)
    rig.bench.fresh()
    here = rig.bench.arm()
    rig.stream(0.2, here)
    rig.line.cut = True
    with contextlib.suppress(Exception):
        rig.stream(0.1, here)
    assert rig.plant.lost is not None
    assert all(servo.driving for servo in bus.servos)
    assert isinstance(rig.line, MemoryLine)
    rig.line.cut = False
    for _ in range(400):
        rig.clock.sleep_until(rig.clock.now_s() + 0.005)
        rig.board.advance(rig.clock.now_s())
        rig.board.integrate(rig.clock.now_s())
    assert rig.plant.lost is None
    assert not any(servo.driving for servo in bus.servos)
