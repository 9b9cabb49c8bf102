"""Requests and what they are answered: each check of PROTOCOL.md, in its order (held, joint, value, mode)."""

from __future__ import annotations

from firmware_protocol.assembly import ANGLE_STEP_RAD
from firmware_protocol.catalogue import (
    MAX_TRIM_RAD,
    NOBODY,
    Acknowledge,
    ClearRequest,
    JointLimits,
    JointMode,
    JointModeRequest,
    LimitKind,
    LimitRequest,
    Message,
    Mode,
    ModeRequest,
    Result,
    TrimRequest,
    ZeroRequest,
    frame_id,
)
from snakebot.softboard.modes import Answer, ModeMachine
from snakebot.softboard.register import SetpointRegister

_MOST_LIMIT = 262.142  # what 17 bits carry
_HALF_LIMIT_STEP = 0.001  # half the wire's resolution of a limit: rounding must not make a limit forbidden


class Configuration:
    """What hosts may set: joint modes and limits (in the register), trims and encoder zeros (in place)."""

    def __init__(
        self,
        machine: ModeMachine,
        register: SetpointRegister,
        trim_rad: list[float],
        zero_counts: list[int],
    ) -> None:
        self._machine = machine
        self._register = register
        self._trim_rad = trim_rad
        self._zero_counts = zero_counts

    def mode(self, request: ModeRequest, t_s: float) -> Acknowledge:
        """Change the board's mode, and say how that went."""
        return self._acknowledge(request, self._machine.request(request.mode, request.host, t_s))

    def clear(self, request: ClearRequest, t_s: float) -> Acknowledge:
        """Leave a latch, and say how that went."""
        return self._acknowledge(request, self._machine.clear(request.number, request.host, t_s))

    def limits(self) -> list[JointLimits]:
        """The limits in force, joint by joint, as far as the wire can say them."""
        return [
            JointLimits(
                index + 1, *(min(self._register.limit(index, kind), _MOST_LIMIT) for kind in LimitKind)
            )
            for index in range(self._register.joints)
        ]

    def take(self, request: Message) -> Acknowledge:
        """Execute any other request, and say how that went."""
        assert isinstance(request, JointModeRequest | LimitRequest | TrimRequest | ZeroRequest)
        if self._machine.held_against(request.host):
            return self._acknowledge(request, (Result.HELD, 0))
        if not 1 <= request.joint <= self._register.joints:
            return self._acknowledge(request, (Result.BAD_JOINT, self._register.joints))
        if request.host == NOBODY:
            return self._acknowledge(request, (Result.BAD_VALUE, 0))
        return self._acknowledge(request, (self._execute(request, request.joint - 1), 0))

    def _execute(
        self, request: JointModeRequest | LimitRequest | TrimRequest | ZeroRequest, index: int
    ) -> Result:
        match request:
            case JointModeRequest():
                return self._joint_mode(request, index)
            case LimitRequest():
                return self._limit(request, index)
            case TrimRequest():
                return self._trim(request, index)
            case ZeroRequest():
                return self._zero(request, index)

    def _joint_mode(self, request: JointModeRequest, index: int) -> Result:
        if request.mode is JointMode.RIGID and not self._register.may_go_to(index, request.angle_rad):
            return Result.BAD_VALUE
        if self._machine.mode in (Mode.STOPPED, Mode.FAULT):
            return Result.FORBIDDEN
        self._register.set_joint_mode(index, request.mode, request.angle_rad)
        return Result.OK

    def _limit(self, request: LimitRequest, index: int) -> Result:
        value, kind = request.value, request.kind
        if not 0 < value <= self._register.built_in(index, kind) + _HALF_LIMIT_STEP:
            return Result.BAD_VALUE
        if self._machine.mode in (Mode.STOPPED, Mode.FAULT):
            return Result.FORBIDDEN
        looser = value > self._register.limit(index, kind) + _HALF_LIMIT_STEP
        if looser and self._machine.mode is not Mode.DISARMED:
            return Result.FORBIDDEN
        self._register.set_limit(index, kind, value)
        return Result.OK

    def _trim(self, request: TrimRequest, index: int) -> Result:
        if abs(request.trim_rad) > MAX_TRIM_RAD + ANGLE_STEP_RAD / 2:
            return Result.BAD_VALUE
        if self._machine.mode is not Mode.DISARMED:
            return Result.FORBIDDEN
        self._trim_rad[index] = request.trim_rad
        return Result.OK

    def _zero(self, request: ZeroRequest, index: int) -> Result:
        if self._machine.mode is not Mode.DISARMED:
            return Result.FORBIDDEN
        self._zero_counts[index] = request.zero_counts
        return Result.OK

    def _acknowledge(
        self,
        request: ModeRequest | ClearRequest | JointModeRequest | LimitRequest | TrimRequest | ZeroRequest,
        answer: Answer,
    ) -> Acknowledge:
        result, detail = answer
        identifier = frame_id(type(request))
        return Acknowledge(request.token, result, self._machine.mode, identifier, int(detail), request.host)
