"""The page: sections of blocks, rendered to one HTML file that needs nothing else."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

from snakebot.errors import cannot_write
from snakebot.report.blocks import Block, Chart
from snakebot.whole_files import replacing

_SCRIPTS = ("uPlot.iife.min.js", "page.js", "line.js", "xy.js", "bars.js", "snake.js", "start.js")
_STYLES = ("uPlot.min.css", "page.css", "answer.css")
_CHARTS = ("line", "xy", "bars", "snake")


@dataclass(frozen=True)
class Beside:
    """Text, and blocks to the right of it."""

    text: Block
    blocks: Sequence[Block]
    kind: str = field(default="beside", init=False)


@dataclass
class Section:
    """A heading (or none), an optional note under it, and blocks. ``folded`` sections open on a click."""

    title: str
    note: str = ""
    folded: bool = False
    level: int = 2
    blocks: list[Block | list[Block] | Beside] = field(default_factory=list)

    def add(self, block: Block) -> Section:
        """Add a block across the whole width."""
        self.blocks.append(block)
        return self

    def add_beside(self, text: Block, *blocks: Block) -> Section:
        """Add text with what it speaks of on its right, or under it on a narrow screen."""
        self.blocks.append(Beside(text, blocks))
        return self

    def add_grid(self, *blocks: Block) -> Section:
        """Add blocks in one row, as many as fit the width of the screen."""
        if blocks:
            self.blocks.append(list(blocks))
        return self


@dataclass
class Page:
    """A report. ``footer`` says where the figures come from (command, version)."""

    title: str
    subtitle: str = ""
    footer: str = ""
    sections: list[Section] = field(default_factory=list)

    def section(self, title: str, note: str = "", *, folded: bool = False, level: int = 2) -> Section:
        """Append a section and return it."""
        self.sections.append(Section(title, note, folded, level))
        return self.sections[-1]

    def html(self) -> str:
        """The whole file as text."""
        from jinja2 import Environment, StrictUndefined
        from markupsafe import Markup

        environment = Environment(
            autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
        )
        charts: dict[str, dict[str, Any]] = {}
        identities = {id(block): f"c{number}" for number, block in enumerate(self._charts(), start=1)}
        for block in self._charts():
            charts[identities[id(block)]] = block.spec()
        script = "\n".join(_asset(name) for name in _SCRIPTS)
        return environment.from_string(_asset("page.html.j2")).render(
            page=self,
            chart_kinds=_CHARTS,
            identity=lambda block: identities[id(block)],
            style=Markup("\n".join(_asset(name) for name in _STYLES)),
            script=Markup(script),
            script_hash=_csp_hash(script),
            data=Markup(json_in_html({"charts": charts})),
            svg=lambda drawing: Markup(drawing.svg()),
            is_grid=lambda block: isinstance(block, list),
        )

    def write(self, path: Path) -> None:
        """Write the file.

        Raises:
            BadInputError: it cannot be written.
        """
        try:
            with replacing(path) as whole:
                whole.write_text(self.html(), encoding="utf-8")
        except OSError as error:
            raise cannot_write(f"{path}: cannot write the report", error) from None

    def _charts(self) -> Iterator[Chart]:
        for section in self.sections:
            for entry in section.blocks:
                for block in _blocks(entry):
                    if hasattr(block, "spec"):
                        yield block  # type: ignore[misc]


def _blocks(entry: Block | list[Block] | Beside) -> Sequence[Block]:
    if isinstance(entry, Beside):
        return [entry.text, *entry.blocks]
    return entry if isinstance(entry, list) else [entry]


def json_in_html(data: object) -> str:
    """JSON that may stand inside a script element: no ``<``, ``>`` or ``&`` is left that could end or open
    a tag.

    ``nan`` and infinity become ``null``.
    """
    import orjson

    text = orjson.dumps(data, option=orjson.OPT_SERIALIZE_NUMPY | orjson.OPT_NON_STR_KEYS).decode()
    for sign in "<>&\u2028\u2029":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return text


def _asset(name: str) -> str:
    return resources.files("snakebot.report").joinpath("assets", name).read_text(encoding="utf-8")


def _csp_hash(script: str) -> str:
    """The script element's content is ``script`` to the letter: the template adds no white space."""
    return "sha256-" + base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
