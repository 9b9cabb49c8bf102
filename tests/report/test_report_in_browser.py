"""The pages in a real Chromium: offline, without an error, without a side scroll on a phone."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
import pytest
from test_report_page import EVIL, full_page

if TYPE_CHECKING:
    from playwright.sync_api import Browser

Scheme = Literal["light", "dark"]
CHROMIUM = next(
    (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None
)

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        CHROMIUM is None, reason="no Chromium on this machine (Debian: apt-get install chromium)"
    ),
]

FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
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


class Visit:
    """A page opened from a file, with all that the browser complained about or asked for."""

    def __init__(self, browser: Browser, path: Path, width: int, scheme: Scheme) -> None:
        self.context = browser.new_context(
            viewport={"width": width, "height": 900}, color_scheme=scheme, has_touch=width < 500
        )
        self.page = self.context.new_page()
        self.complaints: list[str] = []
        self.requests: list[str] = []
        self.page.on(
            "console", lambda m: self.complaints.append(m.text) if m.type in ("error", "warning") else None
        )
        self.page.on("pageerror", lambda e: self.complaints.append(str(e)))
        self.page.on("request", lambda r: self.requests.append(r.url))
        self.page.goto(path.as_uri())
        self.page.wait_for_selector("html[data-ready]")
        self.page.wait_for_timeout(200)

    def painted(self, selector: str) -> bool:
        """Whether a canvas shows more than one colour."""
        more: bool = self.page.evaluate(
            """(selector) => [...document.querySelectorAll(selector)].every((canvas) => {
                const d = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
                for (let i = 4; i < d.length; i += 4) if (d[i + 3] !== d[3] || d[i] !== d[0]) return true;
                return false;
            })""",
            selector,
        )
        return more


def analysis_page_file(tmp_path: Path) -> Path:
    from sample_runs import PENN_STATE, snake_run

    from snakebot.analysis import analyze_run, paper_tables
    from snakebot.analysis.report import analysis_page

    runs = [
        analyze_run(
            snake_run(66, 80, omega, effects=("rate_limit:limit_rad_s=2",), name=EVIL, cycles=4, lost=0.05),
            PENN_STATE,
        )
        for omega in (1, 2, 3)
    ]
    path = tmp_path / "analysis.html"
    analysis_page(runs, paper_tables(runs), EVIL).write(path)
    return path


@pytest.fixture(scope="module", params=["every block", "analysis", "comparison"])
def page_file(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("page")
    if request.param == "analysis":
        return analysis_page_file(folder)
    path = folder / "page.html"
    if request.param == "comparison":
        from sample_runs import loaded, snake_run

        from snakebot.analysis import compare
        from snakebot.analysis.report_compare import comparison_page

        comparison_page(compare(loaded(snake_run(name=EVIL, effects=("backlash:width_deg=4",)))), EVIL).write(
            path
        )
    else:
        full_page(EVIL).write(path)
    return path


@pytest.mark.parametrize(
    ("width", "scheme"), [(1280, "light"), (1280, "dark"), (390, "light"), (390, "dark")]
)
def test_opens_clean_at_every_width_and_in_both_themes(
    browser: Browser, page_file: Path, width: int, scheme: Scheme
) -> None:
    visit = Visit(browser, page_file, width, scheme)
    page = visit.page
    page.evaluate("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
    page.wait_for_timeout(600)
    assert visit.complaints == []
    assert [url for url in visit.requests if not url.startswith(("file:", "data:"))] == []
    assert page.evaluate("window.bad") is None, "a script from a name has run"
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.evaluate("document.documentElement.dataset.theme") == scheme
    figures = page.locator("figure.chart")
    assert figures.count() > 3
    assert page.evaluate(
        "[...document.querySelectorAll('figure.chart')].every((f) => f.dataset.built && f.querySelector('canvas'))"
    )
    assert visit.painted("figure.chart canvas")
    visit.context.close()


def test_zoom_legend_theme_and_animation_answer(browser: Browser, tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    full_page("plain").write(path)
    visit = Visit(browser, path, 1280, "light")
    page = visit.page
    area = page.locator("figure.line .u-over").first
    box = area.bounding_box()
    assert box is not None
    picture = page.locator("figure.line canvas").first
    before = picture.evaluate("c => c.toDataURL()")
    page.mouse.move(box["x"] + box["width"] * 0.3, box["y"] + 40)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * 0.6, box["y"] + 40, steps=5)
    page.mouse.up()
    page.wait_for_timeout(200)
    zoomed = picture.evaluate("c => c.toDataURL()")
    assert zoomed != before, "dragging did not zoom"
    page.locator("figure.line .zoom button", has_text="all").first.click()
    page.mouse.move(5, 5)
    page.wait_for_timeout(200)
    assert picture.evaluate("c => c.toDataURL()") == before, "the button did not zoom out again"

    page.locator("figure.line .legend button").first.click()
    page.wait_for_timeout(100)
    assert picture.evaluate("c => c.toDataURL()") != before, "the legend did not switch the line off"

    page.locator("#theme").click()
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"

    page.locator("details summary").click()
    page.wait_for_timeout(200)
    clock, play = page.locator("figure.snake output"), page.locator("figure.snake .play")
    start = clock.inner_text()
    play.click()
    page.wait_for_timeout(600)
    assert clock.inner_text() != start, "the animation does not play"
    play.click()
    held = clock.inner_text()
    page.wait_for_timeout(300)
    assert clock.inner_text() == held, "the animation does not pause"
    slide = page.locator("figure.snake input[type=range]")
    slide.evaluate("s => { s.value = 2.5; s.dispatchEvent(new Event('input')); }")
    assert clock.inner_text().startswith("2.5"), "the slider does not scrub"
    assert visit.complaints == []
    visit.context.close()


def test_long_names_and_wide_tables_stay_within_a_phone(browser: Browser, tmp_path: Path) -> None:
    from snakebot.report import Axis, Column, Facts, Line, LineChart, Page, Table

    page = Page("x" * 300, "y" * 300, "z" * 300)
    t = np.linspace(0, 1, 50)
    page.section("long").add(LineChart("u" * 200, t, [Line("s" * 150, t)], Axis("r" * 90), Axis("q" * 90)))
    page.section("w" * 200, "v" * 300).add(Facts([("a" * 80, "b" * 80, "c" * 80)])).add(
        Table([Column(f"column {i}") for i in range(30)], [list(np.arange(30.0))], "t" * 100)
    )
    names = [Column("run"), *(Column(f"figure {i}") for i in range(20))]
    page.section("runs").add(Table(names, [["n" * 120, *np.arange(20.0)]]))
    page.section("words").add(Table([Column("run"), Column("fault")], [["a", "rigid:4@12s " * 12]]))
    path = tmp_path / "long.html"
    page.write(path)
    visit = Visit(browser, path, 390, "light")
    assert visit.page.evaluate("document.documentElement.scrollWidth") <= 390
    name = visit.page.evaluate("document.querySelector('td.long').getBoundingClientRect().width")
    assert 100 < name < 0.6 * 390, "a long name is squeezed, or takes the screen"
    width = visit.page.evaluate(
        "document.querySelector('td.long:not(:first-child)').getBoundingClientRect().width"
    )
    assert width < 390, "a cell of words stands in one line, beyond the edge"
    visit.context.close()
