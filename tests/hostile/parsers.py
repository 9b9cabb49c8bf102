"""Every parser of what comes from outside, as one function of bytes. It may only raise what it documents.

Shared by the property tests and by tools/fuzz_parsers.py. Files are put into a folder of our own, in memory where the
system has such a place; ``seeds.py`` has sound input for each.
"""

from __future__ import annotations

import atexit
import importlib.metadata
import os
import re
import shutil
import struct
import tempfile
import warnings
import zlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING
from unittest import mock

import numpy as np
from foreign_recordings import RECORDINGS

from firmware_protocol.catalogue import codecs_of, decode, encode
from firmware_protocol.dbc import read_dbc
from firmware_protocol.frame import Frame, ProtocolError
from firmware_protocol.framing import StreamDecoder, pack_all, unpack
from firmware_protocol.packing import Layout
from snakebot.errors import SnakebotError
from snakebot.servobus.dynamixel import Dynamixel, fast_pieces
from snakebot.servobus.feetech import Feetech
from snakebot.servobus.packets import Dialect

if TYPE_CHECKING:
    from snakebot.robot import Robot
    from snakebot.runlog.number_table import NumberTable
    from snakebot.runlog.run import Run

DOCUMENTED = (SnakebotError, ProtocolError)
FOLDER_VARIABLE = "SNAKEBOT_FUZZ_FOLDER"
SEPARATOR = b"\x1e"


@cache
def folder() -> Path:
    """A folder of our own; a parser may read what is put there and must write nothing."""
    made = Path(tempfile.mkdtemp(prefix="snakebot-hostile-", dir=os.environ.get(FOLDER_VARIABLE)))
    atexit.register(shutil.rmtree, made, ignore_errors=True)
    return made


def _file(name: str, data: bytes) -> Path:
    path = folder() / name
    with open(path, "wb", buffering=0) as file:
        file.write(data)
    return path


def _text(data: bytes) -> str:
    return data.decode("utf-8", "surrogateescape")


# --- the wire


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
    assert decode(encode(message)) == message


def slcan(data: bytes) -> None:
    from snakebot.links.slcan import SlcanDecoder

    decoder = SlcanDecoder()
    for heard in decoder.feed(data):
        assert 0 <= heard.id <= 0x7FF
        assert len(heard.data) <= 8


def _servo_bus(dialect: Dialect, data: bytes) -> None:
    """Both directions; whatever is heard would be said the same way, and no more is kept than one packet."""
    for decoder in (dialect.answers(64), dialect.instructions()):
        for heard in decoder.feed(data):
            assert 0 <= heard.id <= 0xFE
            assert len(heard.parameters) <= decoder.longest
        assert decoder.pending <= decoder.longest
        decoder.reset()
        assert decoder.feed(dialect.answer(7, 0, b"\x01\x02")), "a good packet after noise"


def feetech(data: bytes) -> None:
    _servo_bus(Feetech(), data)


def dynamixel(data: bytes) -> None:
    _servo_bus(Dynamixel(), data)
    for heard in Dynamixel().answers(1024).feed(data):
        fast_pieces(heard.parameters, 4)


def dbc(data: bytes) -> None:
    read = read_dbc(data.decode("utf-8", "replace"))
    for message in read.messages:
        layout = Layout(message, [signal.name for signal in message.signals])
        assert layout.length <= 8
        layout.unpack(b"\x5a" * layout.length)
    codecs_of(read)


# --- options, names and plug-ins


def effect(data: bytes) -> None:
    from snakebot.effects import parse_effect

    spec = parse_effect(_text(data))
    assert parse_effect(str(spec)) == spec


def fault(data: bytes) -> None:
    from snakebot.control import parse_fault

    parse_fault(_text(data), 5)


@cache
def _penn_state() -> Robot:
    from snakebot.robot import load_robot

    return load_robot("penn_state")


def course(data: bytes) -> None:
    """``--line``."""
    from snakebot.steering import parse_line

    assert parse_line(_text(data)).through_m is not None


