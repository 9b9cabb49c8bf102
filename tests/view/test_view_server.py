"""The page's server beside a real run: who may look, who may drive, and that a run never waits for a page."""

from __future__ import annotations

import json
import os
import signal
import socket
import struct
import time
import urllib.error
import urllib.parse
import urllib.request
from collections.abc import Callable
from pathlib import Path

import pytest
from page_client import PageClient, armed, socket_url
from viewed_run import ViewedRun
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin, Subprotocol

from snakebot.errors import EXIT_BOARD_FAULT
from snakebot.runlog import read_log

Start = Callable[..., ViewedRun]


def test_a_page_is_told_the_robot_and_then_how_it_moves(start: Start) -> None:
    run = start()
    page = PageClient(run.url)
    assert page.hello["joints"] == 5
    assert page.hello["speed_limit_rad_s"]
    page.until(armed)
    first = page.until(lambda message: bool(message.get("rows")))
    later = page.until(lambda message: bool(message.get("rows")) and message["rows"][-1][0] > 1.0)
    assert later["rows"][-1][0] > first["rows"][-1][0]
    assert any(abs(angle) > 1.0 for angle in later["rows"][-1][3])
    assert later["pose"] is not None
    assert later["loop"]["rate_hz"] == pytest.approx(100, rel=0.2)
    assert all(value is not None for value in later["rms_deg"])


def test_stop_cuts_the_power_and_the_run_ends_with_its_status(start: Start) -> None:
    run = start()
    page = PageClient(run.url)
    page.until(armed)
    assert page.ask(do="stop") is None
    assert run.ends() == EXIT_BOARD_FAULT
    assert "emergency stop" in str(read_log(run.log).metadata["ended"])


@pytest.mark.slow
@pytest.mark.real_time
def test_ramp_down_ends_the_run_as_ctrl_c_does_and_twice_is_once(start: Start) -> None:
    run = start("--ramp", "0.5")
    page = PageClient(run.url)
    page.until(armed)
    assert page.ask(do="ramp_down") is None
    assert page.ask(do="ramp_down") is None
    assert run.ends() == 130
    assert read_log(run.log).metadata["ended"] == "interrupted"


@pytest.mark.slow
@pytest.mark.real_time
def test_sliders_change_the_gait_and_what_breaks_a_limit_is_refused(start: Start) -> None:
    run = start("--ramp", "0.5")
    page = PageClient(run.url)
    page.until(lambda message: armed(message) and message["status"]["t_s"] > 0.2)
    assert page.ask(do="gait", alpha_deg=30, beta_deg=70, omega_rad_s=1.5, offset_deg=5) is None
    changed = page.until(lambda m: ((m.get("status") or {}).get("gait") or {}).get("alpha_deg") == 30)
    assert changed["status"]["gait"]["offset_deg"] == pytest.approx(5)
    time.sleep(1.5)
    refused = page.ask(do="gait", alpha_deg=300, beta_deg=70, omega_rad_s=1.5, offset_deg=0)
    assert refused is not None
    assert "allows 95 deg" in refused
    for nonsense in ({"alpha_deg": "much"}, {"alpha_deg": None}, {}):
        assert page.ask(do="gait", **nonsense) == "not understood"
    assert page.ask(do="dance") == "not understood"
    page.ask(do="ramp_down")
    run.ends()
    kinds = [event.kind for event in read_log(run.log).events]
    assert kinds.count("gait") == 1


@pytest.mark.slow
@pytest.mark.real_time
def test_a_joint_is_broken_and_mended_by_click(start: Start) -> None:
    run = start("--ramp", "0.5")
    page = PageClient(run.url)
    page.until(lambda message: armed(message) and message["status"]["t_s"] > 0.2)
    assert page.ask(do="fault", fault="free:3") is None
    page.until(lambda message: message.get("joint_modes", [""] * 5)[2] == "free")
    assert page.ask(do="fault", fault="rigid:3@1s") is None
    told = page.until(lambda message: message.get("joint_modes", [""] * 5)[2] == "rigid_here")
    assert any(event["message"] == "joint 3: rigid where it stands" for event in told["events"])
    assert page.ask(do="fault", fault="clear:3") is None
    page.until(lambda message: message.get("joint_modes", [""] * 5)[2] == "active")
    assert "joint 9" in str(page.ask(do="fault", fault="free:9"))


@pytest.mark.slow
@pytest.mark.real_time
def test_one_page_drives_the_others_watch_and_anybody_may_stop(start: Start) -> None:
    run = start()
    first, second = PageClient(run.url), PageClient(run.url)
    assert first.frame()["drives"]
    assert not second.frame()["drives"]
    refused = second.ask(do="gait", alpha_deg=30, beta_deg=70, omega_rad_s=1, offset_deg=0)
    assert refused is not None
    assert "watches" in refused
    first.close()
    second.until(lambda message: bool(message.get("free")))
    second.connection.send(json.dumps({"do": "drive"}))
    second.until(lambda message: bool(message.get("drives")))
    third = PageClient(run.url)
    third.until(armed)
    assert third.ask(do="stop") is None
    assert run.ends() == EXIT_BOARD_FAULT


