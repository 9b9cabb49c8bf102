"""The commands that people use on bus servos, against emulated ones on a pseudo-terminal."""

from __future__ import annotations

import contextlib
import itertools
import json
import math
import re
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rigs import MemoryLine, bench, emulated, master_of, on_a_pty
from servo_ends import call

from snakebot.clock import VirtualClock
from snakebot.control import open_board
from snakebot.doctor.servos import _ids
from snakebot.errors import BoardFaultError
from snakebot.robot import load_robot
from snakebot.runlog import read_log
from snakebot.servobus.calibration import check_limp, direction
from snakebot.servobus.emulated.end import ServoBusEnd
from snakebot.servobus.joints import look_around, roll_call, wanted_servos
from snakebot.servobus.opening import torque_off

SNAKE = "sts3215_snake"


def test_run_is_logged_with_its_servos(
    end: ServoBusEnd, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for servo in end.bus.servos:
        servo.set("profile_velocity", 50)
    log = tmp_path / "run.mcap"
    gait = ("--alpha", "20", "--beta", "80", "--omega", "3", "--duration", "3", "--ramp", "1")
    assert call("run", *gait, "--port", end.port, "--yes", "--log", str(log)) == 0
    told = capsys.readouterr().err
    assert re.search(
        r"on the servo bus: \d+ questions, \d+ of them again, \d+ never answered, \d+ answers damaged or too late",
        told,
    )
    if end.port.startswith("feetech"):
        assert "no bus watchdog: if this program is killed they go on holding, with 100 %" in told
    else:
        assert "no bus watchdog" not in told
    assert "8192 encoder counts a turn" in told, "penn_state is not these servos' robot"
    read = read_log(log)
    about = read.metadata["servo_bus"]
    assert [servo["id"] for servo in about["servos"]] == [1, 2, 3, 4, 5]
    assert "joint 1: profile_velocity 50 -> 0" in about["changed"]
    measured = read.to_run().measured_rad
    assert np.nanmax(abs(measured)) > math.radians(15)
    assert {"current_1_a", "temperature_3_c", "supply_v"} <= set(read.telemetry)
    assert {"bus_asked", "bus_retried", "bus_lost", "bus_corrupt"} <= set(read.link)
    assert not any(servo.driving for servo in end.bus.servos)
    assert {servo.get("profile_velocity") for servo in end.bus.servos} == {50}


def test_the_library_opens_servos_and_warns_of_what_the_command_tells(sts: ServoBusEnd) -> None:
    robot = load_robot(SNAKE)
    with contextlib.ExitStack() as stack:
        with pytest.warns(RuntimeWarning, match="no bus watchdog: if this program is killed they go on"):
            board = stack.enter_context(open_board(sts.port, robot))
        assert board.info is not None
        assert not board.info.simulated
        told: Any = board.link.about()["servo_bus"]
    assert [servo["model"] for servo in told["servos"]] == ["sts3215"] * 5
    heard: list[str] = []
    with open_board(sts.port, robot, tell=heard.append):
        assert len(heard) == 1, "and no warning"


def test_a_rate_beyond_the_bus_is_refused_with_the_figure(capsys: pytest.CaptureFixture[str]) -> None:
    """At 38400 baud the bits of five servos in turn take 11 ms."""
    bus = emulated("scs0009")
    for servo in bus.servos:
        servo.set("baud_rate", 7)
    with on_a_pty(bus) as end:
        port = f"{end.port}?baud=38400"
        status = call(
            "run", "--alpha", "10", "--beta", "80", "--omega", "1", "--rate", "200", "--port", port, "--yes"
        )
    assert status == 2
    told = capsys.readouterr().err
    assert "--rate 200: 5 servos (scs0009, asked one after the other)" in told
    assert "ms a cycle: at most" in told


def test_a_servo_without_a_bus_watchdog_needs_a_word(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bus = emulated("xl430")
    bus.servos[4].set("firmware", 30)
    with on_a_pty(bus) as end:
        run = (
            "run",
            "--alpha",
            "5",
            "--beta",
            "80",
            "--omega",
            "1",
            "--duration",
            "1",
            "--ramp",
            "0.5",
            "--yes",
        )
        words = (*run, "--port", end.port)
        assert call(*words, "--log", str(tmp_path / "run.mcap")) == 2
        assert "joint 5 (servo 5) (xl430, firmware 30) has no bus watchdog" in capsys.readouterr().err
        assert not (tmp_path / "run.mcap").exists()
        assert call(*words, "--no-servo-watchdog", "--log", str(tmp_path / "run.mcap")) == 0
        assert "if this program is killed they go on holding" in capsys.readouterr().err


def test_no_servos_and_wrong_ids_end_with_status_3(
    sts: ServoBusEnd, capsys: pytest.CaptureFixture[str]
) -> None:
    run = ("run", "--alpha", "10", "--beta", "80", "--omega", "1", "--yes", "--port")
    assert call(*run, f"{sts.port}?ids=1-4,9") == 3
    told = capsys.readouterr().err
    assert "servos 1, 2, 3, 4, 9 were expected; 9 does not answer; found: 1 (sts3215)" in told
    assert call(*run, f"{sts.port}?ids=1-4") == 2
    assert "4 ids for robot 'penn_state' with 5 joints" in capsys.readouterr().err
    assert call(*run, sts.port.replace("feetech", "dynamixel")) == 3
    assert "nobody answers at 1000000 baud" in capsys.readouterr().err


def test_the_board_is_the_one_in_the_command(sts: ServoBusEnd, capsys: pytest.CaptureFixture[str]) -> None:
    assert call("board", "info", sts.port, "--robot", SNAKE, "--json") == 0
    about = json.loads(capsys.readouterr().out)
    assert (about["joints"], about["simulated"], about["counts_per_rev"]) == (5, False, 4096)


def test_doctor_names_what_is_wrong(sts: ServoBusEnd, capsys: pytest.CaptureFixture[str]) -> None:
    servos = sts.bus.servos
    for servo in servos:
        servo.set("return_delay", 0)
    servos[1].set("return_delay", 250)
    servos[2].temperature_c = 66.0
    servos[3].set("min_position", 2000)
    servos[4].supply_v = 3.0
    assert call("doctor", sts.port, "--robot", SNAKE, "--json") == 3
    findings = json.loads(capsys.readouterr().out)["findings"]
    told = [f"{each['status']} {each['what']}: {each['found']}" for each in findings]
    assert "warn joint 2: return delay 500 us" in told
    assert "warn joint 3: 66 degC: it stops at 70" in told
    assert any(line.startswith("fail joint 4: its own angle limits are 2000 to 4095") for line in told)
    assert "fail joint 5: the servo's supply is outside its limits: 3.0 V" in told
    assert any(line.startswith("ok joint 1: servo 1: 0.0 deg, 12.0 V") for line in told)
    assert "ok bit rate: 1000000 baud" in told
    assert "ok ids: each answers, nobody twice" in told


def test_doctor_finds_the_bit_rate_and_two_of_one_id(capsys: pytest.CaptureFixture[str]) -> None:
    bus = emulated("xl330", ids=[1, 2, 3, 3, 5])
    for servo in bus.servos:
        servo.set("baud_rate", 1)
    bus.servos[3].set("firmware", 44)
    with on_a_pty(bus) as end:
        assert call("doctor", end.port, "--json") == 3
    told = {f"{each['what']}: {each['found']}" for each in json.loads(capsys.readouterr().out)["findings"]}
    assert "bit rate: they answer at 57600 baud, not 1000000" in told
    assert "ids: two servos have the id 3" in told
    assert "ids: 4 does not answer" in told


@pytest.mark.parametrize("model", ["sts3215", "xl330"])
def test_doctor_tells_twins_by_where_they_stand(model: str) -> None:
    """Two of one make say the same of themselves."""
    bus = emulated(model, ids=[1, 2, 3, 3, 5], start_rad=[0.0, 0.0, 0.1, 0.3, 0.0])
    master = master_of(MemoryLine(bus, VirtualClock()))
    told = [each.found for each in _ids(master, wanted_servos(bench(), ()), [1, 2, 3, 5])]
    assert told == ["two servos have the id 3", "4 does not answer"]
    healthy = master_of(MemoryLine(emulated(model), VirtualClock()))
    found = _ids(healthy, wanted_servos(bench(), ()), [1, 2, 3, 4, 5])
    assert [each.found for each in found] == ["each answers, nobody twice"]


@pytest.mark.parametrize("model", ["sts3215", "xl330"])
@pytest.mark.parametrize("lost", [0, 1, 4])
def test_a_scan_misses_nobody_for_one_lost_answer(model: str, lost: int) -> None:
    bus = emulated(model)
    said = itertools.count()
    bus.to_host = lambda packets: b"" if packets and next(said) == lost else b"".join(packets)
    found = look_around(master_of(MemoryLine(bus, VirtualClock())))
    assert [each.id for each in found] == [1, 2, 3, 4, 5]


def test_probe_finds_servos_on_a_port_that_is_known(sts: ServoBusEnd) -> None:
    from snakebot.cli.board_list import _servos

    assert _servos(sts.port).startswith("servos 1 (sts3215, firmware 3.9), 2 (sts3215")
    assert _servos(sts.port.replace("feetech", "dynamixel")) == ""


def test_stop_takes_the_torque_of_all(end: ServoBusEnd, capsys: pytest.CaptureFixture[str]) -> None:
    for servo in end.bus.servos:
        servo.set("torque_enable", 1)
    assert call("stop", "--port", end.port) == 0
    until_s = time.monotonic() + 5.0
    while any(servo.driving for servo in end.bus.servos) and time.monotonic() < until_s:
        time.sleep(0.01)
    assert not any(servo.driving for servo in end.bus.servos)


@pytest.mark.parametrize("model", ["sts3215", "xl430"])
def test_a_stop_that_no_servo_answers_has_not_ended_well(
    model: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Servos that are not asked let go all the same; those that are named are asked."""
    bus = emulated(model, ids=range(40, 45))
    for servo in bus.servos:
        servo.set("torque_enable", 1)
    with on_a_pty(bus) as end:
        assert call("stop", "--port", end.port) == 3
        assert "no servo answered within 2 s" in capsys.readouterr().err
        assert not any(servo.driving for servo in bus.servos)
        assert call("stop", "--port", f"{end.port}?ids=40-44") == 0


def test_a_stop_that_a_servo_does_not_obey_is_told(
    sts: ServoBusEnd, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    deaf = sts.bus.servos[2]
    deaf.set("torque_enable", 1)
    monkeypatch.setattr(deaf, "write", lambda address, data: 0)
    assert call("stop", "--port", sts.port) == 5
    assert "servo 3 still has torque: cut the supply" in capsys.readouterr().err


def test_calibrate_stores_zeros_and_directions(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The person is a function that turns the joint when it is asked to."""
    zeros = [2000.0, 2100.0, 1900.0, 2200.0, 2048.0]
    signs = [1, -1, 1, -1, 1]
    bus = emulated("sts3215", zero_counts=zeros, direction=signs)
    chain = bus.chain
    assert chain is not None
    asked: list[str] = []

    def person(text: str, **_: object) -> str:
        asked.append(text)
        if text.startswith("Turn joint"):
            joint = int(text.split()[2])
            chain._zero[joint - 1] += signs[joint - 1] * 200
            bus.advance(chain._t_s + 0.01)
        return ""

    monkeypatch.setattr("click.prompt", person)
    out = tmp_path / "mine.yaml"
    with on_a_pty(bus) as end:
        for servo in bus.servos:
            servo.set("torque_enable", 1)
        assert call("robot", "calibrate", end.port, "--robot", SNAKE, "--out", str(out)) == 0
        assert not any(servo.driving for servo in bus.servos), "nobody has torque while it is held"
    assert len(asked) == 6
    robot = load_robot(out)
    assert robot.servos is not None
    assert [servo.zero_counts for servo in robot.servos] == [2000, 2100, 1900, 2200, 2048]
    assert [servo.direction for servo in robot.servos] == signs
    assert robot.provenance["servos"].status == "measured"


def test_calibrate_gives_up_on_a_joint_that_never_turns(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[str] = []

    def absent(text: str, **_: object) -> str:
        asked.append(text)
        assert len(asked) < 100, "asks without end"
        return ""

    monkeypatch.setattr("click.prompt", absent)
    out = tmp_path / "mine.yaml"
    with on_a_pty(emulated("sts3215")) as end:
        assert call("robot", "calibrate", end.port, "--robot", SNAKE, "--out", str(out)) == 2
    assert "joint 1 (servo 1) did not turn in 5 tries" in capsys.readouterr().err
    assert not out.exists()


def test_nobody_is_told_to_turn_a_joint_that_has_torque() -> None:
    bus = emulated("sts3215")
    master = master_of(MemoryLine(bus, VirtualClock()))
    joints = roll_call(master, wanted_servos(bench(), ()))
    bus.servos[1].set("torque_enable", 1)
    with pytest.raises(BoardFaultError, match=r"joint 2 \(servo 2\) still has torque"):
        check_limp(master, joints)
    torque_off(master)
    check_limp(master, joints)


def test_a_turn_that_is_hardly_one_is_no_direction() -> None:
    from rigs import Rig, bench

    joint = Rig(emulated("sts3215", robot=bench()), bench()).board.joints[0]
    assert direction(joint, 2048, 2060) is None
    assert direction(joint, 2048, 2300) == 1
    assert direction(joint, 50, 4000) == -1, "across the end of the turn"


def test_robot_list_and_show(capsys: pytest.CaptureFixture[str]) -> None:
    assert call("robot", "list") == 0
    assert "sts3215_snake" in capsys.readouterr().out
    assert call("robot", "show", SNAKE) == 0
    assert "no bus watchdog" in capsys.readouterr().out
    assert call("robot", "show", "penn_state", "--json") == 0
    assert "servos" not in json.loads(capsys.readouterr().out)
