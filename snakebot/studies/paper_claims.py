"""The paper's claims, each checked by code against what was computed: the value printed there, ours, agree or not, why.

Tables I-IV are pictures in the source: their cells are not known, and none is compared.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from snakebot.studies.hyperredundancy import FaultCase, Kind
from snakebot.studies.inference import OPTIMUM, line_speed
from snakebot.studies.optimum import SweptOptimum, omega_over_speed, slope_through_origin
from snakebot.studies.pareto import Pareto
from snakebot.studies.speed import SimulatedSpeed
from snakebot.studies.sweep import COLUMNS

SPEED, POWER = COLUMNS.index("speed_m_s"), COLUMNS.index("power_in_w")
# A step of the paper's grid in alpha and beta; what "about" and a line drawn through points can be read to.
ALPHA_STEP_DEG, BETA_STEP_DEG, LINE_SHARE, ABOUT_SHARE = 3.0, 6.0, 0.05, 0.10
SPEED_SHARE = 0.05  # of a speed that is printed with two digits
TEXT_M_S = 0.02  # of the speeds of Section IX
FAST_OMEGA, SLOW_OMEGA = 5.0, 1.0  # rad/s; ends of the paper's range
# Joints that are free or rigid together: inner ones.
BELLY: tuple[tuple[int, ...], ...] = ((2,), (3,), (4,), (2, 3), (3, 4))
# The same, of which the paper says that rigid ones make it faster.
FASTER: tuple[tuple[int, ...], ...] = ((1,), (5,), (1, 2), (4, 5))
LITTLE_SHARE = 0.5  # of the healthy speed: what "little locomotion" may be at most
MUCH_POWER = 2.0  # times the healthy power: what "much higher" is at least


@dataclass(frozen=True)
class Row:
    """One line of the table. ``agrees`` None: nothing that a simulation could show."""

    claim: str
    what: str
    paper: str
    ours: str
    agrees: bool | None
    why: str = ""


@dataclass(frozen=True)
class Front:
    """One sweep: the grid's own front, and the cheapest gaits between its gaits, by rising speed."""

    pareto: Pareto
    optima: tuple[SweptOptimum, ...]

    def at(self, omega_rad_s: float, name: str) -> float:
        """A quantity of the cheapest gaits at a frequency; NaN outside of what was swept."""
        omegas = [o.omega_rad_s for o in self.optima]
        if not omegas or not min(omegas) <= omega_rad_s <= max(omegas):
            return math.nan
        order = np.argsort(omegas)
        values = np.array([getattr(o, name) for o in self.optima])
        return float(np.interp(omega_rad_s, np.array(omegas)[order], values[order]))

    def power(self, speed_m_s: float) -> float:
        """Least power of the grid's gaits that are at least this fast; NaN if none is."""
        rows = self.pareto.rows
        fast = rows[rows[:, SPEED] >= speed_m_s, POWER]
        return float(fast.min()) if fast.size else math.nan

    @property
    def swept(self) -> tuple[SweptOptimum, ...]:
        """Those at the frequencies that the paper shows."""
        return tuple(o for o in self.optima if SLOW_OMEGA <= o.omega_rad_s <= FAST_OMEGA)


@dataclass(frozen=True)
class PaperEvidence:
    """All that was computed.

    Attributes:
        fronts: of saito, saito_wheeled, penn_state and penn_state_viscous.
        joint_power_w: sum of |u_i phi_dot_i| of (22, 60, 5), of saito and saito_wheeled.
        settled: largest change of speed between cycles 5 to 8 and 9 to 16, over the cheapest gaits, as a share.
        faults: at (66, 80, 2), the healthy robot first.
        optimum_speed_m_s, optimum_power_w: of (66, 80, 2), ideal tracking.
        servo: speeds with the inferred servo, at omega = 2 to 5.
        servo_effects: its effects.
        reading: what the friction without its normal Coulomb part makes of the facts of ``inference``.
        sweep_s: seconds for 9000 gaits of penn_state in this run, if they were computed in it.
        quick: only a part of the gaits was looked at, so that their number and their time say nothing.
    """

    fronts: Mapping[str, Front]
    joint_power_w: Mapping[str, float]
    settled: float
    faults: Sequence[FaultCase]
    optimum_speed_m_s: float
    optimum_power_w: float
    servo: Sequence[SimulatedSpeed]
    servo_effects: tuple[str, ...]
    reading: Mapping[str, float]
    sweep_s: float | None
    quick: bool = False


