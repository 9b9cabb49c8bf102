"""Another host on the line of a run is told once: in the log, and on the terminal."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from firmware_protocol.catalogue import HostHeartbeat, encode
from firmware_protocol.frame import Frame
from snakebot.cli.run import command
from snakebot.control import ports
from snakebot.links.base import Link
from snakebot.runlog import read_log


def test_another_host_stands_in_the_log_and_on_the_terminal(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    real = ports.open_port

    def crowded(*arguments: Any, **options: Any) -> Link:
        link = real(*arguments, **options)
        receive = link.receive
        beats = iter(range(65536))

        def hear(timeout_s: float) -> Sequence[Frame]:
            frames = receive(timeout_s)
            return [*frames, encode(HostHeartbeat(0xBEEF, next(beats)))] if frames else frames

        monkeypatch.setattr(link, "receive", hear)
        return link

    monkeypatch.setattr(ports, "open_port", crowded)
    log = tmp_path / "crowded.mcap"
    words = ["--alpha", "20", "--beta", "80", "--omega", "2", "--duration", "5", "--fast", "--json"]
    done = CliRunner().invoke(command, [*words, "--log", str(log)])
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["ended"] == "finished"
    assert done.stderr.count("another host (0000beef) spoke on the line of sim") == 1
    told = [event for event in read_log(log).events if event.kind == "other_host"]
    assert len(told) == 1
    assert "0000beef" in told[0].message
