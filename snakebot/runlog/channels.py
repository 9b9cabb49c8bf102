"""The channels of a run log: topic, schema and how one record becomes one JSON message.

JSON with a JSON schema is what Foxglove and PlotJuggler plot without a plug-in. Beside our own fields,
``/events`` has those of ``foxglove.Log`` and ``/pose`` those of ``foxglove.PoseInFrame``, so that the log and
3D panels show them. A missing number is null (JSON has no nan).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import orjson

from snakebot.runlog.metadata import as_utf8
from snakebot.runlog.records import (
    Event,
    Level,
    LinkRecord,
    PoseRecord,
    RawFrame,
    SteeringRecord,
    Telemetry,
    Tick,
)

PROFILE = "snakebot"  # in the header of every log; the schemas below are version 1
MESSAGE_ENCODING = "json"
SCHEMA_ENCODING = "jsonschema"
ROBOT_ATTACHMENT = "robot.yaml"

_LEVELS: dict[Level, int] = {"debug": 1, "info": 2, "warning": 3, "error": 4, "fatal": 5}  # foxglove.Log


@dataclass(frozen=True)
class Channel:
    """A topic and its schema; ``id`` is the channel's and the schema's number in the file."""

    id: int
    topic: str
    schema_name: str
    properties: dict[str, Any]
    description: str

    @property
    def schema(self) -> bytes:
        return orjson.dumps(
            {
                "$schema": "https://json-schema.org/draft/2020-12/schema",
                "title": self.schema_name,
                "description": self.description,
                "type": "object",
                "properties": self.properties,
            }
        )


def _number(text: str, nullable: bool = False) -> dict[str, Any]:
    return {"type": ["number", "null"] if nullable else "number", "description": text}


def _angles(text: str, nullable: bool = False) -> dict[str, Any]:
    items = {"type": "number"}
    return {"type": ["array", "null"] if nullable else "array", "items": items, "description": text}


_TIME = {
    "type": "object",
    "title": "time",
    "properties": {
        "sec": {"type": "integer", "minimum": 0},
        "nsec": {"type": "integer", "minimum": 0, "maximum": 999999999},
    },
}
_T_S = _number("host time since the run's start, s")
_XYZ = {axis: {"type": "number"} for axis in "xyz"}
_POSE = {
    "type": "object",
    "title": "foxglove.Pose",
    "properties": {
        "position": {"type": "object", "title": "foxglove.Vector3", "properties": _XYZ},
        "orientation": {
            "type": "object",
            "title": "foxglove.Quaternion",
            "properties": {**_XYZ, "w": {"type": "number"}},
        },
    },
}

JOINTS = Channel(
    1,
    "/joints",
    "snakebot.Joints",
    {
        "t_s": _T_S,
        "sequence": {"type": "integer", "description": "number of the tick"},
        "host_time_s": _number(
            "wall clock, s since the epoch (to the nanosecond: the message's publish time)"
        ),
        "setpoint_rad": _angles("wanted joint angles; null = servo off"),
        "sent_rad": _angles("joint angles sent, after limits; null = servo off"),
        "applied_rad": _angles("set-point the board says it executes", nullable=True),
        "measured_rad": _angles("encoders; null = sample lost", nullable=True),
        "board_time_us": _number("the board's clock, unwrapped, microseconds", nullable=True),
        "latency_s": _number("from sending the set-point to the board's answer, s", nullable=True),
        "late": {"type": "boolean", "description": "the tick missed its deadline"},
    },
    "One tick of the run loop; arrays hold one number a joint, tail first.",
)
POSE = Channel(
    2,
    "/pose",
    "foxglove.PoseInFrame",
    {
        "timestamp": _TIME,
        "frame_id": {"type": "string"},
        "pose": _POSE,
        "t_s": _T_S,
        "heading_rad": _number("mean link angle, rad"),
        "speed_m_s": _number("forward speed, m/s", nullable=True),
    },
    "Centre of mass on the ground, m; the orientation is the heading's, about z.",
)
EVENTS = Channel(
    3,
    "/events",
    "foxglove.Log",
    {
        "timestamp": _TIME,
        "level": {"type": "integer", "description": "1 debug, 2 info, 3 warning, 4 error, 5 fatal"},
        "message": {"type": "string"},
        "name": {"type": "string"},
        "file": {"type": "string"},
        "line": {"type": "integer"},
        "t_s": _T_S,
        "kind": {"type": "string", "description": "short name of what happened"},
        "data": {"type": "object", "description": "details"},
    },
    "Things that happened once.",
)
LINK = Channel(
    4,
    "/link",
    "snakebot.LinkStatistics",
    {"t_s": _T_S, "counters": {"type": "object", "additionalProperties": {"type": "number"}}},
    "Counters of the link since the run's start.",
)
FRAMES = Channel(
    5,
    "/frames",
    "snakebot.Frame",
    {
        "t_s": _T_S,
        "direction": {"type": "string", "enum": ["sent", "received"]},
        "id": {"type": "integer", "description": "CAN id"},
        "data": {"type": "string", "description": "payload in hexadecimal"},
    },
    "Frames as they were on the wire, when asked for.",
)
TELEMETRY = Channel(
    6,
    "/telemetry",
    "snakebot.Telemetry",
    {
        "t_s": _T_S,
        "supply_v": _number("V"),
        "supply_a": _number("A, of all joints"),
        "supply_temperature_c": _number("degrees Celsius, of what the board tells with its supply"),
        "current_1_a": _number("A, one a joint"),
        "temperature_1_c": _number("degrees Celsius, one a joint"),
    },
    "Further readings by the names that session folders use; any number may be missing or added.",
)
STEERING = Channel(
    7,
    "/steering",
    "snakebot.Steering",
    {
        "t_s": _T_S,
        "x_m": _number("centre of mass, mean over the last cycle, m"),
        "y_m": _number("the same, m"),
        "heading_rad": _number("mean link angle, mean over the last cycle, unwrapped, rad"),
        "wanted_heading_rad": _number("heading that leads to the course, rad", nullable=True),
        "heading_error_rad": _number("heading less the wanted one, rad", nullable=True),
        "cross_track_m": _number("distance from the line, left of it positive, m", nullable=True),
        "offset_rad": _number("offset of all joints from now on, beside the gait's own, rad"),
        "wanted_offset_rad": _number("the same before limits, rad", nullable=True),
        "saturated": {"type": "boolean", "description": "limits cut the offset short"},
        "stale": {"type": "boolean", "description": "no pose: the offset goes back to straight"},
    },
    "One decision of a run that holds a course, about one a cycle.",
)
CHANNELS = (JOINTS, POSE, EVENTS, LINK, FRAMES, TELEMETRY, STEERING)

_OPTIONS = orjson.OPT_SERIALIZE_NUMPY


def _time(start_ns: int, t_s: float) -> dict[str, int]:
    sec, nsec = divmod(max(0, start_ns + round(t_s * 1e9)), 1_000_000_000)
    return {"sec": sec, "nsec": nsec}


def encode_tick(tick: Tick) -> bytes:
    """The tick as JSON; arrays of other types than float64 are converted, never refused."""
    return orjson.dumps(
        {
            "t_s": tick.t_s,
            "sequence": tick.sequence,
            "host_time_s": tick.host_time_ns * 1e-9,
            "setpoint_rad": tick.setpoint_rad,
            "sent_rad": tick.sent_rad,
            "applied_rad": tick.applied_rad,
            "measured_rad": tick.measured_rad,
            "board_time_us": tick.board_time_us,
            "latency_s": tick.latency_s,
            "late": tick.late,
        },
        default=_plain,
        option=_OPTIONS,
    )


def _plain(value: Any) -> Any:
    """For orjson: arrays it cannot take as they are (strided, big-endian) and other sequences."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, (bytes, bytearray)):
        return value.hex()
    if hasattr(value, "__iter__"):
        return list(value)
    return str(value)