def rows(evidence: PaperEvidence) -> list[Row]:
    """The table, claim by claim."""
    parts = (_viscous, _wheeled, _coulomb, _no_coulomb, _protocol, _gap, _faults, _hardware)
    return [row for part in parts for row in part(evidence)]


def near(ours: float, paper: float, tolerance: float) -> bool:
    """Within a tolerance; NaN never is."""
    return abs(ours - paper) <= tolerance


def trend(front: Front, name: str) -> str:
    """rising, falling, constant, or up and down, over the frequencies that the paper shows."""
    values = [getattr(o, name) for o in sorted(front.swept, key=lambda o: o.omega_rad_s)]
    if len(values) < 3:
        return "unknown"
    steps, change = np.diff(values), values[-1] - values[0]
    grain = 0.5 * (ALPHA_STEP_DEG if name == "alpha_deg" else BETA_STEP_DEG)
    if change > grain and steps.min() > -grain:
        return "rising"
    if change < -grain and steps.max() < grain:
        return "falling"
    return "constant" if np.ptp(values) <= 2 * grain else "up and down"


def _grid_speed(front: Front, alpha_deg: float, beta_deg: float, omega_rad_s: float) -> float:
    """Speed of one of the sweep's gaits; NaN if it is not among them."""
    rows = front.pareto.rows
    wanted = [np.radians(alpha_deg), np.radians(beta_deg), omega_rad_s]
    at = np.flatnonzero(np.isclose(rows[:, :3], wanted).all(axis=1))
    return float(rows[at[0], SPEED]) if at.size else math.nan


def _span(front: Front, name: str) -> str:
    low, high = front.at(SLOW_OMEGA, name), front.at(FAST_OMEGA, name)
    return f"{low:.0f} to {high:.0f} deg, {trend(front, name)}"


def _beta(claim: str, front: Front, paper: float) -> Row:
    middle = float(np.median([o.beta_deg for o in front.swept]))
    agrees = near(middle, paper, BETA_STEP_DEG)
    why = f"tolerance: one step of the grid, {BETA_STEP_DEG:g} deg"
    return Row(claim, "beta of the optimal gaits", f"about {paper:g} deg", f"{middle:.0f} deg", agrees, why)


def _constant_alpha(claim: str, front: Front, paper: float) -> Row:
    middle = float(np.median([o.alpha_deg for o in front.swept]))
    low = min(o.alpha_range_deg[0] for o in front.swept)
    high = max(o.alpha_range_deg[1] for o in front.swept)
    flat = trend(front, "alpha_deg") == "constant"
    agrees = flat and (near(middle, paper, ALPHA_STEP_DEG) or low <= paper <= high)
    why = f"{low:.0f} to {high:.0f} deg cost at most 2 % more"
    return Row(claim, "alpha constant over omega", f"near {paper:g} deg", f"{middle:.0f} deg", agrees, why)


def _slope(claim: str, front: Front, paper: float, why: str) -> Row:
    slope = slope_through_origin(front.swept)
    agrees = near(slope, paper, LINE_SHARE * paper)
    return Row(
        claim, "omega / v of the optimal gaits", f"{paper:g} rad/m", f"{slope:.3f} rad/m", agrees,
        "" if agrees else why,
    )  # fmt: skip


def _power(claim: str, front: Front, joint_power_w: float, paper_w: float) -> Row:
    power = front.power(6.0)
    agrees = near(power, paper_w, ABOUT_SHARE * paper_w)
    why = (
        f"sum |u phi_dot| of (22, 60, 5) is {joint_power_w:.0f} W: the figure is near what servos take that give "
        "nothing back, while the optimal gaits are those of the net power"
    )
    ours = f"{power:.0f} W"
    return Row(claim, "power at 6 m/s", f"about {paper_w:g} W", ours, agrees, "" if agrees else why)


