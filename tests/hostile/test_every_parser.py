"""Hostile input to every parser: nothing but the documented error, nothing written, nothing executed."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from parsers import DOCUMENTED, PARSERS, folder, seeds

from snakebot.errors import BadInputError
from snakebot.robot import load_robot


@st.composite
def damaged(draw: st.DrawFn, kind: str) -> bytes:
    """Sound input with parts overwritten, cut out, doubled or put in; or anything at all."""
    if draw(st.integers(0, 9)) == 0:
        return draw(st.binary(max_size=200))
    data = bytearray(draw(st.sampled_from(seeds()[kind])))
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
            data[at:at] = draw(
                st.sampled_from(
                    [b"1e999", b"nan", b"-inf", b"&a [*a]", b"!!python/object/apply:os.system ['x']", b"\xff\xfe",
                     b"2026-99-99", b"{", b"[" * 200, b": ", b"\0", b"99999999999999999999", b"../../etc/passwd",
                     b"? [1]", b"0x", b"~", b"1_0:99", b'"', b"\r", b"\xed\xa0\x80", "\u2028\u0661".encode()]
                )
            )  # fmt: skip
        elif at < len(data):
            data[at] ^= 1 << draw(st.integers(0, 7))
    return bytes(data)


@pytest.mark.parametrize("kind", list(PARSERS))
def test_nothing_but_the_documented_error(kind: str) -> None:
    heavy = kind in ("log", "log_part", "session", "robot", "csv_gz", "parquet", "csv")

    @settings(
        max_examples=15 if heavy else 60,
        deadline=None,
        suppress_health_check=list(HealthCheck),
        database=None,
    )
    @given(damaged(kind))
    def parse(data: bytes) -> None:
        try:
            PARSERS[kind](data)
        except DOCUMENTED as error:
            lines.append(len(str(error).splitlines()))

    lines: list[int] = []
    parse()
    assert max(lines, default=1) <= 1, "an error is one line"


@pytest.mark.parametrize("kind", list(PARSERS))
def test_sound_seeds_are_read(kind: str) -> None:
    """Otherwise the fuzzing would only see the first check."""
    good = 0
    for data in seeds()[kind]:
        try:
            PARSERS[kind](data)
            good += 1
        except DOCUMENTED as error:
            print(kind, error)
    assert good or kind in ("parquet", "fault", "session", "log_part", "column_map")


@pytest.mark.parametrize("kind", ["robot", "gait", "effect_set", "session"])
def test_yaml_executes_nothing_and_does_not_blow_up(kind: str, tmp_path: Path) -> None:
    proof = tmp_path / "executed"
    laughs = "a0: &a0 [x]\n" + "".join(
        f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, 12)
    )
    hostile = [
        f"!!python/object/apply:os.system ['touch {proof}']",
        f"joints: !!python/object/new:os.mkdir ['{proof}']",
        f"!!python/module:os\n? {proof}",
        laughs,
        "[" * 5000,
        "{a: " * 3000,
        "x: &a [*a]",
        "joints: 2026-99-99",
    ]
    for text in hostile:
        with pytest.raises(BadInputError):
            PARSERS[kind](text.encode())
    assert not proof.exists()


@pytest.mark.parametrize(
    "name", ["../../etc/passwd", "/etc/passwd", "robots/../../x", "penn_state\0", "a" * 5000, ""]
)
def test_names_lead_nowhere(name: str) -> None:
    with pytest.raises(BadInputError):
        load_robot(name)


def test_parsers_write_nothing() -> None:
    """Beside the files that the targets lay out themselves there is nothing after all this."""
    for kind, parser in PARSERS.items():
        for data in seeds()[kind]:
            try:
                parser(data)
            except DOCUMENTED:
                continue
    names = {str(path.relative_to(folder())) for path in folder().rglob("*")}
    ours = {
        "robot.yaml",
        "gait.yaml",
        "effects.yaml",
        "run.csv",
        "run.csv.gz",
        "run.parquet",
        "run.mcap",
        "seed.mcap",
    }
    assert names <= ours | {"run.mcap.part", "session", "session/session.yaml", "session/run_01.csv"}
    assert os.path.isdir(folder())