def encode_pose(pose: PoseRecord, start_ns: int) -> bytes:
    half = 0.5 * pose.heading_rad
    finite = math.isfinite(half)
    return orjson.dumps(
        {
            "timestamp": _time(start_ns, pose.t_s),
            "frame_id": "ground",
            "pose": {
                "position": {"x": pose.x_m, "y": pose.y_m, "z": 0.0},
                "orientation": {
                    "x": 0.0,
                    "y": 0.0,
                    "z": math.sin(half) if finite else 0.0,
                    "w": math.cos(half) if finite else 1.0,
                },
            },
            "t_s": pose.t_s,
            "heading_rad": pose.heading_rad,
            "speed_m_s": pose.speed_m_s,
        },
        default=_plain,
        option=_OPTIONS,
    )


def encode_event(event: Event, start_ns: int) -> bytes:
    return orjson.dumps(
        {
            "timestamp": _time(start_ns, event.t_s),
            "level": _LEVELS.get(event.level, 2),
            "message": as_utf8(event.message),
            "name": event.kind,
            "file": "",
            "line": 0,
            "t_s": event.t_s,
            "kind": event.kind,
            "data": orjson.Fragment(_encode_details(event.data)),
        }
    )


def _encode_details(data: Mapping[str, object]) -> bytes:
    try:
        return orjson.dumps(dict(data), default=_plain, option=_OPTIONS | orjson.OPT_NON_STR_KEYS)
    except TypeError:  # integers beyond 64 bits, odd keys: a run must not fail over a remark
        return orjson.dumps({as_utf8(str(key)): as_utf8(str(value)) for key, value in data.items()})


def level_name(number: object) -> Level:
    return next((name for name, value in _LEVELS.items() if value == number), "info")


def encode_link(statistics: LinkRecord) -> bytes:
    record = {"t_s": statistics.t_s, "counters": dict(statistics.counters)}
    return orjson.dumps(record, default=_plain, option=_OPTIONS)


def encode_telemetry(telemetry: Telemetry) -> bytes:
    return orjson.dumps({"t_s": telemetry.t_s, **telemetry.values}, default=_plain, option=_OPTIONS)


def encode_steering(steering: SteeringRecord) -> bytes:
    return orjson.dumps(asdict(steering), default=_plain, option=_OPTIONS)


def encode_frame(frame: RawFrame) -> bytes:
    record = {
        "t_s": frame.t_s,
        "direction": frame.direction,
        "id": frame.id,
        "data": bytes(frame.data).hex(),
    }
    return orjson.dumps(record)