def _viscous(e: PaperEvidence) -> Iterator[Row]:
    front = e.fronts["saito"]
    slow, fast = front.at(SLOW_OMEGA, "alpha_deg"), front.at(FAST_OMEGA, "alpha_deg")
    rising = trend(front, "alpha_deg") == "rising"
    yield Row("1a", "alpha rises with omega", "rises", _span(front, "alpha_deg"), rising)
    ends = near(slow, 15, ALPHA_STEP_DEG) and near(fast, 25, ALPHA_STEP_DEG)
    grid = front.pareto.rows[front.pareto.front]
    last = np.degrees(grid[np.isclose(grid[:, 2], FAST_OMEGA), 0])
    why = (
        f"at omega = 5 the grid's own front holds {last.min():.0f} to {last.max():.0f} deg"
        if last.size
        else ""
    )
    yield Row("1b", "alpha at both ends", "15 to 25 deg", f"{slow:.0f} to {fast:.0f} deg", ends, why)
    yield _beta("1c", front, 60)
    yield _slope("1d", front, 0.83, "")
    speed, end = front.at(FAST_OMEGA, "speed_m_s"), front.pareto.rows[front.pareto.front[-1]]
    yield Row(
        "1e", "top speed: optimal gait at omega = 5", "about 6 m/s", f"{speed:.2f} m/s",
        near(speed, 6.0, ABOUT_SHARE * 6),
        f"beyond it power rises steeply: the grid's front ends at {end[SPEED]:.2f} m/s and {end[POWER]:.0f} W",
    )  # fmt: skip
    yield _power("1f", front, e.joint_power_w["saito"], 200)


def _wheeled(e: PaperEvidence) -> Iterator[Row]:
    front, lying = e.fronts["saito_wheeled"], e.fronts["saito"]
    yield _constant_alpha("2a", front, 27)
    yield _beta("2b", front, 78)
    rate = slope_through_origin(front.swept)
    own = _grid_speed(front, 27, 78, 1)
    why = f"the paper's own gait (27, 78) does not move that fast here: {1 / own:.3f} rad/m at omega = 1"
    yield _slope("2c", front, 0.88, why)
    more = rate > slope_through_origin(lying.swept)
    yield Row("2d", "needs a higher omega than 1 at the same speed", "yes", "yes" if more else "no", more)
    speeds, powers = np.array([(o.speed_m_s, o.power_w) for o in front.optima]).T
    share = max(
        float(np.interp(o.speed_m_s, speeds, powers) / o.power_w)
        for o in lying.swept
        if speeds[0] <= o.speed_m_s <= speeds[-1]
    )
    yield Row("2e", "needs less power than 1 at every speed", "less", f"at most {share:.0%}", share < 1)
    yield _power("2f", front, e.joint_power_w["saito_wheeled"], 160)


def _coulomb(e: PaperEvidence) -> Iterator[Row]:
    front = e.fronts["penn_state"]
    key = [f"alpha at {line_speed(w):.3f} m/s, deg" for w in (2.0, 5.0)]
    without = (
        "with friction as printed, smaller amplitudes are cheaper; without its normal Coulomb part "
        f"alpha would fall from {e.reading[key[0]]:.0f} to {e.reading[key[1]]:.0f} deg (snakebot study infer)"
    )
    falling = trend(front, "alpha_deg") == "falling"
    yield Row(
        "3a", "alpha falls with omega", "70 to 40 deg, falls", _span(front, "alpha_deg"), falling,
        "" if falling else without,
    )  # fmt: skip
    yield _beta("3b", front, 80)
    slope, intercept = omega_over_speed(front.swept)
    agrees = near(slope, 7.88, LINE_SHARE * 7.88) and near(intercept, 0.97, 0.3)
    why = "other gaits are optimal here, see 3a; the slope is 1 / l, and l is inferred"
    yield Row(
        "3c", "omega over speed of the optimal gaits", "7.88 v + 0.97", f"{slope:.2f} v {intercept:+.2f}", agrees,
        "" if agrees else why,
    )  # fmt: skip
    found = [front.at(2.0, name) for name in ("alpha_deg", "beta_deg", "speed_m_s")]
    cheap = float(
        np.interp(e.optimum_speed_m_s, [o.speed_m_s for o in front.optima], [o.power_w for o in front.optima])
    )
    agrees = near(found[0], OPTIMUM[0], ALPHA_STEP_DEG) and near(found[1], OPTIMUM[1], BETA_STEP_DEG)
    why = f"(66, 80, 2) costs {e.optimum_power_w / cheap - 1:.0%} more than the cheapest gait of its speed; see 3a"
    yield Row(
        "3d", "optimal gait at omega = 2", "(66, 80)", f"({found[0]:.0f}, {found[1]:.0f}), {found[2]:.3f} m/s", agrees,
        "" if agrees else why,
    )  # fmt: skip
    speed = line_speed(2.0)
    agrees = near(e.optimum_speed_m_s, speed, ABOUT_SHARE * speed)
    yield Row(
        "3e", "speed of (66, 80, 2) on the line of Fig. 17", f"{speed:.3f} m/s", f"{e.optimum_speed_m_s:.3f} m/s",
        agrees, "l was chosen for it; single gaits of the paper's grid scatter about its line by 10 %",
    )  # fmt: skip


