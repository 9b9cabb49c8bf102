"""Files of about 10 kB, and texts, that ask for gigabytes. Run as a program, with a limit on its memory: a line of JSON
for each, ``[name, parser, bytes, what became of it, MiB that it took]``.
"""

from __future__ import annotations

import contextlib
import gc
import gzip
import io
import json
import resource
import struct
import sys
import warnings
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path

BOUND_MIB = 256  # what reading 10 kB of anything may take, over what is taken before; docs/hostile-input.md


def yaml_bombs() -> Iterator[tuple[str, bytes]]:
    laughs = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n"
    merges = "a0: &a0 {x0: 1}\n"
    for number in range(1, 100):
        laughs += f"a{number}: &a{number} [{', '.join([f'*a{number - 1}'] * 9)}]\n"
        merges += f"a{number}: &a{number} {{<<: [{', '.join([f'*a{number - 1}'] * 9)}], y{number}: 1}}\n"
    long = f"robot: {{joints: 1}}\nt: &t {'x' * 7000}\na0: &a0 [{', '.join(['*t'] * 14)}]\n"
    for number in range(1, 4):
        long += f"a{number}: &a{number} [{', '.join([f'*a{number - 1}'] * 14)}]\n"
    long += "joints: *a3\nruns: [{file: run_01.csv, forward_speed_m_s: *a3}]\n"
    yield "laughs", laughs.encode()
    yield "one long text", long.encode()  # few values, each of them long
    yield "merges", merges.encode()
    yield "base 60", b"joints: 1" + b":59" * 3300
    yield "digits", b"joints: " + b"9" * 10_000
    yield "binary digits", b"joints: 0b" + b"1" * 10_000
    yield "exponent", b"joints: 1.0e+999999999"
    yield "lists", b"[" * 10_000
    yield "keys", b"? " * 5000
    yield "anchors", b"".join(b"a%d: &a%d x\n" % (n, n) for n in range(700))


def _gz(text: bytes) -> bytes:
    return gzip.compress(text, 9, mtime=0)


def csv_gz_bombs() -> Iterator[tuple[str, bytes]]:
    yield "three columns", _gz(b"t_s,cmd_1_rad,enc_1_rad\n" + b"0,0,0\n" * 1_100_000)
    names = b",".join(b"c%d" % n for n in range(1000))
    yield "thousand columns", _gz(names + b"\n" + (b"00," * 999 + b"00\n") * 2000)
    yield "one line", _gz(b"0" * 10_000_000)
    yield "one cell", _gz(b'"' + b"0\n" * 5_000_000)
    yield "blank lines", _gz(b"t_s\n" + b"\n" * 10_000_000)
    yield "many files in one", _gz(b"t_s\n" + b"0\n" * 100_000) * 40


def csv_bombs() -> Iterator[tuple[str, bytes]]:
    yield "columns", b",".join(b"%d" % n for n in range(2000)) + b"\n"
    yield "commas", b"," * 10_000
    yield "quotes", b'"' * 9_999


def _varint(value: int) -> bytes:
    """Zigzag, as Thrift's compact protocol has it."""
    value *= 2
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    return bytes(out) + bytes([value])


def parquet_bombs() -> Iterator[tuple[str, bytes]]:
    import numpy as np
    import pyarrow as pa
    import pyarrow.parquet as pq
    from seeds import parquets

    file = io.BytesIO()
    zeros = {name: np.zeros(2_000_000, np.int8) for name in ("t_s", "cmd_1_rad", "enc_1_rad")}
    pq.write_table(pa.table(zeros), file, compression="zstd", row_group_size=2_000_000)
    yield "rows", file.getvalue()
    sound = parquets()[0]
    start = len(sound) - 8 - struct.unpack("<I", sound[-8:-4])[0]
    for huge in (2**31 - 1, 2**62):
        for at in range(start, len(sound) - 8, 2):  # every other number of the description
            footer = sound[start:at] + _varint(huge) + sound[at + 1 : -8]
            yield f"footer {at} {huge}", sound[:start] + footer + struct.pack("<I", len(footer)) + b"PAR1"
        for at in range(4, 60):  # and of the first page's head; what follows it moves
            yield f"page {at} {huge}", sound[:at] + _varint(huge) + sound[at + 1 :]


