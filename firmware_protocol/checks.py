"""What the DBC says beside the layout: who sends a message, and which values it may hold."""

from __future__ import annotations

from functools import cache

from firmware_protocol.catalogue import MESSAGES, Message, database


@cache
def said_by_boards() -> frozenset[type[Message]]:
    """The messages that a board sends; all others are hosts'."""
    there = {message.name: message for message in database().messages}
    return frozenset(cls for name, cls in MESSAGES.items() if there[name].senders == ["Board"])


def out_of_range(message: Message) -> str | None:
    """The first value that is outside the range which the DBC gives its signal; None where there is none.

    A frame can carry such values, and ``decode`` lets them through: a board answers them.
    """
    for signal in database().get_message_by_name(type(message).__name__).signals:
        value = getattr(message, signal.name)
        assert signal.minimum is not None  # the DBC gives each signal its range
        assert signal.maximum is not None
        slack = 0 if signal.scale == 1 else signal.scale / 2
        if not signal.minimum - slack <= value <= signal.maximum + slack:
            return f"{signal.name} {value:g}, outside {signal.minimum:g} to {signal.maximum:g}"
    return None
