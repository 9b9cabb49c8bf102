"""The first screen of the diagnosis in a real Chromium: seen without scrolling, on a desk and on a phone."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import pytest
from answers import KINDS
from sessions import bench, snake

from snakebot.diagnosis.show.answer import advice, sentence
from snakebot.diagnosis.show.page import page
from snakebot.runlog import Session

if TYPE_CHECKING:
    from playwright.sync_api import Browser

CHROMIUM = next(
    (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None
)
FLAGS = ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"]
SCREENS: tuple[tuple[tuple[int, int], Literal["light", "dark"]], ...] = (
    ((1280, 800), "light"),
    ((390, 844), "dark"),
)
BOXES = """(parts) => [...document.querySelectorAll(parts)].map((e) => {
    const box = e.getBoundingClientRect(); return [box.left, box.top, box.right, box.bottom]; })"""
PARTS = ".answer .sentence, .answer svg.drawing, .answer .fall, .answer .todo > div"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        CHROMIUM is None, reason="no Chromium on this machine (Debian: apt-get install chromium)"
    ),
]


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="playwright (extra `test`) drives the browser"
    )
    with playwright.sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield chromium
        chromium.close()


@pytest.mark.parametrize("kind", KINDS)
def test_sentence_drawing_bar_and_advice_are_on_the_first_screen(
    browser: Browser, tmp_path: Path, kind: str
) -> None:
    found = KINDS[kind]()
    robot = bench(5) if "unexplained" in kind else snake()
    file = tmp_path / "verdict.html"
    file.write_text(page(Session(robot, ()), found), encoding="utf-8")
    context = browser.new_context()
    tab = context.new_page()
    complaints: list[str] = []
    tab.on("console", lambda m: complaints.append(m.text) if m.type in ("error", "warning") else None)
    tab.on("pageerror", lambda error: complaints.append(str(error)))
    tab.goto(file.as_uri())
    tab.wait_for_selector("html[data-ready]")
    for (width, height), scheme in SCREENS:
        tab.set_viewport_size({"width": width, "height": height})
        tab.emulate_media(color_scheme=scheme)
        boxes = tab.evaluate(BOXES, PARTS)
        assert len(boxes) == 3 + len(advice(found))
        for left, top, right, bottom in boxes:
            assert 0 <= left < right <= width
            assert 0 <= top < bottom <= height
        assert tab.evaluate("document.documentElement.scrollWidth") <= width
        ends = tab.evaluate(BOXES, ".answer .fall, .answer .fall b")
        assert max(right for _, _, right, _ in ends[1:]) <= ends[0][2] + 0.5  # no number sticks out
        tab.wait_for_function("scheme => document.documentElement.dataset.theme === scheme", arg=scheme)
    assert tab.locator(".answer .sentence").inner_text() == sentence(found)
    assert complaints == []
    context.close()
