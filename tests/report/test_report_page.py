"""Pages are self-contained, escape what strangers wrote, and stay small."""

from __future__ import annotations

import hashlib
import json
import re
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from snakebot.errors import BadInputError
from snakebot.report import (
    Axis,
    BarChart,
    Bars,
    Column,
    Curve,
    Facts,
    Line,
    LineChart,
    Note,
    Page,
    SnakeAnimation,
    SnakeMotion,
    Table,
    XYChart,
)
from snakebot.report.blocks import significant
from snakebot.report.decimate import bridge_short_gaps, decimate
from snakebot.report.page import json_in_html

EVIL = "</script><script>window.bad=1</script><img src=x onerror=window.bad=1>"
ASSETS = resources.files("snakebot.report").joinpath("assets")


def full_page(text: str = "plain", samples: int = 200) -> Page:
    """Every kind of block, with this text wherever text can stand."""
    t = np.linspace(0, 10, samples)
    page = Page(text, text, text)
    section = page.section(text, text)
    section.add(Facts([(text, text, text)])).add(Note(text, "warning"))
    section.add(Table([Column(text, text, help=text), Column("n")], [[text, 1.5], [text, None]], text))
    section.add(LineChart(text, t, [Line(text, np.sin(t))], Axis(text, text), Axis(text, text), sync=text))
    section.add_grid(
        XYChart(text, [Curve(text, t, t, mode="points", labels=[text] * samples)], Axis(text), Axis(text))
    )
    section.add(BarChart(text, [text], [Bars(text, [0.5], low=[0.4], high=[0.6])], Axis(text)))
    page.section(text, folded=True).add(
        SnakeAnimation(text, t, [SnakeMotion(text, t, t, t, np.zeros((samples, 5)), 0.1)], text)
    )
    return page


def data_of(html: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', html, re.S)
    assert found
    data: dict[str, Any] = json.loads(found[1])
    return data


def test_nothing_is_loaded_from_anywhere() -> None:
    html = full_page().html()
    own = html.replace((ASSETS / "uPlot.iife.min.js").read_text(), "")
    assert not re.search(r"""(src|href)\s*=\s*["'](?!data:)""", own)
    assert not re.search(r"\b(fetch|XMLHttpRequest|WebSocket|import)\s*\(|@import|url\(", own)
    assert "default-src 'none'" in html


def test_text_of_strangers_is_text() -> None:
    html = full_page(EVIL).html()
    assert html.count("<script") == 2  # the data, and the page's own script
    assert html.count("</script") == 2
    assert "<img" not in html
    assert data_of(html)["charts"]["c1"]["title"] == EVIL


@given(st.text(), st.floats())
def test_json_in_a_script_element_comes_back_and_closes_nothing(text: str, number: float) -> None:
    encoded = json_in_html({"text": text, "number": number})
    assert not set("<>&") & set(encoded)
    back = json.loads(encoded)
    assert back["text"] == text
    assert back["number"] == (number if np.isfinite(number) else None)


def test_only_the_pages_own_script_may_run() -> None:
    html = full_page(EVIL).html()
    allowed = re.search(r"script-src '(sha256-[^']+)'", html)
    script = html[html.rindex("<script>") + 8 : html.rindex("</script>")]
    assert allowed
    import base64

    assert allowed[1] == "sha256-" + base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()


def test_vendored_files_are_those_on_record() -> None:
    record = (ASSETS / "VENDORED.md").read_text()
    rows = re.findall(r"^\| `([^`]+)` \|.*`([0-9a-f]{64})` \|$", record, re.M)
    assert {name for name, _ in rows} == {p.name for p in ASSETS.iterdir() if p.name.startswith("uPlot")}
    for name, digest in rows:
        assert hashlib.sha256((ASSETS / name).read_bytes()).hexdigest() == digest, name


@given(
    size=st.integers(1, 4000),
    points=st.integers(20, 500),
    signals=st.integers(1, 5),
    seed=st.integers(0, 20),
)
def test_thinning_keeps_every_extreme_and_stays_within_its_budget(
    size: int, points: int, signals: int, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    x = np.arange(size, dtype=float)
    y = [rng.normal(size=size) for _ in range(signals)]
    y[0][rng.random(size) < 0.2] = np.nan
    keep = decimate(x, y, points)
    assert (np.diff(keep) > 0).all()
    assert len(keep) <= max(points, 5 * signals + 2) * 1.5 + 2
    for signal in y:
        known = np.isfinite(signal)
        if known.any():
            assert np.nanmax(signal) == np.nanmax(signal[keep])
            assert np.nanmin(signal) == np.nanmin(signal[keep])


def test_a_long_gap_stays_a_gap_and_a_lost_sample_does_not() -> None:
    y = np.sin(np.linspace(0, 20, 10_000))
    y[4000:5000] = np.nan
    y[100] = np.nan
    chart = LineChart("", np.arange(10_000.0), [Line("", y)], Axis(""), Axis(""), points=500)
    spec = chart.spec()
    missing = spec["x"][np.isnan(spec["lines"][0]["y"])]
    assert len(missing) > 5
    assert ((missing >= 4000) & (missing < 5000)).all()


def test_bridging_is_a_straight_line_over_short_gaps_only() -> None:
    y = np.array([0.0, np.nan, np.nan, 3.0, np.nan, np.nan, np.nan, 7.0, np.nan])
    out = bridge_short_gaps(y, 2)
    assert out[:4].tolist() == [0, 1, 2, 3]
    assert np.isnan(out[4:7]).all()
    assert np.isnan(out[8])


def test_a_minute_at_200_hz_stays_below_two_megabytes() -> None:
    t = np.arange(0, 60, 0.005)
    page = Page("size")
    rng = np.random.default_rng(0)
    for j in range(5):
        lines = [Line(n, rng.normal(0, 60, len(t))) for n in ("command", "applied", "measured")]
        page.section(f"{j}").add(
            LineChart(f"{j}", t, lines, Axis("t", "s"), Axis("a", "deg", 2), points=2400)
        )
    motion = SnakeMotion("a", t, t, t, rng.normal(size=(len(t), 5)), 0.08)
    page.sections[0].add(SnakeAnimation("b", t, [motion, motion]))
    assert len(page.html()) < 2_000_000


@pytest.mark.parametrize(
    ("value", "digits", "decimals", "text"),
    [
        (0.03125, 3, 6, "0.0312"),
        (1234.5, 3, 6, "1234"),
        (-0.5, 2, 6, "−0.50"),
        (1e-9, 3, 2, "0"),
        (-1e-9, 3, 2, "0"),
        (12.345, 4, 1, "12.3"),
        (3e9, 3, 2, "3.00e+09"),
    ],
)
def test_numbers_have_the_digits_they_are_worth(value: float, digits: int, decimals: int, text: str) -> None:
    assert significant(value, digits, decimals) == text


def test_unknown_is_a_dash() -> None:
    assert [Column("a").text(v) for v in (None, float("nan"), float("inf"), True, 3, "x")] == [
        "–",
        "–",
        "–",
        "yes",
        "3",
        "x",
    ]


def test_a_page_that_cannot_be_written_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match="cannot write the report"):
        full_page().write(tmp_path / "no" / "such" / "folder.html")


def test_abbreviations_among_columns_are_explained_under_the_table() -> None:
    table = Table(
        [Column("TE sim", help="tracking error"), Column("TE robot", help="tracking error"), Column("α")], []
    )
    assert table.legend() == ["TE: tracking error"]
    page = Page("p")
    page.section("s").add(table)
    assert "TE: tracking error</p>" in page.html()
