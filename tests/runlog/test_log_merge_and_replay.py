"""``snakebot log merge-speed`` and ``replay``, as a user types them and underneath."""

from __future__ import annotations

import json
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from log_commands import Capture, snakebot, wave_log
from runlog_samples import ROBOT, START_NS, write_everything

from snakebot.errors import BadInputError
from snakebot.gait import Gait, SampledMotion, check_motion
from snakebot.runlog import RunWriter, Tick, open_run, read_log
from snakebot.runlog.merging import PoseTrack, align_track, with_heading
from snakebot.runlog.replaying import recorded_setpoints


def test_merge_a_speed(tmp_path: Path, capsys: Capture) -> None:
    path = write_everything(tmp_path / "a.mcap")
    before = read_log(path)
    snakebot(capsys, "log", "merge-speed", path, "--speed", "0.131")
    after = read_log(path)
    assert after.forward_speed_m_s == 0.131
    assert after.to_run().forward_speed_m_s == 0.131
    np.testing.assert_array_equal(after.measured_rad, before.measured_rad)
    np.testing.assert_array_equal(after.pose, before.pose)
    assert after.events == before.events
    assert after.attachments == before.attachments
    snakebot(capsys, "log", "merge-speed", path, "--speed", "0.2", "-o", tmp_path / "b.mcap")
    assert read_log(path).forward_speed_m_s == 0.131
    assert read_log(tmp_path / "b.mcap").forward_speed_m_s == 0.2
    assert "not a finite number" in snakebot(capsys, "log", "merge-speed", path, "--speed", "nan", status=2)
    assert "one of them" in snakebot(capsys, "log", "merge-speed", path, status=2)
    part = tmp_path / "p.mcap.part"
    part.write_bytes(path.read_bytes())
    assert "recover" in snakebot(capsys, "log", "merge-speed", part, "--speed", "1", status=6)


def _camera(path: Path, offset_s: float, speed_m_s: float = 0.2, heading_rad: float = 0.7) -> Path:
    """A camera that starts before the run and ends after it: 30 Hz, millimetres, a course of its own."""
    t_s = np.arange(0, 20 + offset_s + 3, 1 / 30)
    run_s = np.clip(t_s - offset_s, 0, 20)
    ramp = np.clip(np.minimum(run_s, 20 - run_s) / 2, 0, 1)
    along, across = np.cumsum(ramp) * speed_m_s / 30, 0.02 * np.sin(2 * run_s) * ramp
    x = along * np.cos(heading_rad) - across * np.sin(heading_rad)
    y = along * np.sin(heading_rad) + across * np.cos(heading_rad)
    rows = "".join(f"{t:.5f},{1000 * a:.3f},{1000 * b:.3f}\n" for t, a, b in zip(t_s, x, y, strict=True))
    path.write_text("t,X,Y\n" + rows)
    return path


@pytest.mark.parametrize("offset_s", [0.4, 3.7])
def test_merge_a_track_aligned_by_the_motion(tmp_path: Path, capsys: Capture, offset_s: float) -> None:
    path = wave_log(tmp_path / "a.mcap")
    camera = _camera(tmp_path / "cam.csv", offset_s)
    maps = ("--map", "t_s=t", "--map", "x_m=X:mm", "--map", "y_m=Y:mm")
    told = json.loads(snakebot(capsys, "log", "merge-speed", path, "--track", camera, *maps, "--json"))
    assert told["aligned_by"] == "motion"
    assert told["offset_s"] == pytest.approx(offset_s, abs=0.1)
    assert told["forward_speed_m_s"] == pytest.approx(0.2, rel=0.02)
    run = open_run(path)
    assert run.forward_speed_m_s == told["forward_speed_m_s"]
    assert run.pose is not None
    steady = (run.t_s > 4) & (run.t_s < 16)
    assert np.isfinite(run.pose[steady]).all()
    assert np.mean(run.pose[steady, 2]) == pytest.approx(0.7, abs=0.1)  # the direction of travel


