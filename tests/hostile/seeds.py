"""Sound input for every parser in ``parsers.py``: what a fuzzer starts from."""

from __future__ import annotations

import gzip
import io
import struct
from collections.abc import Callable
from functools import cache

import numpy as np
from foreign_recordings import SOUND
from parsers import SEPARATOR, folder

from firmware_protocol.catalogue import dbc_text
from firmware_protocol.frame import Frame
from firmware_protocol.framing import pack_all
from snakebot.servobus.dynamixel import Dynamixel, fast_answer
from snakebot.servobus.feetech import Feetech
from snakebot.servobus.packets import Dialect

BENCH = b"joints: 1\nencoder_counts_per_rev: 4096\n"
TICK = (
    b'1{"t_s":%d,"sequence":1,"host_time_s":1,"setpoint_rad":[0.5],"sent_rad":[0.5],"applied_rad":[0.5],'
    b'"measured_rad":[0.4],"board_time_us":7,"latency_s":0.001,"late":false}'
)
POSE = b'2{"t_s":0.5,"heading_rad":0.1,"speed_m_s":null,"pose":{"position":{"x":0,"y":1,"z":0}}}'
EVENT = b'3{"t_s":0,"level":2,"kind":"armed","message":"go","data":{"by":[1]}}'
LINK = b'4{"t_s":0,"counters":{"sent":3}}'
FRAME = b'5{"t_s":0,"direction":"sent","id":16,"data":"00ff"}'
STEERED = (
    b'7{"t_s":0,"x_m":0,"y_m":0.1,"heading_rad":0.3,"wanted_heading_rad":0,"heading_error_rad":0.3,"cross_track_m":null,'
    b'"offset_rad":-0.1,"wanted_offset_rad":-0.2,"saturated":true,"stale":false}'
)
READINGS = b'6{"t_s":0,"supply_v":12.1,"current_1_a":0.2}'


@cache
def recorded() -> bytes:
    """A finished log of a few ticks, small enough to be damaged everywhere."""
    from snakebot.robot import robot_from_mapping
    from snakebot.runlog import Event, LinkRecord, PoseRecord, RunWriter, Telemetry, Tick

    one = np.zeros(1)
    with RunWriter(
        folder() / "seed.mcap", robot_from_mapping({"joints": 1}, "seed"), start_time_ns=10**18
    ) as writer:
        for count in range(4):
            writer.tick(
                Tick(
                    sequence=count, t_s=count / 100, host_time_ns=10**18 + count, setpoint_rad=one, sent_rad=one,
                    applied_rad=one, measured_rad=one, board_time_us=count, latency_s=0.001, late=False,
                )
            )  # fmt: skip
        writer.pose(PoseRecord(0.01, 0.1, 0.2, 0.3))
        writer.event(Event(0.01, "armed", "go"))
        writer.link_statistics(LinkRecord(0.01, {"sent": 3}))
        writer.telemetry(Telemetry(0.01, {"supply_v": 12.0}))
    data = writer.path.read_bytes()
    writer.path.unlink()
    return data


@cache
def unfinished() -> bytes:
    """The same as ``.part``: chunks that are not compressed."""
    from snakebot.robot import robot_from_mapping
    from snakebot.runlog.part_file import beginning, chunk, message

    bench = robot_from_mapping({"joints": 1}, "seed")
    ticks = [message(1, count, count, count, (TICK % count)[1:]) for count in range(4)]
    return beginning(bench, {"note": "x"}, {}, 0) + chunk(ticks[:2]) + chunk([*ticks[2:]])


def split_log() -> tuple[bytes, bytes]:
    """A finished log up to its index, and the index (without footer and closing magic)."""
    data = recorded()
    _, _, start, _, _ = struct.unpack_from("<BQQQI", data, len(data) - 37)
    return data[:start], data[start:-37]


def parquets() -> list[bytes]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    rows = np.arange(6)
    table = pa.table(
        {"t_s": rows / 10, "cmd_1_rad": [0.1, None, 0.3, 0.1, 0.1, 0.1], "enc_1_rad": rows.astype(np.int16)}
    )
    made = []
    for options in (
        {"compression": "none", "use_dictionary": False, "store_schema": False},
        {"compression": "snappy", "use_dictionary": True, "store_schema": False},
        {"compression": "none", "data_page_version": "2.0", "row_group_size": 3},
        {"compression": "zstd", "column_encoding": "BYTE_STREAM_SPLIT", "use_dictionary": False, "store_schema": False},
    ):  # fmt: skip
        numbers = table.select(["t_s", "cmd_1_rad"]) if "column_encoding" in options else table
        file = io.BytesIO()
        pq.write_table(numbers, file, **options)
        made.append(file.getvalue())
    return made


def _configs(kind: str) -> list[bytes]:
    from snakebot.resources import configs_root

    return [path.read_bytes() for path in sorted(configs_root().glob(f"{kind}/*.yaml"))]


def _dbcs() -> list[bytes]:
    """The head of ours, which is quicker to read than the whole, and a smaller one."""
    text = dbc_text()
    values = "\n".join(line for line in text.splitlines() if line.startswith("VAL_ 2 "))
    head = text[: text.index("BO_ 17 ")]
    return [f"{head}\n{values}\n".encode(), b'BO_ 1 A: 2 H\n SG_ a : 0|16@1- (0.1,2) [-9|9] "" B,C\n']


def _bus(dialect: Dialect) -> bytes:
    """A tick on a servo bus, in both directions."""
    goals = {1: b"\x00\x08\x00\x00", 2: b"\xff\xff\xfd\x00"}
    asked = dialect.ping(1) + dialect.sync_write(42, goals) + dialect.sync_read([1, 2], 56, 4)
    return asked + b"".join(dialect.answer(servo, 0, data) for servo, data in goals.items())


