#!/usr/bin/env python3
"""How fast the physics is, beside MuJoCo and beside scipy, and how near the kernel comes to what a core can do.

One run prints:
  * what a core can do: multiply-adds in vector registers, from a small kernel that does nothing else;
  * the grid of 9000 gaits of the paper (alpha 3..90 step 3, beta 6..180 step 6, omega 0.5..5 step 0.5; 8 cycles each);
  * one robot alone, in simulated seconds per second;
  * (a) a MuJoCo chain doing the same gaits, with the ground's forces compiled, and (b) the paper's equations in numpy
    with scipy's solve_ivp, as a user would write them; each with the speed it finds, so that the accuracy shows;
  * operations per step, counted by running the kernel's own source on numbers that count, and the share of the peak;
  * the cost of a step for 2 to 32 links.

Every figure of time is of wall time. "cores" is processor time over wall time: what the machine gave to this run; on a
machine that others use too it says how far the figures can be trusted.

examples:
  tools/bench_physics.py --quick          a minute; a sample of 900 gaits of the grid
  tools/bench_physics.py                  the whole grid
  tools/bench_physics.py --json out.json  the figures for a machine, too
"""

from __future__ import annotations

import argparse
import json
import math
import os
import platform
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from physics_operations import operations_per_step, peak_gflops
from physics_peers import MujocoChain, PaperChain, gait_reference

from snakebot.physics import Chain, ChainModel, Drive, gait_eps_m_s, replay, simulate_gaits
from snakebot.physics.gaits import default_steps_per_cycle
from snakebot.physics.lanes import WIDTH
from snakebot.robot import load_robot

CYCLES = 8


def model_of(robot: str, **changes: Any) -> ChainModel:
    body = load_robot(robot).body
    assert body is not None
    return ChainModel.from_body(body.model_copy(update=changes))


def grid() -> np.ndarray[Any, Any]:
    alpha, beta, omega = np.meshgrid(
        np.radians(np.arange(3, 91, 3)),
        np.radians(np.arange(6, 181, 6)),
        np.arange(0.5, 5.01, 0.5),
        indexing="ij",
    )
    return np.column_stack((alpha.ravel(), beta.ravel(), omega.ravel()))


def timed(work: Callable[[], Any]) -> tuple[Any, float, float]:
    """What it returned, wall time, cores it had."""
    wall, cpu = time.perf_counter(), time.process_time()
    result = work()
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    return result, wall, cpu / wall


def best_of(times: int, work: Callable[[], Any]) -> tuple[Any, float, float]:
    return min((timed(work) for _ in range(times)), key=lambda run: run[1])


def bench_grid(robot: str, quick: bool, peak: float) -> dict[str, Any]:
    model, gaits = model_of(robot), grid()
    if quick:
        gaits = gaits[np.random.default_rng(0).permutation(len(gaits))[:904]]
    simulate_gaits(model, gaits[:WIDTH], cycles=1, averaged_cycles=1)
    result, wall, cores = timed(lambda: simulate_gaits(model, gaits))
    steps = default_steps_per_cycle(model)
    done = len(gaits) * CYCLES * steps
    operations = operations_per_step(model)
    gflops_per_core = done * operations / (wall * cores) / 1e9
    return {
        "robot": robot,
        "gaits": len(gaits),
        "steps_per_cycle": steps,
        "wall_s": wall,
        "cores": cores,
        "gaits_per_s": len(gaits) / wall,
        "gaits_per_core_s": len(gaits) / wall / cores,
        "grid_of_9000_s": 9000 * wall / len(gaits),
        "steps_per_s": done / wall,
        "operations_per_step": operations,
        "gflops_per_core": gflops_per_core,
        "share_of_peak": gflops_per_core / peak,
        "finite": bool(np.all(np.isfinite(result.speed_m_s) & np.isfinite(result.power_in_w))),
    }


def bench_accuracy(robot: str) -> dict[str, Any]:
    """Largest change of speed and of power, over the sample of gaits, when step and eps are refined."""
    model = model_of(robot)
    gaits = np.array([[math.radians(a), math.radians(b), w] for a, b, w in SAMPLE])
    steps = default_steps_per_cycle(model)
    plain = simulate_gaits(model, gaits)
    fine = simulate_gaits(model, gaits, steps_per_cycle=16 * steps)
    halves = [
        simulate_gaits(model.with_eps(gait_eps_m_s(model, g[0], g[2]) / 2), g, steps_per_cycle=16 * steps)
        for g in gaits
    ]
    sharp = np.array([(h.speed_m_s[0], h.power_in_w[0]) for h in halves]).T
    both = np.array((fine.speed_m_s, fine.power_in_w))
    return {
        "robot": robot,
        "of_step": np.abs(np.array((plain.speed_m_s, plain.power_in_w)) / both - 1).max(axis=1).tolist(),
        "of_eps_halved": np.abs(both / sharp - 1).max(axis=1).tolist(),
    }