def test_a_track_with_a_given_offset_or_a_wall_clock(tmp_path: Path, capsys: Capture) -> None:
    path = wave_log(tmp_path / "a.mcap")
    camera = _camera(tmp_path / "cam.csv", 3.7)
    maps = ("--map", "t_s=t", "--map", "x_m=X:mm", "--map", "y_m=Y:mm")
    run = ("log", "merge-speed", path, "--track", camera, *maps)
    told = json.loads(snakebot(capsys, *run, "--offset", "3.7", "-o", tmp_path / "b.mcap", "--json"))
    assert told["aligned_by"] == "given"
    assert "do not overlap" in snakebot(capsys, *run, "--offset", "300", status=2)
    assert "column t is missing" not in snakebot(capsys, "log", "info", tmp_path / "b.mcap")
    rows = camera.read_text().splitlines()
    shifted = [f"{float(r.split(',')[0]) + START_NS * 1e-9 - 3.7:.4f},{r.split(',', 1)[1]}" for r in rows[1:]]
    camera.write_text("\n".join(["t,X,Y", *shifted]))
    told = json.loads(snakebot(capsys, *run, "--json"))
    assert told["aligned_by"] == "wall clock"
    assert told["forward_speed_m_s"] == pytest.approx(0.2, rel=0.02)


def test_a_track_of_something_else_is_refused(tmp_path: Path) -> None:
    log = read_log(wave_log(tmp_path / "a.mcap"))
    rng = np.random.default_rng(0)
    track = PoseTrack(
        np.arange(600) / 30, np.column_stack([np.cumsum(rng.normal(size=(600, 2)), axis=0), np.zeros(600)])
    )
    with pytest.raises(BadInputError, match="give --offset"):
        align_track(log, track)


def test_heading_is_the_direction_of_travel_where_none_is_measured() -> None:
    t_s = np.arange(0, 10, 0.1)
    angle = 0.3 * t_s
    pose = np.column_stack([np.cumsum(np.cos(angle)), np.cumsum(np.sin(angle)), np.full(100, np.nan)])
    heading = with_heading(PoseTrack(t_s, pose), 1.0).pose[:, 2]
    np.testing.assert_allclose(heading[10:-10], angle[10:-10], atol=0.05)
    known = PoseTrack(t_s, np.zeros((100, 3)))
    assert with_heading(known, 1.0) is known


def _ticks_at(path: Path, t_s: np.ndarray, angles: np.ndarray, about: dict[str, object]) -> Path:
    with RunWriter(path, ROBOT, about, start_time_ns=START_NS) as writer:
        for i, t in enumerate(t_s.tolist()):
            writer.tick(Tick(i, t, START_NS, angles[i], angles[i]))
    return writer.path


def test_recorded_setpoints_are_those_of_the_ticks(tmp_path: Path) -> None:
    """Ticks that were sent late do not make the replayed motion jerk."""
    due = np.arange(400) / 100
    sent = due + np.random.default_rng(0).uniform(0, 0.004, due.size)
    gait = Gait.from_degrees(40, 80, 2)
    t_s, angles = recorded_setpoints(
        read_log(_ticks_at(tmp_path / "a", sent, gait.angles(due, 5), {"rate_hz": 100.0}))
    )
    np.testing.assert_allclose(t_s, due, atol=1e-12)
    motion = SampledMotion(t_s, angles, 1.0)
    fine = np.arange(0.0, due[-1], 0.001)
    sampled = motion.sampled(1.0 + fine)
    np.testing.assert_allclose(sampled, gait.angles(fine, 5), atol=1e-6)
    acceleration = np.diff(sampled, n=2, axis=0) / 0.001**2
    assert np.abs(acceleration).max() < 1.05 * gait.alpha_rad * gait.omega_rad_s**2


