"""The runs that were predicted last with the whole body. A search asks for many of them again: where a fit ended it is
scored, and what is scored is drawn, weighed and told.
"""

from __future__ import annotations

from collections.abc import Hashable
from threading import Lock

from cachetools import LRUCache

from snakebot.effects.prediction import JointRun

# Of predicted runs that are kept, MiB: 300 of 20 s at 100 Hz with five joints, several rounds of a fit to six runs;
# chosen.
MOST_MIB = 128


class RecentRuns:
    """Predicted runs by what they were made from, the least recently used forgotten first. May be used from several
    threads. What is kept is shared: it can't be written to.
    """

    def __init__(self, most_bytes: int = MOST_MIB * 2**20) -> None:
        self._runs: LRUCache[Hashable, JointRun] = LRUCache(most_bytes, getsizeof=_bytes)
        self._lock = Lock()

    def get(self, key: Hashable) -> JointRun | None:
        with self._lock:
            return self._runs.get(key)

    def keep(self, key: Hashable, run: JointRun) -> None:
        for array in (run.reading_rad, run.servos.joint_angle_rad, run.servos.load_nm):
            array.flags.writeable = False
        with self._lock:
            if _bytes(run) <= self._runs.maxsize:
                self._runs[key] = run


def _bytes(run: JointRun) -> int:
    servos = run.servos
    arrays = [run.reading_rad, servos.joint_angle_rad, servos.load_nm, servos.powered]
    arrays += [a for a in (servos.base, servos.torque_nm, servos.power_in_w) if a is not None]
    return sum(int(a.nbytes) for a in arrays)
