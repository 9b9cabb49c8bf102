"""What a board needs of the joints behind it. ``snakebot.effects.Plant`` is the simulated one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Literal, Protocol, SupportsInt

if TYPE_CHECKING:
    from snakebot.robot import Robot


class JointPlant(Protocol):
    """Servos, joints, body and encoders. Its time starts at zero with the first reset of the board."""

    @property
    def clock_ppm(self) -> float:
        """By how much its effects make the board's clock run fast, on top of the board's own drift."""
        ...

    def command(self, t_s: float, setpoint_rad: Sequence[float]) -> None:
        """A set-point for all joints leaves the board."""
        ...

    def set_joint_mode(self, joint: int, mode: Literal["active", "free"], /) -> None:
        """``active`` follows set-points from where it is, ``free`` has no power; joints count from 1."""
        ...

    def advance(self, t_s: float) -> None:
        """Let the world go on until ``t_s``."""
        ...

    def encoder_counts(self) -> Iterable[SupportsInt | None]:
        """What the encoders say now; None where one gives no reading."""
        ...

    def pose(self) -> tuple[float, float, float, float] | None:
        """Centre of mass x, y (m), mean heading (rad, unwrapped), speed (m/s); None without a body."""
        ...


def make_plant(
    robot: Robot,
    specs: Sequence[Any],
    seed: int,
    start_rad: Sequence[float] | None,
    start_pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> JointPlant:
    """The plant, with everything compiled: the first tick must not wait for a compiler."""
    from snakebot.effects import Plant

    angles_rad = [0.0] * robot.joints if start_rad is None else list(start_rad)
    trial = Plant(robot, specs, seed, initial_rad=angles_rad)
    trial.set_joint_mode(1, "free")
    trial.command(0.0, angles_rad)
    trial.advance(0.01)
    trial.encoder_counts()
    trial.pose()
    return Plant(robot, specs, seed, initial_rad=angles_rad, pose=start_pose)