def pose(data: bytes) -> None:
    """What a tracker sends: whatever it is, a pose or nothing."""
    from snakebot.steering.pose_line import parse_pose

    found = parse_pose(data)
    assert found is None or np.isfinite(found).all()


def pose_source(data: bytes) -> None:
    """``--pose``."""
    from snakebot.steering.pose_udp import parse_pose_source

    assert 0 < parse_pose_source(_text(data)).port < 1 << 16


def column_map(data: bytes) -> None:
    from snakebot.runlog.column_map import parse_map

    parse_map(_text(data).splitlines(), _penn_state())


def name(data: bytes) -> None:
    """What stands after --robot, --gait, --effect; and what becomes part of a log's name."""
    from snakebot.effects import parse_effects
    from snakebot.resources import config_path
    from snakebot.runlog.naming import new_log_path

    text = _text(data)
    made = new_log_path(text, folder())
    assert made.parent == folder()
    assert re.fullmatch(r"[A-Za-z0-9._+-]+", made.name)
    for kind in ("robots", "gaits", "effects"):
        try:
            assert config_path(kind, text).is_file()
        except SnakebotError:
            continue
    parse_effects([text])


class Package(importlib.metadata.Distribution):
    """An installed package with this list of entry points."""

    def __init__(self, listed: bytes) -> None:
        self._listed = listed

    def read_text(self, filename: str) -> str | None:
        if filename == "entry_points.txt":
            return self._listed.decode("utf-8")
        return "Metadata-Version: 2.1\nName: plugged\nVersion: 1\n" if filename == "METADATA" else None

    def locate_file(self, path: object) -> Path:
        return folder() / str(path)


def plug_in(data: bytes) -> None:
    """No name is imported that is not a plain module's; the modules themselves are not there."""
    from snakebot.effects import registry

    def load(entry: importlib.metadata.EntryPoint) -> object:
        found = entry.pattern.match(entry.value)
        assert found, entry
        assert all(part.isidentifier() for part in found["module"].split(".")), entry
        assert re.fullmatch("[a-z][a-z0-9_]*", entry.name), entry
        raise ImportError(entry.value)

    with (
        mock.patch.object(importlib.metadata, "distributions", side_effect=lambda **_: iter([Package(data)])),
        mock.patch.object(importlib.metadata.EntryPoint, "load", load),
        warnings.catch_warnings(record=True) as told,
    ):
        assert registry._installed() == []
    for warning in told:
        assert str(warning.message).isprintable()


# --- YAML


def robot(data: bytes) -> None:
    from snakebot.robot import load_robot, robot_from_mapping

    read = load_robot(_file("robot.yaml", data))
    assert robot_from_mapping(read.to_mapping(), "again") == read


def gait(data: bytes) -> None:
    from snakebot.gait.named import load_gait

    load_gait(_file("gait.yaml", data))


def effect_set(data: bytes) -> None:
    from snakebot.effects.spec import load_effect_set

    load_effect_set(_file("effects.yaml", data))


def motions(data: bytes) -> None:
    """The menu that comes with snakebot, which a lab may change."""
    from snakebot.diagnosis.proposal.motions import load_motions

    assert load_motions(_file("motions.yaml", data)).start


# --- runs


def _check_run(run: Run) -> None:
    assert np.isfinite(run.t_s).all()
    assert (np.diff(run.t_s) > 0).all()
    assert not np.isinf(run.command_rad).any()
    assert not np.isinf(run.measured_rad).any()


def _no_infinity(table: NumberTable) -> None:
    for values in table.columns.values():
        assert not np.isinf(values).any()


def csv(data: bytes) -> None:
    from snakebot.runlog.number_table import read_table

    _no_infinity(read_table(_file("run.csv", data)))


def csv_gz(data: bytes) -> None:
    from snakebot.runlog.number_table import read_table

    _no_infinity(read_table(_file("run.csv.gz", data)))


def parquet(data: bytes) -> None:
    from snakebot.runlog.number_table import read_table

    _no_infinity(read_table(_file("run.parquet", data)))


def _session() -> None:
    from snakebot.runlog import open_session

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for run in open_session(folder() / "session").runs:
            _check_run(run)


