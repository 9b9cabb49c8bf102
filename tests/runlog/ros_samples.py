"""ROS 2 bags, written by the ``rosbags`` package."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from snakebot.arrays import Floats

START_NS = 1_700_000_000_000_000_000
STORE: Any = get_typestore(Stores.ROS2_HUMBLE)
JOINT_STATE = "sensor_msgs/msg/JointState"
TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
ARRAY = "std_msgs/msg/Float64MultiArray"
CONTROLLER_STATE = "control_msgs/msg/JointTrajectoryControllerState"
STATE_TEXT = """# what ros2_control has published since Iron
std_msgs/Header header
string[] joint_names
uint8 MODE=1
trajectory_msgs/JointTrajectoryPoint reference
trajectory_msgs/JointTrajectoryPoint feedback
trajectory_msgs/JointTrajectoryPoint error
string[<=4] multi_dof_joint_names
float64 speed_scaling_factor
"""
STORE.register(get_types_from_msg(STATE_TEXT, CONTROLLER_STATE))

Row = tuple[str, str, float, Any]  # topic, type, seconds of the bag's time, message


def header(t_s: float) -> Any:
    ns = START_NS + round(t_s * 1e9)
    stamp = STORE.types["builtin_interfaces/msg/Time"](sec=ns // 10**9, nanosec=ns % 10**9)
    return STORE.types["std_msgs/msg/Header"](stamp=stamp, frame_id="base")


def _values(values: Floats) -> Floats:
    return np.ascontiguousarray(values, dtype=np.float64)


def joint_state(t_s: float, names: Iterable[str], position: Floats) -> Any:
    none = np.zeros(0)
    return STORE.types[JOINT_STATE](header(t_s), list(names), _values(position), none, none)


def point(position: Floats, after_s: float = 0.0) -> Any:
    none = np.zeros(0)
    after = STORE.types["builtin_interfaces/msg/Duration"](sec=int(after_s), nanosec=round(after_s % 1 * 1e9))
    kind = STORE.types["trajectory_msgs/msg/JointTrajectoryPoint"]
    return kind(_values(position), none, none, none, after)


def trajectory(t_s: float, names: Iterable[str], points: Iterable[Any]) -> Any:
    return STORE.types[TRAJECTORY](header(t_s), list(names), list(points))


def array(values: Floats) -> Any:
    layout = STORE.types["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
    return STORE.types[ARRAY](layout, _values(values))


def controller_state(t_s: float, names: Iterable[str], reference: Floats, feedback: Floats) -> Any:
    return STORE.types[CONTROLLER_STATE](
        header(t_s), list(names), point(reference), point(feedback), point(np.zeros(0)), ["no"], 1.0
    )


def bag(
    folder: Path,
    rows: Iterable[Row],
    storage: str = "mcap",
    prepare: Callable[[Writer], None] = lambda _: None,
) -> Path:
    plugin = StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3
    writer = Writer(folder, version=8, storage_plugin=plugin)
    prepare(writer)
    with writer:
        connections: dict[str, Any] = {}
        for topic, kind, t_s, message in rows:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=STORE)
            raw = STORE.serialize_cdr(message, kind)
            writer.write(connections[topic], START_NS + round(t_s * 1e9), raw)
    return folder