def bench_one_robot(robot: str) -> dict[str, Any]:
    """Online, called from Python every millisecond; and a replay, in one compiled loop."""
    model = model_of(robot)
    chain, drive = Chain(model, 1e-3), Drive.at_rest(model.joints)
    follow = gait_reference(1.0, 1.4, 2.0, model.joints)
    drives = [follow(1e-3 * i)[:2] for i in range(1, 5001)]

    def online() -> None:
        for drive.angle_rad[:], drive.rate_rad_s[:] in drives:
            chain.step(drive)

    chain.step(drive)
    _, wall, cores = best_of(3, online)
    t = np.arange(0, 200, 5e-3)
    angles = np.array([follow(now)[0] for now in t])
    replay(model, t[:10], angles[:10])
    _, replay_wall, replay_cores = best_of(3, lambda: replay(model, t, angles))
    return {
        "robot": robot,
        "online_us_per_step": wall / 5000 * 1e6 * min(1.0, cores),
        "online_simulated_s_per_s": 5.0 / wall,
        "online_cores": cores,
        "replay_simulated_s_per_s": 200 / replay_wall,
        "replay_cores": replay_cores,
    }


# kp, kd and step of the MuJoCo chain: about the stiffest servo and the longest step that are stable for the sample.
MUJOCO = {"saito": (2000.0, 100.0, 2e-3), "penn_state": (300.0, 3.0, 5e-4)}
SAMPLE = [
    (66, 80, 2.0),
    (30, 60, 1.0),
    (45, 90, 4.0),
    (60, 72, 5.0),
    (21, 60, 2.0),
    (39, 78, 3.0),
    (75, 84, 1.5),
]


def bench_mujoco(robot: str, ours_per_core_s: float) -> dict[str, Any]:
    model, (kp, kd, dt) = model_of(robot), MUJOCO[robot]
    steps_done, wall_all, cpu_all, ratios = 0, 0.0, 0.0, []
    for alpha, beta, omega in SAMPLE:
        gait = (math.radians(alpha), math.radians(beta), omega)
        every = math.ceil(2 * math.pi / omega / dt)
        same_eps = model.with_eps(gait_eps_m_s(model, gait[0], omega))
        peer = MujocoChain(same_eps, dt_s=2 * math.pi / omega / every, kp=kp, kd=kd)
        peer.run(gait, every, every)  # compile
        rows, wall, cores = timed(partial(peer.run, gait, CYCLES * every, every))
        way = np.linalg.norm(np.diff(rows[3:, 1:3], axis=0), axis=1).mean()
        ratios.append(way * omega / (2 * math.pi) / simulate_gaits(model, gait).speed_m_s[0])
        steps_done += CYCLES * every
        wall_all += wall
        cpu_all += wall * cores
    return {
        "robot": robot,
        "step_s": dt,
        "gaits": len(SAMPLE),
        "gaits_per_core_s": len(SAMPLE) / cpu_all,
        "steps_per_core_s": steps_done / cpu_all,
        "cores": cpu_all / wall_all,
        "speed_over_ours": [min(ratios), max(ratios)],
        "we_are_faster_by": ours_per_core_s / (len(SAMPLE) / cpu_all),
    }


def bench_scipy(robot: str, ours_per_core_s: float, quick: bool) -> dict[str, Any]:
    model = model_of(robot)
    alpha, beta, omega = math.radians(66), math.radians(80), 2.0
    if robot == "saito":
        alpha, beta = math.radians(22), math.radians(60)
    model = model.with_eps(gait_eps_m_s(model, alpha, omega))
    cycles = 4 if quick else CYCLES
    period = 2 * math.pi / omega
    peer = PaperChain(model, gait_reference(alpha, beta, omega, model.joints))
    t = np.linspace(0, cycles * period, cycles + 1)
    states, wall, cores = timed(lambda: peer.solve(t, np.zeros(6)))
    way = np.linalg.norm(states[-1, 0:2] - states[-2, 0:2]) / period
    ours = simulate_gaits(model, [alpha, beta, omega], cycles=cycles, averaged_cycles=1).speed_m_s[0]
    cpu = wall * min(cores, 1.0) * CYCLES / cycles
    return {
        "robot": robot,
        "method": "LSODA, rtol 1e-6",
        "cycles_run": cycles,
        "cpu_s_per_gait": cpu,
        "speed_over_ours": way / ours,
        "we_are_faster_by": ours_per_core_s * cpu,
    }


