"""docs/safety.md names tests and tools that exist."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_every_test_and_tool_that_the_page_names_exists() -> None:
    text = (ROOT / "docs" / "safety.md").read_text(encoding="utf-8")
    tests = set(re.findall(r"`(test_\w+\.py)`", text))
    assert len(tests) >= 10
    have = {path.name for path in (ROOT / "tests").rglob("test_*.py")}
    assert tests <= have, tests - have
    tools = set(re.findall(r"`(tools/\w+(?:\.py)?)", text))
    assert tools
    for tool in tools:
        assert (ROOT / tool).exists(), tool
