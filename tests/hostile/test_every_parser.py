"""Hostile input to every parser: nothing but the documented error, nothing written, nothing executed."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from damage import damaged
from hypothesis import HealthCheck, given, settings
from parsers import DOCUMENTED, PARSERS, folder
from seeds import seeds
from watch import watching

from firmware_protocol.dbc import read_dbc
from firmware_protocol.frame import ProtocolError
from snakebot.errors import BadInputError, SnakebotError
from snakebot.robot import load_robot

SLOW = (
    "parquet",
    "session",
    "session_run",
    "log",
    "log_part",
    "log_records",
    "log_index",
    "robot",
    "dbc",
    "lerobot_info",
    "lerobot_data",
    "bag_mcap",
    "bag_sqlite",
)


def attempt(kind: str, data: bytes) -> str:
    """What a parser says of it: nothing, or one line that a terminal may be given."""
    try:
        with watching(folder()):
            PARSERS[kind](data)
    except SnakebotError as error:
        line = str(error)
        assert not any(ord(sign) < 32 or 127 <= ord(sign) < 160 for sign in line), repr(line)
        return line
    except ProtocolError as error:
        return str(error)
    return ""


def warmed(kind: str) -> None:
    """Have everything imported that the parser needs: an import executes text."""
    for data in (*seeds(kind), b""):
        with contextlib.suppress(*DOCUMENTED):
            PARSERS[kind](data)


@pytest.mark.parametrize("kind", list(PARSERS))
def test_nothing_but_the_documented_error(kind: str) -> None:
    warmed(kind)

    @settings(
        max_examples=15 if kind in SLOW else 60,
        deadline=None,
        suppress_health_check=list(HealthCheck),
        database=None,
    )
    @given(damaged(kind))
    def parse(data: bytes) -> None:
        attempt(kind, data)

    parse()


@pytest.mark.parametrize("kind", list(PARSERS))
def test_sound_seeds_are_read(kind: str) -> None:
    """Otherwise the fuzzing would only see the first check."""
    warmed(kind)
    for data in seeds(kind):
        said = attempt(kind, data)
        if kind == "dbc":
            assert said.startswith("the DBC defines no message "), (
                "a part of the catalogue is read, and is a part"
            )
        elif kind != "name":  # one text is no robot, gait and effect at once
            assert said == ""


ENTRIES = b"[snakebot.effects]\n"
FOUND_BY_FUZZING = {
    "robot": [
        b"joints: !!int ''", b"joints: !!bool x", b"joints: !!timestamp x", b"joints: !!float ''",
        b"joints: !!null [1]",
        b"joints: " + b"1:" * 200 + b"1.0", b"joints: 2026-99-99", b"? {a: 1}\n: 2", b'name: "\\ud800"\njoints: 1',
    ],
    "session": [
        b"robot: {joints: 1}\nruns: [{file: run_01.csv, forward_speed_m_s: " + b"1" * 40 + b"}]",
        b"robot: {joints: 1}\nruns: [{file: run_01.csv, gait: {omega_rad_s: -" + b"1" * 40 + b"}}]",
        b"robot: {joints: 1}\nruns: [{file: run_01.csv, forward_speed_m_s: " + b"1" * 9999 + b"}]",
        b"robot: {joints: 1}\nruns: [{file: " + b"a" * 300 + b".csv}]",
    ],
    "plug_in": [
        ENTRIES + b"no equals sign\n", b"[console_scripts]\nnor here\n", ENTRIES + b"x = ../../y:z\n",
        ENTRIES + b"\xff = a:b\n", ENTRIES + b"$(touch x) = a:b\n", ENTRIES + b"x = a:b [\xc2\x85]",
        ENTRIES + b"x = os;system:b\n", ENTRIES + b"x =\n", ENTRIES + b"= a:b\n",
    ],
    "dbc": [
        b"BO_ 1 A: 9 H\n", b"BO_ 1 A // aside\n: 99 H\n", b'BO_ 1 A: 1 H\n SG_ a : 0|99999@1+ (1,0) [0|1] "" H\n',
        b'BO_ 1 A: 1 H\n SG_ a : 0|8@1+ (1E99999999,0) [0|1] "" H\n', b"BO_ 1 A: 1 H\nBO_ 1 B: 1 H\n",
        b"BO_ 2F : 88A", b"BO_2F:88A", b"BO_ 2\tF\n:\n88A",
        b'BO_ 1 A: 1 H\n SG_ a : 0|8@1+ (0,0) [0|1] "" H\n', b'BO_ 1 A: 1 H\n SG_ a : 0|8@0+ (1,0) [0|1] "" H\n',
    ],
    "port": [b"serial:spy:///dev/ttyUSB0?file=/tmp/x", b"SPY://x?all&file=y", b"serial:/dev/x?baud=\xd9\xa1"],
    "fault": [b"free:" + b"9" * 5000, b"free:3@" + b"9" * 400, b"rigid:1=" + b"9" * 5000],
    "name": [b"a" * 5000, b"penn_state\0", b"../../etc/passwd", b"/etc/passwd", b"\xff", b"", b".", b"robots/../../x"],
}  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "data"), [(kind, data) for kind, found in FOUND_BY_FUZZING.items() for data in found]
)
def test_what_was_found_stays_refused(kind: str, data: bytes) -> None:
    warmed(kind)
    said = attempt(kind, data)
    assert said or kind == "plug_in"
    assert len(said) < 2100


@pytest.mark.parametrize(
    ("kind", "data"),
    [
        ("robot", b"schema: snakebot.robot/1\njoints: 1\nname: a\nservo: {gain_found_out: }\n"),
        ("log_index", b"\x09" + bytes(9) + b":" + bytes(3)),  # the footer as the length of an attachment
        ("log_index", b"\x09;" + bytes(31) + b"\xbc" * 35),  # so in the data, which is gone through instead
    ],
)
def test_what_was_found_is_read(kind: str, data: bytes) -> None:
    warmed(kind)
    assert attempt(kind, data) == ""


@pytest.mark.parametrize(
    ("text", "length"), [("BO_ 1 A: 999999999 H\n", 9), ('BO_ 1 A // "\n : 999999999 H // "\n', 9)]
)
def test_a_dbc_is_looked_through_before_it_is_built(text: str, length: int) -> None:
    with pytest.raises(ProtocolError, match=f"message of 9{{{length}}} bytes"):
        read_dbc(text)


@pytest.mark.parametrize("kind", ["robot", "gait", "effect_set", "motions", "session"])
def test_yaml_executes_nothing_and_does_not_blow_up(kind: str, tmp_path: Path) -> None:
    proof = tmp_path / "executed"
    laughs = "a0: &a0 [x]\n" + "".join(
        f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, 12)
    )
    hostile = [
        f"!!python/object/apply:os.system ['touch {proof}']",
        f"joints: !!python/object/new:os.mkdir ['{proof}']",
        f"!!python/module:os\n? {proof}",
        f"!!python/name:os.system\n? {proof}",
        laughs,
        "[" * 5000,
        "{a: " * 3000,
        "[" + "1," * 300_000 + "]",
        "x: &a [*a]",
        "joints: 2026-99-99",
    ]
    warmed(kind)
    for text in hostile:
        assert attempt(kind, text.encode())
    assert not proof.exists()


@pytest.mark.parametrize(
    "name", ["../../etc/passwd", "/etc/passwd", "robots/../../x", "penn_state\0", "a" * 5000, ""]
)
def test_names_lead_nowhere(name: str) -> None:
    with pytest.raises(BadInputError):
        load_robot(name)


def test_an_error_is_one_line_that_a_terminal_may_be_given() -> None:
    said = str(BadInputError("x\x1b[2J\r\nrobot \u202e\udcff\x9b\tend"))
    assert said == r"x\x1b[2J robot \u202e\udcff\x9b\tend"


def test_the_watch_sees_what_it_is_there_for(tmp_path: Path) -> None:
    def trespasses() -> Iterator[Callable[[], object]]:
        yield lambda: (tmp_path / "out").write_text("x")
        yield lambda: (tmp_path / "made").mkdir()
        yield lambda: __import__("os").system("true")
        yield lambda: __import__("subprocess").run(["true"], check=True)
        yield lambda: eval("1 + 1")

    (tmp_path / "own").mkdir()
    for trespass in trespasses():
        with pytest.raises(AssertionError, match="trespass"), watching(tmp_path / "own"):
            trespass()
    with watching(tmp_path / "own"):
        (tmp_path / "own" / "allowed").write_text("x")


def test_parsers_write_nothing() -> None:
    """Beside the files that the targets lay out themselves there is nothing after all this."""
    for kind, parser in PARSERS.items():
        for data in seeds(kind):
            try:
                parser(data)
            except DOCUMENTED:
                continue
    names = {str(path.relative_to(folder())) for path in folder().rglob("*")}
    assert names <= {
        "robot.yaml", "gait.yaml", "effects.yaml", "run.csv", "run.csv.gz", "run.parquet", "run.mcap", "run.mcap.part",
        "records.mcap.part", "indexed.mcap", "session", "session/session.yaml", "session/run_01.csv",
        "motions.yaml", "foreign.txt", "bag.mcap", "bag.db3", "dataset", "dataset/meta", "dataset/meta/info.json",
        "dataset/data", "dataset/data/chunk-000", "dataset/data/chunk-000/file-000.parquet",
    }  # fmt: skip
