"""How often the bands of ``snakebot predict`` hold what a robot then does, on robots for tuning.

    python tools/check_forecast.py --cases 14
    python tools/check_forecast.py --engine second --seed 2 --cases 21 --keep build/forecasts

``--engine own``: robots of snakebot's own simulation with one effect, of the diagnosis's set for tuning, and five
recorded gaits. ``--engine second``: robots of the blind check's engine, which shares no code with the product, with one
or two faults, from recordings as a lab makes them; seeds from 5 on are for scoring.

Each robot is diagnosed; four gaits that were not recorded are predicted by the stated description (before) and by the
calibrated one (after). Printed: the share of figures within their 95 % bands, the width of the bands over the true
figure, and the errors. Robots without a verdict that names a cause count: their bands are those of the stated numbers,
with what the recordings leave of the speed. ``--keep`` leaves sessions and verdicts in a folder, and goes on there.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import shutil
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from blind.chain import CN, CN0, CT, CT0, HALF, MASS
from blind.gait_robots import draw_robot
from blind.robot import Parameters
from blind.robot import Robot as SecondRobot
from blind.session_files import write_session
from diagnosis_cases import SETS, background, make_case

from snakebot.arrays import Floats
from snakebot.calibrated.forecast import Banded, Forecast, figures, forecast
from snakebot.diagnosis import diagnose
from snakebot.diagnosis.result import Diagnosis
from snakebot.diagnosis.show.apply import calibrated
from snakebot.errors import BadInputError
from snakebot.gait import Gait, GaitMotion
from snakebot.robot import Robot, load_robot
from snakebot.runlog import Session, open_session

EFFECTS = (
    "rate_limit",
    "servo_lag",
    "command_delay",
    "deadband",
    "command_gain",
    "compliance",
    "ground_friction",
)
NEW_GAITS = (
    (55, 75, 2.2),
    (28, 85, 4.5),
    (40, 90, 3.2),
    (62, 70, 1.4),
)  # alpha and beta deg, omega rad/s; none recorded
DURATION_S, RAMP_S = 10.0, 1.5
NAMES = ("speed", "power", "tracking error")
FIRST_FOR_SCORING = 5  # seed of the second engine's robots
HELD = 5  # samples of the second engine for a set-point of 10 ms

Truth = Callable[[GaitMotion, tuple[float, float]], Floats]


@dataclass(frozen=True)
class Subject:
    """A robot to be predicted. ``truth``: speed, power and tracking error of a motion, in SI units and degrees."""

    name: str
    session: Session
    truth: Truth


def own(number: int) -> Subject:
    """A robot of snakebot's own simulation."""
    name, seed = EFFECTS[number % len(EFFECTS)], SETS["tune"] + 900_000 + number
    case = make_case((name,), seed, strength=1.0, channel="pose")
    robot = background(load_robot("penn_state"), np.random.default_rng(seed))
    real = robot.model_copy(update={"effects": (*robot.effects, *map(str, case.truth))})
    return Subject(name, case.session, lambda motion, span: figures(real, motion, span)[:3])


def second(seed: int, number: int, folder: Path) -> Subject:
    """A robot of the second engine, recorded into ``folder`` if it is not there yet."""
    robot = draw_robot(seed, number)
    if not folder.exists():
        part = folder.with_suffix(".part")
        shutil.rmtree(part, ignore_errors=True)
        write_session(part, robot.case())
        part.rename(folder)
    clean = robot.parameters.noiseless()
    return Subject(
        robot.words, open_session(folder), lambda motion, span: second_figures(clean, motion, span)
    )


def second_figures(parameters: Parameters, motion: GaitMotion, span_s: tuple[float, float]) -> Floats:
    """(3,) of a robot of the second engine, read by perfect sensors: the way over time, the power that
    the ground takes (over whole cycles what the joints put in), set-point less reading.
    """
    rows = round(motion.duration_s * 100) + 1
    t = np.arange(HELD * rows) * 0.01 / HELD
    command = np.repeat(motion.sampled(0.01 * np.arange(rows, dtype=np.float64)), HELD, axis=0)
    run = SecondRobot(parameters).run(t, command, np.random.default_rng(0))
    use = (t >= span_s[0] - 1e-9) & (t <= span_s[1] + 1e-9)
    first, last = np.flatnonzero(use)[[0, -1]]
    way = run.pose[last] - run.pose[first]
    speed = float(np.hypot(*way[:2]) / (t[last] - t[first]))
    error = np.degrees(
        (command - run.encoder_rad)[use & (np.arange(t.size) % HELD == 0)]
    )  # as read, at the ticks
    return np.array([speed, _lost_to_ground(parameters, run.pose, run.encoder_rad, t)[use].mean(),
                     math.sqrt(np.mean(error**2))])  # fmt: skip


