"""docs/python.md: every block runs, one after the other, and does what the page says."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from snakebot.runlog import read_log

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "python.md").read_text(encoding="utf-8")
SLOW = "Diagnose"  # the heading whose blocks take many seconds


def blocks(*, slow: bool) -> list[str]:
    found = []
    for part in re.split(r"^## ", PAGE, flags=re.MULTILINE)[1:]:
        if slow or not part.startswith(SLOW):
            found += re.findall(r"```python\n(.*?)```", part, flags=re.DOTALL)
    return found


def run_page(*, slow: bool) -> dict[str, Any]:
    names: dict[str, Any] = {"__name__": "page"}
    for number, block in enumerate(blocks(slow=slow), 1):
        exec(compile(block, f"docs/python.md, block {number}", "exec"), names)
    return names


def test_the_page_has_blocks_for_each_part_of_the_product() -> None:
    text = "\n".join(blocks(slow=True))
    for name in (
        "record(",
        "plan_replay(",
        "analyze_run(",
        "compare(",
        "diagnose(",
        "experiments(",
        "near_optimum(",
    ):
        assert name in text
    assert len(blocks(slow=True)) == len(re.findall(r"^```python$", PAGE, flags=re.MULTILINE))


def test_runs_analysis_and_study(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    names = run_page(slow=False)
    assert names["recorded"].log_path.parent == Path("runs")
    assert 0.01 < names["recorded"].forward_speed_m_s < 0.2
    assert names["found"].te > 0.1  # a rate limit of 2 rad/s lets no joint follow 66 deg at 2 rad/s
    assert names["gap"].rms_rad > 0.05
    assert {path.name for path in Path("logs").iterdir()} == {"steps.mcap", "fault.mcap", "replay.mcap"}
    assert read_log(Path("logs/fault.mcap")).metadata["rate_hz"] == 50
    said = capsys.readouterr().out
    assert "/dev/no_such_board: no such device" in said
    assert "\n3\n" in said  # the exit status of a board that is not there
    assert names["grid"].speed_m_s.shape == (3, 3)


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_the_whole_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names = run_page(slow=True)
    assert [cause.effect for cause in names["verdict"].causes] == ["rate_limit"]
    assert len(list(Path("session").glob("*.mcap"))) == 5
    assert len(list(Path("live").glob("*.mcap"))) >= 5
