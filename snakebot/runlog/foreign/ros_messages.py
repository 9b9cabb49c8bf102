"""What the messages of a bag say of joints: names, positions, times."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from snakebot.arrays import Floats
from snakebot.runlog.foreign.ros_types import ARRAY, CONTROLLER_STATE, JOINT_STATE, TRAJECTORY


def _joint_state(message: Mapping[str, Any], measured: bool) -> tuple[Sequence[str], Floats]:
    return message["name"], np.asarray(message["position"], dtype=np.float64)


def _array(message: Mapping[str, Any], measured: bool) -> tuple[Sequence[str], Floats]:
    return (), np.asarray(message["data"], dtype=np.float64)


def _controller_state(message: Mapping[str, Any], measured: bool) -> tuple[Sequence[str], Floats]:
    """Newer versions say reference and feedback, older ones desired and actual."""
    new, old = ("feedback", "actual") if measured else ("reference", "desired")
    part = next(message[key] for key in (new, old, "nothing") if key in message or key == "nothing")
    return message["joint_names"], np.asarray(part["positions"], dtype=np.float64)


_Take = Callable[[Mapping[str, Any], bool], tuple[Sequence[str], Floats]]
TAKEN: dict[str, _Take] = {
    JOINT_STATE: _joint_state,
    ARRAY: _array,
    CONTROLLER_STATE: _controller_state,
    TRAJECTORY: _array,
}


def stamp_ns(message: Mapping[str, Any]) -> int:
    header = message.get("header")
    return _ns(header["stamp"]) if isinstance(header, Mapping) else 0


def _ns(time: Mapping[str, Any]) -> int:
    return int(time["sec"]) * 1_000_000_000 + int(time["nanosec"])


def trajectory(
    rows: Sequence[tuple[int, dict[str, Any]]],
) -> list[tuple[int, int, Sequence[str], Floats]]:
    """The points of trajectories, each at its own time; a new trajectory takes the place of what an older one still had
    to do from its first point on."""
    found: list[tuple[int, int, Sequence[str], Floats]] = []
    for log_ns, message in sorted(rows, key=lambda row: row[0]):
        stamp = stamp_ns(message)
        points = [(_ns(point["time_from_start"]), point["positions"]) for point in message["points"]]
        if not points:
            continue
        begin = log_ns + points[0][0] if not stamp else stamp + points[0][0]
        while found and (found[-1][0] if stamp else found[-1][1]) >= begin:
            found.pop()
        found += [
            (
                stamp + after if stamp else 0,
                (stamp or log_ns) + after,
                message["joint_names"],
                np.asarray(values, dtype=np.float64),
            )
            for after, values in points
        ]
    return found
