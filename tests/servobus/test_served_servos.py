"""A board in a process of its own in front of servos: what programs and people are told of them."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest
from rigs import emulated, on_a_pty

from snakebot.cli.main import main

PROGRAM = [sys.executable, "-c", "from snakebot.cli.main import main; main()"]


def test_a_served_board_tells_programs_what_it_changes_in_the_servos() -> None:
    """No message carries it to the host: it stands in the line that programs wait for."""
    bus = emulated("sts3215")
    for servo in bus.servos:
        servo.set("profile_velocity", 111)
    with on_a_pty(bus) as end:
        words = [*PROGRAM, "board", "serve", end.port, "--tcp", "--json"]
        process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert process.stdout is not None
        told = json.loads(process.stdout.readline())
        process.terminate()
        _, for_people = process.communicate(timeout=20)
    assert "joint 2: profile_velocity 111 -> 0" in told["servo_bus"]["changed"]
    assert [servo["id"] for servo in told["servo_bus"]["servos"]] == [1, 2, 3, 4, 5]
    assert told["servo_bus"]["bus_watchdog"] is False
    assert "while armed: joint 2: profile_velocity 111 -> 0" in for_people


@pytest.mark.parametrize("words", [("trim", "1.5"), ("zero", "2000")])
def test_trims_and_zeros_of_servos_are_stored_by_robot_calibrate(
    words: tuple[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["board", words[0], "feetech:/dev/nowhere", "3", words[1]])
    assert ended.value.code == 2
    assert "`snakebot robot calibrate feetech:/dev/nowhere --out FILE`" in capsys.readouterr().err
