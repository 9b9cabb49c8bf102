"""How work scales on a dask cluster: python tools/bench_cluster.py [--json]

A sweep of gaits, the choice of a gait and a few sessions to diagnose, each in one plain process, and handed to local
clusters of one and of two workers. Seconds by the clock, and each over the plain run's. Plain sweeps and choices use
all cores, workers one each: so two workers on two cores are at best as fast as the plain run. Sessions are
diagnosed one by one in the plain run. Whatever else the computer does is in the figures.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from distributed import Client, LocalCluster

from snakebot.cluster import Workers
from snakebot.diagnosis.many import diagnose_many
from snakebot.effects import predict
from snakebot.gait import Gait, GaitMotion
from snakebot.optimise.goal import Goal
from snakebot.optimise.optimum import optimise
from snakebot.optimise.promise import OptimiseOptions
from snakebot.robot import Robot, load_robot
from snakebot.runlog import Run, Session
from snakebot.studies.sweep import Conditions, sweep

GAITS = ((66, 80, 2.0), (30, 80, 4.0), (50, 60, 1.0))
WORKERS = (0, 1, 2)  # 0: the plain run


def session(number: int) -> Session:
    """Three runs of a bench of two servos whose rate is limited."""
    robot, runs = Robot(name="bench", joints=2), []
    rng = np.random.default_rng(number)
    t = np.arange(600) / 100
    for name, (alpha, beta, omega) in enumerate(GAITS):
        wave = Gait.from_degrees(alpha, beta, omega)
        command = GaitMotion(wave, 2, 6.0, 1.0).sampled(t)
        made = predict(robot, [f"rate_limit:limit_rad_s={1 + 0.1 * number}"], t, command, body=False)
        noisy = made.encoder_rad + 1e-3 * rng.normal(size=command.shape)
        runs.append(Run(f"run_{name}.csv", t, command, noisy, gait=wave))
    return Session(robot, tuple(runs))


def works(gaits: int, sessions: int) -> dict[str, Callable[[str | None], Any]]:
    """Each takes a scheduler's address or None."""
    robot = load_robot("penn_state")
    limited = robot.model_copy(update={"effects": ("rate_limit:limit_rad_s=1.5",)})
    rng = np.random.default_rng(0)
    table = rng.uniform((0.3, 0.8, 1.0), (1.0, 2.0, 4.0), size=(gaits, 3))
    many = {f"s{number}": session(number) for number in range(sessions)}
    options = OptimiseOptions(
        within={"alpha": (25, 50), "beta": (60, 100), "omega": (1, 4)}, draws=2, grid=(6, 6, 4)
    )

    def choice(dask: str | None) -> None:
        with Workers(dask) as workers:
            optimise(limited, Goal("speed"), options, workers=workers)

    def verdicts(dask: str | None) -> None:
        with Workers(dask) as workers:
            diagnose_many(many, {"quick": True, "only": ("rate_limit",)}, workers)

    return {
        f"sweep of {gaits} gaits": lambda dask: sweep(Conditions.of(robot), table, dask=dask),
        "optimize, 6 x 6 x 4 gaits first": choice,
        f"diagnose {sessions} sessions": verdicts,
    }


def warm() -> None:
    """What a process pays once: imports and compiled code."""
    sweep(Conditions.of(load_robot("penn_state")), [[0.6, 1.4, 2.0]])
    with Workers() as here:
        diagnose_many({"s": session(0)}, {"quick": True, "only": ("rate_limit",)}, here)


def measured(gaits: int, sessions: int) -> dict[str, dict[int, float]]:
    """Seconds of each work with each number of workers."""
    todo = works(gaits, sessions)
    found: dict[str, dict[int, float]] = {name: {} for name in todo}
    for count in WORKERS:
        cluster: Any = None
        if count:
            cluster = LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=None)
            with Client(cluster) as client:
                client.run(warm)
        else:
            warm()
        for name, work in todo.items():
            start = time.perf_counter()
            work(None if cluster is None else cluster.scheduler_address)
            found[name][count] = time.perf_counter() - start
        if cluster is not None:
            cluster.close()
    return found


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--gaits", type=int, default=2000, help="of the sweep [%(default)s]")
    parser.add_argument("--sessions", type=int, default=8, help="to diagnose [%(default)s]")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    found = measured(options.gaits, options.sessions)
    if options.json:
        print(json.dumps(found))
        return
    print(f"{os.cpu_count()} cores; load before: {os.getloadavg()[2]:.1f}")
    print("| work | plain, s | 1 worker, s | 2 workers, s | 1 to plain | 2 to plain | 2 to 1 |")
    print("|---|---|---|---|---|---|---|")
    for name, taken in found.items():
        plain, one, two = (taken[count] for count in WORKERS)
        shares = " | ".join(f"{share:.2f}" for share in (one / plain, two / plain, two / one))
        print(f"| {name} | {plain:.1f} | {one:.1f} | {two:.1f} | {shares} |")


if __name__ == "__main__":
    main()
