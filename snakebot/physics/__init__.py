"""The simulation of a planar snake: chain of rigid links, ground friction, joint drives. No I/O, no wire.

Names load on first use, so that importing this package costs no compiler.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from snakebot.lazy import names_from

if TYPE_CHECKING:
    from snakebot.physics.chain import FREE, PRESCRIBED, TORQUE, Chain, Drive
    from snakebot.physics.gaits import GaitResults, Pid, gait_eps_m_s, gait_trajectory, simulate_gaits
    from snakebot.physics.model import ChainModel
    from snakebot.physics.trajectory import Trajectory, replay, replayed_pose

_HOME = {
    "ChainModel": "model",
    "Chain": "chain",
    "Drive": "chain",
    "PRESCRIBED": "chain",
    "TORQUE": "chain",
    "FREE": "chain",
    "GaitResults": "gaits",
    "Pid": "gaits",
    "gait_eps_m_s": "gaits",
    "gait_trajectory": "gaits",
    "simulate_gaits": "gaits",
    "Trajectory": "trajectory",
    "replay": "trajectory",
    "replayed_pose": "trajectory",
}

__all__ = [
    "FREE",
    "PRESCRIBED",
    "TORQUE",
    "Chain",
    "ChainModel",
    "Drive",
    "GaitResults",
    "Pid",
    "Trajectory",
    "gait_eps_m_s",
    "gait_trajectory",
    "replay",
    "replayed_pose",
    "simulate_gaits",
]

__getattr__ = names_from(__name__, _HOME)
