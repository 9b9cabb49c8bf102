"""The generated C codec, framing and CRCs against the golden vectors, with sanitizers on."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path
from typing import Any

from building import FIRMWARE, ROOT, need

from firmware_protocol.catalogue import database

VECTORS: dict[str, Any] = json.loads((ROOT / "firmware_protocol/vectors.json").read_text(encoding="utf-8"))

HEAD = """
#include <stdio.h>
#include <string.h>
#include "core/crc.h"
#include "core/framing.h"
#include "core/generated/catalogue.h"
#include "core/generated/snakebot.h"

static int wrong;
static int checked;
static void CHECK(const char *what, int right)
{
    checked++;
    if (!right) {
        wrong++;
        printf("wrong: %s\\n", what);
    }
}

static struct sb_frame heard;
static unsigned corrupt;

/* How many frames the bytes hold; the last one in `heard`. */
static int feed(const uint8_t *bytes, size_t length)
{
    struct sb_decoder decoder = {0};
    int frames = 0;
    for (size_t i = 0; i < length; i++) {
        frames += sb_decoder_feed(&decoder, bytes[i], &heard) ? 1 : 0;
    }
    corrupt = decoder.corrupt;
    return frames;
}

int main(void)
{
"""


def c_bytes(text: str) -> str:
    data = bytes.fromhex(text)
    return "(const uint8_t[]){" + ", ".join(f"0x{b:02x}u" for b in data or b"\0") + "}"


def c_name(name: str) -> str:
    return re.sub(r"(?<=[a-z0-9])([A-Z])", r"_\1", name).lower()


def frame_checks(vector: dict[str, Any]) -> list[str]:
    """Fields to payload, payload to fields, frame to packet, packet to frame."""
    name = f"snakebot_{c_name(vector['message'])}"
    definition = database().get_message_by_name(vector["message"])
    label = json.dumps(f"{vector['message']} {vector['payload']}")
    length = len(vector["payload"]) // 2
    lines = ["{", f"struct {name}_t in = {{0}}, out = {{0}};", "uint8_t data[8] = {0};"]
    for signal in definition.signals:
        raw = (
            round(vector["fields"][signal.name] / signal.scale)
            if signal.scale != 1
            else vector["fields"][signal.name]
        )
        suffix = "ull" if raw > 0x7FFFFFFF else ""
        lines.append(f"in.{signal.name} = {raw}{suffix};")
    packet = vector["packet"]
    lines += [
        f"CHECK({label}, {name}_pack(data, &in, sizeof data) == {length});",
        f"CHECK({label}, memcmp(data, {c_bytes(vector['payload'])}, {length}) == 0);",
        f"CHECK({label}, {name}_pack(data, &in, {length - 1}) < 0);",
        f"CHECK({label}, {name}_unpack(&out, data, {length}) == 0);",
        f"CHECK({label}, {name}_unpack(&out, data, {length - 1}) < 0);",
        *(f"CHECK({label}, out.{signal.name} == in.{signal.name});" for signal in definition.signals),
        f"CHECK({label}, sb_catalogue_accepts({vector['id']}u, data, {length}));",
        f"struct sb_frame frame = {{{vector['id']}u, {length}, {{0}}}};",
        "uint8_t packet[SB_MAX_ENCODED + 1u];",
        "memcpy(frame.data, data, 8);",
        f"CHECK({label}, sb_pack(&frame, packet) == {len(packet) // 2});",
        f"CHECK({label}, memcmp(packet, {c_bytes(packet)}, {len(packet) // 2}) == 0);",
        f"CHECK({label}, feed(packet, {len(packet) // 2}) == 1 && corrupt == 0u);",
        f"CHECK({label}, heard.id == frame.id && heard.length == frame.length);",
        f"CHECK({label}, memcmp(heard.data, data, {length}) == 0);",
        "}",
    ]
    return lines


def program() -> str:
    lines = []
    for vector in VECTORS["frames"]:
        lines += frame_checks(vector)
    for vector in VECTORS["bad_packets"]:
        count = len(vector["bytes"]) // 2
        lines.append(
            f"CHECK({json.dumps(vector['why'])}, feed({c_bytes(vector['bytes'])}, {count}) == 0 && corrupt == 1u);"
        )
    for vector in VECTORS["bad_frames"]:
        label, length = json.dumps(vector["why"]), len(vector["payload"]) // 2
        packet = vector["packet"]
        lines += [
            f"CHECK({label}, feed({c_bytes(packet)}, {len(packet) // 2}) == 1);",
            f"CHECK({label}, !sb_catalogue_accepts({vector['id']}u, {c_bytes(vector['payload'])}, {length}));",
        ]
    check = VECTORS["check"]
    lines += [
        f'CHECK("CRC-16", sb_crc16((const uint8_t *)"{check["text"]}", 9u) == 0x{check["crc16"]}u);',
        f'CHECK("CRC-32", sb_crc32((const uint8_t *)"{check["text"]}", 9u) == 0x{check["crc32"]}u);',
        f'CHECK("hash", SB_CATALOGUE_HASH == 0x{VECTORS["catalogue_hash"]}u);',
    ]
    return (
        HEAD
        + "\n".join(lines)
        + '\nprintf("%d checks, %d wrong\\n", checked, wrong);\nreturn wrong != 0;\n}\n'
    )


def test_generated_codec_and_framing_meet_the_vectors(tmp_path: Path) -> None:
    need("cc")
    source = tmp_path / "vectors.c"
    source.write_text(program(), encoding="utf-8")
    core = [
        FIRMWARE / "core" / name
        for name in ("crc.c", "framing.c", "generated/catalogue.c", "generated/snakebot.c")
    ]
    built = subprocess.run(
        ["cc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-fsanitize=address,undefined", "-fno-sanitize-recover=all",
         f"-I{FIRMWARE}", f"-I{FIRMWARE / 'core'}", "-o", str(tmp_path / "vectors"), str(source), *map(str, core)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert built.returncode == 0, built.stderr
    done = subprocess.run([str(tmp_path / "vectors")], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert int(done.stdout.split()[0]) > 1000
