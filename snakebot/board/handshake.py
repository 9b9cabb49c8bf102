"""First words with a board: who it is, and whether the two ends speak the same catalogue."""

from __future__ import annotations

from firmware_protocol.catalogue import (
    PROTOCOL_MAJOR,
    PROTOCOL_MINOR,
    InfoFirmware,
    InfoProtocol,
    InfoSerial,
    catalogue_hash,
)
from firmware_protocol.checks import out_of_range
from snakebot.board.readings import BoardInfo
from snakebot.errors import NoBoardError
from snakebot.links.base import LinkStatistics


class Handshake:
    """What a board says of itself, piece by piece. Nothing is sent from here."""

    def __init__(self, where: str) -> None:
        self._where = where
        self._protocol: InfoProtocol | None = None
        self._firmware: InfoFirmware | None = None
        self._serial: InfoSerial | None = None

    def take(self, info: InfoProtocol | InfoFirmware | InfoSerial) -> None:
        """Take in one of the three answers to an InfoRequest.

        Raises:
            NoBoardError: two boards answer.
        """
        match info:
            case InfoProtocol():
                self._protocol = info
            case InfoFirmware():
                before = info if self._firmware is None else self._firmware
                if before.boot_id != info.boot_id:
                    raise self._two(f"boot ids {before.boot_id:04x} and {info.boot_id:04x}")
                self._firmware = info
            case InfoSerial():
                if self._serial is not None and self._serial != info:
                    raise self._two(f"serial numbers {self._serial.serial_number} and {info.serial_number}")
                self._serial = info

    def _two(self, which: str) -> NoBoardError:
        return NoBoardError(
            f"{self._where}: two boards answer on this line ({which}), or one that was reset just now: "
            "leave one board on it, then start again"
        )

    def board(self) -> BoardInfo | None:
        """The board, once it has said everything.

        Raises:
            NoBoardError: the two ends do not speak the same catalogue (both are named), or what the board says of
                itself cannot be.
        """
        protocol, firmware, serial = self._protocol, self._firmware, self._serial
        if protocol is None or firmware is None or serial is None:
            return None
        self._agree(protocol)
        for said in (protocol, firmware):
            wrong = out_of_range(said)
            if wrong is not None:
                raise NoBoardError(f"{self._where}: the board says of itself what cannot be: {wrong}")
        return BoardInfo(
            protocol=f"{protocol.protocol_major}.{protocol.protocol_minor}",
            catalogue_hash=protocol.catalogue_hash,
            firmware=f"{firmware.firmware_major}.{firmware.firmware_minor}.{firmware.firmware_patch}",
            serial_number=serial.serial_number,
            joints=protocol.joints,
            counts_per_rev=firmware.counts_per_rev,
            watchdog_ms=firmware.watchdog_ms,
            simulated=bool(protocol.simulated),
            boot_id=firmware.boot_id,
        )

    def _agree(self, board: InfoProtocol) -> None:
        ours = f"protocol {PROTOCOL_MAJOR}.{PROTOCOL_MINOR}, catalogue {catalogue_hash():08x}"
        theirs = (
            f"protocol {board.protocol_major}.{board.protocol_minor}, catalogue {board.catalogue_hash:08x}"
        )
        if board.protocol_major != PROTOCOL_MAJOR or board.catalogue_hash != catalogue_hash():
            raise NoBoardError(
                f"{self._where}: host and board do not agree: host {ours}; board {theirs}: "
                "update the one that is older"
            )

    def nobody(self, timeout_s: float, heard: LinkStatistics, unreadable: int) -> NoBoardError:
        """What to raise when nobody has answered: what was heard instead tells where to look.

        Args:
            unreadable: frames that were no message of the catalogue.
        """
        hint = "is the board on, and is this the right port?"
        if heard.corrupt:
            hint = f"{heard.corrupt} corrupt packets came in: is the baud rate right on both ends?"
        elif unreadable:
            hint = f"{unreadable} frames came in that this catalogue does not know: is this a snakebot board?"
        return NoBoardError(f"{self._where}: no board answered within {timeout_s:g} s: {hint}")
