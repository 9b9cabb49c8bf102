"""``snakebot jog``: one joint by keys, within its limits."""

from __future__ import annotations

import subprocess
import sys
import time

import pytest

from snakebot.control.registry import STOP_SIGNAL
from snakebot.servobus.emulated.end import ServoBusEnd

SNAKE = "sts3215_snake"


def test_jog_turns_one_joint_within_its_limit(sts: ServoBusEnd) -> None:
    words = ["jog", sts.port, "--joint", "3", "--step", "5", "--robot", SNAKE, "--yes"]
    program = [sys.executable, "-c", "from snakebot.cli.main import main; main()", *words]
    done = subprocess.run(program, input="+++2-q", capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert "joints sent to 0.0 -5.0 15.0 0.0 0.0 deg" in done.stdout
    degrees = [(servo.get("present_position") - 2048) * 360 / 4096 for servo in sts.bus.servos]
    assert degrees == pytest.approx([0, -5, 15, 0, 0], abs=1.0)
    assert not any(servo.driving for servo in sts.bus.servos)


def holding_joint_2(sts: ServoBusEnd, *options: str) -> subprocess.Popen[str]:
    """A jog that has given its joint power."""
    words = ["jog", sts.port, "--joint", "2", *options, "--robot", SNAKE, "--yes"]
    program = [sys.executable, "-c", "from snakebot.cli.main import main; main()", *words]
    pipe = subprocess.PIPE
    jog = subprocess.Popen(program, stdin=pipe, stdout=pipe, stderr=pipe, text=True)
    until_s = time.monotonic() + 60.0
    while jog.poll() is None and time.monotonic() < until_s:
        if sts.bus.servos[1].driving:
            return jog
        time.sleep(0.01)
    jog.kill()
    raise AssertionError(jog.communicate()[1])


@pytest.mark.slow
@pytest.mark.real_time
def test_jog_leaves_the_others_free_where_that_is_wanted(sts: ServoBusEnd) -> None:
    jog = holding_joint_2(sts, "--others-free")
    time.sleep(0.2)
    assert [servo.driving for servo in sts.bus.servos] == [False, True, False, False, False]
    jog.communicate("q", timeout=30)
    assert jog.returncode == 0


def test_stop_ends_a_jog_with_status_5(sts: ServoBusEnd) -> None:
    jog = holding_joint_2(sts)
    jog.send_signal(STOP_SIGNAL)
    _, told = jog.communicate(timeout=30)
    assert jog.returncode == 5, told
    assert "emergency stop" in told
    assert not any(servo.driving for servo in sts.bus.servos)


def test_jog_keeps_limits() -> None:
    from snakebot.errors import BadInputError
    from snakebot.gait.jog import JogMotion

    motion = JogMotion([0.0, 0.95], [1.0, 1.0])
    with pytest.raises(BadInputError, match="joint 2 is at its limit"):
        motion.step(2, 0.0, 0.1)
    motion.step(2, 0.0, -0.1)
    assert motion.target_rad == pytest.approx((0.0, 0.85))
    assert motion.angles(0.0) == pytest.approx([0.0, 0.95])
    assert motion.angles(5.0) == pytest.approx([0.0, 0.85])
    motion.step(1, 6.0, 0.2)
    assert motion.angles(6.0) == pytest.approx([0.0, 0.85])