def mcap_bombs() -> Iterator[tuple[str, bytes]]:
    import zstandard
    from parsers import _declarations
    from seeds import TICK

    from snakebot.runlog.part_file import message

    head, declared = _declarations()

    def record(opcode: int, body: bytes, length: int | None = None) -> bytes:
        return struct.pack("<BQ", opcode, len(body) if length is None else length) + body

    def packed(data: bytes, size: int | None = None) -> bytes:
        stored = zstandard.ZstdCompressor(level=19).compress(data)
        size = len(data) if size is None else size
        return record(
            6, struct.pack("<QQQII4sQ", 0, 0, size, zlib.crc32(data), 4, b"zstd", len(stored)) + stored
        )

    def messages(one: bytes, count: int) -> bytes:
        return packed(declared + message(one[0] & 7, 0, 0, 0, one[1:]) * count)

    yield "record of 4 GiB", head + record(6, b"x" * 100, 1 << 32)
    yield "record of 2^63", head + record(9, b"x" * 100, 1 << 63)
    for opcode in (9, 12):
        yield f"text of 4 GiB in record {opcode}", head + record(opcode, b"\xff\xff\xff\xff" * 20)
    yield "map of 4 GiB in a channel", head + packed(record(4, b"\1\0\1\0" + b"\xff" * 40))
    yield "chunk of 4 GiB", head + packed(bytes(1000), 1 << 32)
    yield "chunk of 8 MiB", head + packed(bytes(8 << 20)) * 4
    wide = b'1{"t_s":0,"setpoint_rad":[' + b"0," * 2_000_000 + b"0]}"
    yield "millions of joints", head + messages(wide, 1) + messages(TICK % 0, 1)
    gone = (
        b'{"t_s":0,"sequence":0,"setpoint_rad":[%s],"sent_rad":null,"applied_rad":null,"measured_rad":null'
        % (b",".join([b"0"] * 31))
    )
    first = b"1" + gone + b',"board_time_us":0,"latency_s":0,"late":false}'
    yield "empty ticks", head + messages(first, 30_000)
    yield "lists in lists", head + messages(b'3{"t_s":0,"data":[' + b"[]," * 1_000_000 + b"0]}", 2)
    detail = b'3{"t_s":0,"level":2,"kind":"","message":"","data":{"a":[' + b"[]," * 1000 + b"0]}}"
    yield "events", head + messages(detail, 2500)
    names = b'6{"t_s":0' + b"".join(b',"n%d":0' % n for n in range(1000)) + b"}"
    yield "readings", head + messages(names, 1) + messages(b'6{"t_s":0}', 180_000)
    yield "many readings", head + messages(names, 800)
    yield "nothing a hundred thousand times", head + messages(b"6", 200_000)
    yield "frames", head + messages(b'5{"t_s":0,"direction":"","id":0,"data":""}', 100_000)


def text_bombs() -> Iterator[tuple[str, str, bytes]]:
    for name, head in (
        ("joints", b"rate_limit:limit_rad_s=1,joints=1"),
        ("values", b"rate_limit:limit_rad_s=1"),
    ):
        yield name, "effect", head + b"+1" * 5000
    yield "digits", "effect", b"rate_limit:limit_rad_s=" + b"9" * 10_000
    yield "joints", "fault", b"free:1" + b"+1" * 5000
    yield "digits", "fault", b"free:" + b"9" * 10_000
    yield "options", "port", b"can:a/b?" + b"a=1&" * 2500
    yield "stars", "column_map", b"*" * 10_000 + b"=" + b"*" * 100
    yield "noise", "stream", b"\1" * 10_000
    yield "one packet", "stream", b"\xff" * 10_000 + b"\0"
    yield "noise", "slcan", b"t" * 10_000
    yield "entries", "plug_in", b"[snakebot.effects]\n" + b"a=b:c\n" * 1500
    yield "length", "dbc", b"BO_ 1 A: 999999999 H\n"
    yield "bits", "dbc", b'BO_ 1 A: 8 H\n SG_ a : 0|999999999@1+ (1,0) [0|1] "" H\n'
    yield "exponent", "dbc", b'BO_ 1 A: 8 H\n SG_ a : 0|8@1+ (1E+999999999,0) [0|1] "" H\n'
    yield (
        "many values",
        "dbc",
        b'BO_ 1 A: 8 H\n SG_ a m0 : 0|8@1+ (1,0) [0|1] "" H\nSG_MUL_VAL_ 1 a a 0-999999999;\n',
    )


def bombs(wanted: Sequence[str]) -> Iterator[tuple[str, str, bytes]]:
    """(name, parser, data) of those for some of the parsers; perhaps of others too."""
    yield from text_bombs()
    for kinds, made in (
        (("robot", "gait", "effect_set", "motions", "session"), yaml_bombs),
        (("csv_gz",), csv_gz_bombs),
        (("csv", "session_run"), csv_bombs),
        (("parquet",), parquet_bombs),
        (("log",), mcap_bombs),
    ):
        for name, data in made() if set(kinds) & set(wanted) else ():
            for kind in kinds:
                yield name, kind, data


def _peak_mib() -> int:
    text = Path("/proc/self/status").read_text()
    return int(text.split("VmHWM:")[1].split()[0]) >> 10


def let_off(kind: str, data: bytes) -> tuple[str, int]:
    """``read``, ``refused`` or what else happened, and the MiB that the process grew by meanwhile."""
    from parsers import DOCUMENTED, PARSERS

    gc.collect()
    Path("/proc/self/clear_refs").write_text("5")  # the high-water mark starts anew
    base = _peak_mib()
    said = "read"
    try:
        PARSERS[kind](data)
    except DOCUMENTED:
        said = "refused"
    except Exception as error:
        said = f"{type(error).__name__}: {error}"[:200]
    return said, _peak_mib() - base


def main() -> None:
    from parsers import DOCUMENTED, PARSERS
    from seeds import seeds

    warnings.simplefilter("ignore")
    wanted = [kind for kind in PARSERS if kind in sys.argv[1:] or len(sys.argv) < 2]
    for kind in wanted:  # what is loaded once is not the bomb's
        for data in seeds(kind):
            with contextlib.suppress(*DOCUMENTED):
                PARSERS[kind](data)
    prepared = [bomb for bomb in bombs(wanted) if bomb[1] in wanted]
    gc.collect()
    gc.freeze()  # what is loaded once is not looked through again for each bomb
    address_space = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (address_space + 4 * (BOUND_MIB << 20),) * 2)
    for name, kind, data in prepared:
        print(json.dumps([name, kind, len(data), *let_off(kind, data)]), flush=True)


if __name__ == "__main__":
    main()
