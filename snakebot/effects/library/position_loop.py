"""A smart servo as it is: a spring to the set-point that must move what hangs on it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats
from snakebot.effects.effect import Effect
from snakebot.effects.loop_identification import LIMITED, Carried, Loop, loops
from snakebot.effects.parameter import Parameter
from snakebot.physics import servo_layout as layout

if TYPE_CHECKING:
    from snakebot.effects.effect import Start
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot

SLOW = 0.3  # share of the peak rate, below which the spring is read off the sag; chosen
LEAST_SAMPLES = 20  # of a swing without power that is evaluated; chosen
LEAST_SWING_RAD = 0.2  # its range; chosen
SWING_RAD = 0.02  # beyond which a sample of it counts less; chosen
SWING_CLOSED = 0.3  # share of the swing's own spread that may be left for it to count as understood; chosen
UNIT_WEIGHT_NM = 1.0  # of an arm that is not described, by definition: torques are then shares of its weight


class PositionLoop(Effect):
    """Priors: geared servos of .1 to 5 N m (Dynamixel, Feetech and hobby servos), as their data sheets say: the
    proportional gain gives full torque for 10 to 60 deg of error, the no-load speed at full voltage is 5 to 15 rad/s
    (back EMF: limit / speed), gears lose a tenth to a half of what they carry.
    """

    name = "position_loop"
    example = "position_loop:stiffness_nm_rad=3,damping_nm_s_rad=0.3,coulomb_nm=0.05,full_drive_deg=60"
    stage = "servo"
    covers = frozenset({"delay"})
    followed = 4  # an arm that is caught a little later swings otherwise; chosen
    summary = (
        "The servo is a proportional position loop with damping, inertia and friction, and sags under load."
    )
    title = "a soft position loop"
    sentence = "{where} [is|are] held softly, by {stiffness_nm_rad}, and [gives|give] way to the load"
    look = "Look at the servo's P gain, at its supply under load, and at what the joint has to carry."
    mark = (
        "Sags by load over stiffness, stands still after a reversal until the set-point has moved on by twice the "
        "friction over stiffness, swings where the load has inertia; above the limit it stays behind."
    )
    confused_with = (
        ("second_order", "without load or friction it is one"),
        ("joint_friction", "slow motion alone: no inertia shows"),
        ("compliance", "the sag alone"),
        ("command_gain", "about the angle at which the arm hangs the sag is a gain; a constant load tells"),
    )
    parameters = (
        Parameter(
            "stiffness_nm_rad", "N m/rad", 0.01, 5000.0, "torque over error, by the proportional gain",
            typical=3.0, spread=1.3, scale="log", words="stiffness",
        ),
        Parameter(
            "damping_nm_s_rad", "N m s/rad", 1e-4, 100.0, "under power: back EMF and derivative gain",
            typical=0.1, spread=1.3, scale="log", words="damping",
        ),
        Parameter(
            "armature_kg_m2", "kg m2", 1e-6, 10.0, "inertia of motor and gear at the joint",
            typical=3e-3, spread=1.2, scale="log", default=1e-3,
            words="inertia of motor and gear", shown=("g m2", 1000.0),
        ),
        Parameter("coulomb_nm", "N m", 0.0, 50.0, "dry friction without load", typical=0.03, spread=0.05, default=0.0,
                  words="dry friction"),
        Parameter(
            "load_friction", "", 0.0, 0.95, "dry friction over the load's torque",
            typical=0.2, spread=0.15, default=0.0, words="dry friction over load", shown=("%", 100.0),
        ),
        Parameter(
            "drive_friction_per_nm", "1/(N m)", 0.0, 20.0, "dry friction over the square of the drive's torque",
            typical=0.2, spread=0.5, default=0.0, words="friction that the drive adds",
        ),
        Parameter(
            "full_drive_deg", "deg", 0.5, 360.0, "error at which the drive gives all it has: supply, current or duty",
            typical=30.0, spread=0.8, scale="log", default=360.0, words="error at full drive",
        ),
        Parameter(
            "down_deg", "deg", -360.0, 360.0, "joint angle at which the arm hangs, less the one that is stated",
            typical=0.0, spread=90.0, default=0.0, words="where the arm hangs",
        ),
        Parameter(
            "gravity_nm", "N m", 0.0, 500.0, "weight of an arm that is not described, when it is level",
            typical=UNIT_WEIGHT_NM, spread=1.0, default=0.0, fitted=False, words="weight of the arm",
        ),
        Parameter(
            "viscous_nm_s_rad", "N m s/rad", 0.0, 100.0, "with power or without",
            typical=0.005, spread=0.01, default=0.0, fitted=False, words="viscous friction",
        ),
        Parameter(
            "breakaway_nm", "N m", 0.0, 50.0, "dry friction at rest, beyond that in motion",
            typical=0.02, spread=0.02, default=0.0, fitted=False, words="breakaway torque",
        ),
        Parameter(
            "stribeck_rad_s", "rad/s", 1e-3, 50.0, "speed at which that is gone",
            typical=0.1, spread=1.0, scale="log", default=0.1, fitted=False, words="speed at which that is gone",
        ),
    )  # fmt: skip

    def write_servo(self, rows: Floats, joints: tuple[int, ...], spec: EffectSpec, robot: Robot) -> None:
        # A servo_lag given as well is applied after this one, and is then a filter in front of it.
        rows[joints, layout.TIME_CONSTANT_S] = 0.0
        for name, column in (
            ("stiffness_nm_rad", layout.LOOP_STIFFNESS_NM_RAD),
            ("damping_nm_s_rad", layout.LOOP_DAMPING_NM_S),
            ("armature_kg_m2", layout.ARMATURE_KG_M2),
            ("coulomb_nm", layout.LOOP_COULOMB_NM),
            ("load_friction", layout.LOAD_FRICTION),
            ("drive_friction_per_nm", layout.DRIVE_FRICTION_PER_NM),
            ("viscous_nm_s_rad", layout.LOOP_VISCOUS_NM_S),
            ("breakaway_nm", layout.LOOP_BREAKAWAY_NM),
            ("stribeck_rad_s", layout.STRIBECK_RAD_S),
        ):
            rows[joints, column] = spec.value(name)
        full_rad = np.radians(spec.value("full_drive_deg"))
        rows[joints, layout.LOOP_LIMIT_NM] = spec.value("stiffness_nm_rad") * full_rad
        if _weight_is_unknown(robot):
            rows[joints, layout.ARM_GRAVITY_NM] = spec.value("gravity_nm")
        rows[joints, layout.ARM_DOWN_RAD] += np.radians(spec.value("down_deg"))

    def can_explain(self, observed: Observed) -> bool:
        """Its many numbers need a load that is known, or was seen to hang: else a lag and a friction say as much."""
        robot = observed.robot
        hangs = bool(np.isfinite(observed.hangs_at_rad).any())
        return robot.body is None and (hangs or not _weight_is_unknown(robot))

    def held(self, observed: Observed) -> Start:
        """The weight of an arm that is not described; that links need no angle to hang at; and the armature where the
        joint was seen to swing without power: slow motion under power says little of it.

        Who describes an arm has weighed it, and not put the horn on to a degree: 1.3 deg with an arm that is level is
        as much as a loop of 3.4 N m/rad sags under 0.08 N m.
        """
        robot = observed.robot
        known: Start = {"gravity_nm": UNIT_WEIGHT_NM} if _weight_is_unknown(robot) else {}
        if robot.body is not None:
            known = {"down_deg": 0.0}
        swing = None if robot.body is not None else _swing(observed)
        return (
            known
            if swing is None
            else {**known, "armature_kg_m2": self.parameter("armature_kg_m2").clip(swing)}
        )

    def lacks(self, robot: Robot) -> str | None:
        if not _weight_is_unknown(robot):
            return None
        return (
            "no arm is described: torques and inertias are in units of the load's own weight; describe the arm "
            "(servo: {arm: {mass_kg, length_m}})"
        )

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        robot = observed.robot
        lag = min(max(observed.over(observed.lag_s, joints, 0.05), 0.01), 0.5)
        if robot.body is not None:
            load = observed.over(observed.peak_load_nm, joints, 0.5)
            rest = max(observed.over(observed.residual_rms_rad, joints, 0.1), 0.01)
            carried = Carried(load, 0.0, 0.0)
            return [self._start(*_likely(load / rest, lag, math.pi, carried), down_rad=0.0)]
        stated = _of_arm(robot, layout.ARM_DOWN_RAD)
        out: list[Start] = []
        for carried in _loads(observed, joints):
            off_rad = carried.down_rad - stated
            out += [
                self._start(*_likely(stiffness, lag, limit, carried), down_rad=off_rad)
                for stiffness, limit in _sags(observed, joints, carried)
            ]
            known = carried._replace(inertia_kg_m2=_of_arm(robot, layout.ARM_INERTIA_KG_M2))
            out += [self._start(loop, 0.0, down_rad=off_rad) for loop in loops(observed, joints, known)]
        return out

    def _start(self, loop: Loop, drive_friction_per_nm: float, *, down_rad: float) -> Start:
        """A loop with a friction that the drive adds, of an arm that hangs so far from where it is stated to."""
        values = {
            "stiffness_nm_rad": loop.stiffness_nm_rad,
            "damping_nm_s_rad": loop.damping_nm_s_rad,
            "armature_kg_m2": loop.armature_kg_m2,
            "coulomb_nm": loop.coulomb_nm,
            "load_friction": loop.load_friction,
            "drive_friction_per_nm": drive_friction_per_nm,
            "full_drive_deg": math.degrees(loop.limit_rad),
            "down_deg": math.degrees(down_rad),
        }
        return {name: self.parameter(name).clip(value) for name, value in values.items()}


def _likely(stiffness: float, lag_s: float, limit_rad: float, carried: Carried) -> tuple[Loop, float]:
    """A loop of this stiffness (N m/rad) that is late by ``lag_s``, and the friction that its drive adds, 1/(N m)."""
    loop = Loop(
        stiffness_nm_rad=stiffness,
        damping_nm_s_rad=0.5 * stiffness * lag_s,
        armature_kg_m2=max(0.3 * carried.inertia_kg_m2, 0.1 * stiffness * lag_s**2),
        coulomb_nm=0.05 * carried.gravity_nm,
        load_friction=0.2,
        limit_rad=limit_rad,
    )
    return loop, 0.2 / max(carried.gravity_nm, 0.05)


def _weight_is_unknown(robot: Robot) -> bool:
    """Whether the robot is a bench whose arm nobody described."""
    return robot.body is None and "arm" not in (robot.servo.model_extra or {})


def _swing(observed: Observed) -> float | None:
    """Armature (kg m2) with which the first joint swings without power as it was seen to, with dry friction of its own;
    None where it was not seen to swing.
    """
    from scipy.optimize import least_squares

    swings = [
        found for run in observed.runs if (found := _free_stretch(run.t_s, run.command_rad, run.measured_rad))
    ]
    if not swings:
        return None
    gravity, down, inertia = _loads(observed, (0,))[0]

    def residual(x: Floats) -> Floats:
        row = layout.nominal_parameters(1, 0.0)
        row[0, layout.ARM_GRAVITY_NM], row[0, layout.ARM_DOWN_RAD] = gravity, down
        row[0, layout.ARM_INERTIA_KG_M2] = _of_arm(observed.robot, layout.ARM_INERTIA_KG_M2)
        row[0, layout.LOOP_STIFFNESS_NM_RAD] = 1.0  # without power any will do
        row[0, layout.ARMATURE_KG_M2] = math.exp(x[0])
        row[0, layout.LOOP_COULOMB_NM], row[0, layout.LOAD_FRICTION] = np.abs(x[1:]) * (gravity, 1.0)
        return np.concatenate([_swung(row, t, angle) - angle for t, angle in swings])

    start = np.array([math.log(max(0.3 * inertia, 1e-6)), 0.03, 0.1])
    found = least_squares(residual, start, loss="soft_l1", f_scale=SWING_RAD, max_nfev=40)
    spread = float(np.std(np.concatenate([angle for _, angle in swings])))
    rest = float(np.sqrt(np.mean(np.square(residual(found.x)))))
    return math.exp(found.x[0]) if rest < SWING_CLOSED * spread else None


def _of_arm(robot: Robot, column: int) -> float:
    """What is stated of the arm: a column of the servos' table."""
    from snakebot.effects.stages import assemble

    return float(assemble(robot, ()).servo_rows[0, column])