WIRE = pack_all([Frame(16, bytes(range(8))), Frame(1, b""), Frame(0x7FF, b"\0\0")])
TABLE = b"t_s,cmd_1_rad,enc_1_rad\n0,0.1,0.1\n0.01,0.2,nan\n0.02,,1e-3\n"
POSED = b't_s,cmd_1_rad,enc_1_rad,applied_1_rad,x_m,y_m,heading_rad,"my, own"\n0,0,0,0,1,1,1,text\n'
SESSION = b"robot: {joints: 1}\nruns:\n  - {file: run_01.csv, gait: {alpha_deg: 66, beta_deg: 80, omega_rad_s: 2}}\n"
BODY = (
    b"robot: {links: 2, half_length_m: 0.1, link_mass_kg: 1, friction: {ct: 1, cn: 2}}\nruns:\n"
    b"  - file: run_01.csv\n    forward_speed_m_s: 0.1\n    hold_out: true\n    metadata: {a: [b]}\n    more: 1\n"
)
ENTRIES = b"[snakebot.effects]\nworn = worn.servo:EFFECT\nother=a:b.c [extra]\n[console_scripts]\nx = y:z\n"
GAIT = b'joints=1\ngait={"alpha_deg":1,"beta_deg":2,"omega_rad_s":3}'
MOTIONS = (
    b"start: [&a {alpha_deg: 4, beta_deg: 80, omega_rad_s: 0.5, offset_deg: -1e+1}]\n"
    b"gaits:\n  - {<<: *a, duration_s: 60}\nprobes: ['sine:amplitude_deg=3,omega_rad_s=1.6+6']\nlifted: []\n"
)

_MADE: dict[str, Callable[[], list[bytes]]] = {
    "port": lambda: [
        b"sim:", b"serial:/dev/ttyUSB0?baud=1000000", b"can:slcan//dev/ttyACM0?bitrate=1000000", b"COM4",
        b"serial:socket://127.0.0.1:5555?logging=debug&dtr=0", b"can:udp_multicast/239.74.163.2",
        b"feetech:/dev/ttyUSB0?baud=500000&ids=1-5,7",
    ],
    "stream": lambda: [WIRE],
    "packet": lambda: [part for part in WIRE.split(b"\0") if part],
    "frame": lambda: [
        b"\x10\0" + bytes(8), b"\x11\0" + bytes(2) + b"\1\1" + bytes(4), b"\1\0" + bytes(5),
        b"\x20\0" + bytes(8), b"\x21\0" + bytes(8),
    ],
    "feetech": lambda: [_bus(Feetech()), Feetech().answer(3, 0, b"\xff\xff\x01\x02")],
    "dynamixel": lambda: [
        _bus(Dynamixel()),
        Dynamixel().answer(3, 0x80, b"\xff\xff\xfd\x00"),
        fast_answer([(1, 0, b"\1\2\3\4"), (2, 0x80, b"\xff\xff\xfd\x00")]),
    ],
    "slcan": lambda: [b"t0108AABBCCDDEEFF0011\r", b"z\r\a", b"T0000001080\r", b"t01020102ABCD\r"],
    "dbc": _dbcs,
    "effect": lambda: [
        b"rate_limit:limit_rad_s=1.6,joints=3+4", b"command_delay:delay_s=0.05", b"slope:angle_deg=1e+0"
    ],
    "fault": lambda: [b"free:3", b"rigid:4+5@12s", b"rigid:2=-30.5", b"clear@20s"],
    "course": lambda: [b"y=0", b"x=-1.5@-90", b"0.5,1@30"],
    "pose": lambda: [
        b'{"t": 12.5, "x": 0.25, "y": -0.03, "heading": 0.17}',
        b'{"t":1,"x":2e0,"y":3,"heading":-4,"tag":7}',
    ],
    "pose_source": lambda: [b"udp://127.0.0.1:9000", b"udp://:9000", b"udp://[::1]:1"],
    "column_map": lambda: [b"cmd_*_rad=servo_#:deg\nt_s=time:ms", b"enc_1_rad=-pos:counts\nsupply_v=u:mV"],
    "name": lambda: [b"penn_state", b"gentle", b"configs/robots/penn_state.yaml", b"rate_limit:limit_rad_s=2"],
    "plug_in": lambda: [ENTRIES],
    "robot": lambda: [*_configs("robots"), BENCH],
    "gait": lambda: _configs("gaits"),
    "effect_set": lambda: [*_configs("effects"), b'effects: ["command_delay:delay_s=0.05"]\n'],
    "motions": lambda: [*_configs("motions"), MOTIONS],
    "csv": lambda: [TABLE, b"a,b\n1,2\n\n\n"],
    "csv_gz": lambda: [gzip.compress(TABLE, mtime=0), gzip.compress(TABLE, 0, mtime=0)],
    "parquet": parquets,
    "session": lambda: [SESSION, BODY],
    "session_run": lambda: [TABLE, POSED],
    "log": lambda: [recorded()],
    "log_part": lambda: [unfinished()],
    "log_records": lambda: [
        SEPARATOR.join([BENCH, GAIT, TICK % 0, TICK % 1, POSE, EVENT, LINK, FRAME, READINGS, STEERED]),
        SEPARATOR.join([BENCH, b"", TICK % 0]),
    ],
    "log_index": lambda: [split_log()[1]],
    **SOUND,
}  # fmt: skip


@cache
def seeds(kind: str) -> list[bytes]:
    return _MADE[kind]()
