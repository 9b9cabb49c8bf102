"""Compile what the tests run, once, before several processes would do it side by side: python tools/compile_kernels.py

Where compiled code is on disk already it takes some seconds. What is not met here is compiled by the first who calls it.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))


def board() -> None:
    """The board in software, and the robot of the blind check behind one."""
    import numpy as np
    from blind.robot import real_robot
    from blind.wire_plant import BlindPlant

    from snakebot.robot import load_robot
    from snakebot.softboard import SoftBoard

    SoftBoard(load_robot("penn_state"))
    BlindPlant(real_robot(np.random.default_rng(0)))


def diagnosis() -> None:
    """A sweep of gaits, a recorded motion replayed, and a diagnosis."""
    import numpy as np
    from bench_cluster import warm

    from snakebot.physics import ChainModel, replay

    t_s = np.linspace(0.0, 0.1, 6)
    replay(ChainModel(*(np.ones(6) for _ in range(8))), t_s, 0.1 * np.sin(t_s)[:, None] * np.ones(5))
    warm()


PARTS = {"board": board, "diagnosis": diagnosis}


def main() -> None:
    if len(sys.argv) > 1:
        return PARTS[sys.argv[1]]()
    board()
    return diagnosis()


if __name__ == "__main__":
    main()