def _swung(row: Floats, t_s: Floats, angle_rad: Floats) -> Floats:
    """(T,) how a joint let go at the first angle, at rest, swings."""
    from snakebot.physics.servo_chain import DrivenChain

    chain = DrivenChain(row, angle_rad[:1], t_s=float(t_s[0]), grid_s=2e-3)
    made: Floats = chain.run(t_s, t_s[:1], np.full((1, 1), math.nan)).angle[:, 0]
    return made


def _free_stretch(t_s: Floats, command_rad: Floats, measured_rad: Floats) -> tuple[Floats, Floats] | None:
    """Times and angles of the first joint from the first turning point without power on, if it turns again."""
    free = np.isnan(command_rad[:, 0]) & np.isfinite(measured_rad[:, 0])
    if free.sum() < LEAST_SAMPLES:
        return None
    first = int(np.argmax(free))
    powered = np.flatnonzero(~free[first:])
    t, angle = (
        a[first : first + int(powered[0]) if powered.size else None] for a in (t_s, measured_rad[:, 0])
    )
    steps = np.diff(angle)
    turns = np.flatnonzero(np.diff(np.sign(steps[steps != 0.0])))
    if angle.size < LEAST_SAMPLES or turns.size < 2 or np.ptp(angle) < LEAST_SWING_RAD:
        return None
    top = int(np.argmax(np.abs(angle - angle[-1])))
    return t[top:], angle[top:]