def _no_coulomb(e: PaperEvidence) -> Iterator[Row]:
    front, rough = e.fronts["penn_state_viscous"], e.fronts["penn_state"]
    yield _constant_alpha("4a", front, 30)
    yield _beta("4b", front, 80)
    slope = slope_through_origin(front.swept)
    half = e.fronts["penn_state"].pareto.robot.body
    assert half is not None
    why = f"the slope is 1 / l: l = {half.half_length_m * slope / 9.30:.3f} m would give it"
    yield _slope("4c", front, 9.30, why)
    omegas = np.arange(SLOW_OMEGA, FAST_OMEGA + 0.1, 0.5)
    gain = [rough.at(w, "alpha_deg") - front.at(w, "alpha_deg") for w in omegas]
    gain = [g for g in gain if math.isfinite(g)]
    larger = bool(gain) and min(gain) > 0
    yield Row(
        "4d", "with Coulomb friction alpha is larger", "larger",
        f"{min(gain):+.0f} to {max(gain):+.0f} deg" if gain else "unknown", larger, "" if larger else "see 3a",
    )  # fmt: skip
    speeds = np.linspace(0.1, 0.3, 5)
    pair = [
        np.interp(
            speeds, [o.speed_m_s for o in which.optima], [[o.omega_rad_s, o.power_w][k] for o in which.optima]
        )
        for k in (0, 1)
        for which in (rough, front)
    ]
    lower = bool((pair[0] < pair[1]).all())
    yield Row(
        "4e", "with it omega is lower at the same speed", "lower",
        f"{np.min(pair[0] / pair[1]):.0%} to {np.max(pair[0] / pair[1]):.0%}", lower,
    )  # fmt: skip
    costly = bool((pair[2] > 2 * pair[3]).all())
    yield Row(
        "4f", "power lost to Coulomb friction is substantial", "substantial",
        f"{np.min(1 - pair[3] / pair[2]):.0%} to {np.max(1 - pair[3] / pair[2]):.0%} of all", costly,
        "agrees if it is more than half at 0.1 to 0.3 m/s",
    )  # fmt: skip


def _protocol(e: PaperEvidence) -> Iterator[Row]:
    swept = e.fronts["penn_state"].pareto.rows
    gaits = int(np.count_nonzero(swept[:, 2] <= FAST_OMEGA))
    whole, why = (None, "a quick look takes a part of them") if e.quick else (gaits == 9000, "")
    yield Row("5a", "gaits of the sweep, 8 cycles each", "9000", f"{gaits}", whole, why)
    ours = f"{e.sweep_s:.1f} s" if e.sweep_s is not None else "kept from an earlier run"
    ours = "not told by a quick look" if e.quick else ours
    yield Row("5b", "time for it", "25 h", ours, None, "other machine, other program")
    yield Row(
        "5c", "steady after 4 cycles (Fig. 4)", "2 to 3 cycles", f"speed moves {e.settled:.1%} after", e.settled < 0.02,
        "cheapest gaits of penn_state; cycles 5 to 8 against 9 to 16",
    )  # fmt: skip


