"""How fast the effects are predicted, beside scipy doing the same: python tools/bench_effects.py [--json]

A session of 6 runs x 20 s x 5 joints at 100 Hz. Peers: scipy.signal.lfilter (the nominal lag and nothing else, the
least that can be done) and scipy.integrate.solve_ivp (lag with a rate limit, as one would write it).
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from snakebot.effects import Plant, assemble, effects
from snakebot.effects.prediction import body_stage, predict
from snakebot.robot import load_robot

RUNS, SECONDS, RATE_HZ = 6, 20.0, 100.0
ON_A_BENCH = {"arm_payload"}  # of a bench with an arm, which this robot is not


def session() -> list[tuple[np.ndarray, np.ndarray]]:
    t = np.arange(0.0, SECONDS, 1 / RATE_HZ)
    phase = np.arange(5) * np.radians(80)
    ramp = np.clip(t / 2, 0, 1)[:, None]
    return [
        (t, ramp * np.radians(50) * np.sin(omega * t[:, None] + phase)) for omega in np.linspace(1, 5, RUNS)
    ]


def best_of(call: Callable[[], Any], times: int = 5) -> float:
    """Least time of several, s: other work on the machine only ever adds."""
    call()
    taken = []
    for _ in range(times):
        start = time.perf_counter()
        call()
        taken.append(time.perf_counter() - start)
    return min(taken)


def by_lfilter(runs: list[tuple[np.ndarray, np.ndarray]], tau_s: float) -> list[np.ndarray]:
    from scipy.signal import lfilter

    a = np.exp(-1 / RATE_HZ / tau_s)
    return [lfilter([0.0, 1 - a], [1.0, -a], command, axis=0) for _, command in runs]


def by_solve_ivp(t: np.ndarray, command: np.ndarray, tau_s: float, limit: float) -> np.ndarray:
    from scipy.integrate import solve_ivp

    out = np.zeros_like(command)
    for i in range(t.size - 1):  # held set-points: one smooth piece a tick
        held = command[i]
        piece = solve_ivp(
            lambda _, x, held=held: np.clip((held - x) / tau_s, -limit, limit),
            (t[i], t[i + 1]), out[i], rtol=1e-6, atol=1e-8,
        )  # fmt: skip
        out[i + 1] = piece.y[:, -1]
    return out


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--json", action="store_true", help="print JSON")
    as_json = arguments.parse_args().json
    robot = load_robot("penn_state")
    tau_s = robot.servo.time_constant_s
    runs = session()

    def servos(text: str | None) -> list[np.ndarray]:
        specs = () if text is None else (text,)
        return [predict(robot, specs, t, c, body=False, quantise=False).encoder_rad for t, c in runs]

    figures: dict[str, float] = {"nominal_ms": 1e3 * best_of(lambda: servos(None))}
    figures["lfilter_ms"] = 1e3 * best_of(lambda: by_lfilter(runs, tau_s))
    figures["lfilter_largest_difference_rad"] = max(
        float(np.abs(a - b).max()) for a, b in zip(servos(None), by_lfilter(runs, tau_s), strict=True)
    )
    t, command = runs[-1]
    start = time.perf_counter()
    peer = by_solve_ivp(t, command, tau_s, 1.6)
    figures["solve_ivp_one_run_ms"] = 1e3 * (time.perf_counter() - start)
    limited = ["rate_limit:limit_rad_s=1.6"]
    ours = predict(robot, limited, t, command, body=False, quantise=False).encoder_rad
    figures["solve_ivp_largest_difference_rad"] = float(np.abs(ours - peer).max())
    figures["rate_limit_one_run_ms"] = 1e3 * best_of(lambda: predict(robot, limited, t, command, body=False))
    stages = assemble(robot)
    figures["body_ms"] = 1e3 * best_of(lambda: [body_stage(stages, t, c) for t, c in runs], 3)

    def online() -> None:
        plant = Plant(robot)
        for now, setpoint in zip(*runs[0], strict=True):
            plant.advance(now)
            plant.encoder_counts()
            plant.command(now, setpoint)

    figures["plant_simulated_s_per_s"] = SECONDS / best_of(online, 3)
    each = {
        name: 1e3 * best_of(partial(servos, effect.example), 3)
        for name, effect in effects().items()
        if name not in ON_A_BENCH
    }
    if as_json:
        print(json.dumps({**figures, "each_ms": each}, indent=2))
        return
    print(f"{RUNS} runs x {SECONDS:.0f} s x {robot.joints} joints at {RATE_HZ:.0f} Hz, ms, best of several:")
    print(f"  nominal servos                     {figures['nominal_ms']:8.2f}")
    print(
        f"  scipy lfilter, the lag alone       {figures['lfilter_ms']:8.2f}   largest difference "
        f"{figures['lfilter_largest_difference_rad']:.1e} rad"
    )
    print(f"  body over ground                   {figures['body_ms']:8.2f}")
    print("One run, lag and rate limit, ms:")
    print(f"  kernel                             {figures['rate_limit_one_run_ms']:8.2f}")
    print(
        f"  scipy solve_ivp                    {figures['solve_ivp_one_run_ms']:8.2f}   largest difference "
        f"{figures['solve_ivp_largest_difference_rad']:.1e} rad"
    )
    print(
        f"Plant with body, in real time steps: {figures['plant_simulated_s_per_s']:.0f} simulated s a second"
    )
    print("Each effect, ms:")
    for name, taken in each.items():
        print(f"  {name:34s} {taken:8.2f}")


if __name__ == "__main__":
    main()