def _loads(observed: Observed, joints: tuple[int, ...]) -> list[Carried]:
    """What a bench's joint may carry, likeliest first."""
    from snakebot.effects.stages import assemble

    row = assemble(observed.robot, ()).servo_rows[joints[0]]
    hangs = observed.over(observed.hangs_at_rad, joints, math.nan)
    if not _weight_is_unknown(observed.robot):
        gravity, down, inertia = row[[layout.ARM_GRAVITY_NM, layout.ARM_DOWN_RAD, layout.ARM_INERTIA_KG_M2]]
        return [Carried(float(gravity), hangs if math.isfinite(hangs) else float(down), float(inertia))]
    angles = [hangs] if math.isfinite(hangs) else [0.0, -0.5 * math.pi, 0.5 * math.pi]
    return [Carried(UNIT_WEIGHT_NM, angle, 0.02 * UNIT_WEIGHT_NM) for angle in angles]


def _sags(observed: Observed, joints: tuple[int, ...], carried: Carried) -> list[tuple[float, float]]:
    """Stiffness (N m/rad) and error at full drive (rad) of loops that hold the weight while the joint is slow, best
    first.

    For each limit of the error the stiffness is the slope through zero of the weight against the limited error, by
    least squares. A slope over all errors would be that of a softer loop.
    """
    errors, pulls = [], []
    for run in observed.runs:
        rate = np.gradient(run.measured_rad, run.t_s, axis=0)
        for j in joints:
            error = run.command_rad[:, j] - run.measured_rad[:, j]
            pull = carried.gravity_nm * np.sin(run.measured_rad[:, j] - carried.down_rad)
            slow = np.abs(rate[:, j]) < SLOW * max(float(observed.peak_rate_rad_s[j]), 1e-6)
            use = slow & np.isfinite(error) & np.isfinite(pull)
            errors.append(error[use])
            pulls.append(pull[use])
    error, pull = np.concatenate(errors), np.concatenate(pulls)
    least = 0.2 * carried.gravity_nm  # an arm this heavy could not be lifted
    furthest = observed.over(observed.furthest_error_rad, joints, 1.0)
    found = []
    for share in LIMITED:
        limited = np.clip(error, -share * furthest, share * furthest)
        square = float(limited @ limited)
        stiffness = max(float(limited @ pull) / square, least) if square > 0 else 5.0 * carried.gravity_nm
        left = float(np.square(pull - stiffness * limited).sum())
        found.append((left, stiffness, share * furthest))
    return [(stiffness, limit) for _, stiffness, limit in sorted(found)]


EFFECT = PositionLoop()
