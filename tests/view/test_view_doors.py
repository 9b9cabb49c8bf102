"""Who may look at a page and send to it: other sites, other computers, nonsense, options that make no sense."""

from __future__ import annotations

import socket
import subprocess
import urllib.error
import urllib.parse
import urllib.request
from collections.abc import Callable
from pathlib import Path

import pytest
from page_client import PAGE, PageClient, armed, socket_url
from viewed_run import PROGRAM, ViewedRun
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from snakebot.view.foxglove import SUBPROTOCOLS
from snakebot.view.server import name_for_others

Start = Callable[..., ViewedRun]


def fetch(url: str, **headers: str) -> tuple[int, str, dict[str, str]]:
    request = urllib.request.Request(url, headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=5.0) as answer:
            return answer.status, answer.read().decode(), dict(answer.headers)
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode(), dict(error.headers)


def test_another_site_in_the_same_browser_gets_nothing(start: Start) -> None:
    run = start()
    with pytest.raises(InvalidStatus, match="403"):
        PageClient(run.url, origin="http://evil.example")
    with pytest.raises(InvalidStatus, match="403"):
        PageClient(run.url, origin="null")
    port = urllib.parse.urlsplit(run.url).port
    status, text, _ = fetch(run.url, Host=f"evil.example:{port}")  # a name of theirs that points here
    assert status == 403
    assert "not this server's" in text
    status, _, headers = fetch(run.url, Origin="http://evil.example")
    assert status == 403
    assert "Access-Control-Allow-Origin" not in headers


def test_the_page_comes_with_a_policy_and_nothing_else_is_served(start: Start) -> None:
    run = start()
    status, text, headers = fetch(run.url)
    assert status == 200
    policy = headers["Content-Security-Policy"]
    assert "unsafe" not in policy
    assert "default-src 'none'" in policy
    assert "<script>" not in text
    assert "style=" not in text
    for name in ("view.js", "view.css", "body.js", "strips.js", "controls.js", "uPlot.iife.min.js"):
        assert fetch(run.url + name)[0] == 200, name
    for name in ("../server.py", "%2e%2e/server.py", "server.py", "page/view.js", "index.html/.."):
        assert fetch(run.url + name)[0] == 404, name


@pytest.mark.slow
@pytest.mark.real_time
def test_beyond_this_computer_a_token_is_wanted(start: Start) -> None:
    run = start("--view-address", "0.0.0.0")
    parts = urllib.parse.urlsplit(run.url)
    assert parts.query.startswith("token=")
    bare = f"http://127.0.0.1:{parts.port}/"
    assert fetch(bare)[0] == 403
    assert fetch(f"{bare}?token=wrong")[0] == 403
    assert fetch(f"{bare}?{parts.query}")[0] == 200
    for protocol in (
        PAGE,
        *SUBPROTOCOLS,
    ):  # a stranger gets no connection, so nothing to look at, steer or stop
        for query in ("", "?token=", "?token=wrong"):
            with pytest.raises(InvalidStatus, match="403"):
                connect(socket_url(bare) + query, subprotocols=[Subprotocol(protocol)])
    assert parts.hostname not in ("0.0.0.0", None), "an address that another computer can open"
    page = PageClient(f"{bare}?{parts.query}", origin=bare.rstrip("/"))
    assert page.hello["joints"] == 5
    again = start("--view-address", "0.0.0.0", "--log", str(run.log.with_name("again.mcap")))
    assert urllib.parse.urlsplit(again.url).query != parts.query, "each run has a token of its own"


@pytest.mark.parametrize("address", ["127.0.0.1", "::1", "localhost", "10.1.2.3"])
def test_an_address_is_shown_as_it_was_given(address: str) -> None:
    assert name_for_others(address) == address


@pytest.mark.parametrize("address", ["0.0.0.0", "::"])
def test_every_address_is_shown_as_one_that_can_be_opened(address: str) -> None:
    assert name_for_others(address) not in ("", "0.0.0.0", "::")


@pytest.mark.slow
@pytest.mark.real_time
def test_options_of_the_page_without_it_are_told(tmp_path: Path) -> None:
    for words in (["--view-port", "1"], ["--view-address", "::1"], ["--view-stop"], ["--view", "--fast"]):
        wave = ["run", "--alpha", "40", "--beta", "80", "--omega", "2", "--log", str(tmp_path / "x.mcap")]
        done = subprocess.run([*PROGRAM, *wave, *words], capture_output=True, text=True)
        assert done.returncode == 2, words
        assert "--view" in done.stderr
        assert done.stderr.count("\n") == 1


@pytest.mark.slow
@pytest.mark.real_time
def test_a_port_that_is_taken_is_told_before_anything_moves(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as door:
        wave = ["run", "--alpha", "40", "--beta", "80", "--omega", "2", "--log", str(tmp_path / "x.mcap")]
        port = str(door.getsockname()[1])
        done = subprocess.run(
            [*PROGRAM, *wave, "--view", "--view-port", port], capture_output=True, text=True
        )
    assert done.returncode == 2
    assert "--view-port" in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.real_time
def test_nonsense_from_a_page_harms_nobody(start: Start) -> None:
    run = start()
    page, other = PageClient(run.url), PageClient(run.url)
    page.until(armed)
    for nonsense in (
        "",
        "x",
        "[]",
        "7",
        "null",
        '{"do":[]}',
        '{"do":{"do":"stop"}}',
        "[" * 4000,
        b"\xff\x00",
    ):
        page.connection.send(nonsense)
    for wish in (
        {"do": "gait", "alpha_deg": 1e308},
        {"do": "fault", "fault": "x" * 3000},
        {"id": "x", "do": None},
    ):
        assert page.ask(**wish)
    gait = {"alpha_deg": "nan", "beta_deg": 0, "omega_rad_s": 1, "offset_deg": 0}
    assert page.ask(do="gait", **gait)
    page.connection.send("y" * 5000)  # more than a page may say
    with pytest.raises(ConnectionClosed):
        while True:
            page.read()
    assert armed(other.until(armed))
    assert other.until(lambda message: bool(message.get("free")))  # the driver has gone
    assert run.process.poll() is None
