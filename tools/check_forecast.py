"""How often the bands of ``snakebot predict`` hold what a robot then does, on the diagnosis's set for tuning.

    python tools/check_forecast.py --cases 12

Each robot has one effect, a lag, friction and masses a few per cent off, and five recorded gaits with a pose. It is
diagnosed; the calibrated description then predicts gaits that were not recorded. Printed: the share of figures within
their 95 % bands, and the errors, before (the stated description) and after. Cases without a verdict that names a cause
count: there the bands are those of the stated numbers.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from diagnosis_cases import SETS, background, make_case

from snakebot.calibrated.forecast import figures, forecast
from snakebot.diagnosis import diagnose
from snakebot.diagnosis.show.apply import calibrated
from snakebot.errors import BadInputError
from snakebot.gait import Gait, GaitMotion
from snakebot.robot import Robot, load_robot

EFFECTS = (
    "rate_limit",
    "servo_lag",
    "command_delay",
    "deadband",
    "command_gain",
    "compliance",
    "ground_friction",
)
NEW_GAITS = ((55, 75, 2.2), (28, 85, 4.5))  # alpha and beta deg, omega rad/s; none of those recorded
DURATION_S, RAMP_S = 10.0, 1.5
NAMES = ("speed", "power", "tracking error")


def true_robot(seed: int, effects: tuple[str, ...]) -> Robot:
    """The robot behind a case, with its effects."""
    robot = background(load_robot("penn_state"), np.random.default_rng(seed))
    return robot.model_copy(update={"effects": (*robot.effects, *effects)})


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cases", type=int, default=12)
    cases = parser.parse_args().cases
    held: list[list[bool]] = []
    errors: list[list[tuple[float, float]]] = []
    for number in range(cases):
        name, seed = EFFECTS[number % len(EFFECTS)], SETS["tune"] + 900_000 + number
        case = make_case((name,), seed, strength=1.0, channel="pose")
        found = diagnose(case.session, quick=True)
        robot = case.session.robot
        with contextlib.suppress(BadInputError):
            robot = calibrated(robot, found)
        real = true_robot(seed, tuple(map(str, case.truth)))
        for alpha, beta, omega in NEW_GAITS:
            motion = GaitMotion(Gait.from_degrees(alpha, beta, omega, 0.0), real.joints, DURATION_S, RAMP_S)
            period = 2 * math.pi / omega
            cycles = int((DURATION_S - 2 * RAMP_S) / period)
            span = (DURATION_S - RAMP_S - cycles * period, DURATION_S - RAMP_S)
            told = forecast(robot, motion, period_s=period, ramp_s=RAMP_S)
            truth, stated = figures(real, motion, span), figures(case.session.robot, motion, span)
            bands = (told.forward_speed_m_s, told.power_w, told.tracking_error_deg)
            rows = [
                (float(t), float(s), b)
                for t, s, b in zip(truth, stated, bands, strict=False)
                if b is not None
            ]
            held.append([b.low <= t <= b.high for t, _, b in rows])
            errors.append([(_off(s, t), _off(b.estimate, t)) for t, s, b in rows])
        causes = ", ".join(cause.specification for cause in found.causes) or "nothing"
        print(f"{number} {name}: {found.verdict}, {causes}; held {held[-2]} {held[-1]}", flush=True)
    for i, figure in enumerate(NAMES):
        before, after = (float(np.median([row[i][k] for row in errors])) for k in (0, 1))
        share = float(np.mean([row[i] for row in held]))
        print(
            f"{figure}: {share:.0%} of {len(held)} within the band; median error {before:.1%}, after {after:.1%}"
        )
    return 0


def _off(value: float, truth: float) -> float:
    return abs(value - truth) / abs(truth)


if __name__ == "__main__":
    sys.exit(main())
