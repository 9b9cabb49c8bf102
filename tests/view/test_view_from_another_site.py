"""A page of another site, open in the same Chromium, tries to look at a run, to steer it and to stop it."""

from __future__ import annotations

import http.server
import json
import threading
import urllib.parse
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from page_client import PAGE, PageClient, armed
from viewed_run import ViewedRun
from visits import NEEDED

from snakebot.view.foxglove import SUBPROTOCOLS

pytestmark = [pytest.mark.slow, pytest.mark.real_time, NEEDED]
Start = Callable[..., ViewedRun]

# Everything that a page may try: web sockets in each protocol and in none, what fetch offers, a form, a frame.
ATTACK = """<!DOCTYPE html><title>elsewhere</title><iframe id="frame"></iframe>
<form method="post" target="frame" enctype="text/plain"><input name='{"do":"stop"}' value=""></form>
<script>
const site = TARGET, told = {}, stop = JSON.stringify({ do: "stop" });
window.told = told;
const socket = (name, ...protocols) => new Promise((done) => {
  const line = new WebSocket(site.replace("http", "ws"), ...protocols);
  line.onopen = () => { line.send(stop); told[name] = "open"; done(); };
  line.onmessage = () => { told[name] = "heard"; };
  line.onerror = () => { told[name] ??= "refused"; done(); };
});
const fetched = async (name, options) => {
  try {
    const answer = await fetch(site, options);
    told[name] = answer.type === "opaque" ? "opaque" : await answer.text();
  } catch { told[name] = "refused"; }
};
const form = document.querySelector("form"), frame = document.getElementById("frame");
form.action = site;
form.submit();
const shown = new Promise((done) => {
  const other = document.createElement("iframe");
  other.onload = () => {
    try { told.frame = other.contentDocument.body.innerText; } catch { told.frame = "refused"; }
    done();
  };
  other.src = site;
  document.body.append(other);
});
Promise.all([
  ...PROTOCOLS.map((name) => socket(name, [name])), socket("no protocol"), shown,
  fetched("read"), fetched("post", { method: "POST", body: stop }),
  fetched("post unseen", { method: "POST", body: stop, mode: "no-cors" }),
]).then(() => { told.done = true; });
</script>"""


@contextmanager
def site(page: str) -> Iterator[int]:
    """A web server with one page; its port."""

    class Answer(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.end_headers()
            self.wfile.write(page.encode())

        def log_message(self, *_: object) -> None:
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Answer) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        try:
            yield server.server_port
        finally:
            server.shutdown()


@pytest.mark.parametrize("name", ["127.0.0.1", "evil.example"])
def test_a_page_of_another_site_neither_sees_nor_stops_a_run(name: str, browser: Any, start: Start) -> None:
    run = start()
    port = urllib.parse.urlsplit(run.url).port
    protocols = [PAGE, *SUBPROTOCOLS]
    # Its own name for this computer is no way in either: then the request says so in Host.
    target = f"http://{name}:{port}/"
    attack = ATTACK.replace("TARGET", json.dumps(target)).replace("PROTOCOLS", json.dumps(protocols))
    watching = PageClient(run.url)
    watching.until(armed)
    with site(attack) as elsewhere:
        page = browser.new_page()
        page.goto(f"http://{name}:{elsewhere}/")
        for _ in range(500):
            if page.evaluate("window.told.done"):
                break
            page.wait_for_timeout(20)
        told = page.evaluate("window.told")
        if name != "127.0.0.1":  # nor does the page itself come by another name
            assert page.goto(target).status == 403
        page.close()
    assert told.pop("done")
    assert set(told) == {*protocols, "no protocol", "frame", "read", "post", "post unseen"}
    assert told.pop("post unseen") in ("opaque", "refused")  # it may be sent; nothing obeys it
    assert set(told.values()) == {"refused"}
    later = watching.frame()["status"]["t_s"] + 0.5
    frame = watching.until(lambda message: message.get("status", {}).get("t_s", 0.0) > later)
    assert frame["status"]["mode"] == "armed"
    assert frame["pages"] == 1
    assert not [event for event in frame["events"] if event["level"] >= 4]
