"""Damaged input, as hypothesis draws it: a sound seed with parts overwritten, cut out, doubled or put in."""

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


@st.composite
def damaged(draw: st.DrawFn, kind: str) -> bytes:
    """One time in ten, anything at all."""
    if draw(st.integers(0, 9)) == 0:
        return draw(st.binary(max_size=200))
    data = bytearray(draw(st.sampled_from(seeds(kind))))
    for _ in range(draw(st.integers(0, 6))):
        at = draw(st.integers(0, len(data)))
        end = min(len(data), at + draw(st.integers(0, 20)))
        what = draw(st.integers(0, 4))
        if what == 0:
            data[at:end] = draw(st.binary(max_size=20))
        elif what == 1:
            del data[at:end]
        elif what == 2:
            data[at:at] = data[at:end]
        elif what == 3:
            data[at:at] = draw(st.sampled_from(NASTY))
        elif at < len(data):
            data[at] ^= 1 << draw(st.integers(0, 7))
    return bytes(data)
