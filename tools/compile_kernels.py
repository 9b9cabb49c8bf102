"""Compile what the tests run, before several processes do it side by side: python tools/compile_kernels.py

Where compiled code is on disk already it takes some seconds. What is not met here is compiled by its first caller.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import numpy as np
from bench_cluster import warm
from blind.robot import real_robot
from blind.wire_plant import BlindPlant
from physics_peers import MujocoChain

from snakebot.diagnosis.evidence.operators import limited, play
from snakebot.diagnosis.evidence.within_bounds import minimum_within
from snakebot.physics import ChainModel, replay
from snakebot.physics.borne_play import borne_side
from snakebot.robot import load_robot
from snakebot.softboard import SoftBoard


def boards() -> None:
    """The board in software, and the robot of the blind check behind one."""
    SoftBoard(load_robot("penn_state"))
    BlindPlant(real_robot(np.random.default_rng(0)))


def recorded_motion() -> None:
    """A chain led by joint angles over time."""
    one = np.ones(6)
    t_s = np.linspace(0.0, 0.1, 6)
    replay(ChainModel(one, one, one, one, one, one, one, one), t_s, np.zeros((6, 5)))


def in_mujoco() -> None:
    """The chain that is compared with MuJoCo's."""
    one = np.ones(6)
    chain = MujocoChain(ChainModel(one, one, one, one, one, one, one, one), dt_s=1e-3, kp=1.0, kd=0.1)
    chain.run((0.1, 1.0, 1.0), steps=1, every=1)


def in_the_diagnosis() -> None:
    """What a session of a bench does not need: the motion over ground, and play."""
    one = np.ones(1)
    borne_side(one, np.ones((1, 1)))
    minimum_within(np.eye(1), one, -one, one, np.zeros(1))
    play(np.zeros(2), 0.1)
    limited(np.arange(2.0), np.zeros(2), 0.1)


if __name__ == "__main__":
    argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    ).parse_args()
    boards()
    recorded_motion()
    in_mujoco()
    in_the_diagnosis()
    warm()  # a sweep of gaits, and a diagnosis
