"""A servo model is one table: where each register is, how its bytes are read, what one count of it is in SI units."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from snakebot.errors import BadInputError

Family = Literal["feetech", "dynamixel"]


@dataclass(frozen=True, slots=True)
class Register:
    """One register of a servo.

    Attributes:
        address: of its first byte.
        size: bytes, 1, 2 or 4.
        sign_bit: the bit that means minus (Feetech's sign and magnitude); None: there is none.
        signed: two's complement.
        unit: what one count is, in the SI unit of the quantity (rad, rad/s, rad/s2, A, V, K, s, or a share of 1).
        stored: kept without power (EEPROM), and writable only without torque.
        end: the first address behind it.
    """

    address: int
    size: int
    unit: float = 1.0
    sign_bit: int | None = None
    signed: bool = False
    stored: bool = False
    end: int = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "end", self.address + self.size)


@dataclass(frozen=True, slots=True)
class ServoModel:
    """Everything that is known of one kind of servo.

    Attributes:
        numbers: what it calls itself in the register ``model_number``.
        counts_per_rev: of a whole turn; the position register may cover less.
        lowest, highest: position in counts that a goal may have in position mode.
        baud: code of the baud rate register -> bit/s.
        position_modes: value of ``operating_mode`` -> name, of the modes in which a goal position is followed.
        multi_turn_modes: those of them in which the position counts on beyond a turn.
        errors: bit of the hardware error register -> what it means.
        big_endian: high byte first (Feetech SCS).
        sync_read: it understands one question to several servos.
        watchdog_firmware: lowest firmware whose bus watchdog works; None: it has none.
        stall_torque_nm: data sheet: torque at a standstill, at the highest usual supply; what emulated servos have.
        stall_current_a: data sheet, at the same supply; turns a load in percent into a current where none is measured.
        by_itself: what it does without being told, in words, for people.
    """

    name: str
    family: Family
    numbers: tuple[int, ...]
    registers: Mapping[str, Register]
    counts_per_rev: float
    lowest: int
    highest: int
    baud: Mapping[int, int]
    position_modes: Mapping[int, str]
    errors: Mapping[int, str]
    big_endian: bool = False
    sync_read: bool = True
    watchdog_firmware: int | None = None
    stall_torque_nm: float = 1.0
    stall_current_a: float = 1.0
    by_itself: tuple[str, ...] = ()
    multi_turn_modes: frozenset[int] = field(default_factory=frozenset)

    @property
    def rad_per_count(self) -> float:
        return 2 * math.pi / self.counts_per_rev

    def __getitem__(self, name: str) -> Register:
        return self.registers[name]

    def __contains__(self, name: object) -> bool:
        return name in self.registers

    def pack(self, name: str, value: int) -> bytes:
        """A register's value as its bytes.

        Raises:
            BadInputError: it does not fit.
        """
        register = self.registers[name]
        raw = value
        if register.sign_bit is not None:
            raw = abs(value)
            if raw >= 1 << register.sign_bit:
                raise BadInputError(f"{self.name}: {name} cannot be {value}")
            raw |= (value < 0) << register.sign_bit
        try:
            return raw.to_bytes(register.size, "big" if self.big_endian else "little", signed=register.signed)
        except OverflowError:
            raise BadInputError(f"{self.name}: {name} cannot be {value}") from None

    def unpack(self, name: str, data: bytes | bytearray) -> int:
        """The value of a register out of its bytes."""
        register = self.registers[name]
        raw = int.from_bytes(data, "big" if self.big_endian else "little", signed=register.signed)
        if register.sign_bit is not None:
            magnitude = raw & ((1 << register.sign_bit) - 1)
            return -magnitude if raw >> register.sign_bit & 1 else magnitude
        return raw

    def part(self, name: str, start: int, block: bytes) -> int:
        """The value of a register out of a block of memory that begins at address ``start``."""
        register = self.registers[name]
        return self.unpack(name, block[register.address - start : register.end - start])

    def si(self, name: str, counts: int) -> float:
        """Counts of a register in SI units."""
        return counts * self.registers[name].unit

    def baud_code(self, baud: int) -> int:
        """What the baud rate register holds at this bit rate.

        Raises:
            BadInputError: this servo does not know it.
        """
        for code, rate in self.baud.items():
            if rate == baud:
                return code
        raise BadInputError(
            f"{self.name}: no {baud} baud; it knows {', '.join(map(str, self.baud.values()))}"
        )