def _gap(e: PaperEvidence) -> Iterator[Row]:
    by_omega = {round(row.omega_rad_s, 6): row for row in e.servo}
    source = (
        f"all of 6: servo fitted to these very numbers: {' + '.join(e.servo_effects)} (snakebot study gap)"
    )
    for letter, omega in (("a", 2.0), ("b", 3.0)):
        row = by_omega[omega]
        ratio = row.speed_m_s / row.ideal_speed_m_s
        yield Row(
            f"6{letter}", f"robot follows the simulation at omega = {omega:g}", "close", f"{ratio - 1:+.1%}",
            near(ratio, 1, SPEED_SHARE), source if letter == "a" else "",
        )  # fmt: skip
    worst = [max(by_omega[w].tracking_error) for w in (3.0, 4.0, 5.0)]
    growing = worst[0] < worst[1] < worst[2]
    yield Row(
        "6c", "servos fail to follow at 4 and 5 (TE of the worst joint)", "rises",
        ", ".join(f"{value:.2f}" for value in worst) + " at 3, 4, 5", growing,
    )  # fmt: skip
    texts = (
        ("d", 4.0, "speed_m_s", 0.24, "speed of the robot"),
        ("e", 5.0, "speed_m_s", 0.18, "speed of the robot"),
        ("f", 4.0, "sine_replay_speed_m_s", 0.28, "sine of the measured angles replayed"),
        ("g", 5.0, "sine_replay_speed_m_s", 0.17, "sine of the measured angles replayed"),
    )
    for letter, omega, name, paper, what in texts:
        value = float(getattr(by_omega[omega], name))
        agrees = near(value, paper, TEXT_M_S)
        why = "a motor's torque-speed line lags, and flattens the motion, less than the paper's servos at this omega"
        yield Row(
            f"6{letter}", f"{what} at omega = {omega:g}", f"{paper:g} m/s", f"{value:.3f} m/s", agrees,
            "" if agrees else why,
        )  # fmt: skip


def _faults(e: PaperEvidence) -> Iterator[Row]:
    ratio = {(case.kind, case.joints): case.speed_ratio for case in e.faults}
    power = {(case.kind, case.joints): case.power_ratio for case in e.faults}
    single = [ratio["free", (joint,)] for joint in range(1, 6)]
    free = [value for (kind, _), value in ratio.items() if kind == "free"]
    yield Row(
        "7a", "any free joint lowers the speed", "lowers", ", ".join(f"{value:.3f}" for value in single),
        max(free) < 1, "ratios of free 1 to 5; pairs and triples are lower as well" if max(free) < 1 else "",
    )  # fmt: skip
    gains = [ratio["rigid", joints] for joints in FASTER]
    yield Row(
        "7b", "rigid 1, 5, 1+2, 4+5 raise the speed", "raise", ", ".join(f"{value:.2f}" for value in gains),
        min(gains) > 1,
    )  # fmt: skip
    costs = [power["rigid", joints] for joints in FASTER]
    yield Row(
        "7c", "at much higher power", "tremendous", ", ".join(f"{value:.1f}" for value in costs) + " times",
        min(costs) > MUCH_POWER, f"agrees if all are more than {MUCH_POWER:g} times",
    )  # fmt: skip
    kinds: tuple[tuple[str, Kind], ...] = (("d", "free"), ("e", "rigid"))
    for letter, kind in kinds:
        belly = [ratio[kind, joints] for joints in BELLY]
        ends = {
            count: min(ratio[kind, joints] for joints in FASTER if len(joints) == count) for count in (1, 2)
        }
        below = all(r < ends[len(joints)] and r < 1 for r, joints in zip(belly, BELLY, strict=True))
        yield Row(
            f"7{letter}", f"belly faults, {kind}: 2, 3, 4, 2+3, 3+4", "lower it fast",
            ", ".join(f"{value:.2f}" for value in belly), below, "agrees if each is below those of head and tail",
        )  # fmt: skip
    triples = {case.label: case.speed_ratio for case in e.faults if len(case.joints) >= 3}
    fast = [label for label, value in triples.items() if value > LITTLE_SHARE]
    yield Row(
        "7f", "three or more failures: little locomotion is left", "negligible",
        f"median {np.median(list(triples.values())):.2f}, {len(triples) - len(fast)} of {len(triples)} at most "
        f"{LITTLE_SHARE:g}",
        not fast, f"faster: {', '.join(fast)}" if fast else "",
    )  # fmt: skip


def _hardware(e: PaperEvidence) -> Iterator[Row]:
    robot = e.fronts["penn_state"].pareto.robot
    counts = robot.encoder_counts_per_rev
    yield Row(
        "8a", "encoder counts per turn", "8192", f"{counts}", counts == 8192, "of the robot description"
    )
    yield Row("8b", "servos: hobby servos with a position loop", "hardware", "not simulated as such", None)
    yield Row("-", "cells of Tables I to IV", "pictures in the source", "not compared", None)
