"""The servo of each joint: who it is, and its counts as angles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from snakebot.errors import BadInputError, NoBoardError
from snakebot.robot import JointServo, Robot
from snakebot.servobus.dynamixel import Dynamixel
from snakebot.servobus.master import LATENCY_S, BusMaster
from snakebot.servobus.models import model_by_number, model_named
from snakebot.servobus.packets import Dialect
from snakebot.servobus.registers import ServoModel

SCAN_IDS = range(1, 21)  # ids that are asked where no ids are given; chosen
_QUICK_TRIES = 1  # of a ping where nobody need be there
_AGAIN_TRIES = 3  # of one to a silent id where somebody answers; chosen


@dataclass(frozen=True, slots=True)
class Identity:
    """What a servo says of itself; ``model`` is None where it is none that is known."""

    id: int
    number: int
    firmware: int
    model: ServoModel | None

    @property
    def name(self) -> str:
        return self.model.name if self.model is not None else f"unknown model {self.number}"

    @property
    def firmware_text(self) -> str:
        if self.model is not None and self.model.family == "feetech":
            major, minor = (self.firmware & 0xFF, self.firmware >> 8)
            if self.model.big_endian:
                major, minor = minor, major
            return f"{major}.{minor}"
        return str(self.firmware)


@dataclass(frozen=True, slots=True)
class Joint:
    """One joint and its servo."""

    number: int  # from 1
    servo: Identity
    model: ServoModel
    direction: int
    zero_counts: int
    torque_limit: float

    @property
    def id(self) -> int:
        return self.servo.id

    @property
    def what(self) -> str:
        """How messages call it."""
        return f"joint {self.number} (servo {self.id})"

    def angle_rad(self, counts: float) -> float:
        """The angle at a position: of all that differ by whole turns, the one nearest to straight."""
        turn = self.model.counts_per_rev
        away = (counts - self.zero_counts + turn / 2) % turn - turn / 2
        return self.direction * away * self.model.rad_per_count

    def counts(self, angle_rad: float) -> float:
        """The position of an angle, in the turn in which the joint is straight at ``zero_counts``."""
        return self.zero_counts + self.direction * angle_rad / self.model.rad_per_count


def identify(master: BusMaster, servo: int, tries: int = 3) -> Identity | None:
    """Who has this id; None: nobody answers."""
    answer = master.ping(servo, tries)
    if answer is None:
        return None
    if isinstance(master.dialect, Dynamixel):
        number, firmware = int.from_bytes(answer[:2], "little"), answer[2]
        return Identity(servo, number, firmware, model_by_number("dynamixel", number))
    start = master.read(servo, 0, 5)
    if start is None:
        return None
    number = int.from_bytes(start[3:5], "little")
    model = model_by_number("feetech", number) or model_by_number(
        "feetech", int.from_bytes(start[3:5], "big")
    )
    if model is not None and model.big_endian:
        number = model.numbers[0]
    order = "big" if model is not None and model.big_endian else "little"
    return Identity(servo, number, int.from_bytes(start[:2], order), model)  # type: ignore[arg-type]


def look_around(master: BusMaster, ids: Sequence[int] = SCAN_IDS) -> list[Identity]:
    """Everybody who answers at one of these ids, in their order.

    Each is asked once. Where somebody answers, the silent ones are asked again, and waited for longer: one lost or
    late answer hides nobody.
    """
    there = {servo for servo in ids if master.ping(servo, _QUICK_TRIES) is not None}
    if there:
        master.latency_s = max(master.latency_s, LATENCY_S)
        there |= {
            servo for servo in ids if servo not in there and master.ping(servo, _AGAIN_TRIES) is not None
        }
    asked = (identify(master, servo) for servo in ids if servo in there)
    return [who for who in asked if who is not None]


def wanted_servos(robot: Robot, ids: Sequence[int]) -> tuple[JointServo, ...]:
    """The servo that each joint should have: of the description, or as the port's ids say.

    Raises:
        BadInputError: both say it, and differ; or the ids are too few or too many.
    """
    if ids and len(ids) != robot.joints:
        raise BadInputError(f"{len(ids)} ids for robot {robot.name!r} with {robot.joints} joints")
    if robot.servos is None:
        return tuple(JointServo(id=number) for number in ids or range(1, robot.joints + 1))
    if ids and [servo.id for servo in robot.servos] != list(ids):
        described = ",".join(str(servo.id) for servo in robot.servos)
        raise BadInputError(f"robot {robot.name!r} has servos with the ids {described}: leave ids= away")
    return robot.servos


def roll_call(master: BusMaster, wanted: Sequence[JointServo]) -> list[Joint]:
    """Find the servo of each joint.

    Raises:
        BadInputError: a model of the description is none, or servos of different kinds share the bus.
        NoBoardError: servos are missing, or are others than the description says; all of that in one line.
    """
    models = [model_named(each.model) if each.model is not None else None for each in wanted]
    found = {each.id: identify(master, each.id) for each in wanted}
    wrong = [
        f"{who.id} is {who.name}" + (f", not {model.name}" if model is not None else "")
        for each, model in zip(wanted, models, strict=True)
        if (who := found[each.id]) is not None and (who.model is None or model not in (None, who.model))
    ]
    missing = [number for number, who in found.items() if who is None]
    if wrong or missing:
        raise NoBoardError(_muster(master, wanted, found, wrong, missing))
    joints = []
    for number, each in enumerate(wanted, 1):
        who = found[each.id]
        assert who is not None
        assert who.model is not None
        middle = (who.model.lowest + who.model.highest + 1) // 2
        zero = middle if each.zero_counts is None else each.zero_counts
        joints.append(Joint(number, who, who.model, each.direction, zero, each.torque_limit))
    _alike(joints)
    return joints


def _muster(
    master: BusMaster,
    wanted: Sequence[JointServo],
    found: Mapping[int, Identity | None],
    wrong: Sequence[str],
    missing: Sequence[int],
) -> str:
    """Missing, wrong, expected and found ids in one line."""
    text = f"{master.where}: servos {', '.join(str(each.id) for each in wanted)} were expected"
    if missing:
        text += f"; {', '.join(map(str, missing))} do{'es' if len(missing) == 1 else ''} not answer"
    if wrong:
        text += f"; {'; '.join(wrong)}"
    others = [who for who in look_around(master) if who.id not in found]
    here = [who for who in found.values() if who is not None] + others
    if not here:
        if master.statistics.corrupt:
            return f"{text}; only damaged answers came: two servos of one id, or a wrong bit rate ({master.baud})?"
        return f"{text}; nobody answers at {master.baud} baud: is the supply on, and is this the bit rate?"
    shown = ", ".join(f"{who.id} ({who.name})" for who in sorted(here, key=lambda who: who.id))
    damaged = "; damaged answers came too: two servos of one id?" if master.statistics.corrupt else ""
    return f"{text}; found: {shown}{damaged}"


def _alike(joints: Sequence[Joint]) -> None:
    """One question must be understood by all.

    Raises:
        BadInputError: SCS and STS servos on one bus.
    """
    kinds = {(j.model.big_endian, j.model.sync_read): j.model.name for j in joints}
    if len(kinds) > 1:
        raise BadInputError(
            f"{' and '.join(sorted(kinds.values()))} on one bus: they store numbers the other way round; "
            "put them on two adapters"
        )


def dialect_of(family: str) -> Dialect:
    """The packet format of a family."""
    from snakebot.servobus.feetech import Feetech

    return Dynamixel() if family == "dynamixel" else Feetech()


def crosses_the_wrap(joint: Joint, limit_rad: float) -> bool:
    """Some angle within the limit is a position that a servo in its one turn cannot be told."""
    ends = (joint.counts(-limit_rad), joint.counts(limit_rad))
    return min(ends) < joint.model.lowest - 0.5 or max(ends) > joint.model.highest + 0.5