def session(data: bytes) -> None:
    """The description of a session whose run is sound."""
    (folder() / "session").mkdir(exist_ok=True)
    _file("session/run_01.csv", b"t_s,cmd_1_rad,enc_1_rad\n0,0,0\n0.1,0,0\n")
    _file("session/session.yaml", data)
    _session()


def session_run(data: bytes) -> None:
    """A run of a session whose description is sound."""
    (folder() / "session").mkdir(exist_ok=True)
    _file("session/run_01.csv", data)
    _file("session/session.yaml", b"robot: {joints: 1}\nruns: [{file: run_01.csv}]\n")
    _session()


# --- logs


def _read_log(path: Path) -> None:
    from snakebot.runlog import read_log

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        read = read_log(path)
        run = read.to_run()
        read.columns()
    _check_run(run)


def log(data: bytes) -> None:
    _read_log(_file("run.mcap", data))


def log_part(data: bytes) -> None:
    _read_log(_file("run.mcap.part", data))


@cache
def _declarations() -> tuple[bytes, bytes]:
    """Magic and header; the chunk that declares the channels."""
    from mcap.data_stream import RecordBuilder
    from mcap.records import Channel, Header, Schema
    from mcap.writer import MCAP0_MAGIC

    from snakebot.runlog import channels

    head, declared = RecordBuilder(), RecordBuilder()
    head.write(MCAP0_MAGIC)
    Header(profile=channels.PROFILE, library="fuzz").write(head)
    for channel in channels.CHANNELS:
        Schema(channel.id, b"{}", "jsonschema", channel.schema_name).write(declared)
        Channel(channel.id, channel.topic, "json", {}, channel.id).write(declared)
    return bytes(head.end()), bytes(declared.end())


def log_records(data: bytes) -> None:
    """What is in the records of a log whose lengths and checksums are all right.

    Parts, separated by 0x1E: the robot's description, the metadata as KEY=VALUE lines, then messages, the channel's
    number as their first character.
    """
    from mcap.data_stream import RecordBuilder
    from mcap.records import Attachment, Metadata

    from snakebot.runlog import metadata
    from snakebot.runlog.part_file import _chunk, chunk, message

    description, _, rest = data.partition(SEPARATOR)
    about, _, rest = rest.partition(SEPARATOR)
    texts = dict(line.partition("=")[::2] for line in about.decode("utf-8", "replace").splitlines())
    texts.pop("crc32", None)
    head, declared = _declarations()
    builder = RecordBuilder()
    Attachment(0, 0, "robot.yaml", "application/yaml", description).write(builder)
    Metadata("run", {**texts, "crc32": metadata._checksum(texts)}).write(builder)
    messages = [
        message(part[0] & 7, number, number, number, part[1:])
        for number, part in enumerate(rest.split(SEPARATOR))
        if part
    ]
    whole = head + builder.end() + _chunk(declared, 0, 0) + (chunk(messages) if messages else b"")
    _read_log(_file("records.mcap.part", whole))


def log_index(data: bytes) -> None:
    """The index at the end of a finished log, its checksum put right."""
    from seeds import split_log

    from snakebot.runlog.listing import summarize

    before, _ = split_log()
    footer = struct.pack("<BQQQ", 2, 20, len(before), 0)
    checked = data + footer
    end = checked + struct.pack("<I", zlib.crc32(checked)) + before[:8]
    found = summarize(_file("indexed.mcap", before + end))
    assert found.ticks >= 0
    assert np.isfinite(found.duration_s)


def _recording(name: str) -> Parser:
    def parse(data: bytes) -> None:
        RECORDINGS[name](folder(), data)

    return parse


Parser = Callable[[bytes], None]
PARSERS: dict[str, Parser] = {
    parser.__name__: parser
    for parser in (
        port, stream, packet, frame, slcan, feetech, dynamixel, dbc,
        effect, fault, course, pose, pose_source, column_map, name, plug_in, robot, gait, effect_set,
        motions,
        csv, csv_gz, parquet, session, session_run, log, log_part, log_records, log_index,
    )
} | {name: _recording(name) for name in RECORDINGS}  # fmt: skip
