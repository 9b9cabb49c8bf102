"""Runs to write and ways to compare them, shared by the tests of this folder."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from snakebot.robot import Robot, load_robot, robot_from_mapping
from snakebot.runlog import (
    Event,
    LinkRecord,
    PoseRecord,
    RawFrame,
    RunLog,
    RunWriter,
    Telemetry,
    Tick,
)
from snakebot.runlog.records import SteeringRecord

ROBOT = load_robot("penn_state")
START_NS = 1_795_000_000_000_000_000
REALDATA = Path(__file__).resolve().parents[3] / "shared" / "realdata"
ONE_JOINT = "robot: {joints: 1}\nruns:\n  - {file: run.csv}\n"
ROWS = "t_s,cmd_1_rad,enc_1_rad\n0.0,0.1,0.2\n0.01,0.3,0.4\n"


def session_folder(
    folder: Path, table: str | bytes = ROWS, text: str = ONE_JOINT, name: str = "run.csv"
) -> Path:
    """A session of one table, written as it is given."""
    folder.mkdir(exist_ok=True)
    (folder / "session.yaml").write_text(text)
    (folder / name).write_bytes(table if isinstance(table, bytes) else table.encode())
    return folder


def bench(joints: int) -> Robot:
    return robot_from_mapping({"joints": joints}, "test")


def make_ticks(count: int, joints: int = 5, seed: int = 0, rate_hz: float = 200.0) -> list[Tick]:
    """Ticks with lost samples, servo-off stretches, board silence and late ticks strewn in."""
    rng = np.random.default_rng(seed)
    angles = rng.normal(size=(count, 4, joints))
    angles[rng.random(angles.shape) < 0.05] = np.nan
    ticks = []
    for i in range(count):
        silent = rng.random() < 0.1
        ticks.append(
            Tick(
                sequence=i,
                t_s=i / rate_hz,
                host_time_ns=START_NS + round(i / rate_hz * 1e9) + int(rng.integers(1000)),
                setpoint_rad=angles[i, 0],
                sent_rad=angles[i, 1],
                applied_rad=None if silent else angles[i, 2],
                measured_rad=None if silent else angles[i, 3],
                board_time_us=None if silent else 10_000_000 + i * 5000,
                latency_s=None if silent else float(rng.random() * 1e-3),
                late=bool(rng.random() < 0.1),
            )
        )
    return ticks


def write_ticks(path: Path, ticks: list[Tick], robot: Robot = ROBOT, **options: object) -> Path:
    with RunWriter(path, robot, start_time_ns=START_NS, **options) as writer:  # type: ignore[arg-type]
        for tick in ticks:
            writer.tick(tick)
    return writer.path


def write_everything(path: Path, count: int = 50) -> Path:
    """A log with something on every channel."""
    about = {
        "gait": {"alpha_deg": 66.0, "beta_deg": 80.0, "omega_rad_s": 2.0},
        "port": "sim:",
        "simulated": True,
    }
    with RunWriter(
        path, ROBOT, about, attachments={"snakebot.dbc": b'VERSION ""'}, start_time_ns=START_NS
    ) as writer:
        writer.event(Event(0.0, "armed", "joints powered", data={"start_rad": np.zeros(5)}))
        for tick in make_ticks(count):
            writer.tick(tick)
            writer.pose(PoseRecord(tick.t_s, 0.01 * tick.sequence, -0.5, 0.1, 0.13))
        writer.steering(SteeringRecord(0.1, 0.2, 0.1, 0.05, 0.0, -0.05, 0.1, 0.03, 0.04, False, False))
        writer.link_statistics(LinkRecord(0.1, {"sent": 12, "corrupt": 0}))
        writer.link_statistics(LinkRecord(0.2, {"sent": 24, "received": 7}))
        writer.telemetry(Telemetry(0.05, {"supply_v": 7.4, "temperature_1_c": 31.0}))
        writer.frame(RawFrame(0.1, "sent", 0x123, b"\x00\xff"))
        writer.add_metadata({"ended": "finished"})
    return writer.path


def flushed(writer: RunWriter) -> None:
    """Wait until all that was recorded is in the ``.part``."""
    writer._wake.set()
    while writer._written_bytes < writer._queued_bytes:
        time.sleep(0.005)


def assert_equals_ticks(log: RunLog, ticks: list[Tick]) -> None:
    """Every row of the log is one of the ticks, to the last bit, and in order."""
    by_sequence = {tick.sequence: tick for tick in ticks}
    joints = log.joints
    nothing = np.full(joints, np.nan)
    for row, sequence in enumerate(log.sequence.tolist()):
        tick = by_sequence[sequence]
        assert log.t_s[row] == tick.t_s
        assert log.host_time_ns[row] == tick.host_time_ns
        assert log.late[row] == tick.late
        for name in ("setpoint_rad", "sent_rad", "applied_rad", "measured_rad"):
            wanted = getattr(tick, name)
            np.testing.assert_array_equal(getattr(log, name)[row], nothing if wanted is None else wanted)
        for name in ("board_time_us", "latency_s"):
            wanted = getattr(tick, name)
            np.testing.assert_array_equal(getattr(log, name)[row], np.nan if wanted is None else wanted)
    assert np.all(np.diff(log.t_s) >= 0)
