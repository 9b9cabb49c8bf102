"""The effects on recordings of a real hobby servo: do they hold what they promise on motions that were not fitted?"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

from snakebot.arrays import Floats
from snakebot.effects import EffectSpec, Observed, find_effect, with_unit_arm
from snakebot.effects.prediction import predict
from snakebot.robot import Robot, robot_from_mapping

RECORDINGS = Path(__file__).resolve().parents[3] / "shared" / "realdata" / "pwm_servo_pendulum"
pytestmark = pytest.mark.skipif(
    not RECORDINGS.is_dir(), reason=f"no recordings of real servos in {RECORDINGS}"
)

BENCH = robot_from_mapping({"joints": 1, "encoder_counts_per_rev": 4096}, "pwm servo")


@dataclass
class Run:
    t_s: np.ndarray
    command_rad: np.ndarray
    measured_rad: np.ndarray


def recordings(folder: str) -> Iterator[Run]:
    for path in sorted((RECORDINGS / folder).glob("*.csv")):
        table = np.genfromtxt(path, delimiter=",", names=True)
        yield Run(table["t_s"], table["cmd_1_rad"][:, None], table["enc_1_rad"][:, None])


def residual(robot: Robot, specs: Sequence[EffectSpec], runs: Sequence[Run]) -> Floats:
    rows = []
    for run in runs:
        found = predict(
            robot, specs, run.t_s, run.command_rad, measured_rad=run.measured_rad, body=False, quantise=False
        )
        use = np.isfinite(run.command_rad) & np.isfinite(run.measured_rad)
        rows.append((found.encoder_rad - run.measured_rad)[use])
    return np.concatenate(rows)


def held_out_deg(robot: Robot, names: Sequence[str], runs: Sequence[Run]) -> float:
    """Fit on every fourth recording from the effects' own starts, and score on every fourth but one."""
    observed = Observed(robot, runs)
    starts = {name: find_effect(name).starts(observed, (0,))[0] for name in names}
    slots = [(name, p) for name in names for p in find_effect(name).parameters if p.fitted]
    x0 = np.array([starts[name][p.name] for name, p in slots])

    def specs(x: Floats) -> list[EffectSpec]:
        values: dict[str, dict[str, float]] = {name: {} for name in names}
        for (name, p), share, start in zip(slots, x, x0, strict=True):
            values[name][p.name] = p.clip(share * start)
        return [EffectSpec(name, found) for name, found in values.items()]

    fit = least_squares(
        lambda x: residual(robot, specs(x), runs[::4]),
        np.ones(x0.size),
        diff_step=0.01,
        max_nfev=30,
        loss="soft_l1",
        f_scale=0.05,
    )
    return float(np.degrees(np.sqrt(np.mean(residual(robot, specs(fit.x), runs[1::4]) ** 2))))


def test_bare_arm_is_a_rate_limit_and_a_lag() -> None:
    runs = list(recordings("without_weight"))
    assert held_out_deg(BENCH, ["second_order", "rate_limit"], runs) < 5.5
    assert held_out_deg(BENCH, ["rate_limit", "command_delay"], runs) < 5.5
    assert held_out_deg(BENCH, ["command_delay"], runs) > 20


def test_weight_is_a_load_dependent_rate() -> None:
    """The drop tests tell where down is; with that, a line of speed over torque explains what a limit does not."""
    runs = list(recordings("with_weight"))
    down = Observed(BENCH, runs).hangs_at_rad
    assert down == pytest.approx([np.radians(-99)], abs=np.radians(3))
    loaded = with_unit_arm(BENCH, float(down[0]))
    plain = held_out_deg(loaded, ["rate_limit", "command_delay"], runs)
    line = held_out_deg(loaded, ["torque_speed", "command_delay"], runs)
    assert plain > 20
    assert line < 0.5 * plain
