"""The fuzz corpus is one archive, packed the same by everybody, and the core stands all of it."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from building import ROOT
from corpus import pack, unpack

ARCHIVE = ROOT / "tests/firmware/corpus.tar.xz"


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_every_input_is_named_by_its_digest(tmp_path: Path) -> None:
    found = contents(unpack(ARCHIVE, tmp_path / "corpus"))
    assert len(found) >= 500
    for name, data in found.items():
        assert hashlib.sha1(data).hexdigest() == name  # libFuzzer's way


def test_the_same_inputs_make_the_same_archive(tmp_path: Path) -> None:
    inputs = {"b": b"\x00\xff", "a": b"", "c": bytes(64)}
    for place, order in (("one", "abc"), ("two", "cba")):
        (tmp_path / place).mkdir()
        for name in order:
            path = tmp_path / place / name
            path.write_bytes(inputs[name])
            if place == "two":
                os.utime(path, (1e9, 1e9))
                path.chmod(0o600)
        pack(tmp_path / place, tmp_path / f"{place}.tar.xz")
    assert (tmp_path / "one.tar.xz").read_bytes() == (tmp_path / "two.tar.xz").read_bytes()
    stale = tmp_path / "out"
    stale.mkdir()
    (stale / "gone").touch()
    assert contents(unpack(tmp_path / "one.tar.xz", stale)) == inputs


@pytest.mark.slow
@pytest.mark.timeout(300)
@pytest.mark.skipif(shutil.which("clang") is None, reason="clang is not installed")
def test_the_fuzzer_starts_from_the_whole_corpus() -> None:
    program = ROOT / "tools/fuzz_firmware.py"
    done = subprocess.run(
        [sys.executable, str(program), "--runs", "2000"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "findings: 0" in done.stdout
    files = re.search(r"corpus: (\d+) files", done.stdout)
    assert files is not None
    assert int(files[1]) >= 500
