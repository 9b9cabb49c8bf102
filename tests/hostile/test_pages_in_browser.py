"""Every HTML page that the program writes, from data full of scripts, in a real Chromium: nothing of it runs.

The page's own policy, which would forbid it too, is switched off: what is tried is that everything is escaped.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from snakebot.cli.main import main
from snakebot.runlog import Event, RunWriter, Telemetry, Tick, write_session

CHROMIUM = next(
    (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None
)
pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(600),
    pytest.mark.skipif(
        CHROMIUM is None, reason="no Chromium on this machine (Debian: apt-get install chromium)"
    ),
]

EVIL = (
    "</script><script>window.bad=1</script><img src=x onerror=window.bad=2>\"'><svg onload=window.bad=3>"
    "${window.bad=4}{{7*7}}<a href=javascript:window.bad=5>--></title></textarea></style><b onmouseover=window.bad=6>"
)
FILE = "<img src=x onerror=window.bad=7>'\""  # what a file may be called


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="playwright (extra `test`) drives the browser"
    )
    with playwright.sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"])
        yield chromium
        chromium.close()


def visit(browser: Any, path: Path) -> dict[str, Any]:
    """Open a page, every part of it, and touch everything on it: what ran, was asked for, and can be read."""
    context = browser.new_context(bypass_csp=True)
    page = context.new_page()
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))

    def refuse(dialog: Any) -> None:
        asked.append(dialog.message)
        dialog.dismiss()

    page.on("dialog", refuse)
    page.goto(path.as_uri())
    page.evaluate("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
    page.evaluate(
        "document.querySelectorAll('*').forEach((e) => ['mouseover', 'mousemove', 'focus', 'click'].forEach((kind) =>"
        " e.tagName !== 'A' && e.dispatchEvent(new MouseEvent(kind, {bubbles: true}))))"
    )
    page.wait_for_timeout(800)
    found = {
        "ran": page.evaluate("window.bad === undefined ? null : window.bad"),
        "scripts": page.locator("script").count(),
        "handlers": page.evaluate(
            "[...document.querySelectorAll('*')].filter((e) => e.getAttributeNames().some((n) => /^on/.test(n))).length"
        ),
        "links": page.evaluate("[...document.links].map((a) => a.protocol)"),
        "asked": [url for url in asked if not url.startswith("data:") and url != path.as_uri()],
        "text": page.evaluate("document.documentElement.innerText"),
    }
    context.close()
    return found


def snakebot(*words: object) -> int:
    with pytest.raises(SystemExit) as ended:
        main([str(word) for word in words])
    return int(ended.value.code or 0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session and three logs; every name and every text in them is hostile."""
    from sessions import bench, make_session

    place = tmp_path_factory.mktemp("pages") / FILE
    robot = bench(1).model_copy(update={"name": EVIL})
    session = make_session(robot, ["rate_limit:limit_rad_s=1.3"])
    runs = [
        replace(run, metadata={"notes": EVIL, EVIL: EVIL}, extra={EVIL: run.t_s, "supply_v": run.t_s})
        for run in session.runs
    ]
    write_session(place / "session", robot, runs)
    described = (place / "session" / "session.yaml").read_text()
    for number, path in enumerate(sorted((place / "session").glob("run_*.csv")), 1):
        path.rename(path.with_name(f"{number}{FILE}.csv"))
        described = described.replace(path.name, '"' + f"{number}{FILE}.csv".replace('"', '\\"') + '"')
    (place / "session" / "session.yaml").write_text(described)
    first, other = session.runs[:2]
    for name, run in ((f"a{FILE}", first), (f"b{FILE}", other), (f"c{FILE}", first)):
        with RunWriter(place / name, robot, {"notes": EVIL, EVIL: EVIL}, start_time_ns=0) as writer:
            for count, t_s in enumerate(run.t_s):
                command, measured = run.command_rad[count], run.measured_rad[count]
                writer.tick(
                    Tick(
                        count,
                        float(t_s),
                        count,
                        command,
                        command,
                        command,
                        measured,
                        count * 10_000,
                        0.001,
                        False,
                    )
                )
            writer.event(Event(1.0, EVIL, EVIL, "error", {EVIL: EVIL}))
            writer.telemetry(Telemetry(0.5, {EVIL: 1.0, "supply_v": 12.0}))
    return place


PAGES = {
    "analyze a session": ["analyze", "{}/session"],
    "analyze logs": ["analyze", "{}/a" + FILE + ".mcap", "{}/b" + FILE + ".mcap"],
    "compare": ["compare", "{}/a" + FILE + ".mcap"],
    "compare two": ["compare", "{}/a" + FILE + ".mcap", "{}/c" + FILE + ".mcap"],
    "diagnose": ["diagnose", "{}/session", "--quick", "--only", "rate_limit", "--only", "servo_lag"],
    "diagnose logs": [
        "diagnose",
        "{}/a" + FILE + ".mcap",
        "{}/b" + FILE + ".mcap",
        "--quick",
        "--only",
        "rate_limit",
    ],
}


@pytest.mark.parametrize("what", list(PAGES))
def test_nothing_runs(
    browser: Any, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], what: str
) -> None:
    page = tmp_path / f"{FILE}.html"
    words = [word.replace("{}", str(folder)) for word in PAGES[what]]
    status = snakebot(*words, "--report", page)
    assert status == 0, capsys.readouterr().err
    found = visit(browser, page)
    assert found["ran"] is None
    assert found["scripts"] == 2, "the data, and the page's own script"
    assert found["handlers"] == 0
    assert "javascript:" not in found["links"]
    assert found["asked"] == []
    assert "onerror=window.bad=7" in found["text"], "file names are there, as text"
    assert "onmouseover=window.bad=6" in found["text"], "so is the name of the robot"


def test_the_browser_would_run_it(browser: Any, tmp_path: Path) -> None:
    page = tmp_path / "open.html"
    page.write_text(f"<!doctype html><title>x</title><p>{EVIL}</p>")
    found = visit(browser, page)
    assert found["ran"] is not None
    assert found["handlers"] > 0
