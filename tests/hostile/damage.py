"""Damaged input, as hypothesis draws it: a sound seed with parts overwritten, cut out, doubled or put in.

The damage is read off a tape of random bytes: one draw for a whole case, or for many (hypothesis takes as long to draw
as most parsers take to read). A tape of zeros does no damage, so what hypothesis shrinks to is close to sound.
"""

from __future__ import annotations

from hypothesis import strategies as st
from seeds import seeds

NASTY = [
    b"1e999", b"nan", b"-inf", b"&a [*a]", b"!!python/object/apply:os.system ['x']", b"\xff\xfe", b"2026-99-99", b"{",
    b"[" * 200, b": ", b"\0", b"99999999999999999999", b"../../etc/passwd", b"? [1]", b"0x", b"~", b"1_0:99", b'"',
    b"\r", b"\xed\xa0\x80", "\u2028\u0661".encode(), b"!!int ''", b"!!bool x", b"!!timestamp x", b"!!float 1:1",
    b"null", b"[]", b"\x1b[2J", b"<script>alert(1)</script>", b"$(touch x)", b"`touch x`", b"\n", b",", b"=", b"1e5",
    b"-0", b"\xe2\x80\xae", b"\x1e1{}", b"A" * 300,
]  # fmt: skip


TAPE_BYTES = 160  # six pieces of damage, of 20 bytes each, and what says where


class Tape:
    """Random bytes, read from front to back; zeros after its end."""

    def __init__(self, data: bytes) -> None:
        self.data, self.at = data, 0

    def bytes(self, count: int) -> bytes:
        part = self.data[self.at : self.at + count]
        self.at += count
        return part

    def below(self, bound: int) -> int:
        return int.from_bytes(self.bytes(2), "little") % bound


def damage(kind: str, tape_bytes: bytes) -> bytes:
    """The damaged input for a parser that this tape describes; one in ten is anything at all."""
    tape = Tape(tape_bytes)
    if tape.below(10) == 9:
        return tape.bytes(tape.below(TAPE_BYTES))
    sound = seeds(kind)
    data = bytearray(sound[tape.below(len(sound))])
    for _ in range(tape.below(7)):
        at = tape.below(len(data) + 1)
        end = min(len(data), at + tape.below(21))
        what = tape.below(5)
        if what == 0:
            data[at:end] = tape.bytes(tape.below(21))
        elif what == 1:
            del data[at:end]
        elif what == 2:
            data[at:at] = data[at:end]
        elif what == 3:
            data[at:at] = NASTY[tape.below(len(NASTY))]
        elif at < len(data):
            data[at] ^= 1 << tape.below(8)
    return bytes(data)


def damaged(kind: str) -> st.SearchStrategy[bytes]:
    """One damaged input."""
    return st.binary(min_size=TAPE_BYTES, max_size=TAPE_BYTES).map(lambda tape: damage(kind, tape))


def damaged_many(kind: str, count: int) -> st.SearchStrategy[list[bytes]]:
    """Several of them, each off its own part of one tape."""
    size = count * TAPE_BYTES
    return st.binary(min_size=size, max_size=size).map(
        lambda tape: [damage(kind, tape[at : at + TAPE_BYTES]) for at in range(0, size, TAPE_BYTES)]
    )
