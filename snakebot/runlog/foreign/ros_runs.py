"""A ROS 2 bag as a run: measured joint angles and commands, joints matched by name, on the clock of the measurement.

Nothing is invented between messages: the command at a measurement is the last one that was given until then.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from snakebot.arrays import Bools, Floats, Ints
from snakebot.errors import BadInputError
from snakebot.runlog.foreign.angles import AngleForm
from snakebot.runlog.foreign.made_run import chosen, made_run
from snakebot.runlog.foreign.ros_bag import Bag
from snakebot.runlog.foreign.ros_message import Topic
from snakebot.runlog.foreign.ros_messages import TAKEN, stamp_ns, trajectory
from snakebot.runlog.foreign.ros_types import (
    ARRAY,
    CONTROLLER_STATE,
    JOINT_STATE,
    KNOWN,
    TRAJECTORY,
    Definition,
    DefinitionError,
    definition,
)
from snakebot.runlog.number_table import MAX_CELLS
from snakebot.runlog.run import Run

COMMANDS = (JOINT_STATE, TRAJECTORY, ARRAY, CONTROLLER_STATE)
MEASUREMENTS = (JOINT_STATE, CONTROLLER_STATE)
MAX_JOINTS = 256  # of one message; chosen
_LISTED = 8  # topics that an error names at most; chosen
_USUAL = ("/joint_states", "joint_states")  # what ros2_control's broadcaster publishes


@dataclass(frozen=True)
class BagOptions:
    """What is said of a bag; what is None is found out."""

    measured: str | None = None  # topic
    command: str | None = None
    joints: tuple[str, ...] = ()
    angles: AngleForm = field(default_factory=AngleForm)


@dataclass(frozen=True)
class _Signal:
    """Positions by joint name: times (M,) of the header (0: none) and of the bag, ns; values (M, joints), and which of
    them the messages hold: a nan that was given is a lost sample, or a servo that is off."""

    names: tuple[str, ...]  # empty where the messages have none
    stamp_ns: Ints
    log_ns: Ints
    values: Floats
    given: Bools


def read_bag(bag: Bag, options: BagOptions) -> tuple[Run, str]:
    """The run, and how the bag was understood, in one line.

    Raises:
        BadInputError: one line: which topic, what is wrong, which option says what is wanted.
    """
    measured_topic, command_topic = _topics(bag, options)
    raw: dict[str, list[tuple[int, dict[str, Any]]]] = {
        topic: [] for topic in {measured_topic, command_topic}
    }
    forms = {topic: _definition(bag, bag.topics[topic]) for topic in raw}
    numbers = 0
    for message in bag.messages(raw.keys()):
        try:
            decoded = forms[message.topic].decode(message.data)
        except DefinitionError as error:
            raise BadInputError(f"{bag.path}: {message.topic}: a message cannot be read: {error}") from None
        raw[message.topic].append((message.time_ns, decoded))
        numbers += len(message.data) // 8
        if numbers > MAX_CELLS:
            raise BadInputError(f"{bag.path}: more than {MAX_CELLS} numbers; cut the bag")
    for topic, rows in raw.items():
        if not rows:
            raise BadInputError(f"{bag.path}: {topic} has no messages")
    measured = _signal(bag, measured_topic, raw[measured_topic], measured=True)
    command = _signal(bag, command_topic, raw[command_topic], measured=False)
    joints = _joints(bag, options, measured, command, command_topic)
    stamped = bool((measured.stamp_ns > 0).all() and (command.stamp_ns > 0).all())
    times = measured.stamp_ns if stamped else measured.log_ns
    order = np.argsort(times, kind="stable")
    kept = order[np.concatenate(([True], np.diff(times[order]) > 0))]
    dropped = len(order) - len(kept)
    times, angle = times[kept], _column(measured, joints)[0][kept]
    held = hold(times, command.stamp_ns if stamped else command.log_ns, *_column(command, joints))
    about: dict[str, Any] = {
        "started_unix_s": float(times[0] / 1e9),
        "imported_from": bag.path.resolve().name,
        "joints": list(joints),
        "measured": measured_topic,
        "command": command_topic,
    }
    # Whole nanoseconds first: a wall clock in float64 seconds keeps 240 ns.
    t_s = (times - times[0]) / 1e9
    angles = options.angles
    run = made_run(bag.path, _name(bag), t_s, angles.to_rad(held), angles.to_rad(angle), about)
    clock = "the headers' time" if stamped else "the bag's time (not every header has one)"
    told = [f"measured {measured_topic}, commands {command_topic}, joints {', '.join(joints[:8])}", clock]
    if command_topic != measured_topic:
        told.append("each command held until the next")
    if bag.topics[command_topic].kind == TRAJECTORY:
        told.append("what the controller made between the points of a trajectory is not in the bag")
    told += [f"{dropped} measurements with the time of another one left out"] if dropped else []
    return run, "; ".join([*told, *dict.fromkeys(bag.problems)])


def _name(bag: Bag) -> str:
    name = bag.path.resolve().name
    return name.removesuffix(".mcap").removesuffix(".db3") or "bag"


def _topics(bag: Bag, options: BagOptions) -> tuple[str, str]:
    """Topics of the measurement and of the command."""
    there = {name: topic for name, topic in bag.topics.items() if topic.kind in COMMANDS}
    said = ", ".join(f"{name} ({topic.kind})" for name, topic in list(bag.topics.items())[:12])
    said = said or "; ".join(["none", *bag.problems])
    for option, name, kinds in (
        ("--measured", options.measured, MEASUREMENTS),
        ("--command", options.command, COMMANDS),
    ):
        if name is not None and (name not in there or there[name].kind not in kinds):
            raise BadInputError(
                f"{bag.path}: {option} {name}: no topic of joints by that name; there are {said}"
            )
    states = [name for name, topic in there.items() if topic.kind == CONTROLLER_STATE]
    measured = options.measured
    if measured is None and options.command is None and len(states) == 1:
        return states[0], states[0]
    if measured is None:
        able = [n for n, topic in there.items() if topic.kind in MEASUREMENTS and n != options.command]
        usual = [name for name in able if name in _USUAL]
        able = usual or able
        if len(able) != 1:
            what = _not_one(able, "measurement", "joint states")
            raise BadInputError(f"{bag.path}: {what}; choose with --measured and --command; there are {said}")
        measured = able[0]
    if options.command is not None:
        return measured, options.command
    if there[measured].kind == CONTROLLER_STATE:
        return measured, measured
    able = [name for name in there if name != measured]
    if len(able) != 1:
        what = _not_one(able, "command", "commands")
        raise BadInputError(f"{bag.path}: {what}; choose with --command; there are {said}")
    return measured, able[0]


def _not_one(able: Sequence[str], role: str, messages: str) -> str:
    """Why a topic is not chosen by itself: several have messages of that kind, or none has."""
    if not able:
        return f"no topic of {messages}"
    return f"more than one topic may be the {role} ({', '.join(able[:_LISTED])})"


def _definition(bag: Bag, topic: Topic) -> Definition:
    if topic.encoding != "cdr":
        raise BadInputError(
            f"{bag.path}: {topic.name} is in {topic.encoding[:20]!r}; messages in CDR are read"
        )
    text = topic.definition or KNOWN.get(topic.kind)
    if text is None:
        raise BadInputError(
            f"{bag.path}: holds no definition of {topic.kind} (bags in SQLite of before ROS 2 Iron have none): "
            "record it as MCAP, or name other topics with --measured and --command"
        )
    try:
        return definition(topic.kind, text)
    except DefinitionError as error:
        raise BadInputError(f"{bag.path}: the definition of {topic.kind} cannot be read: {error}") from None


def _signal(bag: Bag, topic: str, rows: Sequence[tuple[int, dict[str, Any]]], measured: bool) -> _Signal:
    kind = bag.topics[topic].kind
    take = TAKEN[kind]
    names: list[str] = []
    found: list[tuple[int, int, Sequence[str], Floats]] = []
    try:
        if kind == TRAJECTORY:
            found = trajectory(rows)
        else:
            found = [(stamp_ns(message), log_ns, *take(message, measured)) for log_ns, message in rows]
    except (KeyError, TypeError, IndexError, ValueError) as error:
        raise BadInputError(f"{bag.path}: {topic}: {kind} without {error}") from None
    for _, _, here, values in found:
        if len(values) > MAX_JOINTS or len(here) > MAX_JOINTS:
            raise BadInputError(f"{bag.path}: {topic}: more than {MAX_JOINTS} joints; not read")
        names += [name for name in here if name not in names]
        if len(names) > MAX_JOINTS:
            raise BadInputError(f"{bag.path}: {topic}: more than {MAX_JOINTS} names of joints; not read")
    width = len(names) or max((len(values) for _, _, _, values in found), default=0)
    index = {name: number for number, name in enumerate(names)}
    out, given = np.full((len(found), width), np.nan), np.zeros((len(found), width), dtype=bool)
    for row, (_, _, here, values) in enumerate(found):
        places = [index[name] for name in here][: len(values)] if here else list(range(len(values)))
        out[row, places], given[row, places] = values[: len(places)], True
    some = given.any(axis=1)
    if not some.any():
        raise BadInputError(f"{bag.path}: {topic}: no message holds a position")
    stamps = np.array([stamp for stamp, *_ in found], dtype=np.int64)[some]
    logs = np.array([log_ns for _, log_ns, *_ in found], dtype=np.int64)[some]
    return _Signal(tuple(names), stamps, logs, out[some], given[some])


def _joints(
    bag: Bag, options: BagOptions, measured: _Signal, command: _Signal, command_topic: str
) -> tuple[str, ...]:
    where = str(bag.path)
    if not measured.names:
        raise BadInputError(f"{where}: the measurement names no joints")
    if command.names:
        both = tuple(name for name in measured.names if name in command.names)
        if not both and not options.joints:
            raise BadInputError(
                f"{where}: no joint is in both: measured {', '.join(measured.names[:8])}, commanded "
                f"{', '.join(command.names[:8])}"
            )
        names = chosen(options.joints, both, where, "what is both measured and commanded")
        ordered = tuple(
            name for name in command.names if name in names
        )  # a controller's order, not the alphabet's
        return options.joints or ordered
    count = command.values.shape[1]
    if not options.joints and count > 1:
        raise BadInputError(
            f"{where}: {command_topic} names no joints: give them in its order, --joints "
            f"{','.join(measured.names[:count])} for example"
        )
    names = chosen(options.joints, measured.names, where, "the measurement")
    if len(names) != count:
        raise BadInputError(
            f"{where}: {command_topic} has {count} values, but {len(names)} joints were named"
        )
    return names


def _column(signal: _Signal, joints: Sequence[str]) -> tuple[Floats, Bools]:
    if not signal.names:
        return signal.values, signal.given
    columns = [signal.names.index(name) for name in joints]
    return signal.values[:, columns], signal.given[:, columns]


def hold(at_ns: Ints, given_ns: Ints, values: Floats, given: Bools) -> Floats:
    """The last values given until each time (N, k); nan before the first. A joint keeps what it had."""
    order = np.argsort(given_ns, kind="stable")
    given_ns, values, given = given_ns[order], values[order], given[order]
    rows = np.arange(len(values))
    out = np.full((at_ns.size, values.shape[1]), np.nan)
    last = np.searchsorted(given_ns, at_ns, side="right") - 1
    for joint in range(values.shape[1]):
        known = np.maximum.accumulate(np.where(given[:, joint], rows, -1))
        source = np.where(last >= 0, known[np.maximum(last, 0)], -1)
        good = source >= 0
        out[good, joint] = values[source[good], joint]
    return out
