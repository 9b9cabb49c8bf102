"""Which gaits are asked about: the ranges of ``--within``, inside the robot's limits; and what ends them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats
from snakebot.control.plans import RAMP_S
from snakebot.errors import BadInputError
from snakebot.nearest import did_you_mean

if TYPE_CHECKING:
    from snakebot.robot import Robot

# Where nothing is said: the paper's grid.
WITHIN: Mapping[str, tuple[float, float]] = {
    "alpha": (3.0, 90.0),  # deg
    "beta": (6.0, 180.0),  # deg
    "omega": (0.5, 5.0),  # rad/s
}
_EXAMPLES = {"alpha": "alpha=20..60", "beta": "beta=40..120", "omega": "omega=1..4"}
UNITS = {"alpha": "deg", "beta": "deg", "omega": "rad/s"}
MOST_OF_GRID = 100  # alphas, betas or omegas; chosen
BINDING = 0.99  # share of a limit from which it is said to bind; chosen


def _swings() -> tuple[Floats, Floats, Floats]:
    """Omegas in rad/s, and the largest speed and acceleration of a run with amplitude one, its ramps included.

    A ramp b(t) swells the wave: the motion is the real part of b exp(i omega t), and the derivatives of that bound it.
    """
    s = np.linspace(0, 1, 201)
    b, first = s**3 * (10 - 15 * s + 6 * s**2), 30 * s**2 * (1 - s) ** 2 / RAMP_S
    second = 60 * s * (1 - s) * (1 - 2 * s) / RAMP_S**2
    omega = np.geomspace(1e-2, 1e3, 4000)
    w = omega[:, None]
    speed = np.hypot(w * b, first).max(axis=1)
    acceleration = np.hypot(second - w**2 * b, 2 * w * first).max(axis=1)
    return omega, np.maximum.accumulate(speed), np.maximum.accumulate(acceleration)


_OMEGA, _SPEED, _ACCELERATION = _swings()


@dataclass(frozen=True)
class Space:
    """Ranges in rad and rad/s, and the tightest limit of all joints, which a whole run keeps, ramps included.

    Attributes:
        margin: share of each servo's torque that is to be left. With 0, servos whose limit is part of the simulation
            may be used up: it knows how they then fall behind.
        torque_given: the limit is the user's, not the simulation's: it may not be passed.
    """

    alpha_rad: tuple[float, float]
    beta_rad: tuple[float, float]
    omega_rad_s: tuple[float, float]
    angle_rad: float
    speed_rad_s: float
    acceleration_rad_s2: float
    margin: float = 0.0
    torque_given: bool = False

    @classmethod
    def of(
        cls,
        robot: Robot,
        within: Mapping[str, tuple[float, float]] | None = None,
        *,
        margin: float = 0.0,
        torque_given: bool = False,
        joint_speed_rad_s: float = math.inf,
    ) -> Space:
        """
        Args:
            joint_speed_rad_s: a tighter limit of the joints' speed than the robot's own.

        Raises:
            BadInputError: the robot's limits leave no gait in these ranges, or the margin is no share.
        """
        if not 0 <= margin < 1:
            raise BadInputError(f"--margin {margin:g}: a share of the torque, from 0 to below 1")
        ranges = {**WITHIN, **(within or {})}
        space = cls(
            _radians(ranges["alpha"]),
            _radians(ranges["beta"]),
            ranges["omega"],
            min(robot.angle_limit_rad),
            min(*robot.speed_limit_rad_s, joint_speed_rad_s),
            min(robot.acceleration_limit_rad_s2),
            margin,
            torque_given,
        )
        if space.alpha_rad[0] > space.angle_rad:
            raise BadInputError(
                f"no gait within {_said(ranges)}: robot {robot.name!r} allows {math.degrees(space.angle_rad):g} deg"
            )
        if space.omega_most(np.array(space.alpha_rad[0])) < space.omega_rad_s[0]:
            raise BadInputError(
                f"no gait within {_said(ranges)}: "
                + ("what was recorded" if space.speed_rad_s == joint_speed_rad_s else f"robot {robot.name!r}")
                + f" allows joints {space.speed_rad_s:g} rad/s and {space.acceleration_rad_s2:g} rad/s2"
            )
        return space

    @property
    def alpha_most_rad(self) -> float:
        """Largest amplitude that range and limits allow, at the lowest omega."""
        speed, acceleration = swing(self.omega_rad_s[0])
        # Of these alphas, rounding must not leave less than that omega.
        fast = min(self.speed_rad_s / speed, self.acceleration_rad_s2 / acceleration) * (1 - 1e-12)
        return max(self.alpha_rad[0], min(self.alpha_rad[1], self.angle_rad, fast))

    @property
    def torque_most(self) -> float:
        """Largest share of a servo's torque that a gait may take."""
        return 1 - self.margin if self.margin > 0 or self.torque_given else math.inf

    def omega_most(self, alpha_rad: Floats) -> Floats:
        """Highest omega that range and limits allow at these amplitudes; 0 where none is slow enough."""
        fast = _highest(_SPEED, self.speed_rad_s / alpha_rad)
        return np.minimum(
            self.omega_rad_s[1],
            np.minimum(fast, _highest(_ACCELERATION, self.acceleration_rad_s2 / alpha_rad)),
        )

    def nearest(self, gaits: Floats) -> Floats:
        """Gaits (G, 3 or more) moved into the space: omega gives way to the limits."""
        out = gaits.copy()
        out[:, 0] = np.clip(out[:, 0], self.alpha_rad[0], self.alpha_most_rad)
        out[:, 1] = np.clip(out[:, 1], *self.beta_rad)
        out[:, 2] = np.clip(out[:, 2], self.omega_rad_s[0], self.omega_most(out[:, 0]))
        return out

    def grid(self, alphas: int, betas: int, omegas: int) -> Floats:
        """(G, 3) gaits, the ends of the space among them; alpha and omega in equal ratios."""
        rows = []
        for alpha in _ratios(self.alpha_rad[0], self.alpha_most_rad, alphas):
            for beta in np.unique(np.linspace(*self.beta_rad, betas)):
                most = float(self.omega_most(np.array(alpha)))
                rows += [(alpha, beta, omega) for omega in _ratios(self.omega_rad_s[0], most, omegas)]
        return np.array(rows)

    def binds(self, gait: Floats, torque_use: float) -> list[str]:
        """The limits and ranges at whose end a gait is."""
        alpha, beta, omega = (float(value) for value in gait[:3])
        speed, acceleration = swing(omega)
        uses = {
            "joint angle": alpha / self.angle_rad,
            "joint speed": alpha * speed / self.speed_rad_s,
            "joint acceleration": alpha * acceleration / self.acceleration_rad_s2,
            "torque": torque_use / (1 - self.margin),
        }
        found = [name for name, use in uses.items() if use >= BINDING]
        for name, value, (low, high) in (
            ("alpha", alpha, self.alpha_rad),
            ("beta", beta, self.beta_rad),
            ("omega", omega, self.omega_rad_s),
        ):
            near = (1 - BINDING) * (high - low)
            if value >= high - near or value <= low + near:
                found.append(f"range of {name}")
        return found