def bench_links(peak: float) -> list[dict[str, Any]]:
    rows = []
    for n in (2, 3, 4, 6, 8, 12, 16, 24, 32):
        model = model_of("penn_state", links=n)
        gaits = np.column_stack(
            (np.full(64, 0.6), np.full(64, 2 * math.pi / max(n, 4)), np.linspace(1, 4, 64))
        )
        work = partial(simulate_gaits, model, gaits, cycles=2, averaged_cycles=1)
        work()
        _, wall, cores = best_of(3, work)
        steps = 64 * 2 * default_steps_per_cycle(model)
        ns = wall * cores / steps * 1e9
        operations = operations_per_step(model)
        rows.append({
            "links": n, "ns_per_step": ns, "ns_per_step_and_link": ns / n, "operations_per_step": operations,
            "share_of_peak": operations / ns / peak,
        })  # fmt: skip
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--quick", action="store_true", help="a sample of the grid; scipy does 4 of the 8 cycles"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there, too")
    options = parser.parse_args()

    peak = peak_gflops()
    load = os.getloadavg()[0]
    print(f"{platform.machine()}, {os.cpu_count()} cores, load {load:.1f}")
    print(f"one core, multiply-adds in registers: {peak:.1f} Gflop/s\n")

    print("grid of gaits, 8 cycles each")
    grids = {}
    for robot in ("saito", "penn_state"):
        row = grids[robot] = bench_grid(robot, options.quick, peak)
        print(
            f"  {robot:11s} {row['gaits']} gaits in {row['wall_s']:.2f} s on {row['cores']:.2f} cores: "
            f"{row['gaits_per_s']:.0f} gaits/s, {row['steps_per_s'] / 1e6:.2f} M steps/s; 9000 gaits: "
            f"{row['grid_of_9000_s']:.1f} s, {row['grid_of_9000_s'] * row['cores']:.1f} core seconds (paper: 25 h)"
        )
        print(
            f"  {'':11s} {row['operations_per_step']} operations a step, {row['gflops_per_core']:.1f} Gflop/s a core: "
            f"{100 * row['share_of_peak']:.0f} % of what a core can do"
        )
    accuracy = {robot: bench_accuracy(robot) for robot in grids}
    print("\naccuracy: largest change over a sample of gaits (speed, power)")
    for robot, row in accuracy.items():
        step, eps = row["of_step"], row["of_eps_halved"]
        print(
            f"  {robot:11s} a sixteenth of the step: {100 * step[0]:.2f} %, {100 * step[1]:.2f} %; "
            f"half of eps: {100 * eps[0]:.2f} %, {100 * eps[1]:.2f} %"
        )
    alone = bench_one_robot("penn_state")
    print(
        f"\none robot (penn_state)\n  online, step by step from Python: {alone['online_us_per_step']:.1f} us a step of "
        f"1 ms, {alone['online_simulated_s_per_s']:.0f} simulated s per s on {alone['online_cores']:.2f} cores\n"
        f"  replay at 200 Hz: {alone['replay_simulated_s_per_s']:.0f} simulated s per s on "
        f"{alone['replay_cores']:.2f} cores"
    )
    print("\npeers, per second of one core")
    peers = {}
    for robot in ("saito", "penn_state"):
        ours = grids[robot]["gaits_per_core_s"]
        mujoco = bench_mujoco(robot, ours)
        scipy = bench_scipy(robot, ours, options.quick)
        peers[robot] = {"mujoco": mujoco, "scipy": scipy}
        low, high = mujoco["speed_over_ours"]
        print(
            f"  {robot:11s} snakebot {ours:.0f} gaits/s\n"
            f"  {'':11s} MuJoCo   {mujoco['gaits_per_core_s']:.1f} gaits/s ({mujoco['steps_per_core_s'] / 1e3:.0f} k "
            f"steps/s of {1e3 * mujoco['step_s']:.1f} ms; its speeds are {low:.3f} to {high:.3f} of ours): "
            f"{mujoco['we_are_faster_by']:.0f} times slower\n"
            f"  {'':11s} scipy    {1 / scipy['cpu_s_per_gait']:.2f} gaits/s ({scipy['method']}; its speed is "
            f"{scipy['speed_over_ours']:.4f} of ours): {scipy['we_are_faster_by']:.0f} times slower"
        )
    print(
        "\ncost against the number of links (penn_state, one core)\n  links  ns/step  ns/step/link  operations  of peak"
    )
    links = bench_links(peak)
    for row in links:
        print(
            f"  {row['links']:5d}  {row['ns_per_step']:7.0f}  {row['ns_per_step_and_link']:12.1f}  "
            f"{row['operations_per_step']:10d}  {100 * row['share_of_peak']:6.0f} %"
        )
    if options.json:
        figures = {
            "peak_gflops": peak,
            "grid": grids,
            "accuracy": accuracy,
            "one_robot": alone,
            "peers": peers,
            "links": links,
        }
        options.json.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
