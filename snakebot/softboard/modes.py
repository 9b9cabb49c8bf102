"""What mode the board is in, who holds it, and what its watchdog says: the table of PROTOCOL.md, and nothing else.

No wire, no plant, no clock: times are seconds of the board's own clock, handed in.
"""

from __future__ import annotations

import math

from firmware_protocol.catalogue import LATCHES, NOBODY, Fault, Mode, Result

WATCHDOG_MS = 100  # armed: longest time without an executed set-point (PROTOCOL.md)
HOLD_PATIENCE_S = 1.0  # holding: longest time without a heartbeat of the holder
RELAX_S = 2.0  # fault: the joints are frozen this long before they lose power

Answer = tuple[Result, int]  # result and detail of an acknowledgement

_TRANSITIONS: dict[Mode, frozenset[Mode]] = {
    Mode.DISARMED: frozenset({Mode.ARMED}),
    Mode.ARMED: frozenset({Mode.HOLDING, Mode.DISARMED}),
    Mode.HOLDING: frozenset({Mode.ARMED, Mode.DISARMED}),
    Mode.STOPPED: frozenset(),  # only ``clear`` leads out
    Mode.FAULT: frozenset(),
}
_HELD_MODES = (Mode.ARMED, Mode.HOLDING)
_REQUESTABLE = (Mode.DISARMED, Mode.ARMED, Mode.HOLDING)


class ModeMachine:
    """Modes of one board, which waits ``watchdog_s`` for a set-point. Starts disarmed, as after a reset."""

    def __init__(self, watchdog_s: float) -> None:
        self._watchdog_s = watchdog_s
        self.mode = Mode.DISARMED
        self.holder = NOBODY
        self.fault = Fault.NONE
        self.fault_since_s = 0.0
        self.latch = 0  # number of the last one: each fault and each emergency stop raises it
        self.broken = Fault.NONE  # what is wrong with the hardware now
        self.powered = False
        self._fed_s = 0.0  # what the watchdog counts from: arming or set-point; holding or heartbeat

    @property
    def due_s(self) -> float:
        """When ``expire`` has something to do: a time of the board's clock, or infinity."""
        if self.mode is Mode.ARMED:
            return self._fed_s + self._watchdog_s
        if self.mode is Mode.HOLDING:
            return self._fed_s + HOLD_PATIENCE_S
        if self.mode is Mode.FAULT and self.powered:
            return self.fault_since_s + RELAX_S
        return math.inf

    def expire(self, t_s: float) -> bool:
        """The timer of ``due_s`` has run out at ``t_s``. True: the watchdog; False: a fault has lasted long enough."""
        if self.mode is Mode.FAULT:
            self.powered = False
            return False
        self.fail(Fault.WATCHDOG, t_s)
        return True

    def held_against(self, host: int) -> bool:
        """Another host holds the board: requests of this one are not looked at."""
        return self.mode in _HELD_MODES and host != self.holder

    def request(self, wanted: Mode, host: int, t_s: float) -> Answer:
        """Go to a mode, if the table lets this host."""
        if self.held_against(host):
            return Result.HELD, 0
        if wanted not in _REQUESTABLE or host == NOBODY:
            return Result.BAD_VALUE, 0
        if wanted is not self.mode:
            if wanted not in _TRANSITIONS[self.mode]:
                return Result.FORBIDDEN, 0
            if wanted in _HELD_MODES and self.broken is not Fault.NONE:
                return Result.FAULTY, self.broken
            self._enter(wanted, host, t_s)
        return Result.OK, 0

    def clear(self, number: int, host: int, t_s: float) -> Answer:
        """Leave ``stopped`` or ``fault``, if this is the latch that is meant: a late request undoes no newer stop."""
        if self.held_against(host):
            return Result.HELD, 0
        if host == NOBODY:
            return Result.BAD_VALUE, 0
        if number != self.latch:
            return Result.FORBIDDEN, 0
        if self.mode in (Mode.STOPPED, Mode.FAULT):
            self.fault = Fault.NONE
            self._enter(Mode.DISARMED, host, t_s)
        return Result.OK, 0

    def _enter(self, mode: Mode, host: int, t_s: float) -> None:
        if mode is Mode.DISARMED:
            self.holder = NOBODY
        elif self.mode is Mode.DISARMED:
            self.holder = host
        self.mode = mode
        self.powered = mode in _HELD_MODES
        self._fed_s = t_s

    def emergency_stop(self, t_s: float) -> None:
        """From anyone, in any mode; each one is a latch of its own."""
        self.latch = (self.latch + 1) % LATCHES
        if self.mode is not Mode.STOPPED:
            self.fault_since_s = t_s
        self.mode = Mode.STOPPED
        self.fault = Fault.EMERGENCY_STOP
        self.powered = False

    def fail(self, fault: Fault, t_s: float) -> None:
        """A fault of watchdog or hardware, of a board that is armed or holding: only that has something to freeze."""
        self.mode = Mode.FAULT
        self.fault = fault
        self.fault_since_s = t_s
        self.latch = (self.latch + 1) % LATCHES

    def executed(self, t_s: float) -> None:
        """A set-point has been executed: the watchdog of an armed board is fed."""
        if self.mode is Mode.ARMED:
            self._fed_s = t_s

    def heartbeat(self, host: int, t_s: float) -> None:
        """A host's heartbeat: the holder's keeps a holding board from its fault, and does nothing else."""
        if self.mode is Mode.HOLDING and host == self.holder:
            self._fed_s = t_s