@pytest.mark.slow
@pytest.mark.real_time
def test_the_last_page_that_closes_ends_the_run_only_where_it_is_asked_for(start: Start) -> None:
    run = start("--view-stop", "--ramp", "0.5")
    first, second = PageClient(run.url), PageClient(run.url)
    second.until(lambda message: armed(message) and message["status"]["t_s"] > 0.2)
    first.close()
    second.frame()
    assert run.process.poll() is None
    second.close()
    assert run.ends() == 130


@pytest.mark.slow
@pytest.mark.real_time
def test_a_server_that_hangs_or_dies_does_not_touch_the_run(start: Start) -> None:
    run = start("--duration", "5", "--ramp", "0.5")
    page = PageClient(run.url)
    page.until(armed)
    children = Path(f"/proc/{run.process.pid}/task/{run.process.pid}/children").read_text().split()
    os.kill(int(children[0]), signal.SIGSTOP)
    time.sleep(1.0)
    os.kill(int(children[0]), signal.SIGKILL)
    assert run.ends() == 0
    log = read_log(run.log)
    assert log.metadata["ended"] == "finished"
    assert len(log.t_s) == 501


@pytest.mark.slow
@pytest.mark.real_time
def test_a_page_that_reads_nothing_holds_up_neither_the_run_nor_the_others(start: Start) -> None:
    run = start()
    deaf = socket.create_connection(("127.0.0.1", urllib.parse.urlsplit(run.url).port or 0))
    deaf.sendall(
        f"GET / HTTP/1.1\r\nHost: {urllib.parse.urlsplit(run.url).netloc}\r\nUpgrade: websocket\r\n"
        "Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Protocol: snakebot.view.1\r\n\r\n".encode()
    )
    page = PageClient(run.url)
    newest = page.until(lambda message: bool(message.get("rows")) and message["rows"][-1][0] > 2.0)
    assert newest["status"]["mode"] == "armed"
    deaf.close()


FOXGLOVE = ["foxglove.websocket.v1", "foxglove.sdk.v1"]


@pytest.mark.slow
@pytest.mark.real_time
@pytest.mark.parametrize("name", FOXGLOVE)
def test_other_viewers_get_the_logs_own_channels(name: str, start: Start) -> None:
    run = start()
    offers = connect(
        socket_url(run.url), subprotocols=[Subprotocol(name)], origin=Origin(run.url.rstrip("/"))
    )
    with offers as viewer:
        seen = _ticks_of(viewer, name)
    page = PageClient(run.url)
    page.ask(do="stop")
    run.ends()
    log = read_log(run.log)
    rows = {int(number): index for index, number in enumerate(log.sequence)}
    for number, text in seen.items():
        tick = json.loads(text)
        assert tick["t_s"] == pytest.approx(log.t_s[rows[number]], abs=1e-9)
        assert tick["sent_rad"] == pytest.approx(list(log.sent_rad[rows[number]]))


def _ticks_of(viewer: ClientConnection, name: str) -> dict[int, bytes]:
    """Fifty messages of /joints, by their sequence number."""
    assert viewer.subprotocol == name
    info = json.loads(viewer.recv(5.0))
    assert info["op"] == "serverInfo"
    offered = {channel["topic"]: channel for channel in json.loads(viewer.recv(5.0))["channels"]}
    assert {"/joints", "/pose", "/events", "/link"} <= set(offered)
    assert json.loads(offered["/joints"]["schema"])["type"] == "object"
    wanted = {"op": "subscribe", "subscriptions": [{"id": 7, "channelId": offered["/joints"]["id"]}]}
    viewer.send(json.dumps({"op": "nonsense"}))
    viewer.send("not json")
    viewer.send(json.dumps(wanted))
    seen: dict[int, bytes] = {}
    while len(seen) < 50:
        data = viewer.recv(5.0)
        assert isinstance(data, bytes)
        opcode, subscription, _ = struct.unpack_from("<BIQ", data)
        assert (opcode, subscription) == (1, 7)
        seen[json.loads(data[13:])["sequence"]] = data[13:]
    return seen


@pytest.mark.slow
@pytest.mark.real_time
def test_a_stop_does_not_wait_for_a_gait_that_is_being_checked(start: Start) -> None:
    run = start("--duration", "3000")  # checking a new gait takes a while
    page = PageClient(run.url)
    page.until(lambda message: armed(message) and message["status"]["t_s"] > 0.2)
    gait = {"do": "gait", "alpha_deg": 30, "beta_deg": 70, "omega_rad_s": 1.5, "offset_deg": 0}
    for _ in range(5):
        page.connection.send(json.dumps({**gait, "id": "gait"}))
    page.connection.send(json.dumps({"do": "stop", "id": "stop"}))
    replies = []
    while "stop" not in replies:
        message = page.until(lambda message: message["type"] == "reply")
        replies.append(message["id"])
    assert replies.count("gait") < 5  # it went before what was asked for earlier
    assert run.ends() == EXIT_BOARD_FAULT