def _lost_to_ground(parameters: Parameters, pose: Floats, angle_rad: Floats, t_s: Floats) -> Floats:
    """(T,) W, by the friction of each link at its speed."""
    links = parameters.links
    turn = np.cumsum(np.column_stack([np.zeros(t_s.size), angle_rad]), axis=1)
    turn += (pose[:, 2] - turn.mean(axis=1))[:, None]
    c, s, half = np.cos(turn), np.sin(turn), links[HALF]
    steps = [
        np.column_stack([np.zeros(t_s.size), np.cumsum(half[:-1] * q[:, :-1] + half[1:] * q[:, 1:], axis=1)])
        for q in (c, s)
    ]
    share = links[MASS] / links[MASS].sum()
    vx, vy = (
        np.gradient(pose[:, [axis]] + step - (step @ share)[:, None], t_s, axis=0)
        for axis, step in enumerate(steps)
    )
    along, across = c * vx + s * vy, c * vy - s * vx
    lost = links[CT] * along**2 + links[CT0] * abs(along) + links[CN] * across**2 + links[CN0] * abs(across)
    return np.asarray(lost.sum(axis=1))


def verdict(session: Session, kept: Path) -> Diagnosis:
    """What the diagnosis says; what it said before is read."""
    if kept.exists():
        return Diagnosis.model_validate_json(kept.read_text())
    found = diagnose(session, quick=True)
    kept.write_text(found.model_dump_json(by_alias=True))
    return found


def bands(told: Forecast) -> list[Banded]:
    assert told.forward_speed_m_s is not None
    assert told.power_w is not None
    return [told.forward_speed_m_s, told.power_w, told.tracking_error_deg]


def check(subject: Subject, kept: Path) -> tuple[Diagnosis, list[list[Floats]]]:
    """For each gait, for each figure the truth, and low, estimate, high before and after: (7,)."""
    found = verdict(subject.session, kept)
    stated: Robot = subject.session.robot
    robot = stated
    with contextlib.suppress(BadInputError):
        robot = calibrated(stated, found)
    rows = []
    for alpha, beta, omega in NEW_GAITS:
        motion = GaitMotion(Gait.from_degrees(alpha, beta, omega, 0.0), stated.joints, DURATION_S, RAMP_S)
        period = 2 * math.pi / omega
        cycles = int((DURATION_S - 2 * RAMP_S) / period)
        truth = subject.truth(motion, (DURATION_S - RAMP_S - cycles * period, DURATION_S - RAMP_S))
        told = [bands(forecast(one, motion, period_s=period, ramp_s=RAMP_S)) for one in (stated, robot)]
        rows.append(
            [np.array([t, b.low, b.estimate, b.high, a.low, a.estimate, a.high])
             for t, b, a in zip(truth, *told, strict=True)]
        )  # fmt: skip
    return found, rows


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--engine", choices=("own", "second"), default="own")
    parser.add_argument("--seed", type=int, default=2, help="of the second engine's robots [%(default)s]")
    parser.add_argument("--cases", type=int, default=14)
    parser.add_argument("--keep", type=Path, help="folder of sessions and verdicts")
    options = parser.parse_args()
    if options.seed >= FIRST_FOR_SCORING:
        parser.error(f"--seed: below {FIRST_FOR_SCORING}; the others are for scoring")
    all_rows: list[list[Floats]] = []
    understood: list[list[Floats]] = []  # where nothing was left unexplained
    with tempfile.TemporaryDirectory() as temporary:
        keep = options.keep or Path(temporary)
        keep.mkdir(parents=True, exist_ok=True)
        for number in range(options.cases):
            name = f"{options.engine}_{options.seed}_{number:03d}"
            subject = own(number) if options.engine == "own" else second(options.seed, number, keep / name)
            found, rows = check(subject, keep / f"{name}.json")
            all_rows += rows
            understood += rows if found.verdict in ("explained", "no_gap") else []
            causes = ", ".join(cause.specification for cause in found.causes) or "nothing"
            held = ["".join("+" if r[4] <= r[0] <= r[6] else "-" for r in row) for row in rows]
            print(f"{number} {subject.name}: {found.verdict}, {causes}; held {' '.join(held)}", flush=True)
            if options.keep:
                (keep / f"{name}.rows.json").write_text(json.dumps(np.array(rows).tolist()))
    print("\n".join(table(np.array(all_rows))))
    if understood:
        print("\nexplained, or without a gap:\n" + "\n".join(table(np.array(understood))))
    return 0


def table(rows: Floats) -> list[str]:
    """``rows`` (F, 3, 7), see ``check``."""
    lines = [
        f"| of {len(rows)} forecasts | in the band: before, after | median width of the band: before, after "
        "| median error: before, after |",
        "|---|---|---|---|",
    ]
    for i, figure in enumerate(NAMES):
        true, before, after = rows[:, i, 0], rows[:, i, 1:4].T, rows[:, i, 4:7].T
        cells = []
        for low, middle, high in (before, after):
            inside = int(np.sum((low <= true) & (true <= high)))
            cells.append((f"{inside} ({inside / true.size:.2f})", f"{np.median((high - low) / abs(true)):.1%}",
                          f"{np.median(abs(middle / true - 1)):.1%}"))  # fmt: skip
        lines.append(
            f"| {figure} | " + " | ".join(", ".join(pair) for pair in zip(*cells, strict=True)) + " |"
        )
    return lines


if __name__ == "__main__":
    sys.exit(main())
