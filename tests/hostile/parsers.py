"""Every parser of what comes from outside, as one function of bytes. It may only raise what it documents.

Shared by the property tests and by tools/fuzz_parsers.py.
"""

from __future__ import annotations

import os
import tempfile
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

from firmware_protocol.catalogue import decode, encode
from firmware_protocol.frame import Frame, ProtocolError
from firmware_protocol.framing import StreamDecoder, pack_all, unpack
from snakebot.errors import SnakebotError

DOCUMENTED = (SnakebotError, ProtocolError)
MEMORY = os.environ.get("SNAKEBOT_FUZZ_FOLDER", tempfile.gettempdir())


@cache
def folder() -> Path:
    """A folder of our own; a parser may read what is put there and must write nothing."""
    return Path(tempfile.mkdtemp(prefix="snakebot-hostile-", dir=MEMORY))


def _file(name: str, data: bytes) -> Path:
    path = folder() / name
    path.write_bytes(data)
    return path


def _text(data: bytes) -> str:
    return data.decode("utf-8", "surrogateescape")


def port(data: bytes) -> None:
    from snakebot.links.port import parse_port

    parsed = parse_port(_text(data))
    assert parse_port(str(parsed)) == parsed


def stream(data: bytes) -> None:
    decoder = StreamDecoder()
    for frame in decoder.feed(data):
        assert StreamDecoder().feed(pack_all([frame])) == [frame]
    assert len(decoder._pending) <= 13


def packet(data: bytes) -> None:
    unpack(data)


def frame(data: bytes) -> None:
    message = decode(Frame(int.from_bytes(data[:2], "little") & 0x7FF, data[2:10]))
    again = decode(encode(message))
    assert again == message or np.nan in (again, message)


def slcan(data: bytes) -> None:
    from snakebot.links.slcan import SlcanDecoder

    decoder = SlcanDecoder()
    for heard in decoder.feed(data):
        assert 0 <= heard.id <= 0x7FF
        assert len(heard.data) <= 8


def robot(data: bytes) -> None:
    from snakebot.robot import load_robot

    load_robot(_file("robot.yaml", data))


def gait(data: bytes) -> None:
    from snakebot.gait.named import load_gait

    load_gait(_file("gait.yaml", data))


def effect_set(data: bytes) -> None:
    from snakebot.effects.spec import load_effect_set

    load_effect_set(_file("effects.yaml", data))


def effect(data: bytes) -> None:
    from snakebot.effects import parse_effect

    spec = parse_effect(_text(data))
    assert parse_effect(str(spec)) == spec


def fault(data: bytes) -> None:
    from snakebot.control import parse_fault

    parse_fault(_text(data), 5)


def column_map(data: bytes) -> None:
    from snakebot.robot import load_robot
    from snakebot.runlog.column_map import parse_map

    parse_map(_text(data).splitlines(), load_robot("penn_state"))


def csv(data: bytes) -> None:
    from snakebot.runlog.table import read_table

    read_table(_file("run.csv", data))


def csv_gz(data: bytes) -> None:
    from snakebot.runlog.table import read_table

    read_table(_file("run.csv.gz", data))


def parquet(data: bytes) -> None:
    from snakebot.runlog.table import read_table

    read_table(_file("run.parquet", data))


def session(data: bytes) -> None:
    from snakebot.runlog import open_session

    (folder() / "session").mkdir(exist_ok=True)
    _file("session/run_01.csv", b"t_s,cmd_1_rad,meas_1_rad\n0,0,0\n0.1,0,0\n")
    open_session(_file("session/session.yaml", data).parent)


def log(data: bytes) -> None:
    from snakebot.runlog import read_log

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        read_log(_file("run.mcap", data)).to_run()


def log_part(data: bytes) -> None:
    from snakebot.runlog import open_run

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        open_run(_file("run.mcap.part", data))


Parser = Callable[[bytes], None]
PARSERS: dict[str, Parser] = {
    parser.__name__: parser
    for parser in (
        port, stream, packet, frame, slcan, robot, gait, effect_set, effect, fault, column_map,
        csv, csv_gz, parquet, session, log, log_part,
    )
}  # fmt: skip


@cache
def seeds() -> dict[str, list[bytes]]:
    """Sound input of each kind, for mutation."""
    import gzip

    from snakebot.resources import config_path
    from snakebot.robot import load_robot
    from snakebot.runlog import RunWriter, Tick

    root = Path(str(config_path("robots", "penn_state"))).parents[1]
    zero = np.zeros(5)
    with RunWriter(folder() / "seed.mcap", load_robot("penn_state"), start_time_ns=10**18) as writer:
        for count in range(6):
            writer.tick(
                Tick(
                    sequence=count, t_s=count / 100, host_time_ns=10**18 + count, setpoint_rad=zero, sent_rad=zero,
                    applied_rad=zero, measured_rad=zero, board_time_us=count, latency_s=0.001, late=False,
                )
            )  # fmt: skip
    recorded = writer.path.read_bytes()
    robots = [path.read_bytes() for path in sorted(root.glob("robots/*.yaml"))]
    sets = [path.read_bytes() for path in sorted(root.glob("effects/*.yaml"))]
    gaits = [path.read_bytes() for path in sorted(root.glob("gaits/*.yaml"))]
    table = b"t_s,cmd_1_rad,meas_1_rad\n0,0.1,0.1\n0.01,0.2,nan\n0.02,,1e-3\n"
    described = b"runs:\n  - file: run_01.csv\n    gait: {alpha_deg: 66}\nrobot: penn_state\n"
    wire = pack_all([Frame(16, bytes(range(8))), Frame(1, b""), Frame(0x7FF, b"\0\0")])
    return {
        "port": [b"sim:", b"serial:/dev/ttyUSB0?baud=1000000", b"can:slcan//dev/ttyACM0?bitrate=1000000", b"COM4"],
        "stream": [wire],
        "packet": [part for part in wire.split(b"\0") if part],
        "frame": [b"\x10\0" + bytes(8), b"\x11\0" + bytes(8), b"\x01\0", b"\x40\0" + bytes(8)],
        "slcan": [b"t0108AABBCCDDEEFF0011\r", b"z\r\a", b"T0000001080\r"],
        "robot": robots,
        "gait": gaits or [b"alpha_deg: 66\nbeta_deg: 80\nomega_rad_s: 2\n"],
        "effect_set": [*sets, b'effects: ["command_delay:delay_s=0.05"]\n'],
        "effect": [b"rate_limit:limit_rad_s=1.6,joints=3+4", b"command_delay:delay_s=0.05", b"servo_lag"],
        "fault": [b"joint=2,mode=rigid,angle=10", b"joint=3,mode=free,at=4", b"2:rigid:10@3"],
        "column_map": [b"cmd_*_rad=servo_#:deg\nt_s=time:ms", b"meas_1_rad=-enc:counts"],
        "csv": [table],
        "csv_gz": [gzip.compress(table, mtime=0)],
        "parquet": [b"PAR1" + bytes(20) + b"PAR1"],
        "session": [described],
        "log": [recorded],
        "log_part": [recorded[: len(recorded) // 2]],
    }  # fmt: skip
