"""Foxglove's own client library (@foxglove/ws-protocol, npm) reads a live run: what it gets is what the log holds."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from mcap.reader import make_reader
from page_client import PageClient, socket_url
from viewed_run import ViewedRun

from snakebot.runlog import read_log
from snakebot.runlog.channels import CHANNELS

CLIENT = Path(__file__).with_name("foxglove_client.mjs")


@pytest.fixture(scope="module")
def tools(tmp_path_factory: pytest.TempPathFactory) -> Path:
    npm, node = shutil.which("npm"), shutil.which("node")
    if npm is None or node is None:
        pytest.skip("npm and node are not installed; Foxglove's client cannot be tried")
    folder = tmp_path_factory.mktemp("foxglove")
    shutil.copy(CLIENT, folder)
    command = [npm, "install", "--no-audit", "--no-fund", "--silent", "@foxglove/ws-protocol@0.8", "ws@8"]
    installed = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if installed.returncode:
        pytest.skip(f"@foxglove/ws-protocol cannot be installed: {installed.stderr.strip()[-200:]}")
    return folder


@pytest.mark.slow
@pytest.mark.real_time
@pytest.mark.timeout(300)
@pytest.mark.parametrize("subprotocol", ["foxglove.websocket.v1", "foxglove.sdk.v1"])
def test_foxgloves_own_client_sees_what_the_log_holds(
    subprotocol: str, tools: Path, start: Callable[..., ViewedRun]
) -> None:
    run = start()
    command = ["node", CLIENT.name, socket_url(run.url), subprotocol, "150"]
    done = subprocess.run(command, cwd=tools, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    seen = json.loads(done.stdout)
    page = PageClient(run.url)
    page.ask(do="stop")
    run.ends()

    assert seen["info"]["supportedEncodings"] == ["json"]
    assert set(seen["channels"]) == {channel.topic for channel in CHANNELS}
    for channel in CHANNELS:
        offered = seen["channels"][channel.topic]
        assert (offered["encoding"], offered["schemaEncoding"]) == ("json", "jsonschema")
        assert offered["schemaName"] == channel.schema_name
        assert json.loads(offered["schema"]) == json.loads(channel.schema)
    log = read_log(run.log)
    rows = {int(number): index for index, number in enumerate(log.sequence)}
    with run.log.open("rb") as file:
        joints = make_reader(file).iter_messages(["/joints"])
        logged_ns = {message.sequence: message.log_time for _, _, message in joints}
    ticks = seen["messages"]["/joints"]
    assert len(ticks) == 150
    for time_ns, text in ticks:
        tick = json.loads(text)
        row = rows[tick["sequence"]]
        assert int(time_ns) == logged_ns[tick["sequence"]]
        assert tick["measured_rad"] == list(log.measured_rad[row])
    assert len(seen["messages"]["/pose"]) > 100
    assert seen["messages"]["/link"]