LEAST_OMEGA_RAD_S = 0.05  # several cycles are simulated, step by step; chosen


def parse_within(text: str | None) -> dict[str, tuple[float, float]]:
    """``alpha=20..60,omega=1..4``: degrees, and rad/s.

    Raises:
        BadInputError: one line with what is wrong.
    """
    found: dict[str, tuple[float, float]] = {}
    for part in (text or "").split(",") if text is not None else ():
        name, equals, numbers = (piece.strip() for piece in part.partition("="))
        low, dots, high = numbers.partition("..")
        if name not in WITHIN:
            raise BadInputError(
                f"--within {part.strip()!r}: a range of {', '.join(WITHIN)}, as in alpha=20..60"
                + did_you_mean(name, WITHIN)
            )
        try:
            ends = float(low), float(high)
        except ValueError:
            ends, dots = (math.nan, math.nan), ""
        if not (equals and dots and all(map(math.isfinite, ends))):
            raise BadInputError(
                f"--within {part.strip()!r}: two numbers with .. between, as in {_EXAMPLES[name]}"
            )
        if name in found:
            raise BadInputError(f"--within: {name} is given twice")
        if not ends[0] <= ends[1]:
            raise BadInputError(f"--within {name}={low}..{high}: the first number is the larger one")
        if name != "beta" and ends[0] <= 0:
            raise BadInputError(f"--within {name}={low}..{high}: {name} is above zero")
        if name == "omega" and ends[0] < LEAST_OMEGA_RAD_S:
            raise BadInputError(
                f"--within omega={low}..{high}: at least {LEAST_OMEGA_RAD_S:g} rad/s; a cycle takes two minutes there"
            )
        found[name] = ends
    return found


def parse_grid(text: str) -> tuple[int, int, int]:
    """``10,10,7``: how many alphas, betas and omegas.

    Raises:
        BadInputError: not three whole numbers from 2 to 100.
    """
    try:
        alphas, betas, omegas = (int(part) for part in text.split(","))
    except ValueError:
        alphas = betas = omegas = 0
    if not all(2 <= count <= MOST_OF_GRID for count in (alphas, betas, omegas)):
        raise BadInputError(f"--grid {text!r}: three whole numbers from 2 to {MOST_OF_GRID}, as in 6,6,4")
    return alphas, betas, omegas


def swing(omega_rad_s: float) -> tuple[float, float]:
    """Largest speed and acceleration of a run of this omega with amplitude one, a little more rather than less."""
    at = min(int(np.searchsorted(_OMEGA, omega_rad_s)), len(_OMEGA) - 1)
    return float(_SPEED[at]), float(_ACCELERATION[at])


def _highest(swings: Floats, allowed: Floats) -> Floats:
    """The highest omega of the table whose swing is allowed; 0 where there is none."""
    at = np.searchsorted(swings, allowed, side="right")
    return np.where(at > 0, _OMEGA[np.maximum(at - 1, 0)], 0.0)


def _radians(ends: tuple[float, float]) -> tuple[float, float]:
    return math.radians(ends[0]), math.radians(ends[1])


def _said(ranges: Mapping[str, tuple[float, float]]) -> str:
    return ", ".join(f"{name} {low:g} to {high:g} {UNITS[name]}" for name, (low, high) in ranges.items())


def _ratios(low: float, high: float, count: int) -> Floats:
    return np.unique(np.geomspace(low, max(low, high), count))
