"""What servos measure of themselves is in the log of a run, in virtual time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from rigs import Rig, bench, emulated

from snakebot.board import Board
from snakebot.control import RunSettings, plan_run, record
from snakebot.gait import Gait
from snakebot.runlog import read_log
from snakebot.runlog.session import is_known_column


def test_supply_currents_and_temperatures_are_logged(tmp_path: Path) -> None:
    robot = bench()
    rig = Rig(emulated("sts3215", robot=robot), robot)
    rig.servos[3].temperature_c = 41.0
    board = Board(rig.link, rig.clock)
    board.connect()
    plan = plan_run(Gait.from_degrees(10, 80, 1), robot.joints, duration_s=5)
    recorded = record(board, robot, plan, RunSettings(log_path=tmp_path / "run.mcap"))
    read = read_log(recorded.log_path)
    assert {"supply_v", "supply_a", "supply_temperature_c", "current_5_a", "temperature_4_c"} <= set(
        read.telemetry
    )
    assert np.nanmax(read.telemetry["supply_temperature_c"]) == pytest.approx(41.0)  # of the warmest
    assert all(is_known_column(name) for name in read.telemetry)
