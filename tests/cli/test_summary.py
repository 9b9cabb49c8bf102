"""What a run says at its end: degrees beside TE, what state the joints are in, and commands that work as they stand."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest

from snakebot.cli.main import main

RUN = ["run", "--alpha", "40", "--beta", "80", "--omega", "2", "--duration", "6", "--fast"]


def call(*words: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 0, words


def test_the_summary_tells_degrees_the_joints_and_what_next(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    call(*RUN, "--log", "my runs.mcap")
    text = capsys.readouterr().out
    row = re.search(r"1 │ +([0-9.]+) │ +([0-9.]+) │", text)
    assert row is not None
    assert math.radians(float(row[1])) / math.radians(40) == pytest.approx(float(row[2]), abs=2e-4)
    assert "joints: relaxed, without power" in text
    assert "diagnose" not in text  # one run is not enough
    assert re.findall(r"snakebot (\w+) ('.*?'|\S+)", text) == [
        ("analyze", "'my runs.mcap'"),
        ("compare", "'my runs.mcap'"),
    ]


@pytest.mark.slow
def test_what_it_says_comes_next_works_as_it_stands(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    call(*RUN, "--log", "my runs.mcap")
    commands = re.findall(r"snakebot (\w+) '(.*?)'", capsys.readouterr().out)
    assert len(commands) == 2
    for name, path in commands:
        call(name, path)
    call(*RUN, "--log", "second.mcap")
    assert "snakebot diagnose ." in capsys.readouterr().out
    call(*RUN, "--log", "third.mcap", "--json")
    told = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert told["mode"] == "disarmed"
    assert told["rms_error_deg"][0] == pytest.approx(40 * told["tracking_error"][0], abs=1e-3)
