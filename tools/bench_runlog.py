#!/usr/bin/env python
"""How fast run logs are written and read, beside the plain mcap package doing the same.

    tools/bench_runlog.py [--seconds 60] [--rate 200] [--joints 5] [--repeat 5]

Reading: ``snakebot.runlog.read_log`` against ``mcap.reader.make_reader`` + ``json.loads`` (as its documentation shows,
checksums on) and against the same with orjson, all ending in the same numpy arrays. Writing: time in the calling
thread for one ``RunWriter.tick`` while the log's own threads are at work, against ``mcap.writer.Writer.add_message``
with ``json.dumps``, which writes to the disk in the calling thread.
"""

from __future__ import annotations

import argparse
import json
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import orjson
from mcap.reader import make_reader
from mcap.writer import Writer

from snakebot.robot import robot_from_mapping
from snakebot.runlog import PoseRecord, RunWriter, Tick, read_log
from snakebot.runlog.channels import JOINTS

AIM_READ_S = 0.2
AIM_TICK_US = 50.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--rate", type=float, default=200.0)
    parser.add_argument("--joints", type=int, default=5)
    parser.add_argument("--repeat", type=int, default=5)
    options = parser.parse_args()
    count = round(options.seconds * options.rate)
    ticks = make_ticks(count, options.joints, options.rate)
    with tempfile.TemporaryDirectory() as folder:
        path = write(Path(folder) / "run", ticks, options.joints)
        print(
            f"{count} ticks ({options.seconds:g} s at {options.rate:g} Hz), {options.joints} joints, a pose a tick"
        )
        print(f"finished log {path.stat().st_size / 1e6:.2f} MB")
        bench_reading(path, options.repeat)
        bench_writing(Path(folder), ticks, options.joints)


def make_ticks(count: int, joints: int, rate_hz: float) -> list[Tick]:
    """Angles as they are: sines, encoders in counts."""
    t_s = np.arange(count) / rate_hz
    wave = 1.15 * np.sin(2 * t_s[:, None] + np.arange(joints))
    step = 2 * np.pi / 8192
    measured = np.round(1.1 * np.sin(2 * (t_s[:, None] - 0.03) + np.arange(joints)) / step) * step
    start = time.time_ns()
    latency = np.random.default_rng(0).normal(1e-3, 1e-4, count)
    return [
        Tick(
            i,
            float(t_s[i]),
            start + i,
            wave[i],
            wave[i],
            wave[i],
            measured[i],
            i * 5000,
            float(latency[i]),
            False,
        )
        for i in range(count)
    ]


def write(path: Path, ticks: list[Tick], joints: int) -> Path:
    with RunWriter(path, robot_from_mapping({"joints": joints}, "bench")) as writer:
        for tick in ticks:
            writer.tick(tick)
            writer.pose(PoseRecord(tick.t_s, 0.13 * tick.t_s, 0.01, 0.1, 0.13))
    return writer.path


def with_mcap(path: Path, loads: Callable[[bytes], dict[str, object]]) -> dict[str, np.ndarray]:
    """The ticks and poses through the mcap package's reader."""
    rows: list[dict[str, object]] = []
    poses: list[dict[str, object]] = []
    with path.open("rb") as file:
        for _, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            (rows if channel.topic == JOINTS.topic else poses).append(loads(message.data))
    nothing = [None] * len(rows[0]["setpoint_rad"])  # type: ignore[arg-type]
    names = ("setpoint_rad", "sent_rad", "applied_rad", "measured_rad")
    arrays = {name: np.array([row[name] or nothing for row in rows], dtype=float) for name in names}
    arrays.update({name: np.array([row[name] for row in rows], dtype=float) for name in ("t_s", "latency_s")})
    arrays["heading_rad"] = np.array([pose["heading_rad"] for pose in poses], dtype=float)
    return arrays


def timed(function: Callable[[], object], repeat: int) -> tuple[float, float, float]:
    """Best and median wall time of some runs, and best processor time (the same on a busy machine), s."""
    wall, processor = [], []
    for _ in range(repeat):
        start, start_cpu = time.perf_counter(), time.process_time()
        function()
        wall.append(time.perf_counter() - start)
        processor.append(time.process_time() - start_cpu)
    return min(wall), statistics.median(wall), min(processor)


def bench_reading(path: Path, repeat: int) -> None:
    ours, theirs = read_log(path), with_mcap(path, json.loads)
    for name in ("setpoint_rad", "sent_rad", "applied_rad", "measured_rad", "t_s", "latency_s"):
        np.testing.assert_array_equal(getattr(ours, name), theirs[name])  # the same work was done
    print("\nreading                             best s   median s   processor s")
    best: dict[str, float] = {}
    for name, function in (
        ("snakebot.runlog.read_log", lambda: read_log(path)),
        ("mcap make_reader + orjson", lambda: with_mcap(path, orjson.loads)),
        ("mcap make_reader + json", lambda: with_mcap(path, json.loads)),
    ):
        best[name], median, processor = timed(function, repeat)
        print(f"{name:<33} {best[name]:8.3f}   {median:8.3f}      {processor:8.3f}")
    ours_s = best["snakebot.runlog.read_log"]
    verdict = "met" if ours_s < AIM_READ_S else "missed"
    print(
        f"aim under {AIM_READ_S:g} s: {verdict}; {best['mcap make_reader + json'] / ours_s:.1f}x the mcap package"
    )


def bench_writing(folder: Path, ticks: list[Tick], joints: int) -> None:
    """Paced at 500 Hz, as the fastest run loop would call it."""
    paced = ticks[:1500]
    with RunWriter(folder / "paced", robot_from_mapping({"joints": joints}, "bench")) as writer:
        ours = call_times(writer.tick, paced)
    with (folder / "plain.mcap").open("wb", buffering=0) as file:
        plain = Writer(file, chunk_size=16 << 10)
        plain.start()
        channel = plain.register_channel("/joints", "json", plain.register_schema("j", "jsonschema", b"{}"))

        def add(tick: Tick) -> None:
            row = {
                "t_s": tick.t_s,
                "setpoint_rad": list(tick.setpoint_rad),
                "sent_rad": list(tick.sent_rad),
                "applied_rad": None if tick.applied_rad is None else list(tick.applied_rad),
                "measured_rad": None if tick.measured_rad is None else list(tick.measured_rad),
            }
            plain.add_message(
                channel, tick.host_time_ns, json.dumps(row).encode(), tick.host_time_ns, tick.sequence
            )

        theirs = call_times(add, paced)
        plain.finish()
    print("\nwriting, per tick in the calling thread, 500 Hz   median us    p99 us    max us")
    for name, times in (("snakebot.runlog.RunWriter.tick", ours), ("mcap Writer.add_message + json", theirs)):
        print(f"{name:<48} {np.median(times):10.1f} {np.quantile(times, 0.99):9.1f} {times.max():9.1f}")
    verdict = "met" if np.median(ours) < AIM_TICK_US else "missed"
    print(f"aim under {AIM_TICK_US:g} us: {verdict}")


def call_times(function: Callable[[Tick], None], ticks: list[Tick]) -> np.ndarray:
    times = np.empty(len(ticks))
    due = time.perf_counter()
    for i, tick in enumerate(ticks):
        due += 0.002
        time.sleep(max(0.0, due - time.perf_counter()))
        start = time.perf_counter_ns()
        function(tick)
        times[i] = (time.perf_counter_ns() - start) * 1e-3
    return times


if __name__ == "__main__":
    main()
