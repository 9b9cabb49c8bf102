"""The servos' side of a bus: instruction packets in, answers out, and what a bad line makes of both.

No wire and no clock of its own: bytes and times are handed in. Two servos of one id answer at the same time; on the
wire a zero of either wins.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import zip_longest

from snakebot.servobus import dynamixel, feetech
from snakebot.servobus.emulated.chain import ServoChain
from snakebot.servobus.emulated.servo import EmulatedServo
from snakebot.servobus.packets import BROADCAST, Dialect, Packet

ServoWire = Callable[[Sequence[bytes]], bytes]
_OFTEN_S = 0.0005  # the snake is not looked at more often
_GAP_S = 0.002  # a pause within a packet after which a servo forgets its beginning


def _clean(packets: Sequence[bytes]) -> bytes:
    return b"".join(packets)


class EmulatedBus:
    """Servos of one family on one wire.

    Args:
        servos: in any order; only those that listen at ``baud`` hear anything.
        chain: what they move; without one they stand still.
        to_host: what the wire makes of the answers of one instruction.
        to_servos: what the wire makes of the bytes that a host writes.
    """

    def __init__(
        self,
        servos: Sequence[EmulatedServo],
        chain: ServoChain | None = None,
        *,
        to_host: ServoWire = _clean,
        to_servos: ServoWire = _clean,
    ) -> None:
        families = {servo.model.family for servo in servos}
        assert len(families) == 1, families
        self.servos = list(servos)
        self.chain = chain
        self.to_host = to_host
        self.to_servos = to_servos
        self.dialect: Dialect = feetech.Feetech() if "feetech" in families else dynamixel.Dynamixel()
        self.instructions = 0  # that were heard
        self._decoder = self.dialect.instructions()
        self._lived_s = float("-inf")
        self._heard_s = float("-inf")

    def pause(self) -> None:
        """The line is quiet for so long that the servos forget half a packet."""
        self._decoder.reset()

    def advance(self, t_s: float) -> None:
        """Let servos and snake go on until ``t_s``, in seconds since the chain began."""
        if self.chain is not None:
            self.chain.advance(t_s)
        else:
            for servo in self.servos:
                servo.live(t_s)
        self._lived_s = t_s

    def feed(self, data: bytes, t_s: float, baud: int | None = None) -> bytes:
        """What the servos answer to these bytes of a host, which writes at ``baud``."""
        if t_s > self._lived_s + _OFTEN_S:
            self.advance(t_s)
        if t_s > self._heard_s + _GAP_S:
            self.pause()
        self._heard_s = t_s
        said = b""
        for packet in self._decoder.feed(self.to_servos([data])):
            listening = [s for s in self.servos if s.powered and (baud is None or s.baud == baud)]
            self.instructions += 1
            for servo in listening:
                servo.fed(t_s)
            answers = self._obey(packet, listening)
            if answers:
                said += self.to_host(answers)
        if self.chain is not None:
            self.chain.advance(t_s)  # takes what was written; no time passes
        return said

    def _obey(self, packet: Packet, listening: Sequence[EmulatedServo]) -> list[bytes]:
        meant = [servo for servo in listening if packet.id in (servo.id, BROADCAST)]
        try:
            match packet.code:
                case feetech.PING:
                    return self._together(
                        [(s.id, s.error, self._who(s)) for s in sorted(meant, key=lambda s: s.id)]
                    )
                case feetech.READ if packet.id != BROADCAST:
                    return self._read(packet, meant)
                case feetech.WRITE:
                    return self._write(packet, meant)
                case feetech.SYNC_WRITE:
                    return self._sync_write(packet, listening)
                case feetech.SYNC_READ:
                    return self._sync_read(packet, listening)
                case dynamixel.FAST_SYNC_READ if isinstance(self.dialect, dynamixel.Dynamixel):
                    return self._fast_sync_read(packet, listening)
                case dynamixel.REBOOT if isinstance(self.dialect, dynamixel.Dynamixel):
                    for servo in meant:
                        servo.power_cycle()
                    return self._together([(s.id, 0, b"") for s in meant])
        except IndexError:
            return []  # shorter than its instruction needs: a real servo is silent too
        return []

    def _who(self, servo: EmulatedServo) -> bytes:
        if isinstance(self.dialect, feetech.Feetech):
            return b""
        return servo.read(0, 2) + servo.read(servo.model["firmware"].address, 1)

    def _span(self, parameters: bytes) -> tuple[int, int, bytes]:
        """Address, length, and the rest."""
        if isinstance(self.dialect, feetech.Feetech):
            return parameters[0], parameters[1], parameters[2:]
        if len(parameters) < 4:
            raise IndexError
        first, second = parameters[:2], parameters[2:4]
        return int.from_bytes(first, "little"), int.from_bytes(second, "little"), parameters[4:]

    def _read(self, packet: Packet, meant: Sequence[EmulatedServo]) -> list[bytes]:
        address, length, _ = self._span(packet.parameters)
        return self._together([(s.id, s.error, s.read(address, length)) for s in meant])

    def _write(self, packet: Packet, meant: Sequence[EmulatedServo]) -> list[bytes]:
        wide = not isinstance(self.dialect, feetech.Feetech)
        address = int.from_bytes(packet.parameters[: 1 + wide], "little")
        data = packet.parameters[1 + wide :]
        answers = [(servo.id, servo.write(address, data), b"") for servo in meant]
        return self._together(answers) if packet.id != BROADCAST else []

    def _sync_write(self, packet: Packet, listening: Sequence[EmulatedServo]) -> list[bytes]:
        address, length, rest = self._span(packet.parameters)
        for at in range(0, len(rest) - length, length + 1):
            for servo in listening:
                if servo.id == rest[at]:
                    servo.write(address, rest[at + 1 : at + 1 + length])
        return []

    def _sync_read(self, packet: Packet, listening: Sequence[EmulatedServo]) -> list[bytes]:
        if not all(servo.model.sync_read for servo in listening):
            return []
        address, length, wanted = self._span(packet.parameters)
        answers = [
            (s.id, s.error, s.read(address, length)) for number in wanted for s in listening if s.id == number
        ]
        return self._together(answers)

    def _fast_sync_read(self, packet: Packet, listening: Sequence[EmulatedServo]) -> list[bytes]:
        address, length, wanted = self._span(packet.parameters)
        pieces = []
        for number in wanted:
            servo = next((s for s in listening if s.id == number), None)
            if servo is None:
                return []  # who comes behind it waits for its piece, and the packet never ends
            pieces.append((servo.id, servo.error, servo.read(address, length)))
        return [dynamixel.fast_answer(pieces)]

    def _together(self, answers: Sequence[tuple[int, int, bytes]]) -> list[bytes]:
        """The answers one after the other; those of one id on top of each other."""
        said: dict[int, bytes] = {}
        for servo, error, data in answers:
            raw = self.dialect.answer(servo, error, data)
            before = said.get(servo)
            said[servo] = (
                raw if before is None else bytes(a & b for a, b in zip_longest(before, raw, fillvalue=0xFF))
            )
        return list(said.values())
