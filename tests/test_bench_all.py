"""tools/bench_all.py: runs a bench, reads what it prints, and says what it could not."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import bench_all
import bench_growth
import pytest


def test_one_bench_runs_quickly_and_has_its_ratios(root: Path) -> None:
    words = [sys.executable, str(root / "tools" / "bench_all.py"), "--quick", "--only", "codec"]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    machine, head, *rows = done.stdout.splitlines()
    assert re.search(r"\d+ cores; .*Python 3\.\d+", machine)
    assert head.split() == ["bench", "load", "what", "snakebot", "peer", "its", "ratio"]
    assert {"encode", "decode", "pack", "unpack"} <= {row.split()[2] for row in rows}
    for row in rows:
        ours, theirs, ratio = (
            float(v.replace(",", "")) for v in re.findall(r" ([\d.,]+(?:e[+]\d+)?)\b(?=\s|$)", row)[-3:]
        )
        assert ratio > 0
        assert ours > 0
        assert theirs > 0


def test_every_bench_of_the_folder_is_in_the_table(root: Path) -> None:
    named = {bench.words[0] for bench in bench_all.BENCHES.values()}
    there = {f.name for f in (root / "tools").glob("bench_*") if f.suffix in ("", ".py")}
    # bench_experiments compares two ways to choose a motion over days of robots, not two programs
    assert named == there - {"bench_all.py", "bench_experiments"}


def test_the_page_has_a_row_of_every_bench(root: Path) -> None:
    """As it was printed, in one go: nothing left out."""
    page = (root / "docs/performance.md").read_text(encoding="utf-8")
    assert bench_all.MARKDOWN_HEAD in page
    rows = page[page.index(bench_all.MARKDOWN_HEAD) + len(bench_all.MARKDOWN_HEAD) :].split("\n\n")[0]
    assert {row.split("|")[1].strip() for row in rows.strip().splitlines()} == set(bench_all.BENCHES)
    assert "left out" not in rows
    assert all(f"{name} " in page[page.index("Load of the machine") :] for name in bench_all.BENCHES)


def test_printed_tables_are_read() -> None:
    text = (
        "feetech     5 joints  snakebot                800 cycles/s, median 1.2 ms, p99 2 ms, 9 cycles, 0 lost\n"
        "feetech     5 joints  scservo_sdk             200 cycles/s, median 5.0 ms, p99 6 ms, 9 cycles, 0 lost\n"
    )
    (row,) = bench_all.bus(text)
    assert (row.peer, row.ratio) == ("scservo_sdk", 4.0)
    text = (
        "snakebot.runlog.read_log             0.100      0.110         0.120\n"
        "mcap make_reader + json              0.900      1.000         1.100\n"
        "snakebot.runlog.RunWriter.tick                         10.0      20.0      30.0\n"
        "mcap Writer.add_message + json                         30.0      60.0      90.0\n"
    )
    assert [row.ratio for row in bench_all.runlog(text)] == [pytest.approx(9.0), pytest.approx(3.0)]


def test_a_bench_that_fails_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    broken = bench_all.Bench(("bench_codec.py",), ("bench_codec.py", "--no-such-option"), bench_all.codec)
    monkeypatch.setitem(bench_all.BENCHES, "codec", broken)
    done = bench_all.run("codec", quick=True)
    assert "no-such-option" in done.failed
    assert "left out" in bench_all.lines(done)[0]


def test_growth_is_set_beside_proportion_to_the_first_case() -> None:
    first = {
        "joints": 5,
        "runs": 6,
        "duration_s": 20.0,
        "seconds": 8.0,
        "in_proportion_s": 8.0,
        "memory_mib": 200,
    }
    proportional = bench_growth.in_proportion_s(bench_growth.Extent(10, 6, 20.0), 8.0)
    more = {**first, "joints": 10, "seconds": 10.0, "in_proportion_s": proportional, "memory_mib": 250}
    time_first, memory_first, time_more, memory_more = bench_all.growth(json.dumps([first, more]))
    assert time_first.ratio is None
    assert memory_first.ratio is None
    assert (time_more.theirs, time_more.ratio) == (16.0, 1.6)
    assert (memory_more.theirs, memory_more.ratio) == (200, 0.8)


def test_a_table_for_the_page_has_as_many_cells_as_its_head() -> None:
    rows = [bench_all.Row("a", "b", 2.0, 1.0, "s"), bench_all.Row("a", "", 2.0, None, "s")]
    head = bench_all.MARKDOWN_HEAD.splitlines()[0].count("|")
    for done in (bench_all.Done("x", 0.0, rows), bench_all.Done("x", 0.0, [], "no browser")):
        assert {line.count("|") for line in bench_all.markdown(done)} == {head}
