"""Joints on a servo bus, as the board in software drives them: one cycle is one sync read and one sync write.

The board calls ``encoder_counts`` at each set-point, then ``command``. Between the two calls of a tick, in time that
nobody waits for, ``advance`` looks after the servos' health: errors, torque, supply, temperature. That is also what
feeds their bus watchdogs while the board holds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Literal

from firmware_protocol.catalogue import Fault
from firmware_protocol.servo_trouble import ServoTrouble
from snakebot.errors import LostBoardError, SnakebotError
from snakebot.links.stream import Stream
from snakebot.robot import Robot
from snakebot.servobus.dynamixel import ALERT
from snakebot.servobus.health import HEALTH_S, HealthWatch
from snakebot.servobus.joints import Joint
from snakebot.servobus.master import TRIES, BusMaster
from snakebot.servobus.settings import Settings
from snakebot.softboard.hardware import HardwareFault, Health

MISSED_CYCLES = 5  # in a row without an answer: the joint has a fault
ASKED_ALONE_CYCLES = 2  # in a row without an answer: the servo is asked by itself; chosen
HELD_UP_S = 0.025  # for a line on which nobody answers any more: five such cycles are still within 100 ms
ALONE_TRIES = 4  # before a joint is given up; of several silent ones together
TICK_BUDGET_S = 0.007  # for asking again, within one reading
_POWER_TRIES = 8  # of a sync write that is checked by reading back
# No joint turns faster than the first, and no reading jumps by more than the second beside that: such a reading is
# asked again; chosen.
_SWIFT_RAD_S, _JUMP_RAD = 40.0, 0.3
_SAME_RAD = 0.1  # within which two readings of a joint agree; chosen
BEYOND_RAD = math.radians(1.0)  # by which a joint without power may stand beyond its limit
RELAX_AGAIN_S = 0.05  # between two tries to take power from a joint that does not confirm it
UNHEARD_S = 1.0  # after this long without a confirmation it is a fault
REOPEN_S = 0.5  # between looks for a line that is gone
_NEVER_S = math.inf


class ServoPlant:
    """Servos on a bus as a ``HardwarePlant``. All joints begin without power.

    Args:
        robot: whose joints they are; readings are in its encoder counts.
        joints: one servo each, all of one layout of registers.
        master: the bus.
        settings: what is changed in the servos while they have power.
        now_s: the clock of the bus.
        reopen: opens the line again after it was lost (and raises SnakebotError while it cannot): whoever is there
            then is relaxed, whatever the board's mode.
    """

    clock_ppm = 0.0

    def __init__(
        self,
        robot: Robot,
        joints: Sequence[Joint],
        master: BusMaster,
        settings: Settings,
        now_s: Callable[[], float],
        *,
        reopen: Callable[[], Stream] | None = None,
    ) -> None:
        self.robot = robot
        self.joints = tuple(joints)
        self.master = master
        self.settings = settings
        self.lost: LostBoardError | None = None  # the line is gone
        self._now_s = now_s
        self._reopen = reopen
        self._reopen_due_s = -_NEVER_S
        self._model = joints[0].model
        self._in_turn = not self._model.sync_read
        self._by_id = {joint.id: joint for joint in joints}
        self._raw: dict[int, int] = {}  # joint -> last position, as the servo said it
        self._read_s: dict[int, float] = {}
        self._missed = [0] * len(joints)
        self._free = [True] * len(joints)
        self._waking: set[int] = set()
        self._relaxing: set[int] = set()  # told to have no power, not confirmed yet
        self._relax_since_s = self._relax_due_s = -_NEVER_S
        self._turn_counts = [0.0] * len(joints)  # whole turns of a servo that counts on
        self._t_s = 0.0  # the board's time
        self._watch = HealthWatch(joints, master, settings)

    # -- JointPlant --------------------------------------------------------------------------------------------------

    def encoder_counts(self) -> list[int | None]:
        """Ask all servos where they are; None for one that has not answered, asked again as time allows."""
        readings = self._positions()
        counts: list[int | None] = []
        for index, joint in enumerate(self.joints):
            raw = readings.get(joint.number)
            if raw is None:
                self._missed[index] += 1
                if self._missed[index] >= MISSED_CYCLES:
                    self._watch.trouble(joint, ServoTrouble.SILENT)
                counts.append(None)
                continue
            self._missed[index] = 0
            self._watch.heard(joint)
            self._raw[joint.number] = raw
            counts.append(round(joint.angle_rad(raw) / self.robot.rad_per_count))
        return counts

    def command(self, t_s: float, setpoint_rad: Sequence[float]) -> None:
        """Send all goals in one sync write; joints that are to get power get it, where they are."""
        self._t_s = max(self._t_s, t_s)
        if self.lost is not None:
            return
        try:
            if self._waking:
                self._wake(sorted(self._waking))
                self._waking.clear()
                return
            self._send_goals(setpoint_rad)
        except LostBoardError as error:
            self._line_is_gone(error)

    def set_joint_mode(self, joint: int, mode: Literal["active", "free"], /) -> None:
        """Power off at once, confirmed by the next ``advance``; on with the next ``command``, all joints together."""
        self._free[joint - 1] = mode == "free"
        if mode == "active":
            self._waking.add(joint)
            self._relaxing.discard(joint)
            return
        self._waking.discard(joint)
        if not self._relaxing:
            self._relax_since_s = self._now_s()
        self._relaxing.add(joint)
        self._relax_due_s = -_NEVER_S
        if self.lost is None:
            try:
                off = self._model.pack("torque_enable", 0)
                relaxed = {self.joints[number - 1].id: off for number in self._relaxing}
                self.master.sync_write(self._model["torque_enable"].address, relaxed)
            except LostBoardError as error:
                self._line_is_gone(error)

    def advance(self, t_s: float) -> None:
        """See that who should have no power has none; look after the servos' health when it is time."""
        self._t_s = max(self._t_s, t_s)
        if self.lost is not None and not self._found_again():
            return
        try:
            if self._relaxing and self._now_s() >= self._relax_due_s:
                self._relax()
            elif self._now_s() >= self._watch.due_s:
                powered = {j.number for j, free in zip(self.joints, self._free, strict=True) if not free}
                self._watch.look(self._now_s(), powered - self._waking)
        except LostBoardError as error:
            self._line_is_gone(error)

    def pose(self) -> None:
        return None

    # -- HardwarePlant -----------------------------------------------------------------------------------------------

    @property
    def due_s(self) -> float:
        if self.lost is not None:
            return _NEVER_S  # whoever calls ``advance`` anyway may find it again
        due_s = min(self._watch.due_s, self._relax_due_s) if self._relaxing else self._watch.due_s
        return self._t_s + max(due_s - self._now_s(), 0.0)

    def fault(self) -> HardwareFault | None:
        if self.lost is not None:
            return HardwareFault(Fault.SERVO, 0, ServoTrouble.LINE_LOST)
        return self._watch.first() or (self._beyond() if all(self._free) else None)

    def _beyond(self) -> HardwareFault | None:
        """A joint that stands where no set-point may send it: it gets no power there."""
        for joint, limit_rad in zip(self.joints, self.robot.angle_limit_rad, strict=True):
            raw = self._raw.get(joint.number)
            if raw is not None and abs(joint.angle_rad(raw)) > limit_rad + BEYOND_RAD:
                return HardwareFault(
                    Fault.ENCODER, joint.number, round(10 * math.degrees(joint.angle_rad(raw)))
                )
        return None

    def health(self) -> Health | None:
        return self._watch.health()

    def close(self) -> None:
        """Take the power away, put back what was changed, and let go of the line."""
        if self.lost is None:
            try:
                self._relaxing = {joint.number for joint in self.joints}
                self._relax()
            except LostBoardError as error:
                self._line_is_gone(error)
        self.master.close()

    # -- positions and goals -----------------------------------------------------------------------------------------

    def _positions(self) -> dict[int, int]:
        """Joint -> position in counts, of those that answered and can be believed."""
        if self.lost is not None:
            return {}
        try:
            silent = [
                joint.id
                for joint, n in zip(self.joints, self._missed, strict=True)
                if n >= ASKED_ALONE_CYCLES
            ]
            # nobody answers: the line is held up, or gone; wait, as long as the board's watchdog lets us
            if len(silent) == len(self.joints):
                found = self._ask_positions(silent, 1, latency_s=HELD_UP_S)
            else:  # one that is silent may keep those behind it from answering too: it is asked alone
                found = self._ask_positions([servo for servo in self._by_id if servo not in silent])
                for servo in silent:
                    tries = max(1, ALONE_TRIES // len(silent))
                    found |= self._ask_positions([servo], tries, budget_s=_NEVER_S)
            doubted = [servo for servo, raw in found.items() if not self._believable(servo, raw)]
            if doubted:
                again = self._ask_positions(doubted)
                for servo in doubted:
                    first = found.pop(servo)
                    if servo in again and self._near(servo, first, again[servo]):
                        found[servo] = again[servo]
        except LostBoardError as error:
            self._line_is_gone(error)
            return {}
        now_s = self._now_s()
        for servo in found:
            self._read_s[servo] = now_s
        if any(self.master.errors.get(servo, 0) & self._alert for servo in found):
            self._watch.due_s = -_NEVER_S  # one of them has more to say
        return {self._by_id[servo].number: raw for servo, raw in found.items()}

    @property
    def _alert(self) -> int:
        return ALERT if self._model.family == "dynamixel" else 0xFF

    def _ask_positions(
        self,
        servos: Sequence[int],
        tries: int = TRIES,
        budget_s: float = TICK_BUDGET_S,
        latency_s: float | None = None,
    ) -> dict[int, int]:
        register = self._model["present_position"]
        heard = self.master.sync_read(
            servos,
            register.address,
            register.size,
            until_s=self._now_s() + budget_s,
            in_turn=self._in_turn or len(servos) == 1,
            tries=tries,
            latency_s=latency_s,
        )
        return {servo: self._model.unpack("present_position", data) for servo, data in heard.items()}

    def _believable(self, servo: int, raw: int) -> bool:
        before = self._raw.get(self._by_id[servo].number)
        if before is None:
            return True
        far = _JUMP_RAD + _SWIFT_RAD_S * (self._now_s() - self._read_s[servo])
        return self._near(servo, before, raw, far)

    def _near(self, servo: int, one: int, other: int, far_rad: float = _SAME_RAD) -> bool:
        joint = self._by_id[servo]
        away = abs(joint.angle_rad(one) - joint.angle_rad(other))
        return min(away, 2 * math.pi - away) <= far_rad

    def _send_goals(self, setpoint_rad: Sequence[float]) -> None:
        goals = {}
        for index, (joint, angle_rad) in enumerate(zip(self.joints, setpoint_rad, strict=True)):
            if not self._free[index]:
                goals[joint.id] = self._goal(index, joint.counts(angle_rad))
        if goals:
            self.master.sync_write(self._model["goal_position"].address, goals)

    def _goal(self, index: int, counts: float) -> bytes:
        model = self.joints[index].model
        inside = min(max(round(counts), model.lowest), model.highest)
        return model.pack("goal_position", inside + round(self._turn_counts[index]))

    # -- power -------------------------------------------------------------------------------------------------------

    def _wake(self, numbers: Sequence[int]) -> None:
        """Give joints power where they are: read, set the goals to that, then torque; each step is read back.

        A joint that does not go along gets no power, and its fault says so.
        """
        self.settings.unwatch(self.master, numbers)
        at = self._positions()
        refused = {number for number in numbers if number not in at}
        refused |= set(self.settings.apply(self.master, numbers))
        ready = [number for number in numbers if number not in refused]
        for number in ready:
            joint = self.joints[number - 1]
            straight = joint.counts(joint.angle_rad(at[number]))
            self._raw[number] = at[number]
            self._turn_counts[number - 1] = round(at[number] - straight)
        if ready:
            refused |= set(self._set_all("goal_position", {number: at[number] for number in ready}))
            ready = [number for number in ready if number not in refused]
        refused |= set(self._torque(ready, on=True)) | set(self.settings.watch(self.master, ready))
        for number in refused:
            self._watch.trouble(self.joints[number - 1], ServoTrouble.REFUSES)
        self._watch.due_s = self._now_s() + HEALTH_S

    def _relax(self) -> None:
        """Confirm that these joints have no power, then put their settings back; who is not heard is told again."""
        left = set(self._torque(sorted(self._relaxing), on=False))
        self.settings.restore(self.master, sorted(self._relaxing - left))
        self._watch.relaxed(self._relaxing - left)
        self._relaxing = left
        self._relax_due_s = self._now_s() + RELAX_AGAIN_S
        if self._now_s() > self._relax_since_s + UNHEARD_S:
            for number in left:
                self._watch.trouble(self.joints[number - 1], ServoTrouble.REFUSES)

    def _torque(self, numbers: Sequence[int], *, on: bool) -> list[int]:
        """Switch torque; the joints that have not confirmed it."""
        return self._set_all("torque_enable", dict.fromkeys(numbers, int(on)))

    def _set_all(self, name: str, values: dict[int, int]) -> list[int]:
        """Sync write and read back until all have taken it; the joints that have not."""
        left = dict(values)
        register = self._model[name]
        for _ in range(_POWER_TRIES):
            if not left:
                break
            data = {self.joints[n - 1].id: self._model.pack(name, value) for n, value in left.items()}
            self.master.sync_write(register.address, data)
            heard = self.master.sync_read(
                list(data), register.address, register.size, in_turn=self._in_turn, tries=1
            )
            for servo, answer in heard.items():
                if answer == data[servo]:
                    del left[self._by_id[servo].number]
        return sorted(left)

    def _line_is_gone(self, error: LostBoardError) -> None:
        self.lost = error
        self._reopen_due_s = self._now_s() + REOPEN_S

    def _found_again(self) -> bool:
        """Try to open the line again; who is found is to lose power."""
        if self._reopen is None or self._now_s() < self._reopen_due_s:
            return False
        self._reopen_due_s = self._now_s() + REOPEN_S
        try:
            self.master.continue_on(self._reopen())
        except SnakebotError:
            return False
        self.lost = None
        self._relaxing = {joint.number for joint in self.joints}
        self._relax_since_s = self._now_s()
        self._relax_due_s = -_NEVER_S
        return True