@pytest.mark.parametrize("gap_s", [0.6, 200_000.0, 1e7])
def test_a_gap_is_told_and_not_replayed(tmp_path: Path, capsys: Capture, gap_s: float) -> None:
    t_s = np.arange(200) / 100
    t_s[100:] += gap_s
    log = _ticks_at(tmp_path / "gap", t_s, Gait.from_degrees(10, 80, 1).angles(t_s, 5), {"rate_hz": 100.0})
    tracemalloc.start()
    said = snakebot(capsys, "log", "replay", log, "--dry-run", status=2)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert f"no set-points between 0.990 and {1 + gap_s:.3f} s" in said
    assert "cut it at the gap" in said
    assert peak < 64 << 20  # it took 11 GB


def test_memory_of_a_replay_goes_with_the_ticks_and_not_with_the_time(tmp_path: Path) -> None:
    """An hour of two set-points a second."""
    t_s = np.arange(0.0, 3600.0, 0.5)
    log = read_log(_ticks_at(tmp_path / "slow", t_s, np.zeros((t_s.size, 5)), {}))
    tracemalloc.start()
    motion = SampledMotion(*recorded_setpoints(log), 2.0)
    check_motion(motion, ROBOT)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 100 << 20  # 173 MB were resampled set-points alone


@pytest.mark.parametrize(
    ("far_rad", "words"), [(1e300, "joint 4: the motion asks for angle"), (1.7e308, "too far apart")]
)
def test_set_points_beyond_all_numbers_are_refused(
    tmp_path: Path, capsys: Capture, far_rad: float, words: str
) -> None:
    t_s = np.arange(100) / 100
    angles = np.zeros((100, 5))
    angles[50:, 3] = far_rad
    angles[51::2, 3] = -far_rad
    said = snakebot(
        capsys, "log", "replay", _ticks_at(tmp_path / "far", t_s, angles, {}), "--dry-run", status=2
    )
    assert words in said


def test_replay_on_the_simulated_board(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    first = wave_log(tmp_path / "first.mcap", duration_s=5)
    told = json.loads(snakebot(capsys, "log", "replay", first, "--fast", "--log", "second.mcap", "--json"))
    assert told["ended"] == "finished"
    second = read_log(tmp_path / "second.mcap")
    assert second.metadata["replay_of"] == "first"
    assert second.metadata["simulated"] is True
    wanted = read_log(first)
    again = np.interp(
        wanted.t_s + 2.0, second.t_s, second.setpoint_rad[:, 1]
    )  # after the ramp to the first posture
    np.testing.assert_allclose(again, wanted.setpoint_rad[:, 1], atol=2e-3)


def test_replay_checks_limits_and_nonsense_before_anything_moves(tmp_path: Path, capsys: Capture) -> None:
    t_s = np.arange(0, 2, 0.01)
    wild = np.zeros((200, 5))
    wild[:, 2] = 3.0 * np.sin(3 * t_s)
    path = _ticks_at(tmp_path / "wild", t_s, wild, {})
    said = snakebot(capsys, "log", "replay", path, status=2)
    assert "joint 3" in said
    assert "allows" in said
    off = wild * np.nan
    assert "servos were off" in snakebot(
        capsys, "log", "replay", _ticks_at(tmp_path / "off", t_s, off, {}), status=2
    )
    one = _ticks_at(tmp_path / "one", t_s[:1], wild, {})
    assert "nothing to replay" in snakebot(capsys, "log", "replay", one, status=2)
    assert "no such log" in snakebot(capsys, "log", "replay", tmp_path / "gone.mcap", status=2)
    robot = tmp_path / "bench.yaml"
    robot.write_text("joints: 2\n")
    assert "5 joints recorded" in snakebot(capsys, "log", "replay", path, "--robot", robot, status=2)
    assert not (tmp_path / "runs").exists()
    calm = wave_log(tmp_path / "calm.mcap", duration_s=5)
    assert json.loads(snakebot(capsys, "log", "replay", calm, "--dry-run", "--json"))["joints"] == 5
